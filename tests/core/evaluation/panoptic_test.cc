#include "core/evaluation/panoptic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

// Fifteen joints along a line.
Pose3d Line(double x) {
  Pose3d pose;
  for (int j = 0; j < 15; ++j) pose.push_back(Observed(x, 0.0, 0.125 * j));
  return pose;
}

// Frames of people, by position and score.
TrackSequence Panoptic(
    const std::vector<std::vector<std::pair<double, double>>>& frames) {
  TrackSequence tracks = Tracks({}, Panoptic15());
  for (const auto& people : frames) {
    TrackFrame frame = Frame(static_cast<int64_t>(tracks.frames.size()), {});
    for (const auto& [x, score] : people) {
      frame.people.push_back(
          Person(static_cast<int64_t>(frame.people.size()), Line(x)));
      frame.people.back().score = score;
    }
    tracks.frames.push_back(std::move(frame));
  }
  return tracks;
}

PanopticResult At(double threshold_m, const TrackSequence& truth,
                  const TrackSequence& found) {
  PanopticOptions options;
  options.thresholds_m = {threshold_m};
  return EvaluatePanoptic(truth, found, options);
}

const TrackSequence kOne = Panoptic({{{0, 0}}});

TEST(PanopticTest, PerfectPosesScoreOne) {
  const TrackSequence truth = Panoptic({{{0, 0}, {2, 0}}});
  const PanopticResult result = EvaluatePanoptic(truth, truth);
  ASSERT_EQ(result.average_precision.size(), 6u);
  EXPECT_EQ(result.average_precision[0], 1.0);
  EXPECT_EQ(result.recall_at_limit.count, 2);
  EXPECT_EQ(result.mpjpe_m, 0.0);
  EXPECT_EQ(result.joints_compared.count, 30);
}

TEST(PanopticTest, PrecisionFollowsTheScores) {
  // In order of score, the poses are correct, wrong (too far) and correct. The
  // precision is 1, 1/2, 2/3, or 1, 2/3, 2/3 when made non-increasing. Both
  // true people are found, with a mean precision of (1 + 2/3) / 2.
  const TrackSequence truth = Panoptic({{{0, 0}, {4, 0}}});
  const TrackSequence found =
      Panoptic({{{2, 0.8}, {4.0625, 0.7}, {0.03125, 0.9}}});
  const PanopticResult result = At(0.1, truth, found);
  EXPECT_DOUBLE_EQ(result.average_precision[0], (1.0 + 2.0 / 3.0) / 2.0);
  EXPECT_EQ(result.recall[0].count, 2);
  EXPECT_DOUBLE_EQ(result.mpjpe_m, (0.0625 + 0.03125) / 2.0);
}

TEST(PanopticTest, ASecondPoseOfOnePersonIsAFalsePositive) {
  const TrackSequence found = Panoptic({{{0.0625, 0.9}, {0, 0.8}}});
  const PanopticResult result = At(0.1, kOne, found);
  EXPECT_EQ(result.average_precision[0],
            1.0);  // found before the false positive
  EXPECT_EQ(result.recall_at_limit.count, 1);
  EXPECT_EQ(result.mpjpe_m, 0.0625);  // the first by score counts
  // At 0.05 m the pose with the higher score is too far: precision 1/2.
  const PanopticResult tight = At(0.05, kOne, found);
  EXPECT_DOUBLE_EQ(tight.average_precision[0], 0.5);
}

TEST(PanopticTest, ThresholdIsExclusive) {
  const TrackSequence found = Panoptic({{{0.125, 1}}});
  EXPECT_EQ(At(0.125, kOne, found).recall[0].count, 0);
  EXPECT_EQ(At(0.126, kOne, found).recall[0].count, 1);
}

TEST(PanopticTest, MissedPeopleCostRecall) {
  const TrackSequence truth = Panoptic({{{0, 0}, {4, 0}}, {{0, 0}, {4, 0}}});
  const TrackSequence found = Panoptic({{{0, 1}}});
  const PanopticResult result = At(0.1, truth, found);
  EXPECT_DOUBLE_EQ(result.average_precision[0], 0.25);
  EXPECT_EQ(result.recall_at_limit.count, 1);
  EXPECT_EQ(result.recall_at_limit.total, 4);
}

TEST(PanopticTest, UnobservedTrueJointsAreLeftOut) {
  // One of fifteen true joints is displaced and not observed; the other
  // fourteen are 31.25 mm off.
  TrackSequence truth = kOne;
  Joint3d& unseen = truth.frames[0].people[0].joints[4];
  unseen.position_m.x() = 9.0;
  unseen.status = JointStatus::kInferred;
  const TrackSequence found = Panoptic({{{0.03125, 1.0}}});
  const PanopticResult result = At(0.05, truth, found);
  EXPECT_DOUBLE_EQ(result.mpjpe_m, 0.03125);
  EXPECT_EQ(result.joints_compared.count, 14);
  // True people whose mid-hip is missing or not observed are not counted.
  const auto root = static_cast<size_t>(Panoptic15().IndexOf("mid_hip"));
  for (const JointStatus status :
       {JointStatus::kMissing, JointStatus::kInferred}) {
    truth.frames[0].people[0].joints[root].status = status;
    EXPECT_EQ(EvaluatePanoptic(truth, found).recall_at_limit.total, 0);
  }
}

TEST(PanopticTest, NeckAndMidHipAreFilledIn) {
  Pose3d coco(17);
  const std::vector<int> source = MapByName(Panoptic15(), Coco17());
  Pose3d truth = Line(0);
  truth[Panoptic15().IndexOf("neck")] =
      Observed(0, 0, 0.5 * (0.125 * 3 + 0.125 * 9));  // middle of shoulders
  truth[Panoptic15().IndexOf("mid_hip")] =
      Observed(0, 0, 0.5 * (0.125 * 6 + 0.125 * 12));
  for (size_t j = 0; j < source.size(); ++j) {
    if (source[j] >= 0) coco[j] = truth[source[j]];
  }
  const PanopticResult result =
      EvaluatePanoptic(Tracks({Frame(0, {Person(0, truth)})}, Panoptic15()),
                       Tracks({Frame(0, {Person(0, coco)})}, Coco17()));
  EXPECT_EQ(result.joints_compared.count, 15);
  EXPECT_EQ(result.mpjpe_m, 0.0);
}

TEST(PanopticTest, APoseWithoutJointsIsAFalsePositive) {
  TrackSequence found = Panoptic({{{0, 1.0}, {0, 0.5}}});
  found.frames[0].people[0].joints.assign(15, Joint3d{});
  const PanopticResult result = At(0.1, kOne, found);
  EXPECT_EQ(result.found_person_frames, 2);
  EXPECT_DOUBLE_EQ(result.average_precision[0], 0.5);
}

TEST(PanopticTest, NoPeopleGiveNaN) {
  const PanopticResult result = At(0.1, Panoptic({}), Panoptic({}));
  EXPECT_TRUE(std::isnan(result.average_precision[0]));
  EXPECT_TRUE(std::isnan(result.mpjpe_m));
}

}  // namespace
}  // namespace kinegraph::testing
