#include "core/evaluation/world_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;

// Two people who walk, at some distance from the origin.
TrackSequence Walkers() {
  TrackSequence tracks = Tracks({});
  for (int k = 0; k < 50; ++k) {
    tracks.frames.push_back(
        Frame(k, {Person(0, StandingTum14(1.0 + 0.05 * k, 2.0)),
                  Person(1, StandingTum14(-2.0, 1.0 + 0.05 * k))}));
  }
  return tracks;
}

TrackSequence Mapped(TrackSequence tracks, const Eigen::Matrix3d& map) {
  for (TrackFrame& frame : tracks.frames) {
    for (PersonPose& person : frame.people) {
      for (Joint3d& joint : person.joints) {
        joint.position_m = map * joint.position_m;
      }
    }
  }
  return tracks;
}

WorldCheck Check(const TrackSequence& truth, const TrackSequence& tracks) {
  return CheckWorld(PairFrames(truth, tracks), CommonJoints(Tum14(), Tum14()));
}

TEST(CheckWorldTest, OneWorldGivesNoNote) {
  const WorldCheck check = Check(Walkers(), Walkers());
  EXPECT_EQ(check.found.count, 100);
  EXPECT_FALSE(check.other.has_value());
  EXPECT_EQ(check.Text(), "");
}

TEST(CheckWorldTest, FindsTheAxesAndUnitsThatMatchPeople) {
  Eigen::Matrix3d y_up;  // X, Y, Z of the truth are x, z, -y of the tracks
  y_up << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(1, 1) = -1.0;
  const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
  struct Case {
    Eigen::Matrix3d turn;
    double scale;
    const char* axes;
    bool is_mirrored;
  };
  for (const Case& one :
       {Case{y_up, 1.0, "x,z,-y", false}, Case{none, 1000.0, "x,y,z", false},
        Case{none, 0.01, "x,y,z", false}, Case{y_up, 10.0, "x,z,-y", false},
        Case{mirror, 1.0, "x,-y,z", true}}) {
    SCOPED_TRACE(one.axes);
    const WorldCheck check =
        Check(Mapped(Walkers(), one.scale * one.turn), Walkers());
    EXPECT_EQ(check.found.count, 0);
    ASSERT_TRUE(check.other.has_value());
    EXPECT_EQ(check.other->found.count, 100);
    EXPECT_EQ(check.other->AxesText(), one.axes);
    EXPECT_NEAR(check.other->scale * one.scale, 1.0, 1e-12);
    EXPECT_EQ(check.other->is_mirrored(), one.is_mirrored);
    EXPECT_TRUE(check.other->axes.isApprox(one.turn.transpose()));
    EXPECT_THAT(check.Text(), HasSubstr("0 of 100 true people"));
  }
}

TEST(CheckWorldTest, ReportsSubjectsThatTheGateDoesNotSuit) {
  const auto text = [](double scale) {
    const TrackSequence scaled =
        Mapped(Walkers(), scale * Eigen::Matrix3d::Identity());
    return Check(scaled, scaled).GateText();
  };
  EXPECT_EQ(text(1.0), "");
  EXPECT_EQ(text(0.5), "");
  // The box around a person is 1.75 m high and 0.5 m wide.
  EXPECT_THAT(text(0.05), HasSubstr("extend over 0.091 m"));
  EXPECT_THAT(text(0.05), HasSubstr("even a track beside them"));
  EXPECT_THAT(text(10.0), HasSubstr("may not"));
  Pose3d point(14);
  point[0] = Observed(1.0, 2.0, 0.0);
  const TrackSequence points = Tracks({Frame(0, {Person(0, point)})});
  EXPECT_EQ(Check(points, points).GateText(), "") << "unknown size";
}

TEST(CheckWorldTest, ReportsThatNoAxesOrUnitsMatch) {
  TrackSequence elsewhere = Walkers();
  for (TrackFrame& frame : elsewhere.frames) {
    for (PersonPose& person : frame.people) {
      person.joints = Moved(person.joints, 7.0, 4.0);
    }
  }
  const WorldCheck check = Check(Walkers(), elsewhere);
  EXPECT_FALSE(check.other.has_value());
  EXPECT_THAT(check.Text(), HasSubstr("no track is within 0.5 m"));
  TrackSequence nobody = Walkers();
  for (TrackFrame& frame : nobody.frames) frame.people.clear();
  EXPECT_THAT(Check(Walkers(), nobody).Text(), HasSubstr("people in both"));
  // That one of the two people is not found is not sufficient evidence for
  // another world.
  TrackSequence one = elsewhere;
  for (size_t f = 0; f < one.frames.size(); ++f) {
    one.frames[f].people[0] = Walkers().frames[f].people[0];
  }
  EXPECT_EQ(Check(Walkers(), one).Text(), "");
}

}  // namespace
}  // namespace kinegraph::testing
