// Times of a video's pictures. The files were made by ffmpeg 5.1:
//   G="geq=lum='255*mod(floor(N/pow(2,floor(X/16))),2)':cb=128:cr=128"
//   ffmpeg -f lavfi -i "color=black:s=128x48:r=30000/1001:d=2" -vf "$G"
//     -frames:v 40 -c:v libx264 -pix_fmt yuv420p -g 15 -bf 2 -crf 20 bars.mp4
//   ffmpeg -i bars.mp4 -c:v libvpx-vp9 -g 15 -crf 20 -b:v 0 bars.webm
// Picture N shows N in eight columns, white for a one, the lowest digit first.
#include "core/io/detections/video_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using testing::TemporaryFolder;

std::string Bars(const std::string& ending) {
  return testing::ProjectFile("tests/apps/report/videos/bars." + ending)
      .string();
}

// The pictures are stored in another order than they are shown in (B-frames),
// and an edit list takes back the delay that this needs.
TEST(VideoTimes, OfPicturesInAnyOrder) {
  const std::vector<double> mp4 = ReadVideoTimes(Bars("mp4"));
  const std::vector<double> webm = ReadVideoTimes(Bars("webm"));
  ASSERT_EQ(mp4.size(), 40u);
  ASSERT_EQ(webm.size(), 40u);
  for (size_t i = 0; i < mp4.size(); ++i) {
    const double expected_s = static_cast<double>(i) * 1001.0 / 30000.0;
    EXPECT_NEAR(mp4[i], expected_s, 1e-9);
    EXPECT_NEAR(webm[i], expected_s, 0.0005 + 1e-9) << "whole milliseconds";
  }
}

std::string Number(uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes += static_cast<char>(value >> shift & 0xff);
  }
  return bytes;
}

std::string Box(const std::string& name, const std::string& content) {
  return Number(static_cast<uint32_t>(content.size() + 8)) + name + content;
}

// Of three pictures at 10 Hz; `edits` is the content of its edit list.
std::string Movie(const std::string& handler, const std::string& edits,
                  uint32_t pictures = 3) {
  const std::string zero = Number(0);
  const std::string clock = zero + zero + zero + Number(1000) + zero + zero;
  const std::string durations =
      zero + Number(1) + Number(pictures) + Number(100);
  return Box("ftyp", "isom") +
         Box("moov",
             Box("mvhd", clock) +
                 Box("trak",
                     Box("edts", Box("elst", edits)) +
                         Box("mdia",
                             Box("mdhd", clock) +
                                 Box("hdlr", zero + zero + handler) +
                                 Box("minf",
                                     Box("stbl", Box("stts", durations))))));
}

TEST(VideoTimes, EditListsShiftAndCut) {
  const TemporaryFolder folder;
  const std::string zero = Number(0);
  const std::string none = zero + zero;
  // Half a second of nothing, then from the start on.
  const std::string wait = zero + Number(2) + Number(500) + Number(0xffffffff) +
                           Number(1) + Number(300) + zero + Number(1);
  const std::string cut = zero + Number(1) + Number(200) + Number(100);
  const auto times = [&](const std::string& edits) {
    return ReadVideoTimes(folder.Write("a.mp4", Movie("vide", edits)));
  };
  const auto near = [](double value) { return DoubleNear(value, 1e-12); };
  EXPECT_THAT(times(none), ElementsAre(near(0), near(0.1), near(0.2)));
  EXPECT_THAT(times(wait), ElementsAre(near(0.5), near(0.6), near(0.7)));
  EXPECT_THAT(times(cut + Number(1)), ElementsAre(near(0), near(0.1)));
}

TEST(VideoTimes, WhatIsNoneIsRefusedByName) {
  const std::string none = Number(0) + Number(0);
  const std::string whole = ReadTextFile(Bars("mp4"));
  const testing::Faults cases = {
      {"", "no video that is read here"},
      {"RIFF....AVI LIST", "no video that is read here"},
      {Movie("soun", none), "no video track"},
      {whole.substr(0, 900), "moov"},
      {Movie("vide", Number(0) + Number(9)), "ends in the middle"},
      {Movie("vide", none, 29'999'999), "frames, more than it holds"},
  };
  testing::ExpectFaultsIn("a.mp4", cases, ReadVideoTimes);
}

// Cut anywhere, and with every byte another one: never more than an error.
TEST(VideoTimes, BrokenFilesAreRefusedOrRead) {
  const TemporaryFolder folder;
  for (const char* ending : {"mp4", "webm"}) {
    const std::string whole = ReadTextFile(Bars(ending));
    size_t refused = 0;
    for (size_t i = 0; i < whole.size(); i += 3) {
      for (const bool cut : {true, false}) {
        std::string broken = whole.substr(0, cut ? i : whole.size());
        if (!cut) broken[i] = static_cast<char>(~broken[i]);
        try {
          ReadVideoTimes(folder.Write("a", broken));
        } catch (const InputError&) {
          ++refused;
        }
      }
    }
    EXPECT_GT(refused, 10u) << ending;
  }
}

TEST(VideoTimes, NamesTellTheType) {
  EXPECT_EQ(VideoType("a/b.MP4"), "video/mp4");
  EXPECT_EQ(VideoType("b.webm"), "video/webm");
  EXPECT_TRUE(IsVideoName("x.mov"));
  EXPECT_FALSE(IsVideoName("video.mp4/%06d.jpg"));
  EXPECT_FALSE(IsVideoName("mp4"));
}

}  // namespace
}  // namespace kinegraph
