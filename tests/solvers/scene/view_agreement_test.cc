// Tests the agreement of views, in closed form for two cameras side by side,
// whose epipolar lines are the rows of their images.
#include "solvers/scene/view_agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/skeleton/anthropometry.h"
#include "solvers/cameras/camera_change.h"
#include "tests/support/moving_people.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Gains of order 1 are computed from sums of a few dozen products of pixel
// coordinates, about 1e3, with a rounding error of 1e-12; the tolerance is a
// hundred times that.
constexpr double kRoundingOfGains = 1e-10;

// The second camera is 1 m to the right of the first.
CameraRig SideBySide() {
  CameraRig cameras;
  for (const double x_m : {0.0, 1.0}) {
    CameraParameters p;
    p.name = x_m > 0.0 ? "right" : "left";
    p.width_px = 1920;
    p.height_px = 1080;
    p.K << 1000.0, 0.0, 960.0, 0.0, 1000.0, 540.0, 0.0, 0.0, 1.0;
    p.t = Eigen::Vector3d(-x_m, 0.0, 0.0);
    cameras.emplace_back(p);
  }
  return cameras;
}

// Twelve joints in six rows: 30 px wide and 40 px high.
constexpr double kPersonPx = 50.0;
ViewPeople::Person PersonAt(double x_px, double y_px) {
  ViewPeople::Person person;
  for (int j = 0; j < 12; ++j) {
    person.px.emplace_back(x_px + 30.0 * (j % 2), y_px + 8.0 * (j / 2));
    person.found.push_back(1);
  }
  person.size_px = kPersonPx;
  return person;
}

// The person in the right view; at 5 m, 200 px further left.
ViewPeople::Person SeenRight(const ViewPeople::Person& person, double down_px,
                             double left_px = 200.0) {
  ViewPeople::Person seen = person;
  for (Eigen::Vector2d& px : seen.px) px += Eigen::Vector2d(-left_px, down_px);
  return seen;
}

using PeopleInView = std::vector<ViewPeople::Person>;

ViewPeople ViewOf(std::vector<PeopleInView> frames) {
  ViewPeople view;
  view.frames = std::move(frames);
  return view;
}

// The agreement of one frame.
PairAgreement AgreementSideBySide(const PeopleInView& left,
                                  const PeopleInView& right) {
  const CameraRig cameras = SideBySide();
  return AgreementOf(cameras[0], ViewOf({left}), cameras[1], ViewOf({right}),
                     {0});
}

// ---- Agreement of two views ----

// Joints in rows that differ by d are at distance d from each other's epipolar
// lines: the gain is 1 minus d over a tenth of the person's size, and the
// distance is d, at most that tenth.
TEST(PairAgreement, DecreasesWithEpipolarDistance) {
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  for (const double d_px : {0.0, 1.0, 2.5, 4.9, 5.0, 7.0, -1.0, -60.0}) {
    const PairAgreement one =
        AgreementSideBySide({person}, {SeenRight(person, d_px)});
    const double off_px = std::min(std::abs(d_px), 0.1 * kPersonPx);
    EXPECT_EQ(one.possible, 1.0);
    EXPECT_NEAR(one.gain, 1.0 - off_px / (0.1 * kPersonPx), kRoundingOfGains)
        << d_px;
    EXPECT_NEAR(one.mean_px(), off_px, kPersonPx * kRoundingOfGains) << d_px;
  }
}

// The gain uses the mean of the distances relative to the person's size in each
// view.
TEST(PairAgreement, UsesPersonSizesOfBothViews) {
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  ViewPeople::Person larger = SeenRight(person, 2.0);
  larger.size_px = 2.0 * kPersonPx;
  const double expected =
      1.0 - 0.5 * (2.0 / (0.1 * kPersonPx) + 2.0 / (0.2 * kPersonPx));
  EXPECT_NEAR(AgreementSideBySide({person}, {larger}).gain, expected,
              kRoundingOfGains);
}

