// Angles compared with hand-computed values on both sides, and intervals
// compared with sampling.
#include "core/kinematics/angles.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <map>

#include "core/base/random.h"
#include "tests/support/standing_person.h"

namespace kinegraph {
namespace {

using testing::PosedPerson;
using Vec = Eigen::Vector3d;

const Vec kX = Vec::UnitX(), kY = Vec::UnitY(), kZ = Vec::UnitZ();
// Rounding errors of trigonometric functions and their inverses.
constexpr double kRounding = 1e-9;

std::map<std::string, AngleEstimate> AnglesAt(const PersonPose& pose,
                                              const Vec& up = kZ) {
  std::map<std::string, AngleEstimate> angles;
  for (const JointAngle& angle : AnglesOf(Body25())) {
    const auto estimate = MeasureAngle(angle, pose, up);
    if (estimate) angles[angle.name] = *estimate;
  }
  return angles;
}

void ExpectAngles(const PosedPerson& person,
                  const std::map<std::string, double>& expected_deg) {
  const auto angles = AnglesAt(person.pose());
  for (const auto& [name, deg] : expected_deg) {
    ASSERT_EQ(angles.count(name), 1u) << name;
    EXPECT_NEAR(angles.at(name).deg, deg, kRounding) << name;
  }
}

// Expects these angles to be undefined.
void ExpectNone(const PosedPerson& person,
                const std::vector<std::string>& names) {
  const auto angles = AnglesAt(person.pose());
  for (const std::string& name : names)
    EXPECT_EQ(angles.count(name), 0u) << name;
}

// A standing person except for this rotation about the first joint.
PosedPerson Turned(const std::vector<std::string>& joints, double deg,
                   const Vec& axis) {
  PosedPerson person;
  person.Turn(joints, deg, axis);
  return person;
}

PosedPerson TurnedAboutHips(const std::vector<std::string>& joints, double deg,
                            const Vec& axis) {
  PosedPerson person;
  person.TurnAbout({0.0, 0.0, 1.0}, joints, deg, axis);
  return person;
}

TEST(JointAngles, StandingIsZero) {
  const auto angles = AnglesAt(PosedPerson().pose());
  // Seven per side except the plane of hanging arms, and four of the trunk.
  EXPECT_EQ(angles.size(), 16u);
  for (const auto& [name, estimate] : angles) {
    EXPECT_NEAR(estimate.deg, 0.0, kRounding) << name;
    EXPECT_TRUE(estimate.observed);
    EXPECT_FALSE(estimate.low_deg || estimate.high_deg) << "no covariances";
  }
  EXPECT_EQ(angles.count("l_shoulder_plane"), 0u) << "hanging arms have none";
}

// y points left: a positive rotation about it moves a hanging limb backwards.
TEST(JointAngles, LimbAnglesMatchHandComputedValues) {
  for (const std::string s : {"l_", "r_"}) {
    SCOPED_TRACE(s);
    const std::string other = s == "l_" ? "r_" : "l_";
    const double outward = s == "l_" ? 1.0 : -1.0;
    // The ankle moves up behind the body, the hand in front of it.
    ExpectAngles(Turned({s + "knee", s + "ankle"}, 90, kY),
                 {{s + "knee_flexion", 90}, {other + "knee_flexion", 0}});
    ExpectAngles(Turned({s + "elbow", s + "wrist"}, -135, kY),
                 {{s + "elbow_flexion", 135}, {other + "elbow_flexion", 0}});
    // Hips: forward is flexion, inward adduction.
    const std::vector<std::string> thigh = {s + "hip", s + "knee"};
    ExpectAngles(Turned(thigh, -90, kY),
                 {{s + "hip_flexion", 90}, {s + "hip_adduction", 0}});
    ExpectAngles(Turned(thigh, 20, kY), {{s + "hip_flexion", -20}});
    PosedPerson person = Turned(thigh, 30 * outward, kX);
    EXPECT_GT(outward * person.At(s + "knee").y(), 0.3) << "away from the body";
    ExpectAngles(person, {{s + "hip_adduction", -30}, {s + "hip_flexion", 0}});
    // First flexion, then adduction about the axis rotated by flexion.
    person.Turn(thigh, -40, kY);
    ExpectAngles(person, {{s + "hip_flexion", 40}, {s + "hip_adduction", -30}});
    // Shoulders: sideways, forward, backward.
    const std::vector<std::string> arm = {s + "shoulder", s + "elbow"};
    const std::string up = s + "shoulder_elevation",
                      plane = s + "shoulder_plane";
    ExpectAngles(Turned(arm, 90 * outward, kX), {{up, 90}, {plane, 0}});
    ExpectAngles(Turned(arm, -60, kY), {{up, 60}, {plane, 90}});
    ExpectAngles(Turned(arm, 40, kY), {{up, 40}, {plane, -90}});
    // Ankles: toes up.
    const std::vector<std::string> foot = {s + "heel", s + "big_toe"};
    const std::string ankle = s + "ankle_dorsiflexion";
    person = Turned(foot, -20, kY);
    EXPECT_GT(person.At(foot[1]).z(), person.At(foot[0]).z());
    ExpectAngles(person, {{ankle, 20}, {other + "ankle_dorsiflexion", 0}});
    ExpectAngles(Turned(foot, 45, kY), {{ankle, -45}});
  }
}

TEST(JointAngles, TrunkLeansAndTurns) {
  const std::vector<std::string> shoulders = {"l_shoulder", "r_shoulder"};
  // The hip's frame leans with the trunk, so the vertical thigh is flexed in
  // it.
  ExpectAngles(
      TurnedAboutHips(shoulders, 30, kY),
      {{"trunk_forward", 30}, {"trunk_right", 0}, {"l_hip_flexion", 30}});
  const PosedPerson right = TurnedAboutHips(shoulders, 20, kX);
  EXPECT_LT(right.At("l_shoulder").y(), 0.2) << "to the right";
  ExpectAngles(right, {{"trunk_right", 20}, {"trunk_forward", 0}});
  // To the left.
  ExpectAngles(TurnedAboutHips(shoulders, 40, kZ),
               {{"trunk_turn", 40}, {"trunk_forward", 0}});
  const PosedPerson oblique = TurnedAboutHips({"l_hip", "r_hip"}, 10, -kX);
  EXPECT_GT(oblique.At("r_hip").z(), 1.0);
  ExpectAngles(oblique, {{"pelvis_obliquity", 10}});
}

PosedPerson Sprinter() {
  PosedPerson person;
  person.Turn({"l_hip", "l_knee", "l_ankle", "l_heel", "l_big_toe"}, -70.0,
              Vec(0.2, 1.0, 0.1).normalized());
  person.Turn({"l_knee", "l_ankle", "l_heel", "l_big_toe"}, 80.0, kY);
  person.Turn({"r_knee", "r_ankle", "r_heel", "r_big_toe"}, 25.0,
              Vec(0.1, 1.0, 0.3).normalized());
  person.Turn({"l_shoulder", "l_elbow", "l_wrist"}, 50.0,
              Vec(0.5, 1.0, 0.0).normalized());
  person.Turn({"r_shoulder", "r_elbow", "r_wrist"}, -65.0,
              Vec(0.4, 1.0, 0.1).normalized());
  person.Turn({"l_elbow", "l_wrist"}, -90.0, kY);
  person.Turn({"r_elbow", "r_wrist"}, -70.0, Vec(0.2, 1.0, 0.4).normalized());
  person.TurnAbout({0.0, 0.0, 1.0}, {"l_shoulder", "r_shoulder"}, 25.0,
                   Vec(0.2, 1.0, 0.8).normalized());
  person.TurnAbout({0.0, 0.0, 1.0}, {"l_hip", "r_hip"}, 8.0, kX);
  return person;
}

TEST(JointAngles, DoNotDependOnTheWorld) {
  const PosedPerson person = Sprinter();
  const auto expected = AnglesAt(person.pose());
  EXPECT_EQ(expected.size(), 18u);
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(1.1, Vec(1, 2, 3).normalized()));
  PersonPose moved = person.pose();
  for (Joint3d& joint : moved.joints) {
    joint.position_m = turn * joint.position_m + Vec(3.0, -4.0, 5.0);
  }
  const auto found = AnglesAt(moved, turn * kZ);
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [name, estimate] : expected) {
    EXPECT_NEAR(found.at(name).deg, estimate.deg, kRounding) << name;
  }
}

