// Graph mode against paper mode on real Shelf detections and on Campus with
// modelled noise. The configurations leave all numbers of [graph] at their
// defaults, which were not chosen on these figures.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/tables/dataset.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/motion.h"
#include "core/evaluation/mpjpe.h"
#include "core/evaluation/pcp.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/tracks/tracks.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

// Raw OpenPose detections, with the options of paper mode.
LoadedDataset LoadRawShelf() {
  return LoadDataset(ShelfReal(), testing::FindData("")->string());
}

// For each camera, tracks without it and scores the prediction of its
// detections.
HeldOutScores ScoreWithoutEachCamera(const LoadedDataset& shelf,
                                     const RunOptions& options) {
  const std::string folder = testing::FindData("shelf/reference")->string();
  const std::vector<std::string>& views = shelf.detections.header.view_names;
  const CameraRig cameras = ChooseViews(views, shelf.request.cameras).cameras;
  const HeldOutSet set = ReadHeldOutSet(folder + "/held_out_set.json", views);
  const TrackSequence reference =  // names the people of the set
      ReadTracks(folder + "/paper_code_shelf_warm3.json");
  HeldOutScores scores;
  for (size_t view = 0; view < views.size(); ++view) {
    RunRequest request = shelf.request;
    request.without_cameras = {views[view]};
    ScoreHeldOutCamera(
        set, shelf.detections, static_cast<int>(view), cameras[view], reference,
        TrackSequenceOf(options, request, shelf.detections), &scores);
  }
  return scores;
}

RunOptions Offline() {
  return ReadRunOptions(ProjectConfig("offline.toml"),
                        "skeleton=coco17;input.frame_rate=25", "");
}

void RecordRatio(const char* name, double ratio, const Interval& interval) {
  ::testing::Test::RecordProperty(name, std::to_string(ratio));
  ::testing::Test::RecordProperty(
      std::string(name) + "_interval",
      std::to_string(interval.low) + " .. " + std::to_string(interval.high));
}

// Frame, view and class of each joint that was scored.
std::vector<std::array<int64_t, 3>> JointsOf(const HeldOutScores& scores) {
  std::vector<std::array<int64_t, 3>> joints;
  for (const HeldOutJoint& joint : scores.joints) {
    const HeldOutPerson& person = scores.people[joint.person_idx];
    joints.push_back({person.frame, person.view_idx,
                      static_cast<int64_t>(joint.joint_class)});
  }
  return joints;
}

// The mean of min(error, 30 px) and the 90th percentile of the errors of drawn
// frames.
std::array<double, 2> FiguresOf(const HeldOutScores& scores,
                                const std::vector<int64_t>& frames,
                                const DrawCounts& counts) {
  std::vector<double> errors_px;
  double sum_px = 0.0;
  for (const HeldOutJoint& joint : scores.joints) {
    const auto at = std::lower_bound(frames.begin(), frames.end(),
                                     scores.people[joint.person_idx].frame);
    const auto times = static_cast<size_t>(counts[at - frames.begin()]);
    errors_px.insert(errors_px.end(), times, joint.error_px);
    sum_px += static_cast<double>(times) *
              std::min(joint.error_px, kHeldOutTruncationPx);
  }
  return {sum_px / static_cast<double>(errors_px.size()),
          Quantile(errors_px, 0.9)};
}

// 0.88 and 0.80 of paper mode's errors were required of graph mode before it
// was written. The upper ends of the intervals are checked, not the point
// estimates. The results are in docs/results.md.
TEST(GraphModeTest, PredictsHeldOutCamerasBetterThanPaperMode) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const LoadedDataset shelf = LoadRawShelf();
  const HeldOutScores paper = ScoreWithoutEachCamera(shelf, shelf.options);
  const HeldOutScores graph = ScoreWithoutEachCamera(shelf, Offline());
  const HeldOutSummary of_paper = SummariseHeldOut(paper, AllJoints());
  const HeldOutSummary of_graph = SummariseHeldOut(graph, AllJoints());
  const auto ratio = [&](HeldOutFigure figure) {
    return of_graph.figure_px(figure) / of_paper.figure_px(figure);
  };
  const std::vector<int64_t> frames = FramesOf(paper);
  ASSERT_EQ(JointsOf(graph), JointsOf(paper));
  const std::vector<Interval> intervals = BlockBootstrapAll(
      {static_cast<int64_t>(frames.size())}, 2, [&](const DrawCounts& counts) {
        const auto [graph_mean, graph_p90] = FiguresOf(graph, frames, counts);
        const auto [paper_mean, paper_p90] = FiguresOf(paper, frames, counts);
        return std::vector<double>{graph_mean / paper_mean,
                                   graph_p90 / paper_p90};
      });
  const Interval& mean = intervals[0];
  const Interval& p90 = intervals[1];
  RecordRatio("mean_ratio", ratio(HeldOutFigure::kMeanTruncated), mean);
  RecordRatio("p90_ratio", ratio(HeldOutFigure::kP90), p90);
  // In each resample the same frames are drawn for both modes.
  EXPECT_LE(mean.high, 0.88);
  EXPECT_LE(p90.high, 0.80);
  // The smaller error is not due to fewer tracked people: of the same
  // detections, at least as many are matched.
  EXPECT_EQ(of_graph.paired.total, of_paper.paired.total);
  EXPECT_GE(of_graph.paired.count, of_paper.paired.count);
}