TEST(PairAgreement, IsTheMeanOverCommonJoints) {
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  ViewPeople::Person other = SeenRight(person, 0.0);
  // Three of twelve joints are far off.
  for (const int j : {1, 4, 6}) other.px[j].y() += 300.0;
  EXPECT_NEAR(AgreementSideBySide({person}, {other}).gain, 0.75,
              kRoundingOfGains);
  // Two of these are not found, which leaves one outlier among ten joints.
  other.found[1] = other.found[6] = 0;
  EXPECT_NEAR(AgreementSideBySide({person}, {other}).gain, 0.9,
              kRoundingOfGains);
}

TEST(PairAgreement, NeedsSixCommonJoints) {
  ViewPeople::Person person = PersonAt(900.0, 500.0);
  ViewPeople::Person other = SeenRight(person, 0.0);
  for (const int j : {0, 1, 2}) person.found[j] = 0;
  for (const int j : {9, 10, 11}) other.found[j] = 0;
  EXPECT_NEAR(AgreementSideBySide({person}, {other}).gain, 1.0,
              kRoundingOfGains);
  other.found[8] = 0;
  const PairAgreement none = AgreementSideBySide({person}, {other});
  EXPECT_EQ(none.gain, 0.0);
  EXPECT_EQ(none.possible, 1.0);
}

// A person further right in the right view is behind both cameras.
TEST(PairAgreement, PeopleBehindTheCamerasGainNothing) {
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  const PairAgreement behind =
      AgreementSideBySide({person}, {SeenRight(person, 0.0, -200.0)});
  EXPECT_EQ(behind.gain, 0.0);
  EXPECT_EQ(behind.possible, 1.0);
  EXPECT_NEAR(behind.mean_px(), 0.1 * kPersonPx, kRoundingOfGains);
}

TEST(PairAgreement, CoincidentCamerasGainNothing) {
  const CameraRig cameras = SideBySide();
  const ViewPeople view = ViewOf({{PersonAt(900.0, 500.0)}});
  const PairAgreement one =
      AgreementOf(cameras[0], view, cameras[0], view, {0});
  EXPECT_EQ(one.gain, 0.0);
  EXPECT_EQ(one.possible, 1.0);
  EXPECT_EQ(one.score(), 0.0);
}

TEST(PairAgreement, IsZeroWithoutPeople) {
  const PairAgreement nobody = AgreementSideBySide({}, {});
  EXPECT_EQ(nobody.possible, 0.0);
  EXPECT_EQ(nobody.score(), 0.0);
  EXPECT_EQ(nobody.mean_px(), 0.0);
  EXPECT_EQ(AgreementSideBySide({PersonAt(900.0, 500.0)}, {}).possible, 0.0);
}

// The best pair is matched first: the left view's first person is 1 px from the
// middle one of the right view's three and 3 px from the last; the second is
// 2 px from the middle one, which is already matched, and 4 px from the last.
TEST(PairAgreement, MatchesEachPersonOnceBestPairsFirst) {
  const ViewPeople::Person first = PersonAt(900.0, 500.0);
  const ViewPeople::Person second = PersonAt(940.0, 499.0);
  const PeopleInView left = {first, second};
  const PeopleInView right = {SeenRight(first, 300.0), SeenRight(first, 1.0),
                              SeenRight(first, 3.0)};
  // Gains of 0.8 and of 1 - 4 / 5.
  for (const bool turned : {false, true}) {
    PeopleInView others = right;
    if (turned) std::reverse(others.begin(), others.end());
    const PairAgreement one = AgreementSideBySide(left, others);
    EXPECT_EQ(one.possible, 2.0);
    EXPECT_NEAR(one.gain, 0.8 + 0.2, kRoundingOfGains);
    EXPECT_NEAR(one.distance_px, 1.0 + 4.0, kPersonPx * kRoundingOfGains);
  }
}

