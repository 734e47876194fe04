// Tests pairs of views of people whose positions are known exactly.
#include "solvers/rig/view_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>
#include <vector>

#include "solvers/cameras/camera_change.h"
#include "tests/support/moving_people.h"

namespace kinegraph {
namespace {

using ::testing::IsEmpty;
using testing::kMovingRateHz;
using testing::MovingTracklet;
using testing::PoseBetween;

constexpr int kPairFrames = 100;
// For exact points the cost is a rounding error of about 1e-16, and the pose
// has an error of its square root, 1e-8; weakly determined directions need a
// hundred times that.
constexpr double kExactPose = 1e-6;
// Gain of unrelated joints by chance.
constexpr double kChance = 0.35;

// Two people in both views; the second view is late by `late` frames. Tracklets
// 0 and 1 are of the first view, 2 and 3 of the second.
std::vector<ViewTracklet> TwoPeopleIn(const CameraRig& cameras, int late = 0) {
  std::vector<ViewTracklet> tracklets;
  for (const int view : {0, 1}) {
    for (const int who : {0, 1}) {
      tracklets.push_back(MovingTracklet(cameras[view], view, who, kPairFrames,
                                         view == 1 ? late : 0));
    }
  }
  return tracklets;
}

PairFit SearchPairOf(const std::vector<ViewTracklet>& tracklets, int a, int b,
                     PairSearchOptions options = {}) {
  options.frame_rate_hz = kMovingRateHz;
  options.longest_lag_s = std::min(options.longest_lag_s, 1.0);
  const MotionSignals signals(tracklets, RigJoints(Coco17()), Coco17(), 3,
                              options.frame_rate_hz);
  return SearchViewPair(tracklets, signals, a, b, options);
}

// The matched tracklets.
std::set<std::pair<int, int>> WhoIsWho(const PairFit& pair) {
  std::set<std::pair<int, int>> matches;
  for (const TrackletMatch& one : pair.matches) matches.insert({one.a, one.b});
  return matches;
}

using Matches = std::set<std::pair<int, int>>;

void ExpectPose(const RelativePose& found, const RelativePose& truth) {
  EXPECT_LT((found.R - truth.R).norm(), kExactPose);
  EXPECT_LT((found.t - truth.t).norm(), kExactPose);
}

// Evidence [s] of exact joints: the gain beyond chance times the time for which
// people are matched.
double EvidenceOf(int people, int frames) {
  return (1.0 - kChance) * people * frames / kMovingRateHz;
}

TEST(ViewPairs, RecoversLagPoseAndMatchesOfExactPeople) {
  const CameraRig cameras = testing::RingOfCameras(3);
  for (const int late : {0, 7, -9}) {
    const PairFit pair = SearchPairOf(TwoPeopleIn(cameras, late), 0, 1);
    EXPECT_EQ(pair.a, 0);
    EXPECT_EQ(pair.b, 1);
    EXPECT_EQ(pair.lag, late);
    ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
    EXPECT_EQ(WhoIsWho(pair), (Matches{{0, 2}, {1, 3}}));
    // Gains are one minus the squared distance, about 1e-12 here, divided by
    // the square of 3 % of a person's size.
    for (const TrackletMatch& one : pair.matches) {
      EXPECT_NEAR(one.gain, 1.0, 1e-6);
    }
    EXPECT_NEAR(pair.evidence, EvidenceOf(2, kPairFrames - std::abs(late)),
                1e-4);
    EXPECT_LT(pair.rival, pair.evidence);
    EXPECT_FALSE(pair.is_undecided());
    EXPECT_FALSE(pair.is_pose_undecided());
  }
}

TEST(ViewPairs, ExchangedViewsGiveTheInversePose) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras, 7);
  for (ViewTracklet& one : tracklets) one.view = 1 - one.view;
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  EXPECT_EQ(pair.lag, -7);
  ExpectPose(pair.pose, PoseBetween(cameras[1], cameras[0]));
  EXPECT_EQ(WhoIsWho(pair), (Matches{{2, 0}, {3, 1}}));
}

TEST(ViewPairs, InvariantToTheOrderOfPeople) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  std::swap(tracklets[2], tracklets[3]);
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
  EXPECT_EQ(WhoIsWho(pair), (Matches{{0, 3}, {1, 2}}));
}

