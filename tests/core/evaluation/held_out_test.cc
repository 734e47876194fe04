#include "core/evaluation/held_out.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using Eigen::Vector3d;

// Looks along +y from 4 m behind the origin: 100 px per metre at the origin.
Camera MakeCamera() {
  CameraParameters parameters;
  parameters.name = "cam0";
  parameters.K << 400, 0, 500, 0, 400, 500, 0, 0, 1;
  parameters.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  parameters.t = Vector3d(0, 0, 4);
  return Camera(parameters);
}

Detection Project(const Pose3d& pose, const Camera& camera) {
  Detection detection;
  for (const Joint3d& joint : pose) {
    detection.joints.push_back({*camera.Project(joint.position_m), 0.9, true});
  }
  return detection;
}

// One person at the origin in frames 0 and 1, detected without errors.
struct Scene {
  Camera camera = MakeCamera();
  DetectionSequence detections;
  TrackSequence reference;
  HeldOutSet set;

  Scene() {
    detections.header.skeleton = Tum14();
    detections.header.view_names = {"cam1", "cam0"};
    for (int frame = 0; frame < 2; ++frame) {
      DetectionFrame one;
      one.frame = frame;
      one.views.resize(2);
      one.views[1].detections = {Project(StandingTum14(), camera)};
      detections.frames.push_back(one);
      set.detections.push_back({frame, "cam0", 0, TrackId(3)});
    }
    reference = Alone(StandingTum14(), 3, 2);
  }

  HeldOutScores Score(const TrackSequence& run,
                      const HeldOutRules& rules = {}) const {
    HeldOutScores scores;
    ScoreHeldOutCamera(set, detections, 1, camera, reference, run, &scores,
                       rules);
    return scores;
  }
  HeldOutScores Score(const Pose3d& in_both_frames) const {
    return Score(Alone(in_both_frames, 8, 2));
  }
};

HeldOutSummary Summarise(const HeldOutScores& scores) {
  return SummariseHeldOut(scores, AllJoints());
}

TEST(HeldOutTest, PerfectRunHasNoError) {
  const HeldOutScores scores = Scene().Score(StandingTum14());
  const HeldOutSummary summary = Summarise(scores);
  EXPECT_EQ(scores.joints.size(), 28u);
  EXPECT_EQ(summary.figure_px(HeldOutFigure::kP97), 0.0);
  EXPECT_EQ(summary.predicted.count, 28);
  EXPECT_EQ(summary.paired.count, 2);
  EXPECT_EQ(summary.paired.total, 2);
}

TEST(HeldOutTest, ErrorIsThePixelDistance) {
  // 0.1 m to the right at 4 m with f = 400 px: 10 px.
  const HeldOutSummary summary =
      Summarise(Scene().Score(Moved(StandingTum14(), 0.1)));
  for (const double figure : summary.figures_px) EXPECT_NEAR(figure, 10, 1e-9);
}

TEST(HeldOutTest, ErrorsAreCappedAndTruncated) {
  Scene scene;
  Pose3d pose = StandingTum14();
  pose[6].position_m.x() += 3.0;  // 300 px
  const HeldOutScores scores = scene.Score(pose);
  EXPECT_EQ(scores.joints[6].error_px, scene.set.cap_px);
  EXPECT_FALSE(scores.joints[6].predicted);
  EXPECT_TRUE(scores.joints[5].predicted);
  // One of 14 joints counts 30 px, the others zero.
  EXPECT_NEAR(Summarise(scores).figure_px(HeldOutFigure::kMeanTruncated),
              30.0 / 14.0, 1e-12);
}

TEST(HeldOutTest, JointsOfMissingPeopleCostTheCap) {
  const HeldOutSummary summary =
      Summarise(Scene().Score(Tracks({Frame(0, {})})));  // frame 1 is missing
  EXPECT_EQ(summary.figure_px(HeldOutFigure::kMedian), 100.0);
  EXPECT_EQ(summary.predicted.count, 0);
  EXPECT_EQ(summary.predicted.total, 28);
  EXPECT_EQ(summary.paired.count, 0);
  EXPECT_EQ(summary.paired.total, 2);
}

