// Tests that cameras scaled by a factor give poses scaled by this factor.
#include "solvers/session/subject_scale.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "solvers/session/diagnose.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/subject_gauge.h"
#include "tests/solvers/session/recordings.h"

namespace kinegraph {
namespace {

using testing::Recording;

constexpr double kStature_m = 1.72;  // mean of synthetic people

// Two people in view of four cameras for three seconds, with a detector's
// errors.
Recording HumanRecording() {
  NoiseOptions noise;
  noise.joints.sigma_px = 3.0;
  noise.joints.missing_rate = 0.03;
  return testing::Record(MakeScene(testing::Staying(5, 2, 4, 3.0), Coco17()),
                         noise);
}

// The same motion with the joints of an animal.
Recording AnimalRecording() {
  Recording recording = HumanRecording();
  std::vector<std::string> joints = Coco17().joints();
  for (std::string& joint : joints) joint = "paw_" + joint;
  recording.detections.header.skeleton =
      Skeleton("animal", joints, Coco17().bones());
  return recording;
}

// The recording in a world scaled by a factor.
Recording Larger(Recording recording, double factor) {
  recording.request.cameras = Rescaled(recording.request.cameras, factor);
  return recording;
}

// The camera, rotated by 1.7 degrees about its centre.
Camera TurnedInPlace(const Camera& camera) {
  const Eigen::AngleAxisd turn(0.03, Eigen::Vector3d::UnitY());
  return Edited(camera, [&](CameraParameters* turned) {
    turned->R = turn * turned->R;
    turned->t = turn * turned->t;
  });
}

RunOptions OptionsOf(const std::string& set, const std::string& mode) {
  return ParseRunOptions(
      "[gates]\nunits = \"metres\"\n[output]\nestimator = \"batch\"\n"
      "[tracking]\nsecond_pass = true\n[identity]\nlink = true\n",
      set, mode);
}

TrackSequence TrackAt(double factor, const Recording& recording,
                      const std::string& set = "",
                      const std::string& mode = "graph") {
  return testing::Track(Larger(recording, factor), OptionsOf(set, mode));
}

// Largest distance between corresponding joints and between their standard
// deviations, in the scale of `world` [m]; infinite if the number of frames,
// the people or the statuses of joints differ.
double Apart(const TrackSequence& world, const TrackSequence& larger,
             double factor) {
  double apart = world.frames.size() == larger.frames.size() ? 0.0 : INFINITY;
  for (size_t f = 0; apart < INFINITY && f < world.frames.size(); ++f) {
    const auto& people = world.frames[f].people;
    const auto& others = larger.frames[f].people;
    if (people.size() != others.size()) return INFINITY;
    for (size_t p = 0; p < people.size(); ++p) {
      if (people[p].id != others[p].id) return INFINITY;
      for (size_t j = 0; j < people[p].joints.size(); ++j) {
        const Joint3d& joint = people[p].joints[j];
        const Joint3d& other = others[p].joints[j];
        if (joint.status != other.status) return INFINITY;
        if (!joint.present()) continue;
        apart = std::max(apart,
                         (joint.position_m - other.position_m / factor).norm());
        if (people[p].covariances.empty() ||
            !people[p].covariances[j].has_value()) {
          continue;
        }
        const double sigma_m = std::sqrt(people[p].covariances[j]->trace());
        const double other_m = std::sqrt(others[p].covariances[j]->trace());
        apart = std::max(apart, std::abs(sigma_m - other_m / factor));
      }
    }
  }
  return apart;
}

class AnyScale : public ::testing::TestWithParam<double> {};

// The scale is measured in each world, so only rounding errors differ; they are
// amplified by the solver's stopping criterion of 0.03 mm and by a few
// decisions.
TEST_P(AnyScale, AnimalTracksScale) {
  const Recording recording = AnimalRecording();
  for (const char* mode : {"graph", "paper"}) {
    const TrackSequence world = TrackAt(1.0, recording, "", mode);
    ASSERT_EQ(world.frames.size(), recording.detections.frames.size());
    EXPECT_LT(
        Apart(world, TrackAt(GetParam(), recording, "", mode), GetParam()),
        1e-4)
        << mode;
  }
}

TEST_P(AnyScale, WindowTracksScale) {
  const Recording recording = AnimalRecording();
  const std::string set =
      "output.estimator=window;tracking.second_pass=false;identity.link=false";
  EXPECT_LT(Apart(TrackAt(1.0, recording, set),
                  TrackAt(GetParam(), recording, set), GetParam()),
            1e-4);
}

// At scale 1 people keep their size; at the other scales they are normalised to
// 1.7 m. Priors then differ by the ratio of the stature to 1.7 m, and joints by
// less than a hundredth of the stature.
TEST_P(AnyScale, HumanTracksScale) {
  const Recording recording = HumanRecording();
  EXPECT_LT(Apart(TrackAt(1.0, recording), TrackAt(GetParam(), recording),
                  GetParam()),
            0.01 * kStature_m);
}

TEST_P(AnyScale, RefinedCamerasAndFloorScale) {
  Recording recording = HumanRecording();
  recording.request.cameras[1] = TurnedInPlace(recording.request.cameras[1]);
  const auto ready = [&](double factor) {
    const Recording scaled = Larger(recording, factor);
    return MakeRecordingReady(
        OptionsOf("cameras.refine=pose;cameras.ground=feet", "graph"),
        scaled.request, std::nullopt, [&] { return recording.detections; });
  };
  const ReadyRecording world = ready(1.0);
  const ReadyRecording larger = ready(GetParam());
  ASSERT_TRUE(world.ground.has_value());
  ASSERT_TRUE(larger.ground.has_value());
  ASSERT_TRUE(world.refinement->any_taken());
  ASSERT_TRUE(larger.refinement->any_taken());
  // The standard deviation of a camera position is a few millimetres.
  constexpr double kTolerance_m = 5e-3;
  EXPECT_NEAR(larger.ground->spread_m / GetParam(), world.ground->spread_m,
              kTolerance_m);
  for (size_t v = 0; v < world.cameras.size(); ++v) {
    EXPECT_LT(
        (larger.cameras[v].centre() / GetParam() - world.cameras[v].centre())
            .norm(),
        kTolerance_m);
  }
}

TEST_P(AnyScale, FrozenMatchesAreTheSame) {
  const Recording recording = AnimalRecording();
  const auto frozen = [&](double factor) {
    const Recording scaled = Larger(recording, factor);
    return FreezeTracking(OptionsOf("", "graph"), scaled.request,
                          scaled.detections);
  };
  const FrozenRun world = frozen(1.0);
  const FrozenRun larger = frozen(GetParam());
  EXPECT_EQ(larger.matches.people.size(), world.matches.people.size());
  EXPECT_NEAR(larger.scale.metres() / world.scale.metres(), GetParam(),
              1e-9 * GetParam());
  for (size_t v = 0; v < recording.request.cameras.size(); ++v) {
    EXPECT_LT((larger.scene.model.cameras[v].centre() -
               world.scene.model.cameras[v].centre())
                  .norm(),
              1e-9);
  }
}

std::vector<std::string> WarningsAt(double factor, const Recording& recording) {
  return testing::KindsOf(
      testing::ReportOf(Larger(recording, factor), OptionsOf("", "graph"))
          .warnings);
}

TEST_P(AnyScale, FindingsAreTheSame) {
  Recording recording = AnimalRecording();
  EXPECT_EQ(WarningsAt(GetParam(), recording), WarningsAt(1.0, recording));
  recording.request.cameras[0] = TurnedInPlace(recording.request.cameras[0]);
  const std::vector<std::string> kinds = WarningsAt(1.0, recording);
  EXPECT_EQ(WarningsAt(GetParam(), recording), kinds);
  const auto diagnosed = [&](double factor) {
    const Recording scaled = Larger(recording, factor);
    std::vector<std::string> found;
    for (const Finding& finding :
         DiagnoseRecording(OptionsOf("", "graph"), scaled.request,
                           scaled.detections, {})
             .findings) {
      found.push_back(finding.kind + " " + finding.camera);
    }
    return found;
  };
  EXPECT_EQ(diagnosed(GetParam()), diagnosed(1.0));
}

INSTANTIATE_TEST_SUITE_P(Of, AnyScale, ::testing::Values(0.002, 0.05, 20.0));

SubjectScale Measured(const Recording& recording, double factor,
                      const std::string& set = "") {
  return ScaleOf(OptionsOf(set, "graph"),
                 Larger(recording, factor).request.cameras,
                 recording.detections);
}

TEST(SubjectScale, IsOneForPlausibleStaturesOnly) {
  const Recording recording = HumanRecording();
  for (const double factor : {0.35, 0.6, 1.0, 1.25}) {
    EXPECT_TRUE(Measured(recording, factor).is_one()) << factor;
  }
  for (const double factor : {0.002, 0.1, 3.0, 1000.0}) {
    // Limbs determine the stature to a few centimetres, with occluded joints to
    // 10 cm.
    EXPECT_NEAR(Measured(recording, factor).size_m() / factor, kStature_m, 0.15)
        << factor;
  }
}

TEST(SubjectScale, ConfiguredSizeIsNotMeasured) {
  const Recording recording = AnimalRecording();
  EXPECT_DOUBLE_EQ(Measured(recording, 1.0, "cameras.subject_m=0.34").metres(),
                   0.2);
  // A plausible stature of people leaves the scale 1.
  EXPECT_TRUE(
      Measured(HumanRecording(), 1.0, "cameras.subject_m=1.1").is_one());
}

// Points that are not part of the animal: three points of a lure, all at one
// place 9 m above the floor.
TEST(SubjectScale, PointsFarFromTheBodyHardlyMatter) {
  const Recording animal = AnimalRecording();
  Recording with_lure = animal;
  std::vector<std::string> joints = animal.detections.header.skeleton.joints();
  for (size_t i = 0; i < 3; ++i) joints.push_back("lure" + std::to_string(i));
  with_lure.detections.header.skeleton =
      Skeleton("animal", joints, Coco17().bones());
  for (DetectionFrame& frame : with_lure.detections.frames) {
    for (size_t v = 0; v < frame.views.size(); ++v) {
      const auto px = animal.request.cameras[v].Project({0.0, 0.0, 9.0});
      for (Detection& one : frame.views[v].detections) {
        Keypoint lure;
        if (px.has_value()) lure = {*px, 0.9, true};
        one.joints.resize(joints.size(), lure);
      }
    }
  }
  // Three of the nineteen other joints are farther away, so a joint's median
  // distance is the 0.59 quantile of the distances within the body.
  const double size_m = Measured(animal, 1.0).size_m();
  EXPECT_NEAR(size_m, kStature_m, 0.3);
  EXPECT_NEAR(Measured(with_lure, 1.0).size_m(), size_m, 0.25 * size_m);
}

// The size of a box with two points is their distance.
TEST(SubjectScale, SizeOfTwoPointsIsTheDistance) {
  Recording recording = AnimalRecording();
  const int head = Coco17().IndexOf("nose");
  const int foot = Coco17().IndexOf("l_ankle");
  recording.detections.header.skeleton = Skeleton("box", {"top", "bottom"}, {});
  for (DetectionFrame& frame : recording.detections.frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& one : view.detections) {
        one.joints = {one.joints[static_cast<size_t>(head)],
                      one.joints[static_cast<size_t>(foot)]};
      }
    }
  }
  // The distance from ankle to nose is about nine tenths of the stature (0.88
  // in upright standing), which has a standard deviation of 9 cm over people.
  EXPECT_NEAR(Measured(recording, 1.0).size_m(), 0.9 * kStature_m, 0.1);
}