// Views 0 and 1 see two people, view 2 another person.
TEST(ViewPairs, UsesOnlyTheTwoViews) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  tracklets.insert(tracklets.begin(),
                   MovingTracklet(cameras[2], 2, 5, kPairFrames));
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  EXPECT_EQ(WhoIsWho(pair), (Matches{{1, 3}, {2, 4}}));
}

// A third person is seen by the second view alone.
TEST(ViewPairs, PersonInASingleViewIsNotMatched) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  tracklets.push_back(MovingTracklet(cameras[1], 1, 4, kPairFrames));
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
  EXPECT_EQ(WhoIsWho(pair), (Matches{{0, 2}, {1, 3}}));
}

// Both parts of an interrupted tracklet are matched, because they do not
// overlap.
TEST(ViewPairs, PartsOfATrackletMatchTheSamePerson) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  ViewTracklet later = tracklets[3];
  constexpr int kBreak = 40;
  later.first = kBreak;
  later.detections.erase(later.detections.begin(),
                         later.detections.begin() + kBreak);
  later.joints.erase(later.joints.begin(), later.joints.begin() + kBreak);
  tracklets[3].detections.resize(kBreak);
  tracklets[3].joints.resize(kBreak);
  tracklets.push_back(later);
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  EXPECT_EQ(WhoIsWho(pair), (Matches{{0, 2}, {1, 3}, {1, 4}}));
  EXPECT_NEAR(pair.evidence, EvidenceOf(2, kPairFrames), 1e-4);
}

TEST(ViewPairs, FramesAndJointsMissingInOneViewAreOmitted) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  for (int k = 20; k < 30; ++k) {
    tracklets[0].detections[k] = -1;
    tracklets[0].joints[k].resize(2, 0);
  }
  for (NormalisedJoints& points : tracklets[3].joints) {
    points.col(4).setConstant(kNan);
  }
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
  EXPECT_NEAR(pair.evidence,
              EvidenceOf(1, kPairFrames) + EvidenceOf(1, kPairFrames - 10),
              1e-4);
}

TEST(ViewPairs, NoEvidenceIfAViewSeesNobody) {
  const CameraRig cameras = testing::RingOfCameras(3);
  for (const auto& tracklets :
       {TwoPeopleIn(cameras), std::vector<ViewTracklet>()}) {
    const PairFit pair = SearchPairOf(tracklets, 0, 2);
    EXPECT_EQ(pair.a, 0);
    EXPECT_EQ(pair.b, 2);
    EXPECT_THAT(pair.matches, IsEmpty());
    EXPECT_EQ(pair.evidence, 0.0);
    EXPECT_EQ(pair.rival, 0.0);
  }
}

// People who were never in view at the same time, at any lag.
TEST(ViewPairs, NoEvidenceIfPeopleAreNeverSeenTogether) {
  const CameraRig cameras = testing::RingOfCameras(3);
  std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  tracklets[2].first = tracklets[3].first = 2 * kPairFrames;
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  EXPECT_THAT(pair.matches, IsEmpty());
  EXPECT_EQ(pair.evidence, 0.0);
}

// For synchronised views, lags are not searched.
TEST(ViewPairs, ZeroLongestLagGivesZeroLag) {
  const CameraRig cameras = testing::RingOfCameras(3);
  PairSearchOptions options;
  options.longest_lag_s = 0.0;
  EXPECT_EQ(SearchPairOf(TwoPeopleIn(cameras, 7), 0, 1, options).lag, 0);
  const PairFit pair = SearchPairOf(TwoPeopleIn(cameras), 0, 1, options);
  ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
}

TEST(ViewPairs, LeadAndDecisionFollowFromEvidenceAndRival) {
  PairFit pair;
  pair.evidence = 10.0;
  pair.rival = 7.9;
  EXPECT_DOUBLE_EQ(pair.lead(), 6.05);
  EXPECT_FALSE(pair.is_undecided());
  pair.rival = 8.1;
  EXPECT_TRUE(pair.is_undecided());
  EXPECT_TRUE(PairFit().is_undecided());
}

