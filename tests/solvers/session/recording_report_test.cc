// Tests a run's report: faultless recordings give no warnings, and wrong
// set-ups are reported with their cause.
#include "solvers/session/recording_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "solvers/scene/plausible.h"
#include "solvers/session/recording_warnings.h"
#include "solvers/session/subject_gauge.h"
#include "tests/solvers/session/recordings.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::KindsOf;
using testing::Recording;

// Two people in view of four cameras for three seconds, with a detector's
// errors.
Recording FaultlessRecording(const Skeleton& skeleton = Coco17(),
                             double missing_rate = 0.03) {
  SceneOptions options = testing::Staying(5, 2, 4, 3.0);
  options.cameras.focal_px = 1000.0;
  NoiseOptions noise;
  noise.joints.sigma_px = 4.0;
  noise.joints.missing_rate = missing_rate;
  return testing::Record(MakeScene(options, skeleton), noise);
}

RecordingReport ReportOf(const Recording& recording,
                         bool independent_frames = false) {
  RunOptions options = testing::GraphMode();
  options.tracker.gates.units = GateUnits::kMetres;
  options.input.independent_frames = independent_frames;
  return testing::ReportOf(recording, options);
}

std::string TextOf(const RecordingReport& report) {
  std::string text;
  for (const Finding& warning : report.warnings) {
    text += warning.evidence + " | " + warning.fix + "\n";
  }
  return text;
}

TEST(RecordingReport, FaultlessRecordingsHaveStatisticsAndNoWarnings) {
  for (const Skeleton* skeleton :
       {&Coco17(), &Body25(), &Body25B(), &Halpe26(), &MediaPipe33()}) {
    SCOPED_TRACE(skeleton->name());
    const RecordingReport report = ReportOf(FaultlessRecording(*skeleton));
    EXPECT_THAT(report.warnings, IsEmpty()) << TextOf(report);
    EXPECT_EQ(report.people.size(), 2u);
    EXPECT_EQ(report.most_people_in_a_view, 2);
    EXPECT_EQ(report.frames, 75);
    // Both coordinates have a standard deviation of 4 px, so the median
    // distance from the truth is 4 sqrt(2 ln 2) = 4.7 px (Rayleigh); the
    // estimate follows some of the errors, and motion adds others.
    for (const CameraReport& camera : report.cameras) {
      EXPECT_GT(camera.matched_share(), 0.9) << camera.view;
      EXPECT_GT(camera.median_px, 2.5) << camera.view;
      EXPECT_LT(camera.median_px, 7.0) << camera.view;
      EXPECT_GT(camera.p90_px, camera.median_px);
    }
    // Statures have a mean of 1.72 m and a standard deviation of 9 cm, three of
    // which are tolerated; the synthetic body has the segment lengths of
    // Drillis and Contini, as the report assumes, except for the trunk.
    for (const PersonReport& person : report.people) {
      EXPECT_NEAR(person.height_m, 1.72, 0.3);
    }
  }
}

// A skeleton of two points is reported like one of 17 joints.
TEST(RecordingReport, SkeletonsWithTwoPointsAreCounted) {
  Recording recording = FaultlessRecording();
  recording.detections.header.skeleton = Skeleton("box", {"top", "bottom"}, {});
  for (DetectionFrame& frame : recording.frames()) {
    for (ViewDetections& view : frame.views) {
      for (Detection& one : view.detections) {
        one.joints = {one.joints[0], one.joints[15]};
      }
    }
  }
  const RecordingReport report = ReportOf(recording);
  EXPECT_EQ(report.most_people_in_a_view, 2);
  EXPECT_GT(report.poses, 0);
  for (const CameraReport& camera : report.cameras) {
    EXPECT_GT(camera.matched_share(), 0.8) << camera.view;
  }
  EXPECT_THAT(KindsOf(report.warnings),
              ::testing::Not(::testing::Contains("nobody")));
}

// 2 of 15 are hardly any; 1 of 8 may be due to chance.
TEST(RecordingReport, HardlyAnyMatchesDependOnShareAndCount) {
  EXPECT_TRUE(HardlyAny(2, 15));
  EXPECT_TRUE(HardlyAny(4, 20));
  EXPECT_TRUE(HardlyAny(1000, 10000));
  EXPECT_FALSE(HardlyAny(1, 8));
  EXPECT_FALSE(HardlyAny(0, 0));
  EXPECT_FALSE(HardlyAny(3, 12));
  EXPECT_FALSE(HardlyAny(5, 20));
}

// Removes the frames between `from` and `to`, both exclusive.
void Drop(Recording* recording, int64_t from, int64_t to) {
  std::vector<DetectionFrame>& frames = recording->frames();
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const DetectionFrame& frame) {
                                return frame.frame > from && frame.frame < to;
                              }),
               frames.end());
}

