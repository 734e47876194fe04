// How far the window's final poses are from the batch's, by lag, on the real
// Shelf take: the price of answering early. Prints a Markdown table.
//
//   build/tests/benchmarks/lag_accuracy [bones] [--json=FILE]
//
// Both are fed by the same association (causal Gaussian feedback, one pass).
// In the first table nothing is learnt from the take, so that both minimise the
// same cost; the second is the default.
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/evaluation/held_out.h"
#include "core/evaluation/statistics.h"
#include "tests/support/shelf.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using Json = nlohmann::json;

constexpr double kFrameRate = 25.0;  // Hz, of Shelf

// Distances of joints that both observed [m].
std::vector<double> Distances(const TrackSequence& a, const TrackSequence& b) {
  std::map<std::pair<int64_t, TrackId>, const PersonPose*> poses;
  for (const TrackFrame& frame : a.frames) {
    for (const PersonPose& person : frame.people) {
      poses[{frame.frame, person.id}] = &person;
    }
  }
  std::vector<double> distances;
  for (const TrackFrame& frame : b.frames) {
    for (const PersonPose& person : frame.people) {
      const auto other = poses.find({frame.frame, person.id});
      if (other == poses.end()) continue;
      for (size_t j = 0; j < person.joints.size(); ++j) {
        const Joint3d& here = person.joints[j];
        const Joint3d& there = other->second->joints[j];
        if (here.status != JointStatus::kObserved) continue;
        if (there.status != JointStatus::kObserved) continue;
        distances.push_back((here.position_m - there.position_m).norm());
      }
    }
  }
  return distances;
}

double MeanError(const testing::ShelfTake& take, const RunOptions& options) {
  return SummariseHeldOut(testing::ScoreHeldOutCameras(take, options),
                          AllJoints(), {25, 1, 0.95, 1})
      .figure_px(HeldOutFigure::kMeanTruncated);
}

// The rows that it prints.
Json PrintTable(const testing::ShelfTake& take, RunOptions options) {
  Json rows = Json::array();
  options.estimators.output = OutputKind::kBatch;
  const TrackSequence batch = testing::Track(take, options);
  const double batch_px = MeanError(take, options);
  std::printf(
      "| lag, frames | median, mm | 95th, mm | 99th, mm | joints | held-out "
      "mean of min(error, 30), px | to batch |\n|---|---|---|---|---|---|---|"
      "\n");
  options.estimators.output = OutputKind::kWindow;
  for (const int lag : {0, 3, 5, 10, 20, 30}) {
    options.estimators.graph.lag_s = lag / kFrameRate;
    const std::vector<double> m =
        Distances(batch, testing::Track(take, options));
    const double px = MeanError(take, options);
    std::printf("| %d | %.3f | %.2f | %.2f | %zu | %.3f | %+.2f %% |\n", lag,
                1e3 * Quantile(m, 0.5), 1e3 * Quantile(m, 0.95),
                1e3 * Quantile(m, 0.99), m.size(), px,
                100.0 * (px / batch_px - 1.0));
    std::fflush(stdout);
    rows.push_back({{"lag_frames", lag},
                    {"median_mm", 1e3 * Quantile(m, 0.5)},
                    {"p95_mm", 1e3 * Quantile(m, 0.95)},
                    {"p99_mm", 1e3 * Quantile(m, 0.99)},
                    {"joints", m.size()},
                    {"held_out_px", px},
                    {"to_batch_percent", 100.0 * (px / batch_px - 1.0)}});
  }
  std::printf("| batch | | | | | %.3f | |\n", batch_px);
  return rows;
}

int Main(bool bones, const std::string& json_path) {
  const auto data = testing::FindData("shelf");
  if (!data.has_value()) {
    std::fprintf(stderr, "needs real data (set KINEGRAPH_DATA)\n");
    return 1;
  }
  const testing::ShelfTake take =
      testing::LoadRawShelf(data->parent_path().string());
  Json tables;
  const std::pair<std::string, std::string> ways[] = {
      {"same cost",
       "graph.pixel_noise_from=fixed;graph.process_noise_from=fixed;"
       "graph.rival_starts=false;graph.estimate_noise_scale=false"},
      {"default", ""}};
  for (const auto& [title, keys] : ways) {
    RunOptions options =
        ReadRunOptions(ProjectConfig("graph/shelf.toml"), keys, "");
    options.estimators.graph.bones = bones;
    options.estimators.graph.covariance = false;
    std::printf("\n%s bones, %s\n\n", bones ? "with" : "without",
                title.c_str());
    tables[title] = PrintTable(take, options);
  }
  if (!json_path.empty()) std::ofstream(json_path) << tables.dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  bool bones = false;
  std::string json_path;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    bones = bones || argument == "bones";
    if (argument.rfind("--json=", 0) == 0) json_path = argument.substr(7);
  }
  return kinegraph::Main(bones, json_path);
}