TEST(PairAgreement, IsSymmetricInTheViews) {
  const CameraRig cameras = SideBySide();
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  const ViewPeople left = ViewOf({{person, PersonAt(400.0, 300.0)}});
  const ViewPeople right = ViewOf({{SeenRight(person, 1.7)}});
  const PairAgreement one =
      AgreementOf(cameras[0], left, cameras[1], right, {0});
  const PairAgreement other =
      AgreementOf(cameras[1], right, cameras[0], left, {0});
  EXPECT_EQ(one.possible, other.possible);
  EXPECT_NEAR(one.gain, other.gain, kRoundingOfGains);
}

// The person moves down by 3 px per frame, two frames later in the right view.
// At other lags, rows differ by 3 px per frame of difference.
TEST(PairAgreement, LagsShiftTheSecondView) {
  const CameraRig cameras = SideBySide();
  std::vector<PeopleInView> left;
  std::vector<PeopleInView> right;
  for (int k = 0; k < 10; ++k) {
    left.push_back({PersonAt(900.0, 300.0 + 3.0 * k)});
    right.push_back({SeenRight(PersonAt(900.0, 300.0 + 3.0 * (k - 2)), 0.0)});
  }
  const std::vector<int> frames = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const std::vector<int> lags = {-3, 1, 2, 3, 20};
  const auto at = AgreementsOf(cameras[0], ViewOf(left), cameras[1],
                               ViewOf(right), frames, lags);
  ASSERT_EQ(at.size(), 5u);
  // All frames that exist in both views are compared.
  for (size_t i = 0; i < lags.size(); ++i) {
    EXPECT_EQ(at[i].possible, std::max(0, 10 - std::abs(lags[i])));
  }
  EXPECT_NEAR(at[1].score(), 1.0 - 3.0 / 5.0, kRoundingOfGains);
  EXPECT_NEAR(at[2].score(), 1.0, kRoundingOfGains);
  EXPECT_NEAR(at[3].score(), 1.0 - 3.0 / 5.0, kRoundingOfGains);
  EXPECT_EQ(at[0].score(), 0.0);
  // Single lags give the same result.
  for (size_t i = 0; i < lags.size(); ++i) {
    const PairAgreement one = AgreementOf(cameras[0], ViewOf(left), cameras[1],
                                          ViewOf(right), frames, lags[i]);
    EXPECT_EQ(one.gain, at[i].gain);
    EXPECT_EQ(one.distance_px, at[i].distance_px);
  }
}

TEST(PairAgreement, AddSumsAllFields) {
  PairAgreement sum = {1.5, 2.0, 6.0};
  sum.Add({0.3, 1.0, 3.0});
  EXPECT_DOUBLE_EQ(sum.score(), 0.6);
  EXPECT_DOUBLE_EQ(sum.mean_px(), 3.0);
}

// A gain of 0.08 and a score of 0.3 are required; 0.15 and 0.5 give the full
// confidence.
TEST(AgreementGain, IsEnoughDependsOnGainAndScore) {
  AgreementGain gain;
  gain.before = {0.5, 1.0, 0.0};
  gain.after = {0.57, 1.0, 0.0};
  EXPECT_NEAR(gain.gain(), 0.07, 1e-15);
  EXPECT_FALSE(gain.is_enough());
  gain.after.gain = 0.59;
  EXPECT_TRUE(gain.is_enough());
  gain.before.gain = 0.1;
  gain.after.gain = 0.29;
  EXPECT_FALSE(gain.is_enough());
  EXPECT_THAT(AgreementGain::Needed(0.0), DoubleEq(0.3));
  EXPECT_THAT(AgreementGain::Needed(0.5), DoubleEq(0.58));
  EXPECT_THAT(AgreementGain::Sureness(0.5, 0.9), DoubleEq(0.95));
  EXPECT_THAT(AgreementGain::Sureness(0.075, 0.9), DoubleEq(0.475));
  EXPECT_THAT(AgreementGain::Sureness(0.075, 0.25), DoubleEq(0.2375));
}

// ---- All views ----

