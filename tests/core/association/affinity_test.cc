#include "core/association/affinity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/rig.h"

namespace kinegraph {
namespace {

std::vector<int> AllJoints() { return Coco17().association_joints(); }

AssociationOptions Options(AffinityKind kind = AffinityKind::kPart) {
  AssociationOptions options;
  options.affinity = kind;
  options.alpha_2d_px_per_frame = 70.0;
  options.lambda_a_per_frame = 3.0;
  options.epsilon_joints = 11.0;
  return options;
}

// Eq. 1 of Chu et al. (2021) for a projected pose with every joint at the
// origin of the image, and an observation whose first `near` joints lie
// `near_px` to the right of the origin and whose other joints lie `far_px` to
// its right; only the first `found` joints exist.
struct Pair {
  int near;
  double near_px, far_px;
  int found;
  double age_frames;
  AffinityKind kind;
  double expected;
};

TEST(AffinityTest, MatchesHandComputedValues) {
  constexpr AffinityKind kPart = AffinityKind::kPart;
  const double e3 = std::exp(-3.0);
  for (const Pair& pair :
       {// The mean over the joints with positive affinity, at least eleven.
        Pair{11, 35.0, 500.0, 17, 1.0, kPart, 0.5 * e3},
        {10, 35.0, 500.0, 17, 1.0, kPart, 0.0},
        // At a distance of exactly alpha the affinity is not positive.
        {10, 0.0, 70.0, 17, 1.0, kPart, 0.0},
        // The gate grows with the age: 105 px of 2 * 70 px leave a quarter.
        {17, 105.0, 0.0, 17, 1.0, kPart, 0.0},
        {17, 105.0, 0.0, 17, 2.0, kPart, 0.25 * std::exp(-6.0)},
        // Of nine common joints ceil(11 / 17 * 9) = 6 must be positive.
        {6, 35.0, 500.0, 9, 1.0, kPart, 0.5 * e3},
        {5, 35.0, 500.0, 9, 1.0, kPart, 0.0},
        // Fewer than six common joints do not match.
        {17, 0.0, 0.0, 5, 1.0, kPart, 0.0},
        // The mean over all joints: 16 at 1 and one at 1 - 1260 / 70 = -17.
        {1, 1260.0, 0.0, 17, 1.0, AffinityKind::kBody, -e3 / 17.0}}) {
    Observation observation;
    for (int j = 0; j < 17; ++j) {
      observation.joints.push_back(
          {{j < pair.near ? pair.near_px : pair.far_px, 0.0},
           1.0,
           j < pair.found});
    }
    const ProjectedPose origin = {
        std::vector<Eigen::Vector2d>(17, Eigen::Vector2d::Zero()),
        std::vector<char>(17, 1)};
    EXPECT_NEAR(
        Affinity(observation, origin, pair.age_frames, 70.0 * pair.age_frames,
                 AllJoints(), Options(pair.kind)),
        pair.expected, 1e-16)
        << pair.near << " joints at " << pair.near_px << " px";
  }
}

// With graph mode's gate (reach_m_per_frame > 0), four or five common joints
// match if all are within the gate and, on average, within half of it; three do
// not.
TEST(AffinityTest, FewJointsMatchIfAllAreNear) {
  AssociationOptions graph = Options();
  graph.reach_m_per_frame = 0.12;
  const auto affinity = [&](int found, double last_px, double others_px) {
    Observation observation;
    for (int j = 0; j < 17; ++j) {
      const double px = j + 1 == found ? last_px : others_px;
      observation.joints.push_back({{px, 0.0}, 1.0, j < found});
    }
    const ProjectedPose origin = {
        std::vector<Eigen::Vector2d>(17, Eigen::Vector2d::Zero()),
        std::vector<char>(17, 1)};
    return Affinity(observation, origin, 1.0, 70.0, AllJoints(), graph);
  };
  const double e3 = std::exp(-3.0);
  EXPECT_NEAR(affinity(5, 14.0, 14.0), 0.8 * e3, 1e-16);
  EXPECT_NEAR(affinity(4, 14.0, 14.0), 0.8 * e3, 1e-16);
  EXPECT_EQ(affinity(3, 14.0, 14.0), 0.0);
  EXPECT_EQ(affinity(5, 36.0, 36.0), 0.0);  // beyond half of 70 px
  EXPECT_EQ(affinity(5, 71.0, 0.0), 0.0);   // one is beyond the gate
}

class ViewMatcherTest : public ::testing::Test {
 protected:
  std::vector<int> Match(const std::vector<AssociationTarget>& targets,
                         const std::vector<Pose3d>& seen) {
    std::vector<Observation> observations;
    for (const Pose3d& pose : seen) {
      observations.push_back(testing::Observe(pose, cameras_, 0));
    }
    std::vector<int> match;
    matcher_.Match(targets, observations, cameras_[0], {}, &match);
    return match;
  }

