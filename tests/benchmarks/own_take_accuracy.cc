// What the five steps of docs/own_take.md reach without a hand-written
// configuration, over detectors, frame rates, units and focal lengths:
//
//   build/tests/benchmarks/own_take_accuracy [FIRST [COUNT]] [--json=FILE]
//   build/tests/benchmarks/own_take_accuracy covering [--json=FILE]
//
// takes those from FIRST on (0) of all 120, or the twenty in which each value
// of one meets each value of another, prints a line each and then a table by
// detector. In the lines: joints' mean error with what `init` writes and
// with hand-made gates [mm], their ratio, switches of identity, identities
// found and true, and whether anything was warned of.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/arguments.h"
#include "tests/support/own_take.h"
#include "tests/support/test_data.h"

int main(int argc, char** argv) {
  using kinegraph::testing::OwnTake;
  using kinegraph::testing::OwnTakeOutcome;
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string json_path =
      kinegraph::testing::TakeFlag("--json=", &arguments);
  arguments.resize(2);
  const bool covering = arguments[0] == "covering";
  if (covering) arguments[0].clear();
  const std::vector<OwnTake> takes = covering
                                         ? kinegraph::testing::CoveringTakes()
                                         : kinegraph::testing::AllTakes();
  const size_t first = arguments[0].empty() ? 0 : std::stoul(arguments[0]);
  const size_t count =
      arguments[1].empty() ? takes.size() : std::stoul(arguments[1]);
  nlohmann::json json = nlohmann::json::array();
  struct Row {
    int takes = 0;
    int right = 0;   // identities
    int within = 0;  // 5 % of the hand-made
    double worst = 0.0;
  };
  std::map<std::string, Row> rows;
  for (size_t i = first; i < std::min(takes.size(), first + count); ++i) {
    const kinegraph::testing::TemporaryFolder folder;
    const OwnTakeOutcome outcome =
        kinegraph::testing::WalkFiveSteps(takes[i], folder.path().string());
    if (!outcome.failed.empty()) {
      std::printf("%3zu %s FAILED %s\n", i, takes[i].name().c_str(),
                  outcome.failed.c_str());
      ++rows[takes[i].skeleton].takes;
      continue;
    }
    const double ratio = outcome.error_m / outcome.by_hand_error_m;
    const auto& identity = outcome.identity;
    const bool warned =
        (outcome.init + outcome.track).find("warning") != std::string::npos;
    std::printf("%3zu %-28s %6.2f %6.2f %6.3f  %lld  %lld/%lld  %s\n", i,
                takes[i].name().c_str(), 1e3 * outcome.error_m,
                1e3 * outcome.by_hand_error_m, ratio,
                static_cast<long long>(identity.switches),
                static_cast<long long>(identity.identities),
                static_cast<long long>(identity.true_people),
                warned ? "warned" : "-");
    std::fflush(stdout);
    json.push_back({{"take", takes[i].name()},
                    {"skeleton", takes[i].skeleton},
                    {"error_mm", 1e3 * outcome.error_m},
                    {"by_hand_mm", 1e3 * outcome.by_hand_error_m},
                    {"right", identity.switches == 0 &&
                                  identity.identities == identity.true_people},
                    {"warned", warned}});
    Row& row = rows[takes[i].skeleton];
    ++row.takes;
    row.right += identity.switches == 0 &&
                 identity.identities == identity.true_people && !warned;
    row.within += ratio <= 1.05;
    row.worst = std::max(row.worst, ratio);
  }
  std::printf("\n%-12s takes  identities right  within 5 %%  worst ratio\n",
              "skeleton");
  for (const auto& [name, row] : rows) {
    std::printf("%-12s %5d  %16d  %10d  %11.3f\n", name.c_str(), row.takes,
                row.right, row.within, row.worst);
  }
  if (!json_path.empty()) std::ofstream(json_path) << json.dump(1) << "\n";
  return 0;
}
