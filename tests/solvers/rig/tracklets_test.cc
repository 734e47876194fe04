// Tests tracklets of synthetic figures, and the similarity of their motion.
#include "solvers/rig/tracklets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/constants.h"
#include "core/base/time.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A figure of the twelve body joints of COCO-17 in normalised coordinates: six
// rows of two, in a box of 0.06 x 0.2.
const double kFigureSize = std::hypot(0.06, 0.2);

Detection FigureAt(const Eigen::Vector2d& place) {
  Detection figure;
  figure.joints.resize(17);
  for (int j = 5; j < 17; ++j) {
    const Eigen::Vector2d at =
        place +
        Eigen::Vector2d(j % 2 == 0 ? -0.03 : 0.03, 0.04 * ((j - 5) / 2));
    figure.joints[j] = {1000.0 * at + Eigen::Vector2d(960.0, 540.0), 1.0, true};
  }
  return figure;
}

// The same figure, `sizes` times its size to the right of the image's centre.
Detection FigureAside(double sizes) {
  return FigureAt({sizes * kFigureSize, 0.0});
}

using FiguresOfFrames = std::vector<std::vector<Detection>>;

// One view's recording.
DetectionSequence RecordingOf(const FiguresOfFrames& frames, double rate_hz) {
  DetectionSequence recording;
  recording.header.skeleton = Coco17();
  recording.header.view_names = {"cam0"};
  recording.header.frame_rate_hz = rate_hz;
  for (size_t k = 0; k < frames.size(); ++k) {
    DetectionFrame& frame = recording.frames.emplace_back();
    frame.frame = static_cast<int64_t>(k);
    frame.time = FrameClock(rate_hz).TimeOf(frame.frame);
    frame.views.resize(1);
    frame.views[0].detections = frames[k];
  }
  return recording;
}

std::vector<ViewTracklet> Followed(const FiguresOfFrames& frames,
                                   double rate_hz = 25.0) {
  return FollowInViews(testing::RingOfCameras(1), RecordingOf(frames, rate_hz),
                       RigJoints(Coco17()));
}

// One person at rest.
FiguresOfFrames AtRest(size_t frames) {
  return FiguresOfFrames(frames, {FigureAside(0.0)});
}

// First frames and ends of the tracklets.
std::vector<std::pair<int, int>> SpansOf(
    const std::vector<ViewTracklet>& tracklets) {
  std::vector<std::pair<int, int>> spans;
  for (const ViewTracklet& one : tracklets) {
    spans.emplace_back(one.first, one.end());
  }
  std::sort(spans.begin(), spans.end());
  return spans;
}

using Span = std::pair<int, int>;

