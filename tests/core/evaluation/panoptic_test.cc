#include "core/evaluation/panoptic.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/evaluation/people.h"

namespace kinegraph::testing {
namespace {

// Fifteen joints along a line.
Pose3d Line(double x) {
  Pose3d pose;
  for (int j = 0; j < 15; ++j) pose.push_back(Observed(x, 0.0, 0.125 * j));
  return pose;
}

PersonPose Scored(int64_t id, double x, double score) {
  PersonPose person = Person(id, Line(x));
  person.score = score;
  return person;
}

TrackSequence Panoptic(std::vector<TrackFrame> frames) {
  return Tracks(std::move(frames), Panoptic15());
}

PanopticOptions At(double threshold_m) {
  PanopticOptions options;
  options.thresholds_m = {threshold_m};
  return options;
}

TEST(PanopticTest, PerfectPosesScoreOne) {
  const TrackSequence truth =
      Panoptic({Frame(0, {Scored(0, 0, 0), Scored(1, 2, 0)})});
  const PanopticResult result = EvaluatePanoptic(truth, truth);
  ASSERT_EQ(result.average_precision.size(), 6u);
  EXPECT_EQ(result.average_precision[0], 1.0);
  EXPECT_EQ(result.recall_at_limit.count, 2);
  EXPECT_EQ(result.mpjpe_m, 0.0);
  EXPECT_EQ(result.joints_compared.count, 30);
}

TEST(PanopticTest, PrecisionFollowsTheScores) {
  // By score: right, wrong (too far), right. Precision 1, 1/2, 2/3; made
  // falling from the right 1, 2/3, 2/3. Two of two true people: (1 + 2/3) / 2.
  const TrackSequence truth =
      Panoptic({Frame(0, {Scored(0, 0, 0), Scored(1, 4, 0)})});
  const TrackSequence found =
      Panoptic({Frame(0, {Scored(5, 2, 0.8), Scored(6, 4.0625, 0.7),
                          Scored(7, 0.03125, 0.9)})});
  const PanopticResult result = EvaluatePanoptic(truth, found, At(0.1));
  EXPECT_DOUBLE_EQ(result.average_precision[0], (1.0 + 2.0 / 3.0) / 2.0);
  EXPECT_EQ(result.recall[0].count, 2);
  EXPECT_DOUBLE_EQ(result.mpjpe_m, (0.0625 + 0.03125) / 2.0);
}

TEST(PanopticTest, ASecondPoseOfOnePersonIsFalse) {
  const TrackSequence truth = Panoptic({Frame(0, {Scored(0, 0, 0)})});
  const TrackSequence found =
      Panoptic({Frame(0, {Scored(5, 0.0625, 0.9), Scored(6, 0, 0.8)})});
  const PanopticResult result = EvaluatePanoptic(truth, found, At(0.1));
  EXPECT_EQ(result.average_precision[0], 1.0);  // all found before the false
  EXPECT_EQ(result.recall_at_limit.count, 1);
  EXPECT_EQ(result.mpjpe_m, 0.0625);  // the first by score counts
  // The other way round the false one comes first: precision 1/2.
  const PanopticResult tight = EvaluatePanoptic(truth, found, At(0.05));
  EXPECT_DOUBLE_EQ(tight.average_precision[0], 0.5);
}

TEST(PanopticTest, ThresholdIsExclusive) {
  const TrackSequence truth = Panoptic({Frame(0, {Scored(0, 0, 0)})});
  const TrackSequence found = Panoptic({Frame(0, {Scored(5, 0.125, 1)})});
  EXPECT_EQ(EvaluatePanoptic(truth, found, At(0.125)).recall[0].count, 0);
  EXPECT_EQ(EvaluatePanoptic(truth, found, At(0.126)).recall[0].count, 1);
}

TEST(PanopticTest, MissedPeopleCostRecall) {
  const TrackSequence truth =
      Panoptic({Frame(0, {Scored(0, 0, 0), Scored(1, 4, 0)}),
                Frame(1, {Scored(0, 0, 0), Scored(1, 4, 0)})});
  const TrackSequence found = Panoptic({Frame(1, {Scored(5, 0, 1)})});
  const PanopticResult result = EvaluatePanoptic(truth, found, At(0.1));
  EXPECT_DOUBLE_EQ(result.average_precision[0], 0.25);
  EXPECT_EQ(result.recall_at_limit.count, 1);
  EXPECT_EQ(result.recall_at_limit.total, 4);
}

TEST(PanopticTest, PeopleWithoutMidHipAreLeftOut) {
  TrackSequence truth =
      Panoptic({Frame(0, {Scored(0, 0, 0), Scored(1, 4, 0)})});
  truth.frames[0].people[1].joints[Panoptic15().IndexOf("mid_hip")] = Joint3d{};
  EXPECT_EQ(EvaluatePanoptic(truth, truth).recall_at_limit.total, 1);
}

TEST(PanopticTest, TrueJointsThatNobodySawAreLeftOut) {
  // Of fifteen true joints one is not seen, and far off there: the other
  // fourteen are 31.25 mm off.
  TrackSequence truth = Panoptic({Frame(0, {Scored(0, 0, 0)})});
  Joint3d& unseen = truth.frames[0].people[0].joints[4];
  unseen.position_m.x() = 9.0;
  unseen.status = JointStatus::kInferred;
  const TrackSequence found = Panoptic({Frame(0, {Scored(5, 0.03125, 1.0)})});
  const PanopticResult result = EvaluatePanoptic(truth, found, At(0.05));
  EXPECT_DOUBLE_EQ(result.mpjpe_m, 0.03125);
  EXPECT_EQ(result.joints_compared.count, 14);
  // Whose middle of the hips is not seen is hidden.
  const auto root = static_cast<size_t>(Panoptic15().IndexOf("mid_hip"));
  truth.frames[0].people[0].joints[root].status = JointStatus::kInferred;
  EXPECT_EQ(EvaluatePanoptic(truth, found).recall_at_limit.total, 0);
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
      EvaluatePanoptic(Panoptic({Frame(0, {Person(0, truth)})}),
                       Tracks({Frame(0, {Person(0, coco)})}, Coco17()));
  EXPECT_EQ(result.joints_compared.count, 15);
  EXPECT_EQ(result.mpjpe_m, 0.0);
}

TEST(PanopticTest, APoseWithoutJointsIsAFalsePositive) {
  const TrackSequence truth = Panoptic({Frame(0, {Scored(0, 0, 0)})});
  PersonPose empty = Person(5, Pose3d(15));
  empty.score = 1.0;
  const TrackSequence found = Panoptic({Frame(0, {empty, Scored(6, 0, 0.5)})});
  const PanopticResult result = EvaluatePanoptic(truth, found, At(0.1));
  EXPECT_EQ(result.found_person_frames, 2);
  EXPECT_DOUBLE_EQ(result.average_precision[0], 0.5);
}

TEST(PanopticTest, NobodyAnywhere) {
  const PanopticResult result =
      EvaluatePanoptic(Panoptic({}), Panoptic({}), At(0.1));
  EXPECT_TRUE(std::isnan(result.average_precision[0]));
  EXPECT_TRUE(std::isnan(result.mpjpe_m));
}

}  // namespace
}  // namespace kinegraph::testing