// People with errors of a few pixels, so that no value is at a limit.
DetectionSequence NoisyPeople(const CameraRig& cameras) {
  DetectionSequence seen = testing::SeenBy(cameras, 10, [](int frame) {
    return std::vector<Pose3d>{testing::MovingPerson(0, 5.0 * frame),
                               testing::MovingPerson(1, 5.0 * frame)};
  });
  Random random(4);
  for (DetectionFrame& frame : seen.frames) {
    for (ViewDetections& view : frame.views) {
      for (Detection& detection : view.detections) {
        for (Keypoint& joint : detection.joints) {
          joint.px.x() += random.Normal(0.0, 4.0);
          joint.px.y() += random.Normal(0.0, 4.0);
        }
      }
    }
  }
  return seen;
}

const std::vector<int> kTenFrames = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

TEST(AgreementOfAll, InvariantToWorldFrameAndOrderOfPeopleAndViews) {
  CameraRig cameras = testing::RingOfCameras(3);
  DetectionSequence seen = NoisyPeople(cameras);
  const PairAgreement before =
      AgreementOfAll(cameras, IdealPeople(seen, cameras), kTenFrames);
  EXPECT_EQ(before.possible, 3.0 * 10.0 * 2.0);
  EXPECT_GT(before.score(), 0.5);
  const Eigen::Matrix3d turn = ExpRotation({0.3, -0.8, 1.1});
  cameras = Edited(cameras, [&](CameraParameters* camera) {
    camera->R = camera->R * turn.transpose();
    camera->t -= camera->R * Eigen::Vector3d(2.0, 3.0, -1.0);
  });
  for (DetectionFrame& frame : seen.frames) {
    for (ViewDetections& view : frame.views) {
      std::reverse(view.detections.begin(), view.detections.end());
    }
  }
  const PairAgreement after =
      AgreementOfAll(cameras, IdealPeople(seen, cameras), kTenFrames);
  EXPECT_EQ(after.possible, before.possible);
  // 60 matches of people whose size is at most 500 px.
  EXPECT_NEAR(after.gain, before.gain, 60.0 * kRoundingOfGains);
  EXPECT_NEAR(after.distance_px, before.distance_px,
              60.0 * 500.0 * kRoundingOfGains);
  // Distances are in pixels of a pair's first view and change with the order of
  // views.
  std::swap(cameras[0], cameras[2]);
  for (DetectionFrame& frame : seen.frames) {
    std::swap(frame.views[0], frame.views[2]);
  }
  const PairAgreement turned =
      AgreementOfAll(cameras, IdealPeople(seen, cameras), kTenFrames);
  EXPECT_EQ(turned.possible, before.possible);
  EXPECT_NEAR(turned.gain, before.gain, 60.0 * kRoundingOfGains);
}

TEST(ComparisonsOfAll, IsTheSumOfProductsOfPeopleCounts) {
  const ViewPeople::Person one = PersonAt(900.0, 500.0);
  const std::vector<ViewPeople> views = {ViewOf({{one, one}, {one}}),
                                         ViewOf({{one, one, one}, {}}),
                                         ViewOf({{one}, {one, one}})};
  // First frame: 2 x 3 + 2 x 1 + 3 x 1; second frame: 0 + 1 x 2 + 0.
  EXPECT_EQ(ComparisonsOfAll(views, {0}), 11.0);
  EXPECT_EQ(ComparisonsOfAll(views, {0, 1}), 13.0);
  EXPECT_EQ(ComparisonsOfAll(views, {}), 0.0);
}

// ---- Selection of people and frames ----

