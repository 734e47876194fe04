// Accuracy and honesty on synthetic scenes: what is found, how far off it is,
// and whether the stated covariances cover the errors. Prints Markdown.
//
//   build/tests/benchmarks/synthetic_accuracy [SCENE [SEEDS]]
//
// SCENE is a file of configs/synthetic without its ending (default: all). Each
// scene is made with so many seeds (default 3) and all are pooled.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "core/evaluation/consistency.h"
#include "solvers/session/run.h"

namespace kinegraph {
namespace {

struct Pool {
  double count = 0.0;
  double squared = 0.0;
  double nees = 0.0;
  Share inside;

  void Add(const ConsistencyRow& row) {
    if (row.count == 0) return;
    const auto joints = static_cast<double>(row.count);
    count += joints;
    squared += joints * row.rmse_m * row.rmse_m;
    if (row.stated.covered.total > 0) {
      nees += static_cast<double>(row.stated.covered.total) *
              row.stated.nees_per_dof;
    }
    inside += row.stated.covered;
  }
};

void PrintRow(const std::string& scene, const std::string& estimator,
              const char* status, const Pool& pool) {
  std::printf("| %s | %s | %s | %.0f | %.1f | %.1f | %.2f |\n", scene.c_str(),
              estimator.c_str(), status, pool.count,
              1e3 * std::sqrt(pool.squared / pool.count), pool.inside.percent(),
              pool.nees / static_cast<double>(pool.inside.total));
  std::fflush(stdout);
}

int Main(const std::string& only, int seeds) {
  std::printf(
      "| scene | estimator | joints | count | RMSE, mm | in 95 %% ellipsoid, "
      "%% | NEES / 3 |\n|---|---|---|---|---|---|---|\n");
  for (const std::string scene : {"hard", "demo", "correlated_25hz",
                                  "correlated_60hz", "correlated_120hz"}) {
    if (!only.empty() && scene != only) continue;
    for (const std::string estimator : {"paper", "window", "batch"}) {
      const RunOptions options = ReadRunOptions(
          ProjectConfig("synthetic/track_" + estimator + ".toml"), "", "");
      Pool observed;
      Pool inferred;
      for (int seed = 1; seed <= seeds; ++seed) {
        const std::string number = std::to_string(100 + seed);
        const SyntheticTake take =
            MakeTake(ProjectConfig("synthetic/" + scene + ".toml"),
                     "scene.seed=" + number + ";noise.seed=" + number);
        RunRequest request;
        request.cameras = take.scene.cameras;
        const ConsistencyResult result = EvaluateConsistency(
            take.truth, TrackSequenceOf(options, request, take.detections));
        observed.Add(result.observed);
        inferred.Add(result.inferred);
      }
      PrintRow(scene, estimator, "observed", observed);
      PrintRow(scene, estimator, "inferred", inferred);
    }
  }
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::Main(argc > 1 ? argv[1] : "",
                         argc > 2 ? std::atoi(argv[2]) : 3);
}