TEST(SubjectScale, APointHasNoSize) {
  Recording recording = AnimalRecording();
  recording.detections.header.skeleton = Skeleton("drone", {"drone"}, {});
  for (DetectionFrame& frame : recording.detections.frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& one : view.detections) one.joints.resize(1);
    }
  }
  EXPECT_TRUE(Measured(recording, 0.1).is_one());
  EXPECT_DOUBLE_EQ(Measured(recording, 0.1, "cameras.subject_m=0.17").metres(),
                   0.1);
}

// Streams of people start without delay. Other subjects wait for the
// measurement of their size, and no frames are lost.
TEST(SubjectScale, StreamsOfNonHumansWaitForTheSize) {
  const RunOptions options = ParseRunOptions("mode = \"paper\"\n", "", "");
  for (const bool is_human : {true, false}) {
    const Recording recording =
        is_human ? HumanRecording() : Larger(AnimalRecording(), 0.01);
    Session session(options, recording.request, recording.detections.header);
    size_t written = 0;
    size_t waited = 0;
    for (const DetectionFrame& frame : recording.detections.frames) {
      const size_t now = session.Process(frame).size();
      if (is_human) {
        EXPECT_EQ(now, 1U);
      }
      waited += written + now == 0 ? 1 : 0;
      written += now;
    }
    EXPECT_EQ(waited > 0, !is_human);
    EXPECT_LT(waited, 12U);  // ten measured frames suffice
    written += session.Finish().size();
    EXPECT_EQ(written, recording.detections.frames.size());
  }
}

