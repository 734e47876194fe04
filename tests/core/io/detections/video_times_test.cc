// Times of a video's images. The files were made by ffmpeg 5.1:
//   G="geq=lum='255*mod(floor(N/pow(2,floor(X/16))),2)':cb=128:cr=128"
//   ffmpeg -f lavfi -i "color=black:s=128x48:r=30000/1001:d=2" -vf "$G"
//     -frames:v 40 -c:v libx264 -pix_fmt yuv420p -g 15 -bf 2 -crf 20 bars.mp4
//   ffmpeg -i bars.mp4 -c:v libvpx-vp9 -g 15 -crf 20 -b:v 0 bars.webm
// Picture N shows N in eight columns, white for a one, the lowest digit first.
#include "core/io/detections/video_times.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::TemporaryFolder;

std::string Bars(const std::string& ending) {
  return testing::ProjectFile("tests/apps/report/videos/bars." + ending)
      .string();
}

// The order of storage differs from that of display (B-frames), and an edit
// list compensates for the delay. MP4's times are printed in whole
// microseconds, WebM stores whole milliseconds.
TEST(VideoTimes, ImagesStoredOutOfDisplayOrderAreSorted) {
  const std::vector<double> mp4 = ReadVideoTimes(Bars("mp4"));
  const std::vector<double> webm = ReadVideoTimes(Bars("webm"));
  ASSERT_EQ(mp4.size(), 40u);
  ASSERT_EQ(webm.size(), 40u);
  for (size_t i = 0; i < mp4.size(); ++i) {
    const double expected_s = static_cast<double>(i) * 1001.0 / 30000.0;
    EXPECT_NEAR(mp4[i], expected_s, 0.5e-6 + 1e-9);
    EXPECT_NEAR(webm[i], expected_s, 0.5e-3 + 1e-9);
  }
}

TEST(VideoTimes, ErrorNamesAnInvalidFile) {
  const std::string whole = ReadTextFile(Bars("mp4"));
  const testing::Faults cases = {{"", "a.mp4"},
                                 {"RIFF....AVI LIST", "a.mp4"},
                                 {whole.substr(0, 900), "a.mp4"}};
  testing::ExpectFaultsIn("a.mp4", cases, ReadVideoTimes);
}

// A playlist would make ffprobe open the files that it names.
TEST(VideoTimes, NoOtherFileIsOpened) {
  const TemporaryFolder folder;
  const std::string list = folder.Write(
      "a.mp4", "#EXTM3U\n#EXTINF:1,\nfile://" + Bars("mp4") + "\n");
  testing::InputErrorOf([&] { ReadVideoTimes(list); });
}

// Images that an edit list cuts off are not shown. When ffmpeg cuts between two
// key frames, the file keeps all images since the first of the two.
TEST(VideoTimes, EditListsShiftTimesAndOmitImages) {
  const TemporaryFolder folder;
  const std::string cut = folder.path() / "cut.mp4";
  const std::string command = "ffmpeg -v error -ss 0.2 -i '" + Bars("mp4") +
                              "' -c copy '" + cut + "' < /dev/null";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs ffmpeg";
  const std::vector<double> times_s = ReadVideoTimes(cut);
  ASSERT_FALSE(times_s.empty());
  EXPECT_GE(times_s.front(), -1e-6);
  EXPECT_LT(times_s.front(), 1001.0 / 30000.0);
  // 40 pictures, six of which begin before 0.2 s.
  EXPECT_EQ(times_s.size(), 34u);
}

TEST(VideoTimes, TypeFollowsFromTheExtension) {
  EXPECT_EQ(VideoType("a/b.MP4"), "video/mp4");
  EXPECT_EQ(VideoType("b.webm"), "video/webm");
  EXPECT_TRUE(IsVideoName("x.mov"));
  EXPECT_FALSE(IsVideoName("video.mp4/%06d.jpg"));
  EXPECT_FALSE(IsVideoName("mp4"));
}

}  // namespace
}  // namespace kinegraph
