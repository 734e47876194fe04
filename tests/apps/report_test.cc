// The program kinegraph-report: input, output, rejections.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"
#include "tests/support/base64.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class ReportTest : public CommandTest {
 protected:
  ReportTest() {
    const CameraRig rig = RingOfCameras(3);
    TrackSequence tracks;
    tracks.header.skeleton = Coco17();
    tracks.header.frame_rate_hz = 25.0;
    for (int f = 0; f < 20; ++f) {
      TrackFrame& frame = tracks.frames.emplace_back();
      frame.frame = f;
      frame.time = FrameClock(25.0).TimeOf(f);
      PersonPose& person = frame.people.emplace_back();
      person.id = TrackId(0);
      person.joints = StandingPerson(0.02 * f, 0.0);
      person.covariances.assign(17, Eigen::Matrix3d::Identity() * 1e-4);
    }
    WriteTracks(tracks_, tracks);
    WriteDetections(detections_, SeenBy(rig, 20, [](int f) {
                      return std::vector<Pose3d>{StandingPerson(0.02 * f, 0.0)};
                    }));
    WriteCameras(cameras_, rig);
  }

  ProgramOutcome Run(const std::string& flags) const {
    return Done("report", flags + " --out='" + out_ + "'");
  }

  const std::string tracks_ = Path("tracks.jsonl");
  const std::string detections_ = Path("detections.jsonl");
  const std::string cameras_ = Path("cameras.json");
  const std::string out_ = Path("page.html");
};

TEST_F(ReportTest, PrintsTheCountsOfThePage) {
  ProgramOutcome outcome = Run("--tracks=" + tracks_);
  EXPECT_THAT(outcome.output, HasSubstr("20 frames, 20 poses, "));
  EXPECT_THAT(outcome.output, Not(HasSubstr("detections")));
  EXPECT_THAT(outcome.output, Not(HasSubstr("covariances"))) << "not asked for";
  outcome =
      Run("--tracks=" + tracks_ + "," + tracks_ + " --ground_truth=" + tracks_ +
          " --cameras=" + cameras_ + " --detections=" + detections_ +
          " --with_covariance --title='a < b'");
  EXPECT_THAT(outcome.output, HasSubstr("20 frames, 60 poses, "));
  EXPECT_THAT(outcome.output, HasSubstr(", detections 0.0 MB, covariances"));
  EXPECT_THAT(ContentOf(out_), HasSubstr("<title>a &lt; b</title>"));
}

// Files with the headers of JPEG and PNG; only the browser interprets the rest.
TEST_F(ReportTest, PicturesAreLinkedOrEmbeddedUnchanged) {
  const std::string view = ReadCameras(cameras_)[0].name();
  fs::create_directory(Path("pictures"));
  for (int f = 0; f < 20; ++f) {
    const std::string magic = f % 2 == 0 ? "\xff\xd8\xff" : "\x89PNG\r\n\x1a\n";
    WriteTextFile(Path("pictures/" + std::to_string(f) + ".jpg"),
                  magic + std::string(3000, 'x'));
  }
  const std::string what = "--tracks=" + tracks_ + " --cameras=" + cameras_ +
                           " --detections=" + detections_ + " --images='" +
                           view + "=" + Path("pictures/%d.jpg") + "'";
  ProgramOutcome outcome = Run(what);
  EXPECT_THAT(ContentOf(out_), HasSubstr("pictures/%d.jpg"));
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("\"base64\"")));
  outcome = Run(what + " --embed_megabytes=5");
  EXPECT_THAT(outcome.output, HasSubstr("20 pictures inside the page\n"));
  EXPECT_THAT(ContentOf(out_), HasSubstr("\"base64\":[\"/9j/"));
  EXPECT_THAT(ContentOf(out_), HasSubstr(",\"iVBORw0KGgp4"));
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("%d.jpg")));
  // 20 pictures of slightly more than 4 kB each in base64, at most 20 kB: one
  // in four, i.e. five pictures, would exceed the limit.
  outcome = Run(what + " --embed_megabytes=0.02");
  EXPECT_THAT(outcome.output,
              HasSubstr("4 pictures inside the page, one frame in 5\n"));
  WriteTextFile(Path("pictures/0.jpg"), "no picture");
  EXPECT_THAT(
      Refusal("report", what + " --embed_megabytes=5 --out='" + out_ + "'"),
      HasSubstr("0.jpg: is neither JPEG nor PNG"));
}

// The images of cam1 are four frames late, and clocks.json contains this
// offset.
TEST_F(ReportTest, RecordedClocksAreApplied) {
  const CameraRig rig = RingOfCameras(3);
  DetectionSequence late = ReadDetections(detections_);
  for (size_t k = late.frames.size(); k-- > 0;) {
    const size_t shown = k - std::min<size_t>(k, 4);
    late.frames[k].views[1].detections = late.frames[shown].views[1].detections;
  }
  WriteDetections(Path("late.jsonl"), late);
  WriteCameras(Path("clocks.json"), rig,
               R"({"cameras": [{"name": "cam1", )"
               R"("clock": {"offset_s": -0.16, "drift": 0}}]})");
  const std::string flags =
      "--tracks=" + tracks_ + " --detections=" + Path("late.jsonl");
  const auto worst_px = [&](const std::string& cameras) {
    Run(flags + " --cameras=" + cameras);
    const std::string page = ContentOf(out_);
    const std::string key = "\"residual\":\"";
    const size_t begin = page.find(key) + key.size();
    const std::string bytes =
        FromBase64(page.substr(begin, page.find('"', begin) - begin));
    std::vector<uint16_t> residuals(bytes.size() / 2);  // frame, view; 0.1 px
    std::memcpy(residuals.data(), bytes.data(), bytes.size());
    EXPECT_EQ(residuals.size(), 20u * 3u);
    double worst = 0.0;
    for (size_t k = 4; k + 4 < residuals.size() / 3; ++k) {
      worst = std::max(worst, 0.1 * residuals[3 * k + 1]);
    }
    return worst;
  };
  EXPECT_GT(worst_px(cameras_), 5.0);
  EXPECT_LT(worst_px(Path("clocks.json")), 0.5);

  WriteTextFile(Path("0.jpg"), "\xff\xd8\xff");
  EXPECT_THAT(Run(flags + " --cameras=" + Path("clocks.json") +
                  " --images='cam1=" + Path("%d.jpg") + "'")
                  .errors,
              HasSubstr("are not applied to the pictures and videos of cam1"));
}

