// Checks of input before use and of results before writing.
#include "core/data/checks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/data/identity_edit.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

// Two views of the same person, at 100 s.
struct TwoViews {
  DetectionHeader header;
  DetectionFrame frame;

  TwoViews() {
    header.skeleton = Coco17();
    header.view_names = {"left", "right"};
    frame = testing::FrameSeenBy(testing::RingOfCameras(2), 2500,
                                 {testing::StandingPerson(0.0, 0.0)});
  }
  std::string Refusal() const {
    try {
      CheckDetectionFrame(header, frame);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CheckDetectionFrame, NamesTheFrameAndTheView) {
  TwoViews whole;
  EXPECT_EQ(whole.Refusal(), "");
  TwoViews views = whole;
  views.frame.views.pop_back();
  EXPECT_TRUE(
      Contains(views.Refusal(), "frame 2500: found 1 views, expected 2"))
      << views.Refusal();
  TwoViews joints = whole;
  joints.frame.views[1].detections[0].joints.pop_back();
  EXPECT_TRUE(
      Contains(joints.Refusal(), "view 'right': found 16 joints, expected 17"))
      << joints.Refusal();
}

TEST(CheckDetectionFrame, OnlyFoundJointsMustBeFinite) {
  for (const bool found : {true, false}) {
    TwoViews pixel;
    Keypoint& joint = pixel.frame.views[0].detections[0].joints[4];
    joint.px.y() = std::nan("");
    joint.found = found;
    EXPECT_EQ(Contains(pixel.Refusal(), "is not finite"), found);
    TwoViews confidence;
    Keypoint& other = confidence.frame.views[0].detections[0].joints[4];
    other.confidence = INFINITY;
    other.found = found;
    EXPECT_EQ(Contains(confidence.Refusal(), "view 'left'"), found);
  }
}

TEST(CheckCaptureTime, ClocksMayBeTenSecondsApart) {
  const TimeNs second = FromSeconds(1.0);
  for (const int sign : {-1, 1}) {
    TwoViews clocks;
    clocks.frame.views[1].capture_time = clocks.frame.time + sign * 10 * second;
    EXPECT_EQ(clocks.Refusal(), "");
    clocks.frame.views[1].capture_time += sign * second;
    EXPECT_TRUE(Contains(clocks.Refusal(), "'right' has")) << clocks.Refusal();
  }
  // The difference of these times overflows TimeNs.
  const TimeNs most = std::numeric_limits<TimeNs>::max();
  EXPECT_THROW(CheckCaptureTime("left", most, -most), InputError);
}

// A frame of one person, as it would be written.
struct Written {
  CameraRig cameras = testing::RingOfCameras(4);
  TrackHeader header;
  TrackFrame frame;

  Written() {
    header.skeleton = Coco17();
    frame.frame = 12;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(3);
    person.joints = testing::StandingPerson(0.0, 0.0);
    person.covariances.resize(17);
  }
  Joint3d& joint() { return frame.people[0].joints[5]; }
  void SetCovariance(const Eigen::Matrix3d& covariance) {
    frame.people[0].covariances[5] = covariance;
  }
  std::string Fault() const {
    try {
      PoseCheck(cameras).Require(header, frame);
    } catch (const std::logic_error& error) {
      return error.what();
    }
    return "";
  }
};

TEST(PoseCheck, PositionsAreFiniteAndInTheScene) {
  Written written;
  EXPECT_EQ(written.Fault(), "");
  // The ring has a radius of 5 m; the limit is a billion times that.
  written.joint().position_m.x() = 4.9e9;
  EXPECT_EQ(written.Fault(), "");
  const std::vector<double> wrong = {5.1e9, -5.1e9, INFINITY, std::nan("")};
  for (const double x_m : wrong) {
    written.joint().position_m.x() = x_m;
    EXPECT_TRUE(Contains(written.Fault(), "frame 12, person 3, l_shoulder"))
        << written.Fault();
  }
  written.joint().status = JointStatus::kMissing;
  EXPECT_EQ(written.Fault(), "");
}

TEST(PoseCheck, OneCameraSetsNoLimitOfPositions) {
  Written written;
  written.cameras = testing::RingOfCameras(1);
  written.joint().position_m.x() = 1e30;
  EXPECT_EQ(written.Fault(), "");
  written.joint().position_m.x() = std::nan("");
  EXPECT_NE(written.Fault(), "");
}

TEST(PoseCheck, CovariancesArePositiveSemidefiniteUpToRounding) {
  const Eigen::Vector3d u = Eigen::Vector3d(1.0, 2.0, 3.0).normalized();
  const Eigen::Vector3d v = u.unitOrthogonal();
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d flat = u * u.transpose() + 0.5 * v * v.transpose();
  Eigen::Matrix3d skewed = identity;
  skewed(0, 1) = 1e-6;
  Eigen::Matrix3d infinite = identity;
  infinite(2, 2) = INFINITY;
  Written written;
  for (const Eigen::Matrix3d& covariance :
       {identity, flat, Eigen::Matrix3d(1e-12 * flat)}) {
    written.SetCovariance(covariance);
    EXPECT_EQ(written.Fault(), "") << covariance;
  }
  // Zero, with an eigenvalue below 0 by more than rounding (1e-9 of the largest
  // entry), not symmetric, or not finite.
  for (const Eigen::Matrix3d& covariance :
       {Eigen::Matrix3d(-identity), Eigen::Matrix3d::Zero().eval(),
        Eigen::Matrix3d(flat - 1e-6 * identity), skewed, infinite}) {
    written.SetCovariance(covariance);
    EXPECT_TRUE(Contains(written.Fault(), "covariance")) << covariance;
  }
}

// ---- Names after corrections ----

IdentityEdit Edit(EditOp op, int64_t one, int64_t other) {
  IdentityEdit edit;
  edit.op = op;
  edit.persons = {TrackId(one), TrackId(other)};
  return edit;
}

IdentityEdit Naming(int64_t one, const std::string& name) {
  IdentityEdit edit;
  edit.op = EditOp::kName;
  edit.persons = {TrackId(one)};
  edit.name = name;
  return edit;
}

TEST(NamesAfter, AJoinPassesANameToAnUnnamedPerson) {
  EXPECT_EQ(NamesAfter({Naming(2, "Ann"), Edit(EditOp::kJoin, 1, 2)}),
            (PersonNames{{TrackId(1), "Ann"}}));
  // A person with a name keeps it; the other's name is lost.
  EXPECT_EQ(NamesAfter({Naming(2, "Ann"), Naming(1, "Bob"),
                        Edit(EditOp::kJoin, 1, 2)}),
            (PersonNames{{TrackId(1), "Bob"}}));
  EXPECT_EQ(NamesAfter({Naming(1, "Bob"), Edit(EditOp::kJoin, 1, 2)}),
            (PersonNames{{TrackId(1), "Bob"}}));
}

TEST(NamesAfter, LastNameCountsAndOtherEditsKeepNames) {
  EXPECT_TRUE(NamesAfter({}).empty());
  EXPECT_EQ(NamesAfter({Naming(1, "Bob"), Naming(1, "Robert"),
                        Edit(EditOp::kCut, 1, 2), Edit(EditOp::kSwap, 1, 2),
                        Edit(EditOp::kUndecided, 3, 1)}),
            (PersonNames{{TrackId(1), "Robert"}}));
}

TEST(FrameSpan, ContainsBothEnds) {
  const FrameSpan span = {3, 5};
  for (int64_t frame = 0; frame < 9; ++frame) {
    EXPECT_EQ(span.Contains(frame), frame >= 3 && frame <= 5) << frame;
  }
}

}  // namespace
}  // namespace kinegraph
