// What a run says of itself: of sound recordings nothing but figures, of
// recordings that are set up wrongly the cause.
#include "solvers/session/recording_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/limbs.h"
#include "solvers/session/recording_warnings.h"
#include "solvers/session/run.h"
#include "solvers/session/stream_sample.h"
#include "solvers/session/used_frames.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ReportRecording {
  CameraRig cameras;
  DetectionSequence detections;
  RunOptions options;
};

// Two people before four cameras for three seconds, with a detector's errors.
ReportRecording SoundRecording(const Skeleton& skeleton = Coco17(),
                               double missing_rate = 0.03) {
  SceneOptions options;
  options.seed = 5;
  options.people = 2;
  options.duration_s = 3.0;
  options.motion.visitors = 0.0;
  options.cameras.count = 4;
  options.cameras.focal_px = 1000.0;
  const Scene scene = MakeScene(options, skeleton);
  NoiseOptions noise;
  noise.joints.sigma_px = 4.0;
  noise.joints.missing_rate = missing_rate;
  ReportRecording recording;
  recording.cameras = scene.cameras;
  recording.detections = Observe(scene, noise, nullptr);
  recording.options.estimators.mode = Mode::kGraph;
  recording.options.tracker.gates.units = GateUnits::kMetres;
  return recording;
}

RecordingReport ReportOf(const ReportRecording& recording) {
  RunRequest request;
  request.cameras = recording.cameras;
  request.kept_matches = KeptMatches::kDetections;
  Session session(recording.options, request, recording.detections.header);
  RecordingReporter reporter(session.scene(),
                             recording.detections.header.skeleton);
  UsedFrames used(session.scene(), nullptr);
  session.set_frame_listener(
      [&](const DetectionFrame& frame) { used.Feed(frame); });
  MemorySource source(recording.detections);
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    const DetectionFrame* seen = used.At(frame.frame);
    ASSERT_NE(seen, nullptr);
    reporter.See(*seen, frame);
  });
  return reporter.Report();
}

std::vector<std::string> KindsOf(const RecordingReport& report) {
  std::vector<std::string> kinds;
  for (const Finding& warning : report.warnings) {
    kinds.push_back(warning.kind);
  }
  return kinds;
}

std::string TextOf(const RecordingReport& report) {
  std::string text;
  for (const Finding& warning : report.warnings) {
    text += warning.evidence + " | " + warning.fix + "\n";
  }
  return text;
}

TEST(RecordingReport, SoundTakesHaveFiguresAndNoWarnings) {
  for (const Skeleton* skeleton :
       {&Coco17(), &Body25(), &Body25B(), &Halpe26(), &MediaPipe33()}) {
    SCOPED_TRACE(skeleton->name());
    const RecordingReport report = ReportOf(SoundRecording(*skeleton));
    EXPECT_THAT(report.warnings, IsEmpty()) << TextOf(report);
    EXPECT_EQ(report.people.size(), 2u);
    EXPECT_EQ(report.most_people_in_a_view, 2);
    EXPECT_EQ(report.frames, 75);
    // Both coordinates have a standard deviation of 4 px, so that the median
    // distance of the truth is 4 sqrt(2 ln 2) = 4.7 px (Rayleigh); the estimate
    // takes some of the errors along and motion adds some.
    for (const CameraReport& camera : report.cameras) {
      EXPECT_GT(camera.matched_share(), 0.9) << camera.view;
      EXPECT_GT(camera.median_px, 2.5) << camera.view;
      EXPECT_LT(camera.median_px, 7.0) << camera.view;
      EXPECT_GT(camera.p90_px, camera.median_px);
    }
    // Statures are 1.72 m and their standard deviation is 9 cm; limbs' shares
    // are Drillis and Contini's in the synthetic body too, but for the trunk's.
    for (const PersonReport& person : report.people) {
      EXPECT_NEAR(person.height_m, 1.72, 0.3);
    }
  }
}

CameraRig Changed(const CameraRig& cameras, size_t camera_idx,
                  const std::function<void(CameraParameters*)>& change) {
  CameraRig changed;
  for (size_t c = 0; c < cameras.size(); ++c) {
    CameraParameters parameters = cameras[c].parameters();
    if (c == camera_idx || camera_idx >= cameras.size()) change(&parameters);
    changed.emplace_back(parameters);
  }
  return changed;
}
constexpr size_t kAll = 1000;

void ForEachJoint(DetectionSequence* recording, size_t view,
                  const std::function<void(Keypoint*)>& change) {
  for (DetectionFrame& frame : recording->frames) {
    for (Detection& detection : frame.views[view].detections) {
      for (Keypoint& joint : detection.joints) change(&joint);
    }
  }
}