  CameraRig cameras_ = testing::RingOfCameras(1, 6.0);
  ViewMatcher matcher_{Options(), AllJoints()};
  const Pose3d left_ = testing::StandingPerson(-1.0, 1.0);
  const Pose3d right_ = testing::StandingPerson(1.0, -1.0);
};

TEST_F(ViewMatcherTest, AssignsDetectionsToPeople) {
  EXPECT_EQ(Match({{&left_, 1.0}, {&right_, 1.0}}, {right_, left_}),
            (std::vector<int>{1, 0}));
  // A recent track has precedence over a stale one.
  EXPECT_EQ(Match({{&left_, 4.0}, {&left_, 1.0}}, {left_}),
            (std::vector<int>{-1, 0}));
  // At an age of ten frames the factor e^-30 = 1e-13 must not be treated as
  // zero.
  EXPECT_EQ(Match({{&left_, 10.0}}, {left_}), (std::vector<int>{0}));
  EXPECT_LT(matcher_.affinities()[0], 1e-12);
  const Pose3d behind = testing::StandingPerson(40.0, 0.0);  // behind camera 0
  EXPECT_EQ(Match({{&behind, 1.0}}, {left_}), (std::vector<int>{-1}));
  EXPECT_EQ(Match({{&left_, 1.0}}, {}), (std::vector<int>{-1}));
  EXPECT_TRUE(Match({}, {}).empty());
}

// A camera at the origin that looks along z with a focal length of 1000 px.
Camera FrontalCamera() {
  CameraParameters parameters;
  parameters.K << 1000.0, 0.0, 500.0, 0.0, 1000.0, 500.0, 0.0, 0.0, 1.0;
  return Camera(parameters);
}

TEST(GateTest, GrowsByPixelsOrMetresPerFrame) {
  const auto gate_px = [](double reach_m, double age_frames, double depth_m) {
    const Pose3d pose(17, {{0.0, 0.0, depth_m}, JointStatus::kObserved});
    AssociationOptions options = Options();
    options.reach_m_per_frame = reach_m;
    return GatePx(pose, age_frames, FrontalCamera(), options);
  };
  EXPECT_EQ(gate_px(0.0, 1.0, 5.0), 70.0);  // the paper's
  EXPECT_EQ(gate_px(0.0, 10.0, 5.0), 700.0);
  EXPECT_EQ(gate_px(0.0, 0.1, 5.0), 7.0);
  // The paper's gate for the next frame, then 0.125 m (25 px at 5 m) more per
  // frame.
  EXPECT_EQ(gate_px(0.125, 1.0, 5.0), 70.0);
  EXPECT_EQ(gate_px(0.125, 9.0, 5.0), 270.0);
  // Never larger than the paper's gate: at 1 m depth, 0.125 m would be 125 px.
  EXPECT_EQ(gate_px(0.125, 9.0, 1.0), 630.0);
  // A detector's errors do not shrink with the interval.
  EXPECT_EQ(gate_px(0.125, 0.1, 5.0), 70.0);
}

// The affinity of Chen et al. (2020).
class CrossViewAffinityTest : public ::testing::Test {
 protected:
  CrossViewAffinityTest() : camera_(Parameters()) {
    options_.affinity = AffinityKind::kCrossView;
    options_.alpha_2d_px_per_frame = 60.0;
    options_.alpha_3d_m = 0.15;
    options_.lambda_a_per_frame = 5.0;
    options_.min_common_joints = 0.0;
    // The pixel (370, 240) is the ray along (0.1, 0, 1).
    observation_.joints.assign(17, {{370.0, 240.0}, 1.0, true});
    observation_.ideal_px.assign(17, {370.0, 240.0});
    // 6 cm beside the ray: 1 - 0.06 / 0.15 = 0.6.
    expected_.assign(17, {{0.5, 0.06, 5.0}, JointStatus::kObserved});
    // 12 px away: 1 - 12 / 60 = 0.8 after one frame.
    last_seen_.assign(17, {true, {370.0, 252.0}, 1.0});
  }