// As in `track`, cameras.use and --without_cameras leave out views, which then
// need no camera.
TEST_F(ReportTest, ViewsWithoutACameraCanBeLeftOut) {
  CameraRig cameras = ReadCameras(cameras_);
  const std::string left_out = cameras.back().name();
  const std::string names =
      "\"" + cameras[0].name() + "\", \"" + cameras[1].name() + "\"";
  const std::string config =
      folder_.Write("use.toml", "[cameras]\nuse = [" + names + "]\n");
  const std::string what =
      "--tracks=" + tracks_ + " --detections=" + detections_ + " ";
  Run(what + "--cameras=" + cameras_ + " --config=" + config);
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("\"" + left_out + "\"")));
  cameras.pop_back();
  WriteCameras(Path("two.json"), cameras);
  Run(what + "--cameras=" + Path("two.json") +
      " --without_cameras=" + left_out);
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("\"" + left_out + "\"")));
}

// `track` with cameras.use and refinement writes only the used cameras.
TEST_F(ReportTest, ViewsOutsideARefinedRunAreLeftOut) {
  TrackSequence tracks = ReadTracks(tracks_);
  tracks.header.config_json = R"({"cameras": {"refine": "pose"}})";
  WriteTracks(tracks_, tracks);
  CameraRig cameras = ReadCameras(cameras_);
  const std::string left_out = cameras.back().name();
  cameras.pop_back();
  const std::string beside = Path("tracks.cameras.json");
  WriteCameras(beside, cameras);
  WriteTextFile(
      beside, WithFingerprint(ContentOf(beside), FingerprintOfTracks(tracks_)));
  Run("--tracks=" + tracks_ + " --detections=" + detections_ +
      " --cameras=" + cameras_);
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("\"" + left_out + "\"")));
}

TEST_F(ReportTest, ClocksMayStepBack) {
  DetectionSequence detections = ReadDetections(detections_);
  for (size_t f = 10; f < detections.frames.size(); ++f) {
    DetectionFrame& frame = detections.frames[f];
    frame.time -= FromSeconds(0.3);
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  WriteDetections(detections_, detections);
  EXPECT_THAT(Run("--tracks=" + tracks_ + " --cameras=" + cameras_ +
                  " --detections=" + detections_)
                  .output,
              HasSubstr("20 frames, 20 poses, "));
}

TEST_F(ReportTest, BadInputGivesOneLineAndExitCodeTwo) {
  const std::string picture = Path("%d.jpg");
  WriteTextFile(Path("0.jpg"), "");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "--tracks"},
      {"--tracks=/nowhere.jsonl", "/nowhere.jsonl"},
      {"--tracks=" + tracks_ + "," + tracks_ + "," + tracks_ + "," + tracks_ +
           "," + tracks_ + "," + tracks_ + "," + tracks_,
       "found 7 files, expected one to 6"},
      {"--tracks=" + tracks_ + " --detections=" + detections_,
       "needs --cameras"},
      {"--tracks=" + tracks_ + " --without_cameras=cam0",
       "--without_cameras: needs --cameras"},
      {"--tracks=" + tracks_ + " --cameras=" + cameras_ +
           " --detections=" + detections_ + " --without_cameras=cam9",
       "named 'cam9'"},
      {"--tracks=" + tracks_ + " --set=cameras.unit=m", "needs --config"},
      {"--tracks=" + tracks_ + " --frames_out=" + Path("x"),
       "--frames_out was removed: the page of"},
      {"--tracks=" + tracks_ + " --embed_megabytes=3", "needs --images"},
      {"--tracks=" + tracks_ + " --cameras=" + cameras_ +
           " --detections=" + detections_ + " --images=nobody=a%d.jpg",
       "no view 'nobody', expected VIEW=PATTERN or VIEW=VIDEO with one of "},
      {"--tracks=" + tracks_ + " --cameras=" + cameras_ +
           " --detections=" + detections_ + " --images=cam0",
       "'cam0' has no '='"},
      {"--tracks=" + tracks_ + " --cameras=" + cameras_ +
           " --detections=" + detections_ + " --images='cam0=" + picture +
           ";cam0=" + picture + "'",
       "view 'cam0' is given twice"},
      {"--tracks=" + tracks_ + " --up=w", "--up"},
      {"--tracks=" + detections_, "detections"},
      {"--tracks=" + tracks_ + " --no_such_flag", "no_such_flag"}};
  for (const auto& [flags, expected] : cases) {
    EXPECT_THAT(Refusal("report", flags + " --out='" + out_ + "'"),
                HasSubstr(expected));
    EXPECT_FALSE(fs::exists(out_)) << flags;
  }
}

}  // namespace
}  // namespace kinegraph::testing