// A view whose frames are `late` frames later than they say.
void Delay(DetectionSequence* recording, size_t view, size_t late) {
  for (size_t f = recording->frames.size(); f-- > late;) {
    recording->frames[f].views[view].detections =
        recording->frames[f - late].views[view].detections;
  }
}

struct WrongSetUp {
  std::string name;
  std::function<void(ReportRecording*)> spoil;
  std::vector<std::string> kinds;  // one of them must be there
  std::string words;               // that must be among the warnings'
};

class WrongSetUps : public ::testing::TestWithParam<WrongSetUp> {};

TEST_P(WrongSetUps, EndInAWarningThatNamesTheCause) {
  ReportRecording recording =
      SoundRecording(GetParam().name == "skeleton" ? Body25B() : Coco17());
  GetParam().spoil(&recording);
  const RecordingReport report = ReportOf(recording);
  const std::vector<std::string> kinds = KindsOf(report);
  bool named = false;
  for (const std::string& kind : GetParam().kinds) {
    named = named || std::count(kinds.begin(), kinds.end(), kind) > 0;
  }
  EXPECT_TRUE(named) << TextOf(report);
  EXPECT_THAT(TextOf(report), HasSubstr(GetParam().words));
}

// Every frame but those between `from` and `to`.
void Drop(ReportRecording* recording, int64_t from, int64_t to) {
  std::vector<DetectionFrame>& frames = recording->detections.frames;
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const DetectionFrame& frame) {
                                return frame.frame > from && frame.frame < to;
                              }),
               frames.end());
}

TEST(RecordingReport, HolesInTheRecordingAreNamed) {
  ReportRecording recording = SoundRecording();
  Drop(&recording, 20,
       29);  // 0.36 s without a frame: within a lost track's life
  EXPECT_THAT(KindsOf(ReportOf(recording)), IsEmpty());
  Drop(&recording, 40, 55);
  const RecordingReport report = ReportOf(recording);
  ASSERT_EQ(KindsOf(report), std::vector<std::string>{"frames"});
  EXPECT_THAT(report.warnings[0].evidence, HasSubstr("1 hole"));
  EXPECT_THAT(report.warnings[0].evidence, HasSubstr("0.6 s"));
}

