// Speeds, path lengths and centres of mass of known motions.
#include "core/kinematics/kinematics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/kinematics/ground.h"
#include "tests/support/standing_person.h"

namespace kinegraph {
namespace {

using testing::PosedPerson;
using Vec = Eigen::Vector3d;

PersonPose StandingAt(const Vec& place_m, int id) {
  PersonPose pose = PosedPerson().pose();
  for (Joint3d& joint : pose.joints) joint.position_m += place_m;
  pose.id = TrackId(id);
  return pose;
}

// Walks forward at 1.5 m/s, bobbing by 2 cm, at 50 Hz.
TrackSequence Walk(int frames) {
  TrackSequence tracks;
  tracks.header.skeleton = Body25();
  tracks.header.frame_rate_hz = 50.0;
  for (int k = 0; k < frames; ++k) {
    const Vec place_m(0.03 * k, 0.0, k % 2 == 0 ? 0.0 : 0.02);
    tracks.frames.push_back(
        {100 + k, TimeNs{20000000} * k, {StandingAt(place_m, 3)}});
  }
  return tracks;
}

double ValueAt(const KinematicsTable& table, size_t row,
               const std::string& column) {
  const int at = table.IndexOf(column);
  EXPECT_GE(at, 0) << column;
  return at < 0 ? 0.0 : table.rows[row].values[static_cast<size_t>(at)];
}

// Rounding errors of sums of a few positions in metres.
constexpr double kMetreRounding = 1e-12;

TEST(Kinematics, SpeedAndPathLengthMatchAKnownWalk) {
  const TrackSequence tracks = Walk(11);
  const KinematicsTable table = MeasureKinematics(tracks);
  EXPECT_EQ(table.up, Vec::UnitZ()) << "from the standing person";
  EXPECT_TRUE(table.has_times);
  ASSERT_EQ(table.rows.size(), 11u);
  EXPECT_EQ(table.rows[4].frame, 104);
  EXPECT_EQ(table.rows[4].id, TrackId(3));
  for (const char* column :
       {"pelvis_speed_m_s", "com_speed_m_s", "l_wrist_speed_m_s"}) {
    // Two frames apart the bobbing is the same.
    EXPECT_NEAR(ValueAt(table, 5, column), 1.5, 1e-10) << column;
    EXPECT_TRUE(std::isnan(ValueAt(table, 0, column)));
    EXPECT_TRUE(std::isnan(ValueAt(table, 10, column)));
  }
  // Path along the floor, without the bobbing.
  EXPECT_NEAR(ValueAt(table, 10, "pelvis_path_m"), 0.3, kMetreRounding);
  EXPECT_EQ(ValueAt(table, 0, "pelvis_path_m"), 0.0);
  EXPECT_TRUE(std::isnan(ValueAt(table, 5, "nose_speed_m_s"))) << "no nose";
}

TEST(Kinematics, JointsOfUnknownNamesHaveSpeeds) {
  TrackSequence tracks;
  tracks.header.skeleton =
      Skeleton("mouse", {"tail_base", "l_paw", "l_hand_5", "l_index"}, {});
  for (int k = 0; k < 3; ++k) {
    PersonPose mouse;
    mouse.id = TrackId(0);
    mouse.joints.assign(4, {Vec(0.01 * k, 0.0, 0.0), JointStatus::kObserved});
    tracks.frames.push_back({k, TimeNs{20000000} * k, {mouse}});
  }
  const KinematicsTable table = MeasureKinematics(tracks);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"tail_base_speed_m_s",
                                                     "l_paw_speed_m_s"}));
  EXPECT_NEAR(ValueAt(table, 1, "tail_base_speed_m_s"), 0.5, 1e-10);
  EXPECT_THAT(table.notes, ::testing::Contains(::testing::HasSubstr(
                               "none of the joints that angles need")));
}