TEST(RecordingReport, GapsInTheRecordingAreReported) {
  Recording recording = FaultlessRecording();
  // 0.36 s from frame to frame, shorter than kHole.
  Drop(&recording, 20, 29);
  EXPECT_THAT(KindsOf(ReportOf(recording).warnings), IsEmpty());
  Drop(&recording, 40, 55);
  const RecordingReport report = ReportOf(recording);
  ASSERT_EQ(KindsOf(report.warnings), std::vector<std::string>{"frames"});
  EXPECT_THAT(report.warnings[0].evidence, HasSubstr("1 gap"));
  EXPECT_THAT(report.warnings[0].evidence, HasSubstr("0.6 s"));
}

TEST(RecordingReport, UnrelatedFramesAreReportedUnlessConfigured) {
  Recording recording = FaultlessRecording();
  for (DetectionFrame& frame : recording.detections.frames) {
    const TimeNs shift = frame.frame * FromSeconds(60.0);
    frame.time += shift;
    for (ViewDetections& view : frame.views) view.capture_time += shift;
  }
  for (const bool independent : {false, true}) {
    const auto kinds = KindsOf(ReportOf(recording, independent).warnings);
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), "frame_rate"),
              independent ? 0 : 1);
    EXPECT_THAT(kinds, ::testing::Not(::testing::Contains("frames")));
  }
}

using Spoil = std::function<void(Recording*)>;

constexpr size_t kAll = 1000;  // instead of an index: every camera
Spoil ChangeCamera(size_t camera_idx,
                   const std::function<void(CameraParameters*)>& change) {
  return [=](Recording* recording) {
    CameraRig& cameras = recording->request.cameras;
    for (size_t c = 0; c < cameras.size(); ++c) {
      if (c != camera_idx && camera_idx != kAll) continue;
      cameras[c] = Edited(cameras[c], change);
    }
  };
}

Spoil Scale(double factor) {
  return ChangeCamera(kAll, [=](CameraParameters* p) { p->t *= factor; });
}

Spoil Frames(const std::function<void(DetectionFrame*)>& change) {
  return [=](Recording* recording) {
    for (DetectionFrame& frame : recording->frames()) change(&frame);
  };
}

void Turn(double angle_rad, const Eigen::Vector3d& axis, CameraParameters* p) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  p->R = turn * p->R;
  p->t = turn * p->t;
}

struct WrongSetUp {
  std::string name;
  Spoil spoil;
  std::vector<std::string> kinds;  // at least one is required
  std::string words;               // required in the warnings
};

std::vector<WrongSetUp> WrongOnes() {
  return {{"millimetres_as_metres", Scale(1000.0), {"unit"}, "cameras.unit=mm"},
          {"metres_as_millimetres", Scale(0.001), {"unit"}, "cameras.unit=m\n"},
          {"skeleton",
           [](Recording* recording) {
             recording->detections.header.skeleton = Body25();
           },
           {"skeleton"},
           "detections.skeleton=body25b"},
          {"exchanged_cameras",
           Frames([](DetectionFrame* frame) {
             std::swap(frame->views[0], frame->views[1]);
           }),
           {"swapped_views"},
           "cameras.map"},
          {"turned_camera",
           ChangeCamera(3,
                        [](CameraParameters* p) {
                          Turn(0.15, Eigen::Vector3d::UnitY(), p);
                        }),
           {"camera", "matched", "error"},
           "kinegraph doctor"},
          {"late_view",
           [](Recording* recording) {  // by a second
             auto& frames = recording->frames();
             for (size_t f = frames.size(); f-- > 25;) {
               frames[f].views[0].detections =
                   frames[f - 25].views[0].detections;
             }
           },
           {"clock_offset"},
           "cameras.refine_clock"},
          {"another_room",
           // Every camera is rotated, each by another angle.
           ChangeCamera(kAll,
                        [](CameraParameters* p) {
                          const Eigen::Vector3d before = p->t;
                          Turn(1.0 + 2.0 * p->R(0, 0), {1.0, 1.0, 0.0}, p);
                          p->t = before;
                        }),
           {"never_matched", "nobody", "matched"},
           "another set-up"},
          {"rate",
           [](Recording* recording) {
             recording->detections.header.frame_rate_hz *= 20.0;
             Frames([](DetectionFrame* frame) {
               frame->time /= 20;
               for (ViewDetections& view : frame->views) {
                 view.capture_time /= 20;
               }
             })(recording);
           },
           {"rate"},
           "input.frame_rate"},
          {"legs_alone",
           Frames([](DetectionFrame* frame) {
             constexpr size_t kFirst = 11;  // hips, knees, ankles
             for (ViewDetections& view : frame->views) {
               for (Detection& one : view.detections) {
                 for (size_t j = 0; j < kFirst; ++j) {
                   one.joints[j].found = false;
                 }
               }
             }
           }),
           {"joints"},
           "initialisation.min_joints=4"},
          {"one_view_with_people",
           Frames([](DetectionFrame* frame) {
             for (size_t v = 1; v < frame->views.size(); ++v) {
               frame->views[v].detections.clear();
             }
           }),
           {"nobody"},
           "fewer than two views"}};
}

