// The program `calibrate`: files, messages, exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "core/io/calibration/calibration.h"
#include "tests/apps/command.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CalibrateTest : public CommandTest {
 protected:
  // The detections of one person who walks in front of three cameras; returns
  // their path.
  std::string DetectionsOf(double seconds) const {
    const std::string name = "s" + std::to_string(static_cast<int>(seconds));
    Done("synthesize",
         "--config=" +
             folder_.Write(name + ".toml",
                           "[scene]\nseed = 4\npeople = 1\nduration = " +
                               std::to_string(seconds) +
                               "\n[scene.cameras]\ncount = 3\n") +
             " --out=" + Path(name));
    return Path(name) + "/detections.jsonl";
  }
};

// A refusal removes the cameras of an earlier recording, so that they are not
// used by mistake.
TEST_F(CalibrateTest, ARefusalFailsAndLeavesNoCameras) {
  const std::string out = folder_.Write("found.json", "of an earlier run\n");
  const ProgramOutcome outcome =
      RunProgram("calibrate", "--detections=" + DetectionsOf(0.5) +
                                  " --image_size=1920,1080 --out=" + out);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.output, HasSubstr("refused\n"));
  EXPECT_THAT(outcome.errors, HasSubstr("found.calibrate.json"));
  EXPECT_FALSE(fs::exists(out));
  EXPECT_THAT(ContentOf(Path("found.calibrate.json")),
              HasSubstr("\"verdict\": \"refused\""));
}

TEST_F(CalibrateTest, RefusesUnwritableOutputPaths) {
  const std::string detections = DetectionsOf(0.5);
  fs::create_directory(Path("folder.json"));
  const std::string file = folder_.Write("file", "");
  for (const std::string& out :
       {Path("folder.json"), file + "/c.json", detections}) {
    Refusal("calibrate", "--detections=" + detections +
                             " --image_size=1920,1080 --out=" + out);
  }
}

// Focal lengths of --cameras are exact unless --focal_error is given, even with
// its default value of 1.
TEST_F(CalibrateTest, FocalErrorOfOnePercentAppliesToCameras) {
  const std::string detections = DetectionsOf(8.0);
  const std::string flags = "--detections=" + detections +
                            " --cameras=" + Path("s8/cameras.json") +
                            " --out=" + Path("found.json");
  const auto focal_px = [this] {
    return ReadCameras(Path("found.json")).front().K()(0, 0);
  };
  Done("calibrate", flags);
  const double stated_px = focal_px();
  EXPECT_EQ(stated_px, ReadCameras(Path("s8/cameras.json")).front().K()(0, 0));
  Done("calibrate", flags + " --focal_error=1");
  EXPECT_GT(std::abs(focal_px() - stated_px), 0.01);
}

TEST_F(CalibrateTest, AnErrorOfUnknownFocalLengthsIsRefused) {
  const std::string detections = DetectionsOf(0.5);
  for (const std::string percent : {"10", "1"}) {
    EXPECT_THAT(Refusal("calibrate",
                        "--detections=" + detections +
                            " --image_size=1920,1080 --focal_error=" + percent +
                            " --out=" + Path("c.json")),
                HasSubstr("--focal_error: needs --focal"));
  }
}

TEST_F(CalibrateTest, UnreadableInputLeavesNoFolders) {
  Refusal("calibrate",
          "--detections=" + folder_.Write("d.jsonl", "[\n") +
              " --image_size=1920,1080 --out=" + Path("new/folder/c.json"));
  EXPECT_FALSE(fs::exists(Path("new")));
}

// Without this check only the writer would fail, after the whole calibration.
TEST_F(CalibrateTest, RefusesAFormatWithoutLensesAtOnce) {
  EXPECT_THAT(
      Refusal("calibrate",
              "--detections=" + DetectionsOf(0.5) +
                  " --image_size=1920,1080 --to=tum --out=" + Path("tum")),
      HasSubstr("--to=tum: its matrices cannot express the lenses"));
  EXPECT_FALSE(fs::exists(Path("tum")));
}

// Lengths in millimetres instead of metres, a huge one and a negative one.
TEST_F(CalibrateTest, RefusesLengthsOutOfRange) {
  const std::string detections = DetectionsOf(0.5);
  for (const std::string length :
       {"scale=1750", "scale=1e300", "scale=-1", "distance=nose,l_hip,600",
        "cameras_apart=cam0,cam1,4500"}) {
    EXPECT_THAT(Refusal("calibrate", "--detections=" + detections +
                                         " --image_size=1920,1080 --" + length +
                                         " --out=" + Path("c.json")),
                HasSubstr("--" + length.substr(0, length.find('='))));
  }
}

}  // namespace
}  // namespace kinegraph::testing