TEST(GraphModeTest, IsSmootherThanPaperModeAndNoLessAccurate) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const LoadedDataset shelf = LoadRawShelf();
  const TrackSequence paper = TracksOf(shelf);
  const TrackSequence graph = TracksOf(shelf, Offline());

  MotionOptions motion;
  motion.frames = ShelfProtocol().frames;
  const MotionResult moves_paper = EvaluateMotion(paper, 25.0, motion);
  const MotionResult moves_graph = EvaluateMotion(graph, 25.0, motion);
  // Required before graph mode was written: at most a quarter of paper mode's
  // acceleration, bone lengths that vary by at most 7 mm, and at most 0.92 of
  // paper mode's error against the annotation.
  EXPECT_LE(moves_graph.acceleration_m_s2,
            0.25 * moves_paper.acceleration_m_s2);
  EXPECT_LE(moves_graph.bone_length_spread_m, 0.007);

  MpjpeOptions mpjpe;
  mpjpe.frames = motion.frames;
  EXPECT_LE(EvaluateMpjpe(shelf.truth, graph, mpjpe).bias_removed_m,
            0.92 * EvaluateMpjpe(shelf.truth, paper, mpjpe).bias_removed_m);

  for (const EndpointRule rule : {EndpointRule::kMean, EndpointRule::kEach}) {
    PcpProtocol protocol = ShelfProtocol();
    protocol.endpoints = rule;
    const Interval difference = MeanOfActorsDifference(
        EvaluatePcp(shelf.truth, graph, protocol),
        EvaluatePcp(shelf.truth, paper, protocol), PcpGroup::kTotal);
    RecordProperty(std::string("pcp_difference_") + ToString(rule),
                   std::to_string(difference.low) + " .. " +
                       std::to_string(difference.high));
    // Not significantly worse: the interval is not entirely below zero.
    EXPECT_GE(difference.high, 0.0) << ToString(rule);
  }
}

struct CampusCase {
  const char* name;
  const char* set;  // as in --set, on top of configs/graph/campus.toml
};

class GraphOnCampusTest : public ::testing::TestWithParam<CampusCase> {};

// The detections are the annotation with modelled noise, not a detector's
// output.
TEST_P(GraphOnCampusTest, FindsMorePartsThanPaperMode) {
  KINEGRAPH_DATA_OR_SKIP(data, "campus/detections_modelled");
  for (const std::string level : {"clean", "typical", "hard"}) {
    const Dataset dataset = CampusModelled(level);
    const LoadedDataset loaded =
        LoadDataset(dataset, testing::FindData("")->string());
    const RunOptions options =
        ReadRunOptions(ProjectConfig("graph/campus.toml"), GetParam().set, "");
    const auto score = [&](const RunOptions& run) {
      return EvaluatePcp(loaded.truth, TracksOf(loaded, run), dataset.protocol);
    };
    const PcpResult paper = score(loaded.options);
    const PcpResult graph = score(options);
    const Interval difference =
        MeanOfActorsDifference(graph, paper, PcpGroup::kTotal);
    const std::string figures =
        dataset.name + ": " +
        std::to_string(MeanOfActors(graph, PcpGroup::kTotal)) + " against " +
        std::to_string(MeanOfActors(paper, PcpGroup::kTotal)) +
        ", difference " + std::to_string(difference.low) + " .. " +
        std::to_string(difference.high);
    SCOPED_TRACE(figures);
    // On clean detections hardly any part is lost, and graph mode omits joints
    // that paper mode writes: those whose standard deviation exceeds half of
    // their longest bone. So it must only not be significantly worse.
    if (level == "clean") {
      EXPECT_GE(difference.high, 0.0);
    } else {
      EXPECT_GT(difference.low, 0.0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Campus, GraphOnCampusTest,
    ::testing::Values(
        CampusCase{"window", ""},
        CampusCase{"batch",
                   "output.estimator=batch;graph.bones=true;tracking.backfill="
                   "true;tracking.second_pass=true"}),
    [](const ::testing::TestParamInfo<CampusCase>& test) {
      return std::string(test.param.name);
    });

}  // namespace
}  // namespace kinegraph