TEST(PeopleOfViews, RequiresSixConfidentJoints) {
  const CameraRig cameras = testing::RingOfCameras(1);
  const auto person = [](int) {
    return std::vector<Pose3d>(3, testing::StandingPerson(0.0, 0.0));
  };
  DetectionSequence seen = testing::SeenBy(cameras, 1, person);
  auto& detections = seen.frames[0].views[0].detections;
  for (size_t j = 6; j < 17; ++j) {
    // Six joints of the first person and five of the second are found with
    // sufficient confidence.
    detections[0].joints[j].confidence = 0.29;
    detections[1].joints[j].found = false;
    // All joints of the third person lie at one point.
    detections[2].joints[j].px = detections[2].joints[0].px;
  }
  detections[1].joints[5].found = false;
  for (size_t j = 0; j < 6; ++j) {
    detections[0].joints[j].px = {100.0 + 3.0 * j, 200.0 + 4.0 * j};
    detections[2].joints[j].px = detections[2].joints[0].px;
  }
  const std::vector<ViewPeople> views = PeopleOfViews(seen);
  ASSERT_EQ(views.size(), 1u);
  ASSERT_EQ(views[0].frames.size(), 1u);
  ASSERT_EQ(views[0].frames[0].size(), 1u);
  const ViewPeople::Person& first = views[0].frames[0][0];
  EXPECT_EQ(std::count(first.found.begin(), first.found.end(), 1), 6);
  EXPECT_EQ(first.px[2], Eigen::Vector2d(106.0, 208.0));
  // The box is 15 by 20 px.
  EXPECT_EQ(first.size_px, 25.0);
}

TEST(PeopleOfViews, KeepsTheHundredPeopleWithMostJoints) {
  const CameraRig cameras = testing::RingOfCameras(1);
  const auto crowd = [](int) {
    return std::vector<Pose3d>(103, testing::StandingPerson(0.0, 0.0));
  };
  DetectionSequence seen = testing::SeenBy(cameras, 1, crowd);
  for (const size_t d : {4u, 50u, 102u}) {
    seen.frames[0].views[0].detections[d].joints[0].found = false;
  }
  const std::vector<ViewPeople> views = PeopleOfViews(seen);
  ASSERT_EQ(views[0].frames[0].size(), 100u);
  for (const ViewPeople::Person& person : views[0].frames[0]) {
    EXPECT_EQ(person.found[0], 1);
  }
}

TEST(IdealPeople, EqualPinholeProjections) {
  const auto person = [](int) {
    return std::vector<Pose3d>{testing::StandingPerson(0.3, -0.2)};
  };
  const CameraRig bent =
      testing::RingOfCameras(1, 5.0, {-0.12, 0.03, 0.001, -0.0005, 0.0});
  const CameraRig straight = testing::RingOfCameras(1);
  const auto ideal = IdealPeople(testing::SeenBy(bent, 1, person), bent);
  const auto exact =
      IdealPeople(testing::SeenBy(straight, 1, person), straight);
  const auto& one = ideal[0].frames[0][0];
  const auto& other = exact[0].frames[0][0];
  for (size_t j = 0; j < one.px.size(); ++j) {
    EXPECT_EQ(one.found[j], 1);
    // The lens is inverted to 1e-13 of a focal length of 1000 px; a hundred
    // times that covers the slope of the distortion and rounding.
    EXPECT_LT((one.px[j] - other.px[j]).norm(), 1e-8);
  }
}

TEST(Frames, EvenSelectionBeginsWithTheFirst) {
  EXPECT_THAT(Evenly(kTenFrames, 4), ElementsAre(0, 2, 5, 7));
  EXPECT_THAT(Evenly(kTenFrames, 1), ElementsAre(0));
  EXPECT_THAT(Evenly({3, 8}, 2), ElementsAre(3, 8));
  EXPECT_THAT(Evenly({3, 8}, 5), ElementsAre(3, 8));
  EXPECT_THAT(Evenly(kTenFrames, 0), IsEmpty());
  EXPECT_THAT(Evenly({}, 3), IsEmpty());
}