class WrongSetUps : public ::testing::TestWithParam<WrongSetUp> {};

TEST_P(WrongSetUps, ReportTheCauseInAWarning) {
  Recording recording =
      FaultlessRecording(GetParam().name == "skeleton" ? Body25B() : Coco17());
  GetParam().spoil(&recording);
  const RecordingReport report = ReportOf(recording);
  EXPECT_THAT(KindsOf(report.warnings),
              ::testing::Contains(::testing::AnyOfArray(GetParam().kinds)))
      << TextOf(report);
  EXPECT_THAT(TextOf(report), HasSubstr(GetParam().words));
}

INSTANTIATE_TEST_SUITE_P(RecordingReport, WrongSetUps,
                         ::testing::ValuesIn(WrongOnes()),
                         [](const auto& test) { return test.param.name; });

TEST(RecordingReport, TooFewFramesForATrackAreReported) {
  Recording recording = FaultlessRecording();
  recording.frames().resize(2);
  const RecordingReport report = ReportOf(recording);
  ASSERT_EQ(report.poses, 0);
  EXPECT_THAT(TextOf(report), HasSubstr("2 frames are too few"));
  EXPECT_THAT(TextOf(report), HasSubstr("input.independent_frames=true"));
  EXPECT_THAT(TextOf(report),
              ::testing::Not(HasSubstr("fewer than two views")));
  recording.frames().resize(1);
  EXPECT_THAT(TextOf(ReportOf(recording)), HasSubstr("1 frame is too few"));
  EXPECT_GT(ReportOf(recording, true).poses, 0);
}

// Three views lose every second image, so that their frames count at half the
// rate of the second view. Sanitized builds also check that the times of the
// second view's frames are finite.
TEST(RecordingReport, ViewOfAnotherRateIsReported) {
  testing::FaultySceneOptions options = {21, 4, 2, 5.0};
  options.frame_rate_hz = 30.0;
  const testing::FaultyScene scene = testing::MakeFaultyScene(options);
  Recording recording;
  recording.request.cameras = scene.cameras;
  recording.detections = scene.detections;
  recording.detections.header.frame_rate_hz = 15.0;
  const std::vector<DetectionFrame>& seen = scene.detections.frames;
  for (size_t k = 0; k < seen.size(); ++k) {
    DetectionFrame& frame = recording.frames()[k];
    frame.time = 2 * seen[k].time;
    for (size_t v = 0; v < 4; ++v) {
      frame.views[v].capture_time = frame.time;
      if (v == 1) continue;
      frame.views[v].detections.clear();
      if (2 * k >= seen.size()) continue;
      frame.views[v].detections = seen[2 * k].views[v].detections;
    }
  }
  const RecordingReport report = ReportOf(recording);
  EXPECT_THAT(KindsOf(report.warnings), ::testing::Contains("view_rate"));
  EXPECT_THAT(TextOf(report), HasSubstr("input.view_frame_rate"));
}

// A run refuses to refine clocks that the calibration already contains.
TEST(RecordingReport, RecordedClocksAreNotToBeRefined) {
  for (const WrongSetUp& one : WrongOnes()) {
    if (one.name != "late_view") continue;
    Recording recording = FaultlessRecording();
    one.spoil(&recording);
    const RecordingReport report =
        testing::ReportOf(recording, testing::GraphMode(), true);
    EXPECT_THAT(KindsOf(report.warnings), ::testing::Contains("clock_offset"));
    EXPECT_THAT(TextOf(report), ::testing::Not(HasSubstr("refine_clock")));
  }
}

// If each of two views misses two fifths of the joints, about a third are found
// in both: 6 of 17 on average, but a new track requires 10. Tracks then start
// late, if at all.
TEST(RecordingReport, TooFewJointsForNewTracksAreReported) {
  const RecordingReport report = ReportOf(FaultlessRecording(Coco17(), 0.4));
  EXPECT_THAT(KindsOf(report.warnings), ::testing::Contains("joints"));
  EXPECT_THAT(TextOf(report), HasSubstr("initialisation.min_common_joints"));
}

TEST(RecordingReport, JointsOf17CountsAssociationJoints) {
  Detection detection;
  detection.joints.resize(WholeBody133().joints().size());
  for (size_t j = 0; j < 17; ++j) detection.joints[j].found = true;
  EXPECT_DOUBLE_EQ(JointsOf17(detection, WholeBody133()), 17.0);
  for (size_t j = 0; j < 11; ++j) detection.joints[j].found = false;
  EXPECT_DOUBLE_EQ(JointsOf17(detection, WholeBody133()), 6.0);
}