TEST(HeldOutTest, JointsWithoutAPixelCostTheCap) {
  const Skeleton body("body", {"r_ankle", "l_ankle", "r_hip", "l_hip"}, {});
  const Pose3d truth = StandingTum14();
  const Pose3d pose = {truth[0], truth[5], truth[2], Joint3d{}};
  const HeldOutScores scores =
      Scene().Score(Tracks({Frame(0, {Person(8, pose)})}, body));
  int predicted = 0;
  for (size_t i = 0; i < 14; ++i) predicted += scores.joints[i].predicted;
  EXPECT_EQ(predicted, 3);
  EXPECT_EQ(scores.joints[3].error_px, 100.0);   // l_hip, missing
  EXPECT_EQ(scores.joints[13].error_px, 100.0);  // joint not in the skeleton
  Pose3d behind = truth;
  behind[0].position_m.y() = -5.0;
  const HeldOutJoint ankle = Scene().Score(behind).joints[0];
  EXPECT_FALSE(ankle.predicted);
  EXPECT_EQ(ankle.error_px, 100.0);  // behind the camera
}

TEST(HeldOutTest, PairsWithinTheGateByTheBodyNotTheHead) {
  const auto is_paired = [](const Pose3d& pose) {
    return Scene().Score(pose).people[0].paired;
  };
  // Exact in binary, so that the mean distance is the gate itself.
  EXPECT_TRUE(is_paired(StandingTum14(0.0, 0.5)));
  EXPECT_FALSE(is_paired(StandingTum14(0.0, 0.5625)));
  Pose3d pose = StandingTum14();
  pose[12].position_m.x() += 50.0;  // would move the mean of 14 by 3.6 m
  EXPECT_TRUE(is_paired(pose));
}

TEST(HeldOutTest, PairsOneToOne) {
  Scene scene;
  // A second person of the reference next to the first takes the run's only
  // pose, because it is nearer.
  scene.reference.frames[0].people.push_back(
      Person(4, StandingTum14(0.0, 0.25)));
  const HeldOutScores scores = scene.Score(StandingTum14(0.0, 0.1875));
  EXPECT_FALSE(scores.people[0].paired);
  EXPECT_TRUE(scores.people[1].paired);
}

TEST(HeldOutTest, ScoresConfidentJointsNamedByTheReference) {
  Scene scene;
  Detection& detection = scene.detections.frames[0].views[1].detections[0];
  detection.joints[0].confidence = 0.3;  // the least confidence that is scored
  detection.joints[1].confidence = 0.2999;
  detection.joints[2].found = false;
  EXPECT_EQ(scene.Score(StandingTum14()).joints.size(), 26u);
  scene = Scene();
  std::vector<std::string> names = Tum14().joints();
  names[0] = "r_toe_ring";
  scene.detections.header.skeleton = Skeleton("odd", names, {});
  EXPECT_EQ(scene.Score(StandingTum14()).joints.size(), 26u);
}

TEST(HeldOutTest, RefusesASetOfOtherDetections) {
  const auto score = [](const HeldOutDetection& second) {
    Scene scene;
    scene.set.detections[1] = second;
    scene.Score(StandingTum14());
  };
  EXPECT_THROW(score({1, "cam0", 1, TrackId(3)}), InputError);
  EXPECT_THROW(score({1, "cam0", 0, TrackId(77)}), InputError);
  EXPECT_THROW(score({99, "cam0", 0, TrackId(3)}), InputError);
  EXPECT_NO_THROW(score({99, "cam1", 0, TrackId(3)}));  // of another camera
}

TEST(HeldOutTest, FiltersByClassAndView) {
  HeldOutScores scores = Scene().Score(StandingTum14());
  EXPECT_EQ(SummariseHeldOut(scores, JointsOfClass(JointClass::kKnee))
                .predicted.total,
            4);
  EXPECT_EQ(SummariseHeldOut(scores, JointsWithoutFace()).predicted.total, 24);
  EXPECT_EQ(SummariseHeldOut(scores, JointsOfView(1)).predicted.total, 28);
  const HeldOutSummary nothing = SummariseHeldOut(scores, JointsOfView(0));
  EXPECT_EQ(nothing.predicted.total, 0);
  EXPECT_EQ(nothing.paired.total, 0);
  EXPECT_TRUE(std::isnan(nothing.figure_px(HeldOutFigure::kMedian)));
  EXPECT_TRUE(std::isnan(nothing.intervals_px[0].low));
}