// An unmeasurable detection in two views, then 16 s without any: frames do not
// wait for the end of the stream, and a subject that comes later is measured
// unless it is a person.
TEST(SubjectScale, StreamsWaitTenSecondsForTheSize) {
  const RunOptions options = ParseRunOptions("mode = \"paper\"\n", "", "");
  constexpr int64_t kEmpty = 400;
  for (const bool is_human : {true, false}) {
    const Recording recording =
        is_human ? HumanRecording() : Larger(AnimalRecording(), 0.01);
    const DetectionFrame& first = recording.detections.frames.front();
    Session session(options, recording.request, recording.detections.header);
    size_t written = 0;
    for (int64_t k = 0; k < kEmpty; ++k) {
      DetectionFrame frame = first;
      frame.frame = k;
      frame.time = FromSeconds(0.04 * static_cast<double>(k));
      for (ViewDetections& view : frame.views) {
        view.detections.clear();
        view.capture_time = frame.time;
      }
      for (size_t v = 0; k == 0 && v < 2; ++v) {
        // The views show no joint in common.
        Detection& one = frame.views[v].detections.emplace_back();
        one.joints.resize(17);
        for (const size_t j : {5 + v, 11 + v}) {
          const auto px = static_cast<double>(100 * j);
          one.joints[j] = {Eigen::Vector2d(px, 0.5 * px), 0.9, true};
        }
      }
      written += session.Process(std::move(frame)).size();
    }
    EXPECT_EQ(written, static_cast<size_t>(kEmpty)) << is_human;
    for (DetectionFrame frame : recording.detections.frames) {
      frame.frame += kEmpty;
      frame.time += FromSeconds(20.0);
      for (ViewDetections& view : frame.views) {
        view.capture_time += FromSeconds(20.0);
      }
      session.Process(std::move(frame));
    }
    session.Finish();
    const SubjectScale measured =
        ScaleOf(options, recording.request.cameras, recording.detections);
    EXPECT_NEAR(session.scale().metres() / measured.metres(), 1.0, 0.05);
    EXPECT_EQ(session.scale().is_one(), is_human);
  }
}

