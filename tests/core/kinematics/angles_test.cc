// Known angles by hand, both sides, and intervals against sampling.
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
// Sines and cosines of a few degrees, and back: rounding alone.
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

double AngleAt(const PosedPerson& person, const std::string& name) {
  const auto angles = AnglesAt(person.pose());
  const auto at = angles.find(name);
  return at == angles.end() ? std::nan("") : at->second.deg;
}

TEST(JointAngles, StandingIsZero) {
  const auto angles = AnglesAt(PosedPerson().pose());
  // Seven a side but the plane of hanging arms, and four of the trunk.
  EXPECT_EQ(angles.size(), 16u);
  for (const auto& [name, estimate] : angles) {
    EXPECT_NEAR(estimate.deg, 0.0, kRounding) << name;
    EXPECT_TRUE(estimate.observed);
    EXPECT_FALSE(estimate.low_deg || estimate.high_deg) << "no covariances";
  }
  EXPECT_EQ(angles.count("l_shoulder_plane"), 0u) << "hanging arms have none";
}

TEST(JointAngles, KneeAndElbowBend) {
  for (const std::string s : {"l_", "r_"}) {
    PosedPerson person;
    // The heel comes up behind: y points left, so x turns away from z.
    person.Turn({s + "knee", s + "ankle"}, 90.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "knee_flexion"), 90.0, kRounding);
    EXPECT_LT(person.At(s + "ankle").x(), -0.3);
    person.Turn({s + "elbow", s + "wrist"}, -135.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "elbow_flexion"), 135.0, kRounding);
    const std::string other = s == "l_" ? "r_" : "l_";
    EXPECT_NEAR(AngleAt(person, other + "knee_flexion"), 0.0, kRounding);
    EXPECT_NEAR(AngleAt(person, other + "elbow_flexion"), 0.0, kRounding);
  }
}

TEST(JointAngles, HipFlexionIsForwardAndAdductionIsInward) {
  for (const std::string s : {"l_", "r_"}) {
    const double outward = s == "l_" ? 1.0 : -1.0;
    PosedPerson person;
    person.Turn({s + "hip", s + "knee"}, -90.0, kY);
    EXPECT_NEAR(person.At(s + "knee").x(), 0.5, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "hip_flexion"), 90.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "hip_adduction"), 0.0, kRounding);
    person = PosedPerson();
    person.Turn({s + "hip", s + "knee"}, 20.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "hip_flexion"), -20.0, kRounding);
    person = PosedPerson();
    person.Turn({s + "hip", s + "knee"}, 30.0 * outward, kX);
    EXPECT_GT(outward * person.At(s + "knee").y(), 0.3) << "away from the body";
    EXPECT_NEAR(AngleAt(person, s + "hip_adduction"), -30.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "hip_flexion"), 0.0, kRounding);
    // First flexion, then adduction about the axis that flexion turned.
    person.Turn({s + "hip", s + "knee"}, -40.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "hip_flexion"), 40.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "hip_adduction"), -30.0, kRounding);
  }
}

TEST(JointAngles, AnkleDorsiflexionIsToesUp) {
  PosedPerson person;
  person.Turn({"l_heel", "l_big_toe"}, -20.0, kY);
  EXPECT_GT(person.At("l_big_toe").z(), person.At("l_heel").z());
  EXPECT_NEAR(AngleAt(person, "l_ankle_dorsiflexion"), 20.0, kRounding);
  person.Turn({"l_heel", "l_big_toe"}, 65.0, kY);
  EXPECT_NEAR(AngleAt(person, "l_ankle_dorsiflexion"), -45.0, kRounding);
  EXPECT_NEAR(AngleAt(person, "r_ankle_dorsiflexion"), 0.0, kRounding);
}

TEST(JointAngles, ShoulderElevationAndItsPlane) {
  for (const std::string s : {"l_", "r_"}) {
    const double outward = s == "l_" ? 1.0 : -1.0;
    PosedPerson person;
    person.Turn({s + "shoulder", s + "elbow"}, 90.0 * outward, kX);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_elevation"), 90.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_plane"), 0.0, kRounding);
    person = PosedPerson();
    person.Turn({s + "shoulder", s + "elbow"}, -60.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_elevation"), 60.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_plane"), 90.0, kRounding)
        << "forward";
    person.Turn({s + "shoulder", s + "elbow"}, 100.0, kY);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_elevation"), 40.0, kRounding);
    EXPECT_NEAR(AngleAt(person, s + "shoulder_plane"), -90.0, kRounding)
        << "backward";
  }
}

