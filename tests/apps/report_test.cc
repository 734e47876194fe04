// kinegraph-report itself: what it reads, says and refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/report/picture.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"
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

TEST_F(ReportTest, SaysHowMuchThePageHolds) {
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

// Annotated pictures on grey, which then stand behind the panels: linked, and
// inside of the page.
TEST_F(ReportTest, PicturesAreWrittenLinkedAndEmbedded) {
  const std::string what = "--tracks=" + tracks_ + " --cameras=" + cameras_ +
                           " --detections=" + detections_;
  ProgramOutcome outcome = Run(what + " --frames_out=" + Path("new/annotated"));
  EXPECT_THAT(outcome.output, HasSubstr("60 annotated pictures -> "));
  const std::string view = ReadCameras(cameras_)[0].name();
  const std::string folder = Path("new/annotated/") + view;
  const Picture picture = ReadPicture(folder + "/000019.jpg");
  EXPECT_EQ(picture.width, ReadCameras(cameras_)[0].width_px());
  // Grey, and the person's blue (0, 114, 178) within what JPEG does to it.
  int blue = 0;
  for (size_t i = 0; i < picture.rgb.size(); i += 3) {
    blue += picture.rgb[i] < 60 && picture.rgb[i + 2] > 140;
  }
  EXPECT_GT(blue, 100);
  EXPECT_LT(blue, picture.width * picture.height / 4);

  const std::string images = " --images='" + view + "=" + folder + "/%06d.jpg'";
  outcome = Run(what + images);
  EXPECT_THAT(ContentOf(out_),
              HasSubstr("new/annotated/" + view + "/%06d.jpg"));
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("\"jpeg\"")));
  outcome = Run(what + images + " --embed_megabytes=5");
  EXPECT_THAT(outcome.output, HasSubstr("20 pictures inside the page"));
  EXPECT_THAT(ContentOf(out_), HasSubstr("\"jpeg\":[\"/9j/"));
  EXPECT_THAT(ContentOf(out_), Not(HasSubstr("%06d.jpg")));
  const size_t page = ContentOf(out_).size();
  // Little room: smaller ones, of fewer frames, never more than was allowed.
  outcome = Run(what + images + " --embed_megabytes=0.02");
  EXPECT_THAT(outcome.output, HasSubstr("240 px wide, one frame in "));
  EXPECT_LT(ContentOf(out_).size(), page);
}

TEST_F(ReportTest, BadInputIsOneLineAndExitTwo) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "--tracks"},
      {"--tracks=/nowhere.jsonl", "/nowhere.jsonl"},
      {"--tracks=" + tracks_ + "," + tracks_ + "," + tracks_ + "," + tracks_ +
           "," + tracks_ + "," + tracks_ + "," + tracks_,
       "found 7 files, expected one to 6"},
      {"--tracks=" + tracks_ + " --detections=" + detections_,
       "needs --cameras"},
      {"--tracks=" + tracks_ + " --set=cameras.unit=m", "needs --config"},
      {"--tracks=" + tracks_ + " --frames_out=" + Path("x"),
       "--frames_out: needs --cameras and --detections"},
      {"--tracks=" + tracks_ + " --embed_megabytes=3", "needs --images"},
      {"--tracks=" + tracks_ + " --cameras=" + cameras_ +
           " --detections=" + detections_ + " --images=nobody=a%d.jpg",
       "no view 'nobody', expected VIEW=PATTERN or VIEW=VIDEO with one of "},
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