TEST(RigJoints, AreLimbJointsOfPeople) {
  EXPECT_THAT(RigJoints(Coco17()),
              ElementsAre(5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
  // Neck, mid-hip, face and feet of BODY_25 are left out.
  std::vector<int> of_body25;
  for (const char* side : {"r_", "l_"}) {
    for (const char* name :
         {"shoulder", "elbow", "wrist", "hip", "knee", "ankle"}) {
      of_body25.push_back(Body25().IndexOf(side + std::string(name)));
    }
  }
  EXPECT_THAT(RigJoints(Body25()),
              ::testing::UnorderedElementsAreArray(of_body25));
}

TEST(RigJoints, AreAllJointsOfAWand) {
  const Skeleton wand("wand", {"top", "grip"}, {{0, 1}});
  EXPECT_THAT(RigJoints(wand), ElementsAre(0, 1));
}

TEST(ViewTrackletTest, SeenAtAndOverlap) {
  ViewTracklet one;
  one.first = 3;
  one.detections = {0, -1, 2};
  EXPECT_EQ(one.end(), 6);
  EXPECT_FALSE(one.SeenAt(2));
  EXPECT_TRUE(one.SeenAt(3));
  EXPECT_FALSE(one.SeenAt(4));
  EXPECT_TRUE(one.SeenAt(5));
  EXPECT_FALSE(one.SeenAt(6));
  ViewTracklet other;
  other.detections = {0};
  for (const int first : {2, 6}) {
    other.first = first;
    EXPECT_FALSE(Overlap(one, other)) << first;
    EXPECT_FALSE(Overlap(other, one)) << first;
  }
  for (const int first : {3, 4, 5}) {
    other.first = first;
    EXPECT_TRUE(Overlap(one, other)) << first;
    EXPECT_TRUE(Overlap(other, one)) << first;
  }
}

TEST(FollowInViews, NoTrackletsWithoutPeople) {
  EXPECT_THAT(Followed({}), IsEmpty());
  EXPECT_THAT(Followed(FiguresOfFrames(50)), IsEmpty());
}

TEST(FollowInViews, OnePersonIsOneTrackletInNormalisedCoordinates) {
  FiguresOfFrames frames;
  for (int k = 0; k < 40; ++k) {
    frames.push_back({FigureAt({0.002 * k, -0.001 * k})});
  }
  frames[7][0].joints[9].found = false;
  frames[8][0].joints[9].confidence = 0.29;  // less than kMinJointConfidence
  const auto tracklets = Followed(frames);
  ASSERT_EQ(tracklets.size(), 1u);
  const ViewTracklet& one = tracklets.front();
  EXPECT_EQ(one.first, 0);
  EXPECT_EQ(one.end(), 40);
  // Pixel coordinates near 1000 are rounded to 1e-13, which is 1e-16 at a focal
  // length of 1000 px; sums of a few terms add a little.
  constexpr double kRounding = 1e-14;
  EXPECT_NEAR(one.size, kFigureSize, kRounding);
  for (int k = 0; k < 40; ++k) {
    EXPECT_EQ(one.detections[k], 0);
    const NormalisedJoints& points = one.At(k);
    ASSERT_EQ(points.cols(), 12);
    for (int j = 0; j < 12; ++j) {
      if (j == 4 && (k == 7 || k == 8)) {
        EXPECT_TRUE(std::isnan(points(0, j)) && std::isnan(points(1, j)));
        continue;
      }
      EXPECT_NEAR(points(0, j), 0.002 * k + (j % 2 == 0 ? 0.03 : -0.03),
                  kRounding);
      EXPECT_NEAR(points(1, j), -0.001 * k + 0.04 * (j / 2), kRounding);
    }
  }
}

TEST(FollowInViews, RemovesLensDistortion) {
  const CameraRig cameras =
      testing::RingOfCameras(2, 5.0, {-0.12, 0.03, 0.001, -0.0005, 0.0});
  const auto person = [](int frame) {
    return std::vector<Pose3d>{
        testing::StandingPerson(0.01 * frame - 0.2, 0.5)};
  };
  const std::vector<int> joints = RigJoints(Coco17());
  const auto tracklets =
      FollowInViews(cameras, testing::SeenBy(cameras, 40, person), joints);
  ASSERT_EQ(tracklets.size(), 2u);
  for (const ViewTracklet& one : tracklets) {
    const Camera& camera = cameras[one.view];
    for (int k = 0; k < 40; ++k) {
      for (size_t j = 0; j < joints.size(); ++j) {
        const Eigen::Vector3d in_camera =
            camera.R() * person(k)[0][joints[j]].position_m + camera.t();
        // The lens is inverted to 1e-13 of distorted coordinates; a hundred
        // times that covers the slope of the distortion, which is near 1, and
        // rounding.
        EXPECT_LT((one.At(k).col(static_cast<Eigen::Index>(j)) -
                   in_camera.hnormalized())
                      .norm(),
                  1e-11);
      }
    }
  }
}

TEST(FollowInViews, SeparatePeopleKeepTrackletsInAnyDetectionOrder) {
  FiguresOfFrames frames;
  for (int k = 0; k < 50; ++k) {
    frames.push_back({FigureAside(-1.0 + 0.02 * k), FigureAside(1.0)});
    if (k % 3 == 1) std::swap(frames.back()[0], frames.back()[1]);
  }
  const auto tracklets = Followed(frames);
  ASSERT_EQ(tracklets.size(), 2u);
  EXPECT_THAT(SpansOf(tracklets), ElementsAre(Span(0, 50), Span(0, 50)));
  for (const ViewTracklet& one : tracklets) {
    for (int k = 0; k < 50; ++k) {
      const bool exchanged = one.detections[k] != one.detections[0];
      EXPECT_EQ(exchanged, k % 3 == 1) << k;
    }
  }
}

// Two people start two sizes left and right of the centre, approach each other
// by 0.05 sizes per frame each, and meet in frame 40, where both are equally
// near to both tracklets.
TEST(FollowInViews, BothTrackletsEndIfPeopleMeet) {
  FiguresOfFrames frames;
  for (int k = 0; k <= 80; ++k) {
    frames.push_back(
        {FigureAside(-2.0 + 0.05 * k), FigureAside(2.0 - 0.05 * k)});
  }
  const auto tracklets = Followed(frames);
  EXPECT_THAT(SpansOf(tracklets), ElementsAre(Span(0, 40), Span(0, 40),
                                              Span(41, 81), Span(41, 81)));
  // No tracklet contains another person.
  for (const ViewTracklet& one : tracklets) {
    EXPECT_THAT(one.detections, ::testing::Each(one.detections.front()));
  }
}

// Number of tracklets of a person who steps by `sizes` from one frame to the
// next, between two intervals of two seconds at rest, alone or with another
// person in view.
int TrackletsOfAStep(double sizes, bool alone) {
  FiguresOfFrames frames;
  for (int k = 0; k < 100; ++k) {
    frames.push_back({FigureAside(k < 50 ? 0.0 : sizes)});
    if (!alone) frames.back().push_back(FigureAside(-3.0));
  }
  return static_cast<int>(Followed(frames).size()) - (alone ? 0 : 1);
}

// The gate is 0.1 sizes plus two sizes per second: 0.18 from frame to frame at
// 25 Hz, and four times that for a single person.
TEST(FollowInViews, StepsBeyondTheGateStartANewTracklet) {
  EXPECT_EQ(TrackletsOfAStep(0.17, false), 1);
  EXPECT_EQ(TrackletsOfAStep(0.19, false), 2);
  EXPECT_EQ(TrackletsOfAStep(0.71, true), 1);
  EXPECT_EQ(TrackletsOfAStep(0.73, true), 2);
}

// Tracklets with `missing` empty frames between two intervals of two seconds at
// rest.
std::vector<ViewTracklet> AfterAGap(int missing, double rate_hz) {
  const auto half = static_cast<size_t>(std::lround(2.0 * rate_hz));
  FiguresOfFrames frames = AtRest(2 * half + static_cast<size_t>(missing));
  for (int k = 0; k < missing; ++k) frames[half + k].clear();
  return Followed(frames, rate_hz);
}

// The time between detections is 0.04 s times one more than the number of
// missing frames. Exactly 0.4 s are bridged.
TEST(FollowInViews, GapsOfFourTenthsOfASecondAreBridged) {
  const auto bridged = AfterAGap(9, 25.0);
  ASSERT_EQ(bridged.size(), 1u);
  EXPECT_EQ(bridged[0].end(), 109);
  for (int k = 0; k < 109; ++k) {
    EXPECT_EQ(bridged[0].SeenAt(k), k < 50 || k >= 59) << k;
    EXPECT_EQ(bridged[0].joints[k].size(), bridged[0].SeenAt(k) ? 24 : 0);
  }
  EXPECT_THAT(SpansOf(AfterAGap(10, 25.0)),
              ElementsAre(Span(0, 50), Span(60, 110)));
}

// Ten detections in two seconds, twice. A gap of three frames is longer than
// 0.4 s, but is bridged at a low frame rate.
TEST(FollowInViews, GapsOfThreeFramesAreBridgedAtLowFrameRates) {
  EXPECT_THAT(SpansOf(AfterAGap(3, 5.0)), ElementsAre(Span(0, 23)));
  EXPECT_THAT(SpansOf(AfterAGap(4, 5.0)),
              ElementsAre(Span(0, 10), Span(14, 24)));
}

TEST(FollowInViews, TrackletsNeedASecondAndTenDetections) {
  // 26 frames span one second.
  EXPECT_THAT(Followed(AtRest(25)), IsEmpty());
  EXPECT_THAT(SpansOf(Followed(AtRest(26))), ElementsAre(Span(0, 26)));
  // At 5 Hz nine detections span 1.6 s.
  EXPECT_THAT(Followed(AtRest(9), 5.0), IsEmpty());
  EXPECT_THAT(SpansOf(Followed(AtRest(10), 5.0)), ElementsAre(Span(0, 10)));
}

// Detections 0.04 sizes apart are one person, 0.5 sizes apart two.
TEST(FollowInViews, KeepsTheMostCompleteOfDuplicateDetections) {
  for (const bool fuller_first : {false, true}) {
    FiguresOfFrames frames;
    for (int k = 0; k < 30; ++k) {
      Detection partly = FigureAside(0.04);
      partly.joints[7].found = false;
      frames.push_back({partly, FigureAside(0.0)});
      if (fuller_first) std::swap(frames[k][0], frames[k][1]);
    }
    const auto tracklets = Followed(frames);
    ASSERT_EQ(tracklets.size(), 1u);
    EXPECT_THAT(tracklets[0].detections, ::testing::Each(fuller_first ? 0 : 1));
  }
  const FiguresOfFrames apart(30, {FigureAside(0.0), FigureAside(0.5)});
  EXPECT_EQ(Followed(apart).size(), 2u);
}

TEST(FollowInViews, PersonNeedsFourJoints) {
  for (const int found : {3, 4}) {
    FiguresOfFrames frames = AtRest(30);
    for (auto& figures : frames) {
      for (int j = 5 + found; j < 17; ++j) figures[0].joints[j].found = false;
    }
    EXPECT_EQ(Followed(frames).size(), found == 4 ? 1u : 0u) << found;
  }
}

// Both joints of a wand are required.
TEST(FollowInViews, WandNeedsBothJoints) {
  FiguresOfFrames frames(30);
  for (auto& figures : frames) {
    figures.resize(1);
    figures[0].joints = {{{900.0, 500.0}, 1.0, true},
                         {{980.0, 560.0}, 1.0, true}};
  }
  DetectionSequence recording = RecordingOf(frames, 25.0);
  recording.header.skeleton = Skeleton("wand", {"top", "grip"}, {{0, 1}});
  const CameraRig cameras = testing::RingOfCameras(1);
  const auto tracklets = FollowInViews(cameras, recording, {0, 1});
  ASSERT_EQ(tracklets.size(), 1u);
  // The diagonal of 80 and 60 px at a focal length of 1000 px.
  EXPECT_NEAR(tracklets[0].size, 0.1, 1e-14);
  for (auto& frame : recording.frames) {
    frame.views[0].detections[0].joints[1].found = false;
  }
  EXPECT_THAT(FollowInViews(cameras, recording, {0, 1}), IsEmpty());
}

// ---- The similarity of motions ----

// An upright person of size one whose joints oscillate vertically and
// horizontally, each at its own frequency.
ViewTracklet Moving(int view, int first, int frames, double phase) {
  ViewTracklet tracklet;
  tracklet.view = view;
  tracklet.first = first;
  tracklet.size = 1.0;
  for (int k = 0; k < frames; ++k) {
    NormalisedJoints points(2, 12);
    for (int j = 0; j < 12; ++j) {
      const double angle = 2.0 * kPi * (0.7 + 0.13 * j) * k / 25.0 + phase * j;
      points(0, j) = (j % 2 == 0 ? 0.2 : -0.2) + 0.05 * std::cos(angle);
      points(1, j) = 0.2 * (j / 2) + 0.06 * std::sin(1.3 * angle);
    }
    tracklet.detections.push_back(0);
    tracklet.joints.push_back(points);
  }
  return tracklet;
}

// Motion signals of the tracklets, each in its own view.
MotionSignals SignalsOf(std::vector<ViewTracklet> tracklets,
                        double rate_hz = 25.0) {
  int views = 0;
  for (ViewTracklet& one : tracklets) one.view = views++;
  return MotionSignals(tracklets, RigJoints(Coco17()), Coco17(), views,
                       rate_hz);
}

// Signals are floats; sums of a few thousand products have errors of about
// 1e-6.
constexpr double kOfFloats = 1e-5;

// The step in frames is the frame rate over 12.5 Hz, rounded, and at least one.
TEST(MotionSignals, SamplingRateIsAboutTwelveHertz) {
  const std::vector<std::pair<double, int>> steps = {
      {5.0, 1}, {12.5, 1}, {25.0, 2}, {30.0, 2}, {50.0, 4}, {60.0, 5}};
  for (const auto& [rate_hz, step] : steps) {
    EXPECT_EQ(SignalsOf({}, rate_hz).step(), step) << rate_hz;
  }
}

TEST(MotionSignals, MotionMatchesItself) {
  const MotionSignals signals = SignalsOf({Moving(0, 0, 100, 0.0)});
  const auto likeness = signals.Compare(0, 0, 0);
  EXPECT_NEAR(likeness.correlation, 1.0, kOfFloats);
  EXPECT_EQ(likeness.samples, 50);  // every other frame
}

TEST(MotionSignals, DelayedMotionMatchesAtItsLag) {
  const MotionSignals signals =
      SignalsOf({Moving(0, 10, 100, 0.0), Moving(1, 24, 100, 0.0)});
  // 14 frames are seven samples.
  const auto right = signals.Compare(0, 1, 7);
  EXPECT_NEAR(right.correlation, 1.0, kOfFloats);
  EXPECT_EQ(right.samples, 50);
  for (int lag = -20; lag <= 20; ++lag) {
    const auto one = signals.Compare(0, 1, lag);
    const auto turned = signals.Compare(1, 0, -lag);
    EXPECT_EQ(one.samples, 50 - std::abs(lag - 7)) << lag;
    EXPECT_EQ(turned.samples, one.samples) << lag;
    EXPECT_NEAR(turned.correlation, one.correlation, kOfFloats) << lag;
    // The signals are heights and speeds. The slowest height oscillates at
    // 1.3 * 0.7 = 0.91 Hz: one sample of 0.08 s changes its phase by 26
    // degrees, whose cosine is 0.9, and that of the other heights by more.
    // Speeds vary mostly at twice the joints' frequencies.
    if (lag == 7) continue;
    EXPECT_LT(one.correlation, 0.9) << lag;
  }
}

// Images of different cameras differ in position, size, mirroring and roll.
TEST(MotionSignals, SimilarityIsInvariantToTranslationScaleMirroringAndRoll) {
  const ViewTracklet one = Moving(0, 0, 100, 0.4);
  ViewTracklet other = one;
  other.size = 0.3;
  Eigen::Matrix2d turn;
  turn << 0.0, -1.0, 1.0, 0.0;
  for (NormalisedJoints& points : other.joints) {
    points.row(0) *= -1.0;
    points = (0.3 * turn * points).eval();
    points.colwise() += Eigen::Vector2d(0.7, -0.4);
  }
  const auto likeness = SignalsOf({one, other}).Compare(0, 1, 0);
  EXPECT_NEAR(likeness.correlation, 1.0, kOfFloats);
}

TEST(MotionSignals, DifferentMotionsAreLessSimilar) {
  const MotionSignals signals =
      SignalsOf({Moving(0, 0, 200, 0.0), Moving(1, 0, 200, 1.7)});
  EXPECT_LT(signals.Compare(0, 1, 0).correlation, 0.5);
}

// All coordinates are multiples of 1/4, and shoulders and hips are symmetric
// about the centre, so nothing is rounded.
TEST(MotionSignals, PersonAtRestHasNoSimilarity) {
  NormalisedJoints pose(2, 12);
  for (int j = 0; j < 12; ++j) {
    pose.col(j) << (j % 2 == 0 ? 0.25 : -0.25), (j / 2) / 4.0;
  }
  pose.col(6).y() = pose.col(7).y() = 0.5;
  ViewTracklet still = Moving(0, 0, 100, 0.0);
  still.joints.assign(100, pose);
  const auto likeness = SignalsOf({still}).Compare(0, 0, 0);
  EXPECT_EQ(likeness.correlation, 0.0);
  EXPECT_EQ(likeness.samples, 50);
}

// At 25 Hz and every other frame, a second has 12.5 samples, rounded to 13.
TEST(MotionSignals, LessThanASecondHasNoSimilarity) {
  const MotionSignals signals =
      SignalsOf({Moving(0, 0, 60, 0.0), Moving(1, 0, 60, 0.0)});
  EXPECT_EQ(signals.Compare(0, 1, 17).samples, 13);
  EXPECT_EQ(signals.Compare(0, 1, 18).samples, 0);
  EXPECT_EQ(signals.Compare(0, 1, 18).correlation, 0.0);
  EXPECT_EQ(signals.Compare(0, 1, 500).samples, 0);
  EXPECT_EQ(signals.Compare(0, 1, -500).samples, 0);
}

// The fraction of the signal's energy that is lost if some joints are missing.
// The inner product with the whole signal is the remaining energy, so the
// squared correlation is the remaining fraction.
double ShareOf(const std::vector<Eigen::Index>& joints) {
  const ViewTracklet whole = Moving(0, 0, 200, 0.0);
  ViewTracklet partly = whole;
  for (NormalisedJoints& points : partly.joints) {
    for (const Eigen::Index j : joints) {
      points.col(j).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  const MotionSignals signals = SignalsOf({whole, partly});
  EXPECT_NEAR(signals.Compare(1, 1, 0).correlation, 1.0, kOfFloats);
  const double correlation = signals.Compare(0, 1, 0).correlation;
  return 1.0 - correlation * correlation;
}

// Wrists and knees do not contribute to the body's centre.
TEST(MotionSignals, MissingJointsReduceTheEnergyAdditively) {
  const double of_wrist = ShareOf({5});
  const double of_knee = ShareOf({8});
  EXPECT_GT(of_wrist, 0.01);
  EXPECT_GT(of_knee, 0.01);
  // Three numbers, each with twice the error of a correlation.
  EXPECT_NEAR(ShareOf({5, 8}), of_wrist + of_knee, 6.0 * kOfFloats);
}

// A frame without a detection is a sample without motion.
TEST(MotionSignals, FramesWithoutDetectionsHaveNoMotion) {
  ViewTracklet gaps = Moving(0, 0, 200, 0.0);
  for (const int k : {40, 42, 120}) {
    gaps.detections[k] = -1;
    gaps.joints[k].resize(2, 0);
  }
  const MotionSignals signals = SignalsOf({gaps});
  const auto likeness = signals.Compare(0, 0, 0);
  EXPECT_NEAR(likeness.correlation, 1.0, kOfFloats);
  EXPECT_EQ(likeness.samples, 100);
}

}  // namespace
}  // namespace kinegraph