// The second person moves like the first, rotated by half a turn: exchanging
// them in one view gives another pose that fits all points.
TEST(ViewPairs, PeopleWhoCanBeExchangedLeaveThePoseUndecided) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const Eigen::Matrix3d half_turn =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).matrix();
  std::vector<ViewTracklet> tracklets;
  for (const int view : {0, 1}) {
    const Camera turned = Edited(cameras[view], [&](CameraParameters* camera) {
      camera->R *= half_turn;
    });
    for (const Camera& camera : {cameras[view], turned}) {
      tracklets.push_back(MovingTracklet(camera, view, 0, kPairFrames));
    }
  }
  const PairFit pair = SearchPairOf(tracklets, 0, 1);
  EXPECT_EQ(pair.lag, 0);
  EXPECT_NEAR(pair.evidence, EvidenceOf(2, kPairFrames), 1e-4);
  EXPECT_NEAR(pair.rival_pose, pair.evidence, 1e-4);
  EXPECT_TRUE(pair.is_pose_undecided());
}

// ---- Unknown focal lengths ----

// Coordinates normalised with focal lengths that are too short by
// `magnification`.
std::vector<ViewTracklet> Magnified(std::vector<ViewTracklet> tracklets,
                                    double magnification) {
  for (ViewTracklet& one : tracklets) {
    one.size *= magnification;
    for (NormalisedJoints& points : one.joints) points *= magnification;
  }
  return tracklets;
}

// If optical axes intersect equally far from both cameras, focal lengths are
// undetermined (Sturm, "On focal length calibration from two views", 2001), so
// the second camera is rotated. The gradient of the prior of 20 % is log(1.1) /
// 0.2^2 = 2.4, against about a thousand points, which a doubled focal length
// displaces by at least the scale of the loss (1.2 % of a person). The bias is
// therefore at most 0.24 %, and the tolerance four times that, because angles
// absorb part of the effect.
TEST(ViewPairs, RecoversFocalLengthsAndRefitsPoses) {
  CameraRig cameras = testing::RingOfCameras(3);
  cameras[1] = Edited(cameras[1], [](CameraParameters* camera) {
    const Eigen::Matrix3d turn = ExpRotation({0.1, 0.15, 0.05});
    camera->R = turn * camera->R;
    camera->t = turn * camera->t;
  });
  const RelativePose truth = PoseBetween(cameras[0], cameras[1]);
  const std::vector<ViewTracklet> tracklets = TwoPeopleIn(cameras);
  PairSearchOptions options;
  options.focal_sigma = 0.2;
  PairFit pair = SearchPairOf(Magnified(tracklets, 1.1), 0, 1, options);
  EXPECT_NEAR(pair.pose.magnification, 1.1, 0.01);
  EXPECT_EQ(WhoIsWho(pair), (Matches{{0, 2}, {1, 3}}));
  // With coordinates for the correct focal lengths, the pose is exact.
  RefitPose(tracklets, &pair);
  EXPECT_EQ(pair.pose.magnification, 1.0);
  ExpectPose(pair.pose, truth);
}

TEST(ViewPairs, RefitRecoversThePoseWithoutAStart) {
  const CameraRig cameras = testing::RingOfCameras(3);
  for (const int late : {0, 5}) {
    PairFit pair;
    pair.a = 0;
    pair.b = 1;
    pair.lag = late;
    pair.matches = {{0, 2, 1.0}, {1, 3, 1.0}};
    RefitPose(TwoPeopleIn(cameras, late), &pair);
    ExpectPose(pair.pose, PoseBetween(cameras[0], cameras[1]));
  }
}

TEST(ViewPairs, RefitWithoutPointsKeepsThePose) {
  const CameraRig cameras = testing::RingOfCameras(3);
  PairFit pair;
  pair.pose = PoseBetween(cameras[1], cameras[2]);
  pair.pose.magnification = 1.3;
  const RelativePose before = pair.pose;
  // One common frame has twelve points, but sixteen are required.
  pair.matches = {{0, 2, 1.0}};
  pair.lag = kPairFrames - 1;
  for (const auto& matches : {pair.matches, std::vector<TrackletMatch>()}) {
    pair.matches = matches;
    RefitPose(TwoPeopleIn(cameras), &pair);
    EXPECT_EQ(pair.pose.R, before.R);
    EXPECT_EQ(pair.pose.t, before.t);
    EXPECT_EQ(pair.pose.magnification, 1.0);
  }
}

}  // namespace
}  // namespace kinegraph