TEST(RecordingReport, SingleFramesAreNamedUnlessTheOptionsSaySo) {
  ReportRecording recording = SoundRecording();
  for (DetectionFrame& frame : recording.detections.frames) {
    const TimeNs shift = frame.frame * FromSeconds(60.0);
    frame.time += shift;
    for (ViewDetections& view : frame.views) view.capture_time += shift;
  }
  const auto count = [&] {
    const std::vector<std::string> kinds = KindsOf(ReportOf(recording));
    return std::count(kinds.begin(), kinds.end(), "frames");
  };
  EXPECT_EQ(count(), 1);
  recording.options.input.independent_frames = true;
  EXPECT_EQ(count(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    RecordingReport, WrongSetUps,
    ::testing::Values(
        WrongSetUp{"millimetres_as_metres",
                   [](ReportRecording* recording) {
                     recording->cameras =
                         Changed(recording->cameras, kAll,
                                 [](CameraParameters* p) { p->t *= 1000.0; });
                   },
                   {"unit"},
                   "cameras.unit=mm"},
        WrongSetUp{"centimetres_as_metres",
                   [](ReportRecording* recording) {
                     recording->cameras =
                         Changed(recording->cameras, kAll,
                                 [](CameraParameters* p) { p->t *= 100.0; });
                   },
                   {"unit"},
                   "cameras.unit=cm"},
        WrongSetUp{"metres_as_millimetres",
                   [](ReportRecording* recording) {
                     recording->cameras =
                         Changed(recording->cameras, kAll,
                                 [](CameraParameters* p) { p->t *= 0.001; });
                   },
                   {"unit"},
                   "cameras.unit=m\n"},
        WrongSetUp{"skeleton",
                   [](ReportRecording* recording) {
                     recording->detections.header.skeleton = Body25();
                   },
                   {"skeleton"},
                   "detections.skeleton=body25b"},
        WrongSetUp{"exchanged_cameras",
                   [](ReportRecording* recording) {
                     for (DetectionFrame& frame :
                          recording->detections.frames) {
                       std::swap(frame.views[0], frame.views[1]);
                     }
                   },
                   {"swapped_views"},
                   "cameras.map"},
        WrongSetUp{"mirrored_view",
                   [](ReportRecording* recording) {
                     const double width = recording->cameras[1].width_px();
                     ForEachJoint(&recording->detections, 1,
                                  [width](Keypoint* joint) {
                                    joint->px.x() = width - joint->px.x();
                                  });
                   },
                   {"image"},
                   "images were mirrored"},
        WrongSetUp{
            "upside_down_view",
            [](ReportRecording* recording) {
              const Eigen::Vector2d size(recording->cameras[2].width_px(),
                                         recording->cameras[2].height_px());
              ForEachJoint(&recording->detections, 2, [size](Keypoint* joint) {
                joint->px = size - joint->px;
              });
            },
            {"image"},
            "turned by 180 degrees"},
        WrongSetUp{"turned_camera",
                   [](ReportRecording* recording) {
                     recording->cameras = Changed(
                         recording->cameras, 3, [](CameraParameters* p) {
                           const Eigen::Matrix3d turn =
                               Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY())
                                   .toRotationMatrix();
                           p->R = turn * p->R;
                           p->t = turn * p->t;
                         });
                   },
                   {"camera", "matched", "error"},
                   "kinegraph doctor"},
        WrongSetUp{"late_view",
                   [](ReportRecording* recording) {
                     Delay(&recording->detections, 0, 25);
                   },
                   {"clock_offset"},
                   "cameras.refine_clock"},
        WrongSetUp{"another_room",
                   [](ReportRecording* recording) {
                     recording->cameras = Changed(
                         recording->cameras, kAll, [](CameraParameters* p) {
                           // Each camera looks elsewhere.
                           const double angle = 1.0 + 2.0 * p->R(0, 0);
                           p->R =
                               Eigen::AngleAxisd(
                                   angle,
                                   Eigen::Vector3d(1.0, 1.0, 0.0).normalized())
                                   .toRotationMatrix() *
                               p->R;
                         });
                   },
                   {"never_matched", "nobody", "matched"},
                   "another set-up"},
        WrongSetUp{"rate",
                   [](ReportRecording* recording) {
                     recording->detections.header.frame_rate_hz *= 20.0;
                     for (DetectionFrame& frame :
                          recording->detections.frames) {
                       frame.time /= 20;
                       for (ViewDetections& view : frame.views) {
                         view.capture_time /= 20;
                       }
                     }
                   },
                   {"rate"},
                   "input.frame_rate"},
        WrongSetUp{"legs_alone",
                   [](ReportRecording* recording) {
                     constexpr size_t kFirst = 11;  // hips, knees, ankles
                     for (DetectionFrame& frame :
                          recording->detections.frames) {
                       for (ViewDetections& view : frame.views) {
                         for (Detection& one : view.detections) {
                           for (size_t j = 0; j < kFirst; ++j) {
                             one.joints[j].found = false;
                           }
                         }
                       }
                     }
                   },
                   {"joints"},
                   "initialisation.min_joints=4"},
        WrongSetUp{"one_view_with_people",
                   [](ReportRecording* recording) {
                     for (DetectionFrame& frame :
                          recording->detections.frames) {
                       for (size_t v = 1; v < frame.views.size(); ++v) {
                         frame.views[v].detections.clear();
                       }
                     }
                   },
                   {"nobody"},
                   "fewer than two views"}),
    [](const ::testing::TestParamInfo<WrongSetUp>& test) {
      return test.param.name;
    });

// A body without its hands and face is a whole body.
// Of two views with two fifths of the joints missing a third is common: 6 of 17
// on average, where a new person needs 10. People begin late then, if at all.
TEST(RecordingReport, WhoBeginsLateForWantOfJointsIsNamed) {
  const RecordingReport report = ReportOf(SoundRecording(Coco17(), 0.4));
  ASSERT_THAT(KindsOf(report), ::testing::Contains("joints"));
  for (const Finding& warning : report.warnings) {
    if (warning.kind != "joints") continue;
    EXPECT_THAT(warning.fix, HasSubstr("initialisation.min_common_joints"));
  }
}

TEST(RecordingReport, JointsAreThoseThatAssociationCompares) {
  Detection detection;
  detection.joints.resize(WholeBody133().joints().size());
  for (size_t j = 0; j < 17; ++j) detection.joints[j].found = true;
  EXPECT_DOUBLE_EQ(JointsOf17(detection, WholeBody133()), 17.0);
  for (size_t j = 0; j < 11; ++j) detection.joints[j].found = false;
  EXPECT_DOUBLE_EQ(JointsOf17(detection, WholeBody133()), 6.0);
}

TEST(RecordingReport, FewerJointsWhereDetectionsShowFew) {
  EXPECT_EQ(FewerJoints(17.0, 10.0), std::nullopt);
  EXPECT_EQ(FewerJoints(12.5, 10.0), std::nullopt);
  EXPECT_EQ(FewerJoints(12.0, 10.0), 6);
  EXPECT_EQ(FewerJoints(6.0, 10.0), 4);
  EXPECT_EQ(FewerJoints(6.0, 4.0), std::nullopt);   // asked for already
  EXPECT_EQ(FewerJoints(0.0, 10.0), std::nullopt);  // nobody was seen
}

TEST(RecordingReport, FasterGatesForThoseWhoRun) {
  EXPECT_EQ(FasterGate(1.4, 6.2), std::nullopt);  // walks, at 30 Hz
  EXPECT_EQ(FasterGate(4.9, 6.2), std::nullopt);
  EXPECT_EQ(FasterGate(6.2, 6.2), 9.0);
  EXPECT_EQ(FasterGate(6.2, 12.6), std::nullopt);  // with the gate asked for
  EXPECT_EQ(FasterGate(9.0, 6.2), std::nullopt);   // nobody: a wrong rate
  EXPECT_EQ(FasterGate(6.2, 0.0), std::nullopt);   // gates in pixels
}

TEST(RecordingReport, UnitsFollowFromHeights) {
  EXPECT_EQ(UnitsThatFit(1720.0, 1.0, 2.3), "--set=cameras.unit=mm");
  EXPECT_EQ(UnitsThatFit(172.0, 1.0, 2.3), "--set=cameras.unit=cm");
  EXPECT_EQ(UnitsThatFit(0.00172, 1.0, 2.3), "--set=cameras.unit=m");
  EXPECT_EQ(UnitsThatFit(0.0172, 1.0, 2.3), "--set=cameras.unit=m");
  EXPECT_EQ(UnitsThatFit(6.0, 1.0, 2.3), "");
  // The distance of a mouse's cameras in mm: all that may be are named.
  EXPECT_EQ(UnitsThatFit(333.0, 0.005, 150.0),
            "--set=cameras.unit=cm or --set=cameras.unit=mm");
}

// A fly 12 mm from its cameras, and a mouse as long as it likes.
TEST(RecordingReport, NoUnitIsToldByWhatIsNoHuman) {
  RecordingFacts facts;
  for (const bool is_human : {true, false}) {
    facts.is_human = is_human;
    RecordingReport report;
    report.working_distance_m = 0.012;
    AddWarnings(facts, &report);
    EXPECT_EQ(KindsOf(report).front() == "unit", is_human);
  }
  std::vector<std::string> joints = Coco17().joints();
  joints.push_back("tail_base");
  const Pose3d pose(joints.size(),
                    {Eigen::Vector3d::UnitZ(), JointStatus::kObserved});
  const Limbs mouse(Skeleton("mouse", joints, {}));
  EXPECT_FALSE(mouse.MiddleOfHips(pose).has_value());
  EXPECT_TRUE(Limbs(Coco17()).MiddleOfHips(pose).has_value());
}

TEST(RecordingReport, TypicalHeightWeighsByFrames) {
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

TEST(StreamSample, IsFairAndBounded) {
  StreamSample sample(512);
  for (int i = 0; i < 100000; ++i) sample.Add(i % 1000);
  EXPECT_EQ(sample.count(), 100000);
  // The median of 512 of them lies within 4 sigma, 4 * 1000 / (2 sqrt(512)).
  EXPECT_NEAR(sample.Quantile(0.5), 500.0, 89.0);
  EXPECT_EQ(StreamSample().Quantile(0.5), 0.0);
}

TEST(UsedFrames, ReadAgainAndFedGiveTheSameFrames) {
  const ReportRecording recording = SoundRecording();
  RunRequest request;
  request.cameras = recording.cameras;
  const RunScene scene =
      PrepareScene(recording.options, request, recording.detections.header);
  UsedFrames fed(scene, nullptr);
  UsedFrames again(scene, [&] {
    return std::make_unique<MemorySource>(recording.detections);
  });
  for (const DetectionFrame& frame : recording.detections.frames)
    fed.Feed(frame);
  for (const int64_t frame : {3, 4, 40}) {
    const DetectionFrame* a = fed.At(frame);
    const DetectionFrame* b = again.At(frame);
    ASSERT_NE(a, nullptr);
    ASSERT_NE(b, nullptr);
    EXPECT_EQ(a->frame, frame);
    EXPECT_EQ(b->frame, frame);
    EXPECT_EQ(a->views[0].detections.size(), b->views[0].detections.size());
  }
  EXPECT_EQ(fed.At(5000), nullptr);
  EXPECT_EQ(again.At(5000), nullptr);
}

}  // namespace
}  // namespace kinegraph