TEST(JointAngles, AMirrorExchangesTheSides) {
  const PosedPerson person = Sprinter();
  const auto expected = AnglesAt(person.pose());
  PosedPerson mirrored;
  for (int j = 0; j < Body25().joint_count(); ++j) {
    const auto from = static_cast<size_t>(j);
    const auto to = static_cast<size_t>(Body25().mirror(j));
    mirrored.pose().joints[to] = person.pose().joints[from];
    mirrored.pose().joints[to].position_m.y() *= -1.0;
  }
  const auto found = AnglesAt(mirrored.pose());
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [name, estimate] : expected) {
    const bool sided = name[1] == '_';
    const std::string other =
        sided ? (name[0] == 'l' ? "r" : "l") + name.substr(1) : name;
    const double sign = sided || name == "trunk_forward" ? 1.0 : -1.0;
    EXPECT_NEAR(found.at(other).deg, sign * estimate.deg, kRounding) << name;
  }
}

TEST(JointAngles, UndefinedAnglesAreMissing) {
  PosedPerson person;
  person.Remove("l_knee");
  ExpectNone(person,
             {"l_knee_flexion", "l_hip_flexion", "l_ankle_dorsiflexion"});
  ExpectAngles(person, {{"r_knee_flexion", 0}});
  person = PosedPerson();
  person.Put("l_knee", person.At("l_hip"));
  ExpectNone(person, {"l_knee_flexion", "l_hip_flexion"});
  // With the thigh nearly along the axis of flexion, flexion is undefined.
  person = Turned({"l_hip", "l_knee"}, 85, kX);
  ExpectNone(person, {"l_hip_flexion"});
  ExpectAngles(person, {{"l_hip_adduction", -85}});
  // A person lying on their side has no heading.
  person = PosedPerson();
  EXPECT_EQ(AnglesAt(person.pose(), kY).count("trunk_forward"), 0u);
  person.pose().joints[PosedPerson::Index("l_ankle")].status =
      JointStatus::kInferred;
  EXPECT_FALSE(AnglesAt(person.pose()).at("l_knee_flexion").observed);
}