TEST(Kinematics, AGapHasNoSpeedAndAStraightPath) {
  TrackSequence tracks = Walk(11);
  tracks.frames[5].people.clear();
  const KinematicsTable table = MeasureKinematics(tracks);
  ASSERT_EQ(table.rows.size(), 10u);
  // Rows 4 and 5 are the frames 104 and 106, on both sides of the gap.
  EXPECT_TRUE(std::isnan(ValueAt(table, 4, "pelvis_speed_m_s")));
  EXPECT_TRUE(std::isnan(ValueAt(table, 5, "pelvis_speed_m_s")));
  EXPECT_NEAR(ValueAt(table, 6, "pelvis_speed_m_s"), 1.5, 1e-10);
  EXPECT_NEAR(ValueAt(table, 9, "pelvis_path_m"), 0.3, kMetreRounding);
}

TEST(Kinematics, PeopleAreKeptApart) {
  TrackSequence tracks = Walk(6);
  for (size_t k = 0; k < 6; ++k) {
    tracks.frames[k].people.push_back(
        StandingAt({2.0, 0.06 * static_cast<double>(k), 0.0}, 1));
  }
  const KinematicsTable table = MeasureKinematics(tracks);
  ASSERT_EQ(table.rows.size(), 12u);
  EXPECT_NEAR(ValueAt(table, 10, "pelvis_path_m"), 0.15, kMetreRounding);
  EXPECT_NEAR(ValueAt(table, 11, "pelvis_path_m"), 0.30, kMetreRounding);
  EXPECT_NEAR(ValueAt(table, 7, "pelvis_speed_m_s"), 3.0, 1e-10);
}

TEST(Kinematics, MissingJointsGiveNoValue) {
  TrackSequence tracks = Walk(5);
  PosedPerson person;
  tracks.frames[2].people[0].joints[PosedPerson::Index("l_hip")] = {};
  tracks.frames[3].people[0].joints[PosedPerson::Index("r_knee")].status =
      JointStatus::kInferred;
  KinematicsTable table = MeasureKinematics(tracks);
  for (const char* column :
       {"l_hip_flexion_deg", "r_hip_flexion_deg", "trunk_forward_deg",
        "com_x_m", "pelvis_speed_m_s", "pelvis_path_m"}) {
    EXPECT_TRUE(std::isnan(ValueAt(table, 2, column))) << column;
  }
  EXPECT_NEAR(ValueAt(table, 2, "r_knee_flexion_deg"), 0.0, 1e-9);
  EXPECT_NEAR(ValueAt(table, 3, "r_knee_flexion_deg"), 0.0, 1e-9);
  EXPECT_NEAR(ValueAt(table, 4, "pelvis_path_m"), 0.12, kMetreRounding);
  KinematicsOptions options;
  options.observed_only = true;
  table = MeasureKinematics(tracks, options);
  EXPECT_TRUE(std::isnan(ValueAt(table, 3, "r_knee_flexion_deg")));
}

TEST(Kinematics, NotesWhatCannotBeComputed) {
  TrackSequence tracks = Walk(3);
  for (TrackFrame& frame : tracks.frames) frame.time = 0;
  KinematicsTable table = MeasureKinematics(tracks);
  EXPECT_FALSE(table.has_times);
  EXPECT_EQ(table.IndexOf("pelvis_speed_m_s"), -1);
  EXPECT_EQ(table.IndexOf("l_knee_flexion_low_deg"), -1) << "no covariances";
  ASSERT_EQ(table.notes.size(), 2u);
  EXPECT_NE(table.notes[0].find("no covariances"), std::string::npos);
  EXPECT_NE(table.notes[1].find("no times"), std::string::npos);
  PersonPose& person = tracks.frames[1].people[0];
  person.covariances.assign(person.joints.size(), std::nullopt);
  for (const char* joint : {"l_hip", "l_knee", "l_ankle"}) {
    person.covariances[PosedPerson::Index(joint)] =
        1e-4 * Eigen::Matrix3d::Identity();
  }
  table = MeasureKinematics(tracks);
  EXPECT_GT(ValueAt(table, 1, "l_knee_flexion_high_deg"), 1.0);
  EXPECT_TRUE(std::isnan(ValueAt(table, 0, "l_knee_flexion_high_deg")));
  EXPECT_TRUE(std::isnan(ValueAt(table, 1, "r_knee_flexion_high_deg")));
}