TEST(Frames, AreSelectedFoundAndShifted) {
  const CameraRig cameras = testing::RingOfCameras(2);
  DetectionSequence seen = NoisyPeople(cameras);
  for (DetectionFrame& frame : seen.frames) frame.frame = 100 + 3 * frame.frame;
  const DetectionSequence some = FramesOf(seen, {7, 2});
  ASSERT_EQ(some.frames.size(), 2u);
  EXPECT_EQ(some.frames[0].frame, 121);
  EXPECT_EQ(some.frames[1].frame, 106);
  EXPECT_EQ(some.header.view_names, seen.header.view_names);
  EXPECT_EQ(IndexOfFrame(seen, 121), 7);
  EXPECT_EQ(IndexOfFrame(seen, 122), -1);
  EXPECT_EQ(IndexOfFrame(seen, 99), -1);
  // The second view in reverse; its first frame has no source.
  const DetectionSequence moved = FramesMoved(seen, [](size_t view, int64_t k) {
    return view == 0 ? k : k == 0 ? int64_t{10} : 9 - k;
  });
  for (size_t k = 0; k < 10; ++k) {
    EXPECT_EQ(moved.frames[k].frame, seen.frames[k].frame);
    EXPECT_EQ(moved.frames[k].time, seen.frames[k].time);
    EXPECT_EQ(moved.frames[k].views[0].detections[0].joints[3].px,
              seen.frames[k].views[0].detections[0].joints[3].px);
    const auto& detections = moved.frames[k].views[1].detections;
    if (k == 0) {
      EXPECT_THAT(detections, IsEmpty());
      continue;
    }
    EXPECT_EQ(detections[0].joints[3].px,
              seen.frames[9 - k].views[1].detections[0].joints[3].px);
  }
}

TEST(FramesToLookAt, AreFramesWithPeopleInTwoViews) {
  const ViewPeople::Person one = PersonAt(900.0, 500.0);
  const std::vector<ViewPeople> views = {
      ViewOf({{one}, {one}, {}, {one}, {}, {}}),
      ViewOf({{one}, {}, {}, {one}, {one}, {one}}),
      ViewOf({{one}, {}, {}, {}, {one}, {}})};
  EXPECT_THAT(FramesToLookAt(views, 10), ElementsAre(0, 3, 4));
  EXPECT_THAT(FramesToLookAt(views, 2), ElementsAre(0, 3));
  EXPECT_THAT(FramesToLookAt({}, 10), IsEmpty());
  EXPECT_THAT(FramesToLookAt({views[0]}, 10), IsEmpty());
}

// 40 x 50 = 2000 comparisons per frame and a limit of four million permit 2000
// frames without repetition and four frames with 500 repetitions; at least two
// frames are used.
TEST(FramesToLookAt, AreFewForCrowds) {
  const ViewPeople::Person one = PersonAt(900.0, 500.0);
  const std::vector<ViewPeople> views = {
      ViewOf(std::vector<PeopleInView>(20, PeopleInView(40, one))),
      ViewOf(std::vector<PeopleInView>(20, PeopleInView(50, one)))};
  EXPECT_EQ(FramesToLookAt(views, 15).size(), 15u);
  EXPECT_THAT(FramesToLookAt(views, 15, 500), ElementsAre(0, 5, 10, 15));
  EXPECT_THAT(FramesToLookAt(views, 15, 100000), ElementsAre(0, 10));
}

// ---- People in 3D ----

TEST(PlacePeople, RecoversExactJoints) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const auto people = [](int frame) {
    return std::vector<Pose3d>{testing::MovingPerson(0, 5.0 * frame),
                               testing::MovingPerson(1, 5.0 * frame)};
  };
  DetectionSequence seen = testing::SeenBy(cameras, 2, people);
  // One joint is missing in the third view.
  seen.frames[1].views[2].detections[0].joints[9].found = false;
  const auto placed = PlacePeople(cameras, IdealPeople(seen, cameras), {0, 1});
  // Two people, three pairs of views and two frames.
  ASSERT_EQ(placed.size(), 12u);
  for (const PlacedPerson& person : placed) {
    const auto truth = people(person.frame);
    // The true person with the nearest nose.
    const size_t who =
        (*person.joints[0] - truth[0][0].position_m).norm() <
                (*person.joints[0] - truth[1][0].position_m).norm()
            ? 0
            : 1;
    for (size_t j = 0; j < 17; ++j) {
      const bool seen_by_both =
          !(person.frame == 1 && person.view_b == 2 && who == 0 && j == 9);
      ASSERT_EQ(person.joints[j].has_value(), seen_by_both) << j;
      if (!seen_by_both) continue;
      // Pixel coordinates of about 1000 are rounded to 1e-13; rays are 5 m long
      // and meet at 60 degrees.
      EXPECT_LT((*person.joints[j] - truth[who][j].position_m).norm(), 1e-9);
    }
  }
}