TEST(JointAngles, AnglesDependOnTheJointsOfTheSkeleton) {
  const auto count = [](const Skeleton& skeleton) {
    return AnglesOf(skeleton).size();
  };
  EXPECT_EQ(count(Body25()), 18u);
  EXPECT_EQ(count(Halpe26()), 18u);
  EXPECT_EQ(count(MediaPipe33()), 18u) << "foot_index is the toe";
  EXPECT_EQ(count(WholeBody133()), 18u);
  for (const Skeleton* skeleton :
       {&Coco17(), &Coco18(), &Tum14(), &Panoptic15(), &Panoptic19()}) {
    EXPECT_EQ(count(*skeleton), 16u) << skeleton->name() << " has no feet";
  }
  EXPECT_EQ(count(Skeleton("hand", {"a", "b"}, {})), 0u);
}

// ---- Intervals --------------------------------------------------------------

// Gives each joint a covariance elongated in a random direction, with standard
// deviations of about `sigma_m`.
void GiveCovariances(double sigma_m, PersonPose* pose, Random* random) {
  pose->covariances.assign(pose->joints.size(), std::nullopt);
  for (size_t j = 0; j < pose->joints.size(); ++j) {
    if (!pose->joints[j].present()) continue;
    Vec axis;
    for (Eigen::Index i = 0; i < 3; ++i) axis[i] = random->Normal();
    axis.normalize();
    pose->covariances[j] =
        sigma_m * sigma_m *
        (0.5 * Eigen::Matrix3d::Identity() + 1.5 * axis * axis.transpose());
  }
}

PersonPose Disturbed(const PersonPose& pose, Random* random) {
  PersonPose noisy = pose;
  for (size_t j = 0; j < pose.joints.size(); ++j) {
    if (!pose.joints[j].present()) continue;
    Vec white;
    for (Eigen::Index i = 0; i < 3; ++i) white[i] = random->Normal();
    const Eigen::LLT<Eigen::Matrix3d> root(*pose.covariances[j]);
    noisy.joints[j].position_m += root.matrixL() * white;
  }
  return noisy;
}