// Heights of the segments' centres: trunk 1 + 0.66 0.5 = 1.33, upper arms
// 1.5 - 0.436 0.3 = 1.3692, forearms 1.2 - 0.682 0.25 = 1.0295, thighs
// 1 - 0.433 0.5 = 0.7835, shanks 0.5 - 0.606 0.4 = 0.2576. Times 0.578, 0.056,
// 0.044, 0.2, 0.122: 0.76874 + 0.0766752 + 0.045298 + 0.1567 + 0.0314272.
TEST(Kinematics, CentreOfMassMatchesHandComputedValue) {
  const KinematicsTable table = MeasureKinematics(Walk(1));
  EXPECT_NEAR(ValueAt(table, 0, "com_z_m"), 1.0788404, kMetreRounding);
  EXPECT_NEAR(ValueAt(table, 0, "com_y_m"), 0.0, kMetreRounding);
  TrackSequence hand = Walk(1);
  hand.header.skeleton = Skeleton("hand", {"a", "b"}, {});
  hand.frames[0].people[0].joints.resize(2);
  EXPECT_EQ(MeasureKinematics(hand).IndexOf("com_z_m"), -1);
}

// A lying person: angles within the body exist, those that depend on up do not.
TEST(Kinematics, UnknownUpOmitsDependentColumns) {
  TrackSequence tracks = Walk(11);
  for (TrackFrame& frame : tracks.frames) {
    for (Joint3d& joint : frame.people[0].joints) {
      const Vec at = joint.position_m;
      joint.position_m = {at.z(), at.y(), 0.3 + 0.5 * at.x()};
    }
  }
  const KinematicsTable table = MeasureKinematics(tracks);
  EXPECT_FALSE(table.up.has_value());
  for (const char* column :
       {"trunk_forward_deg", "trunk_right_deg", "pelvis_obliquity_deg",
        "pelvis_speed_m_s", "pelvis_path_m"}) {
    EXPECT_EQ(table.IndexOf(column), -1) << column;
  }
  EXPECT_NEAR(ValueAt(table, 5, "l_knee_flexion_deg"), 0.0, 1e-6);
  // Half of the walk's speed; two frames apart the bobbing is the same. The
  // tolerance only has to cover rounding errors of 1e-15 m in 0.04 s.
  EXPECT_NEAR(ValueAt(table, 5, "com_speed_m_s"), 0.75, 1e-10);
  EXPECT_THAT(table.notes, ::testing::Contains(::testing::HasSubstr("--up=z")));
  KinematicsOptions options;
  options.known.stated = Vec::UnitZ();
  const KinematicsTable stated = MeasureKinematics(tracks, options);
  EXPECT_EQ(stated.up, Vec::UnitZ());
  EXPECT_NEAR(std::abs(ValueAt(stated, 5, "trunk_forward_deg")), 90.0, 1e-6);
}

TEST(FloorHeightTest, ToesTouchTheFloorAndAnklesDoNot) {
  const auto floor_m = [](const std::string& joint, double height_m) {
    TrackSequence tracks;
    tracks.header.skeleton = Skeleton("one", {"l_knee", joint}, {});
    TrackFrame& frame = tracks.frames.emplace_back();
    PersonPose& person = frame.people.emplace_back();
    person.joints = {{{0.0, 0.0, 0.5}, JointStatus::kObserved},
                     {{0.0, 0.0, height_m}, JointStatus::kObserved}};
    return FloorHeight(tracks, Vec::UnitZ());
  };
  EXPECT_NEAR(floor_m("l_big_toe", 0.02), 0.02, 1e-12);
  EXPECT_NEAR(floor_m("l_ankle", 0.10), 0.02, 1e-12);
  EXPECT_NEAR(floor_m("l_paw", 0.02), 0.02, 1e-12);
}

}  // namespace
}  // namespace kinegraph
