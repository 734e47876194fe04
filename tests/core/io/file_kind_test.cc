#include "core/io/file_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

TEST(FileKind, RefusesUnknownFiles) {
  const TemporaryFolder folder;
  for (const char* text : {"", "hello",
                           "\x7f"
                           "ELF"}) {
    const std::string path = folder.Write("file", text);
    EXPECT_THAT(InputErrorOf([&] { RecogniseKind(path); }),
                HasSubstr("is not a calibration, detections or tracks"));
  }
  EXPECT_THAT(InputErrorOf([&] { RecogniseKind("missing.json"); }),
              HasSubstr("missing.json"));
  fs::create_directory(folder.path() / "empty");
  EXPECT_THAT(
      InputErrorOf([&] { RecogniseKind((folder.path() / "empty").string()); }),
      HasSubstr("is not a calibration"));
}

// XML in UTF-8 and UTF-16, a pickle, plain numbers.
TEST(FileKind, LaboratoryCalibrationsAreRecognised) {
  const TemporaryFolder folder;
  const std::string wide = std::string("\xff\xfe<\0a\0/\0>\0", 10);
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>{"cal.txt", "\n <calibration/>"},
        {"Cal.mcal", wide},
        {"camera", std::string("\x80\x04}.", 4)},
        {"00.mp4.calib", "1920\n1080\n1 0 0\n"}}) {
    EXPECT_EQ(RecogniseKind(folder.Write(name, text)), FileKind::kCalibration)
        << name;
  }
}

// The first 200 bytes decide whether a text is a table of numbers. They may end
// within a number, for example after its sign.
TEST(FileKind, NumbersAreRecognisedWhereverTheExaminedTextEnds) {
  const TemporaryFolder folder;
  for (size_t shift = 0; shift < 8; ++shift) {
    std::string text(shift + 1, ' ');
    for (int k = 0; k < 64; ++k) text += "-1.5e-3\n";
    EXPECT_EQ(RecogniseKind(folder.Write("skel.txt", text)), FileKind::kTracks)
        << shift;
  }
}

// The folders of a session's cameras are not mistaken for folders of views with
// detections.
TEST(FileKind, OpenCapSessionIsACalibration) {
  const TemporaryFolder folder;
  folder.Write("session/Videos/Cam0/cameraIntrinsicsExtrinsics.pickle", "");
  for (const char* where :
       {"session", "session/Videos", "session/Videos/Cam0"}) {
    EXPECT_EQ(RecogniseKind((folder.path() / where).string()),
              FileKind::kCalibration)
        << where;
  }
}

}  // namespace
}  // namespace kinegraph