TEST(HeldOutTest, MakesASetFromTheMatchesOfTracks) {
  TrackSequence reference = Tracks({Frame(5, {Person(3, StandingTum14())})});
  reference.header.view_names = {"a", "b"};
  reference.frames[0].people[0].matches = {{1, 4, {}}};
  const HeldOutSet set = MakeHeldOutSet(reference, 192.0);
  ASSERT_EQ(set.detections.size(), 1u);
  EXPECT_EQ(set.detections[0].view_name, "b");
  EXPECT_EQ(set.detections[0].detection_idx, 4);
  EXPECT_EQ(set.detections[0].person, TrackId(3));
  EXPECT_EQ(set.cap_px, 192.0);
}

TEST(HeldOutTest, PairsByIdentityOnRequest) {
  const Scene scene;
  // One metre away: no pair by distance.
  const Pose3d far = Moved(StandingTum14(), 1.0);
  const TrackSequence run =
      Tracks({Frame(0, {Person(3, far)}), Frame(1, {Person(4, far)})});
  HeldOutRules rules;
  rules.pairing = HeldOutRules::Pairing::kById;
  const HeldOutSummary summary = Summarise(scene.Score(run, rules));
  EXPECT_EQ(summary.paired.count, 1);
  EXPECT_EQ(summary.paired.total, 2);
}

TEST(HeldOutTest, TruncatedErrorsPoolToTheMean) {
  const Scene scene;
  // 0.2 m are 20 px, 0.5 m are 50 px and count 30.
  HeldOutScores scores =
      scene.Score(Tracks({Frame(0, {Person(8, Moved(StandingTum14(), 0.2))}),
                          Frame(1, {Person(8, Moved(StandingTum14(), 0.5))})}));
  const RatioSeries units = TruncatedErrors(scores, AllJoints());
  ASSERT_EQ(units.size(), 2u);
  EXPECT_NEAR(units[0].sum / units[0].weight, 20.0, 1e-9);
  EXPECT_NEAR(units[1].sum / units[1].weight, 30.0, 1e-9);
  EXPECT_NEAR(PooledRatio({units}),
              Summarise(scores).figure_px(HeldOutFigure::kMeanTruncated),
              1e-12);
}

TEST(HeldOutTest, NormalisesResidualsByPredictionAndDetector) {
  const Scene scene;
  // 0.1 m sideways are 10 px. A standard deviation of 0.03 m is 3 px and the
  // detector's is 4 px, so the normalised square is 10^2 / (3^2 + 4^2) = 4.
  PersonPose person = Person(3, Moved(StandingTum14(), 0.1));
  person.covariances.assign(
      14, Eigen::Matrix3d(0.03 * 0.03 * Eigen::Matrix3d::Identity()));
  HeldOutRules rules;
  rules.sigma_px = [](JointClass, double confidence, double depth_m,
                      double focal_px) {
    EXPECT_EQ(confidence, 0.9);
    EXPECT_EQ(focal_px, 400.0);
    EXPECT_DOUBLE_EQ(depth_m, 4.0);
    return 4.0;
  };
  const HeldOutScores scores =
      scene.Score(Tracks({Frame(0, {person}), Frame(1, {person})}), rules);
  ASSERT_EQ(scores.joints.size(), 28u);
  for (const HeldOutJoint& joint : scores.joints) {
    ASSERT_TRUE(joint.normalised_squared.has_value());
    // Off the optical axis, an error in depth also appears in the image: with v
    // = (x, y) / depth, the covariance is 25 I + 9 v v^T px^2, which reduces
    // the square by at most 9 / 25 v_x^2. Wrists are farthest off, with v_x =
    // 0.35 / 4: by 0.28 %, 0.011 of 4.
    EXPECT_NEAR(*joint.normalised_squared, 4.0, 0.0111);
  }
}

}  // namespace
}  // namespace kinegraph::testing
