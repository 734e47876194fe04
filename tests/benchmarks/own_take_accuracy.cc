// What the five steps of docs/own_take.md reach without a hand-written
// configuration, over detectors, frame rates, units and focal lengths:
//
//   build/tests/benchmarks/own_take_accuracy [FIRST [COUNT]]
//
// takes those from FIRST on (0) of all 120, prints a line each and then a table
// by detector. In the lines: joints' mean error with what `init` writes and
// with hand-made gates [mm], their ratio, switches of identity, identities
// found and true, and whether anything was warned of.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "tests/support/own_take.h"
#include "tests/support/test_data.h"

int main(int argc, char** argv) {
  using kinegraph::testing::OwnTake;
  using kinegraph::testing::OwnTakeOutcome;
  const std::vector<OwnTake> takes = kinegraph::testing::AllTakes();
  const size_t first = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 0;
  const size_t count =
      argc > 2 ? std::strtoul(argv[2], nullptr, 10) : takes.size();
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
  return 0;
}