// The rays of cameras 0.05 m apart to a person at 5 m enclose 0.01 rad.
TEST(PlacePeople, NearlyParallelRaysPlaceNobody) {
  CameraRig cameras = SideBySide();
  cameras[1] = Edited(cameras[1],
                      [](CameraParameters* camera) { camera->t.x() = -0.05; });
  const ViewPeople::Person person = PersonAt(900.0, 500.0);
  const std::vector<ViewPeople> views = {
      ViewOf({{person}}), ViewOf({{SeenRight(person, 0.0, 10.0)}})};
  for (const PlacedPerson& one : PlacePeople(cameras, views, {0})) {
    for (const auto& joint : one.joints) EXPECT_FALSE(joint.has_value());
  }
}

// Vectors [m]: shoulder to hip 0.08 and 0.5, hip to knee 0.01, 0.03 and 0.42,
// knee to ankle 0.03 and 0.41. The sum of their lengths is 0.779 of the
// stature.
TEST(StatureOf, FollowsFromBoneLengths) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const auto person = [](int frame) {
    return std::vector<Pose3d>{testing::StandingPerson(0.1 * frame, 0.0)};
  };
  const DetectionSequence seen = testing::SeenBy(cameras, 4, person);
  const Stature stature = StatureOf(cameras, seen, 100);
  const double bones_m = std::hypot(0.08, 0.5) + std::hypot(0.01, 0.03, 0.42) +
                         std::hypot(0.03, 0.41);
  EXPECT_NEAR(stature.median_m, bones_m / kAnkleToShoulderShare, 1e-9);
  // Two sides of the body, three pairs of views and four frames.
  EXPECT_EQ(stature.count, 24);
  // If lengths are in feet, the stature is in feet.
  const Stature feet = StatureOf(Rescaled(cameras, 1.0 / 0.3048), seen, 100);
  EXPECT_NEAR(feet.median_m, stature.median_m / 0.3048, 1e-9);
}

TEST(StatureOf, IsUnknownWithoutHumans) {
  const CameraRig cameras = testing::RingOfCameras(3);
  const auto nobody = [](int) { return std::vector<Pose3d>(); };
  DetectionSequence seen = testing::SeenBy(cameras, 4, nobody);
  EXPECT_EQ(StatureOf(cameras, seen, 100).count, 0);
  EXPECT_EQ(StatureOf(cameras, seen, 100).median_m, 0.0);
  const auto person = [](int) {
    return std::vector<Pose3d>{testing::StandingPerson(0.0, 0.0)};
  };
  seen = testing::SeenBy(cameras, 4, person);
  std::vector<std::string> joints = Coco17().joints();
  joints[0] = "tail_base";
  seen.header.skeleton = Skeleton("cat", joints, {});
  EXPECT_EQ(StatureOf(cameras, seen, 100).count, 0);
}

TEST(PlacedJoint, IsFoundByNameAmongTheComparedJoints) {
  PlacedPerson person;
  for (const int j : Body25().association_joints()) {
    person.joints.emplace_back(Eigen::Vector3d::Constant(j));
  }
  for (const char* name : {"nose", "l_wrist", "r_ankle"}) {
    const auto joint = PlacedJoint(person, Body25(), name);
    ASSERT_TRUE(joint.has_value()) << name;
    EXPECT_EQ(joint->x(), Body25().IndexOf(name));
  }
  // Feet are not compared, and wings do not exist.
  EXPECT_FALSE(PlacedJoint(person, Body25(), "l_heel").has_value());
  EXPECT_FALSE(PlacedJoint(person, Body25(), "l_wing").has_value());
}

}  // namespace
}  // namespace kinegraph