TEST(JointAngles, TrunkLeansAndTurns) {
  const std::vector<std::string> shoulders = {"l_shoulder", "r_shoulder"};
  const Vec hips = {0.0, 0.0, 1.0};
  PosedPerson person;
  person.TurnAbout(hips, shoulders, 30.0, kY);
  EXPECT_NEAR(AngleAt(person, "trunk_forward"), 30.0, kRounding);
  EXPECT_NEAR(AngleAt(person, "trunk_right"), 0.0, kRounding);
  // The hip's frame leans with the trunk: the standing thigh is bent in it.
  EXPECT_NEAR(AngleAt(person, "l_hip_flexion"), 30.0, kRounding);
  person = PosedPerson();
  person.TurnAbout(hips, shoulders, 20.0, kX);
  EXPECT_LT(person.At("l_shoulder").y(), 0.2) << "to the right";
  EXPECT_NEAR(AngleAt(person, "trunk_right"), 20.0, kRounding);
  EXPECT_NEAR(AngleAt(person, "trunk_forward"), 0.0, kRounding);
  person = PosedPerson();
  person.TurnAbout(hips, shoulders, 40.0, kZ);
  EXPECT_NEAR(AngleAt(person, "trunk_turn"), 40.0, kRounding) << "to the left";
  EXPECT_NEAR(AngleAt(person, "trunk_forward"), 0.0, kRounding);
  person = PosedPerson();
  person.TurnAbout(hips, {"l_hip", "r_hip"}, 10.0, -kX);
  EXPECT_GT(person.At("r_hip").z(), 1.0);
  EXPECT_NEAR(AngleAt(person, "pelvis_obliquity"), 10.0, kRounding);
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

TEST(JointAngles, NothingIsMadeUp) {
  PosedPerson person;
  person.Remove("l_knee");
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_knee_flexion")));
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_hip_flexion")));
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_ankle_dorsiflexion")));
  EXPECT_NEAR(AngleAt(person, "r_knee_flexion"), 0.0, kRounding);
  person = PosedPerson();
  person.Put("l_knee", person.At("l_hip"));
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_knee_flexion")));
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_hip_flexion")));
  // A thigh along the axis of flexion says nothing of flexion.
  person = PosedPerson();
  person.Turn({"l_hip", "l_knee"}, 85.0, kX);
  EXPECT_TRUE(std::isnan(AngleAt(person, "l_hip_flexion")));
  EXPECT_NEAR(AngleAt(person, "l_hip_adduction"), -85.0, kRounding);
  // Who lies on the side has no heading.
  person = PosedPerson();
  EXPECT_EQ(AnglesAt(person.pose(), kY).count("trunk_forward"), 0u);
  person.pose().joints[PosedPerson::Index("l_ankle")].status =
      JointStatus::kInferred;
  EXPECT_FALSE(AnglesAt(person.pose()).at("l_knee_flexion").observed);
}

TEST(JointAngles, SkeletonsHaveWhatTheirJointsAllow) {
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

// Elongated in a direction of its own a joint, of about `sigma_m`.
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
      // Angles that go round: the truth may lie a turn away.
      const double low = *found.low_deg, high = *found.high_deg;
      const double nearest = found.deg - error;
      sampled[name].covered += low <= nearest && nearest <= high;
    }
  }
  return sampled;
}

TEST(JointAngleIntervals, SpreadIsThatOfSamples) {
  Random random(7);
  PersonPose pose = Sprinter().pose();
  GiveCovariances(0.005, &pose, &random);
  const auto truth = AnglesAt(pose);
  for (const auto& [name, sampled] : SampleAngles(pose, &random)) {
    const AngleEstimate& estimate = truth.at(name);
    const double stated =
        (*estimate.high_deg - *estimate.low_deg) / (2.0 * 1.959964);
    const double seen = std::sqrt(sampled.square_sum / kSamples);
    // 10000 samples know a spread to 1 / sqrt(20000) = 0.7 %; the second order
    // of errors of 5 mm on segments of 0.25 m and more is below 1 %; 4 sigmas.
    EXPECT_NEAR(stated / seen, 1.0, 0.04) << name;
    const double covered = static_cast<double>(sampled.covered) / kSamples;
    // sqrt(0.95 0.05 / 10000) = 0.2 %, 4 sigmas, and the second order.
    EXPECT_NEAR(covered, 0.95, 0.015) << name;
  }
}

// At a straight limb the angle can only grow: the interval must still hold.
TEST(JointAngleIntervals, HoldForStraightLimbs) {
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