struct Sampled {
  double square_sum = 0.0;
  int covered = 0;
};

constexpr int kSamples = 10000;

std::map<std::string, Sampled> SampleAngles(const PersonPose& pose,
                                            Random* random) {
  const auto truth = AnglesAt(pose);
  std::map<std::string, Sampled> sampled;
  for (int i = 0; i < kSamples; ++i) {
    for (const auto& [name, found] : AnglesAt(Disturbed(pose, random))) {
      const auto at = truth.find(name);
      if (at == truth.end()) continue;
      const double deg = at->second.deg;
      const double error = std::remainder(found.deg - deg, 360.0);
      sampled[name].square_sum += error * error;
      // Angles are cyclic: the truth may be a full turn away.
      const double low = *found.low_deg, high = *found.high_deg;
      const double nearest = found.deg - error;
      sampled[name].covered += low <= nearest && nearest <= high;
    }
  }
  return sampled;
}

TEST(JointAngleIntervals, SpreadMatchesSampling) {
  Random random(7);
  PersonPose pose = Sprinter().pose();
  GiveCovariances(0.005, &pose, &random);
  const auto truth = AnglesAt(pose);
  for (const auto& [name, sampled] : SampleAngles(pose, &random)) {
    const AngleEstimate& estimate = truth.at(name);
    const double stated =
        (*estimate.high_deg - *estimate.low_deg) / (2.0 * 1.959964);
    const double seen = std::sqrt(sampled.square_sum / kSamples);
    // 10000 samples determine a spread to 1 / sqrt(20000) = 0.7 %; second-order
    // effects of errors of 5 mm on segments of 0.25 m or more are below 1 %.
    // The tolerance is 4 sigmas (2.8 %) plus these effects.
    EXPECT_NEAR(stated / seen, 1.0, 0.04) << name;
    const double covered = static_cast<double>(sampled.covered) / kSamples;
    // sqrt(0.95 * 0.05 / 10000) = 0.2 %: 4 sigmas, and second-order effects.
    EXPECT_NEAR(covered, 0.95, 0.015) << name;
  }
}

// Errors can only increase the angle of a straight limb and only decrease that
// of a folded one: the interval must still contain the true angle.
TEST(JointAngleIntervals, CoverStraightLimbs) {
  Random random(8);
  for (const double bend_deg : {0.0, 1.0, 2.0, 3.0, 5.0, 8.0}) {
    PosedPerson person;
    person.Turn({"l_knee", "l_ankle"}, bend_deg, kY);
    person.Turn({"r_elbow", "r_wrist"}, 180.0 - bend_deg, kY);
    PersonPose pose = person.pose();
    GiveCovariances(0.01, &pose, &random);
    const auto sampled = SampleAngles(pose, &random);
    for (const char* name : {"l_knee_flexion", "r_elbow_flexion"}) {
      const double covered =
          static_cast<double>(sampled.at(name).covered) / kSamples;
      // 95 %, less 4 sigmas of sampling (0.9 %) and second-order effects.
      EXPECT_GT(covered, 0.935) << name << " bent by " << bend_deg;
    }
  }
  PersonPose pose = PosedPerson().pose();
  GiveCovariances(0.01, &pose, &random);
  const AngleEstimate knee = AnglesAt(pose).at("l_knee_flexion");
  EXPECT_EQ(*knee.low_deg, 0.0) << "no angle is below 0";
  EXPECT_GT(*knee.high_deg, 1.0);
}

TEST(JointAngleIntervals, NeedEveryCovariance) {
  Random random(9);
  PersonPose pose = Sprinter().pose();
  GiveCovariances(0.01, &pose, &random);
  pose.covariances[PosedPerson::Index("l_ankle")].reset();
  const auto angles = AnglesAt(pose);
  EXPECT_FALSE(angles.at("l_knee_flexion").low_deg);
  EXPECT_TRUE(angles.at("r_knee_flexion").low_deg);
}

}  // namespace
}  // namespace kinegraph