TEST(RecordingReport, RecommendationsMatchStatistics) {
  EXPECT_EQ(FewerJoints(17.0, 10.0), std::nullopt);
  EXPECT_EQ(FewerJoints(12.5, 10.0), std::nullopt);
  EXPECT_EQ(FewerJoints(12.0, 10.0), 6);
  EXPECT_EQ(FewerJoints(6.0, 10.0), 4);
  EXPECT_EQ(FewerJoints(6.0, 4.0), std::nullopt);   // already as low as 4
  EXPECT_EQ(FewerJoints(0.0, 10.0), std::nullopt);  // nothing detected

  EXPECT_EQ(FasterGate(1.4, 6.2), std::nullopt);  // walking, at 30 Hz
  EXPECT_EQ(FasterGate(4.9, 6.2), std::nullopt);
  EXPECT_EQ(FasterGate(6.2, 6.2), 9.0);
  EXPECT_EQ(FasterGate(6.2, 12.6), std::nullopt);  // with the recommended gate
  EXPECT_EQ(FasterGate(13.0, 6.2), std::nullopt);  // implausible: a wrong rate
  EXPECT_EQ(FasterGate(6.2, 0.0), std::nullopt);   // gates in pixels

  EXPECT_EQ(UnitsThatFit(1720.0, 1.0, 2.3), "--set=cameras.unit=mm");
  EXPECT_EQ(UnitsThatFit(172.0, 1.0, 2.3), "--set=cameras.unit=cm");
  EXPECT_EQ(UnitsThatFit(0.00172, 1.0, 2.3), "--set=cameras.unit=m");
  EXPECT_EQ(UnitsThatFit(0.0172, 1.0, 2.3), "--set=cameras.unit=m");
  EXPECT_EQ(UnitsThatFit(6.0, 1.0, 2.3), "");
  // The distances of a mouse's cameras in mm: all possible units are listed.
  EXPECT_EQ(UnitsThatFit(333.0, 0.005, 150.0),
            "--set=cameras.unit=cm or --set=cameras.unit=mm");
}

// A fly may be 12 mm from its cameras. A skeleton with a tail is not human, so
// no stature is measured from its limbs.
TEST(RecordingReport, NonHumanSubjectsDoNotDetermineTheUnit) {
  for (const bool is_human : {true, false}) {
    RecordingReport report;
    report.is_human = is_human;
    report.working_distance_m = 0.012;
    AddWarnings(RecordingFacts(), Diagnosis(), &report);
    EXPECT_EQ(KindsOf(report.warnings).front() == "unit", is_human);
  }
  std::vector<std::string> joints = Coco17().joints();
  joints.push_back("tail_base");
  const Pose3d pose(joints.size(),
                    {Eigen::Vector3d::UnitZ(), JointStatus::kObserved});
  const Limbs mouse(Skeleton("mouse", joints, {}));
  EXPECT_FALSE(mouse.MiddleOfHips(pose).has_value());
  EXPECT_TRUE(Limbs(Coco17()).MiddleOfHips(pose).has_value());
}

TEST(RecordingReport, TypicalHeightIsWeightedByFrames) {
  PersonReport passing;
  passing.height_m = 5.0;
  passing.frames = 3;
  PersonReport staying;
  staying.height_m = 1.7;
  staying.frames = 100;
  PersonReport unknown;
  unknown.frames = 1000;
  EXPECT_EQ(TypicalHeight({passing, unknown, staying}), 1.7);
  EXPECT_EQ(TypicalHeight({unknown}), 0.0);
}

TEST(UsedFrames, RereadAndFedFramesAreEqual) {
  const Recording recording = FaultlessRecording();
  const RunScene scene = PrepareScene(testing::GraphMode(), recording.request,
                                      recording.detections.header);
  UsedFrames fed(scene, nullptr);
  UsedFrames again(scene, [&] {
    return std::make_unique<MemorySource>(recording.detections);
  });
  for (const DetectionFrame& frame : recording.detections.frames)
    fed.Feed(frame);
  for (const int64_t frame : {3, 4, 40}) {
    for (UsedFrames* frames : {&fed, &again}) {
      const DetectionFrame* at = frames->At(frame);
      ASSERT_NE(at, nullptr);
      EXPECT_EQ(at->frame, frame);
      EXPECT_EQ(at->views[0].detections.size(),
                recording.detections.frames[frame].views[0].detections.size());
    }
  }
  EXPECT_EQ(fed.At(5000), nullptr);
  EXPECT_EQ(again.At(5000), nullptr);
}

}  // namespace
}  // namespace kinegraph