  static CameraParameters Parameters() {
    CameraParameters parameters;
    parameters.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
    return parameters;
  }

  double Affinity(double expected_age_frames) const {
    return CrossViewAffinity(observation_, last_seen_, expected_,
                             expected_age_frames, camera_, AllJoints(),
                             options_);
  }

  static constexpr double kRounding = 1e-12;  // of 34 terms of order one
  Camera camera_;
  AssociationOptions options_;
  Observation observation_;
  Pose3d expected_;
  std::vector<LastSeenJoint> last_seen_;
};

TEST_F(CrossViewAffinityTest, SumsBothTermsOverTheJoints) {
  // 17 (0.4 * 0.8 + 0.6 * 0.6) e^-5.
  EXPECT_NEAR(Affinity(1.0), 17.0 * 0.68 * std::exp(-5.0), kRounding);
  // The 3D term does not decay if the expected pose is of this frame (age 0).
  EXPECT_NEAR(Affinity(0.0), 17.0 * (0.32 * std::exp(-5.0) + 0.36), kRounding);
  // The 2D term has its own age: 12 px of a gate of 2 * 60 px.
  for (LastSeenJoint& joint : last_seen_) joint.age_frames = 2.0;
  EXPECT_NEAR(Affinity(1.0),
              17.0 * (0.4 * 0.9 * std::exp(-10.0) + 0.36 * std::exp(-5.0)),
              kRounding);
}

TEST_F(CrossViewAffinityTest, TermsOfMissingJointsAreZero) {
  last_seen_.clear();  // never matched in this view
  EXPECT_NEAR(Affinity(1.0), 17.0 * 0.36 * std::exp(-5.0), kRounding);
  // The sum is not part-aware: one far joint outweighs the rest, 16 joints of
  // 0.36 and one of 0.6 (1 - 2.0 / 0.15) = -7.4.
  expected_[0].position_m.y() = 2.0;
  EXPECT_NEAR(Affinity(0.0), 16.0 * 0.36 + 0.6 * (1.0 - 2.0 / 0.15), kRounding);
  expected_[0].position_m.y() = 0.06;
  for (int j = 1; j < 17; ++j) expected_[j].status = JointStatus::kMissing;
  EXPECT_NEAR(Affinity(1.0), 0.36 * std::exp(-5.0), kRounding);
  expected_[0].position_m *= -1.0;  // on the line, behind the camera
  EXPECT_EQ(Affinity(1.0), 0.0);
}

TEST_F(CrossViewAffinityTest, TooFewJointsDoNotMatch) {
  options_.min_common_joints = 6.0;
  for (int j = 5; j < 17; ++j) observation_.joints[j].found = false;
  EXPECT_EQ(Affinity(1.0), 0.0);
  observation_.joints[5].found = true;
  EXPECT_GT(Affinity(1.0), 0.0);
}

// (0.5, 0.06, 5) projects to (370, 246): 6 px away.
TEST_F(CrossViewAffinityTest, ViewMatcherUsesCrossViewAffinity) {
  AssociationTarget target;
  target.pose = &expected_;
  target.age_frames = 1.0;
  target.last_seen = &last_seen_;
  const auto matched = [&](Target2d target_2d) {
    options_.target_2d = target_2d;
    ViewMatcher matcher(options_, AllJoints());
    std::vector<int> match;
    matcher.Match({target}, std::vector<Observation>{observation_}, camera_, {},
                  &match);
    return matcher.affinities()[0];
  };
  EXPECT_NEAR(matched(Target2d::kMatched), 17.0 * 0.68 * std::exp(-5.0),
              kRounding);
  EXPECT_NEAR(matched(Target2d::kProjected),
              17.0 * (0.4 * 0.9 + 0.36) * std::exp(-5.0), kRounding);
  // The 3D term uses the expected pose, here on the ray and with age 0.
  Pose3d nearer = expected_;
  for (Joint3d& joint : nearer) joint.position_m.y() = 0.0;
  target.expected = &nearer;
  target.expected_age_frames = 0.0;
  EXPECT_NEAR(matched(Target2d::kProjected),
              17.0 * (0.4 * 0.9 * std::exp(-5.0) + 0.6), kRounding);
}

}  // namespace
}  // namespace kinegraph