// Some detectors put all joints that were not found in the middle of the image,
// with some jitter or none.
TEST(SubjectScale, CoincidentJointsHaveNoSize) {
  for (const double jitter_px : {0.0, 3.0}) {
    Recording recording = HumanRecording();
    std::vector<DetectionFrame>& frames = recording.detections.frames;
    for (size_t f = 0; f < 30; ++f) {
      for (ViewDetections& view : frames[f].views) {
        view.detections.resize(1);
        for (size_t j = 0; j < 17; ++j) {
          const double angle = static_cast<double>(j);
          view.detections[0].joints.resize(17);
          view.detections[0].joints[j] = {
              Eigen::Vector2d(640.0 + jitter_px * std::cos(angle),
                              360.0 + jitter_px * std::sin(angle)),
              0.9, true};
        }
      }
    }
    EXPECT_TRUE(ScaleOf(OptionsOf("", "graph"), recording.request.cameras,
                        recording.detections)
                    .is_one());
  }
  EXPECT_THROW(SubjectScale::OfSize(0.0), std::logic_error);
  EXPECT_THROW(SubjectScale::OfSize(INFINITY), std::logic_error);
}

TEST(SubjectScale, OnlyPositionsAndResultsAreScaled) {
  const SubjectScale scale = SubjectScale::OfSize(0.17);
  RunOptions options;
  options.identity.entries = {1.0, 2.0, 3.0, 0.5};
  options.tracker.gates.working_distance_m = 0.4;
  const RunOptions inside = scale.IntoRun(options);
  EXPECT_NEAR(inside.identity.entries[1], 20.0, 1e-9);
  EXPECT_NEAR(inside.identity.entries[3], 5.0, 1e-9);
  EXPECT_NEAR(inside.tracker.gates.working_distance_m, 4.0, 1e-9);
  EXPECT_EQ(inside.tracker.gates.reach_m, options.tracker.gates.reach_m);
  LearntNoise noise;
  noise.classes[0].sigma_px = 3.0;
  noise.classes[0].process_noise = 2.0;
  const LearntNoise outside = scale.IntoWorld(noise);
  EXPECT_NEAR(outside.classes[0].sigma_px, 0.3, 1e-12);
  EXPECT_NEAR(outside.classes[0].process_noise, 0.02, 1e-12);
  TrackFrame frame;
  frame.people.resize(1);
  frame.people[0].derivatives.resize(2);
  JointDerivatives& derivatives = frame.people[0].derivatives[1].emplace();
  derivatives.velocity_m_s = {1.0, 2.0, 3.0};
  derivatives.acceleration_m_s2 = Eigen::Vector3d(10.0, 0.0, 0.0);
  frame = scale.IntoWorld(std::move(frame));
  const JointDerivatives& scaled = *frame.people[0].derivatives[1];
  EXPECT_NEAR(scaled.velocity_m_s.z(), 0.3, 1e-12);
  EXPECT_NEAR(scaled.acceleration_m_s2->x(), 1.0, 1e-12);
}

}  // namespace
}  // namespace kinegraph
