// The cut-offs chosen by each rule on a recording, joint by joint.
#ifndef KINEGRAPH_APPS_COMPARE_CUTOFFS_H_
#define KINEGRAPH_APPS_COMPARE_CUTOFFS_H_

#include <string>
#include <vector>

#include "apps/compare/scores.h"
#include "core/base/ids.h"

namespace kinegraph {

struct ChosenCutoff {
  TrackId person;
  int joint_idx = 0;
  int rule_idx = 0;  // of CutoffRules()
  // By axis, then of the three together [Hz].
  std::vector<double> cutoffs_hz;
};

// With the configured Butterworth filter, for the points that it filters
// (filters.points), over each joint's longest interval without a gap. By
// person, joint and rule.
std::vector<ChosenCutoff> ChooseCutoffs(const CompareResult& result);

// A row per person, joint, axis ("x", "y", "z", "all") and rule.
std::string CutoffsCsv(const CompareResult& result,
                       const std::vector<ChosenCutoff>& chosen);
// A row per joint, a column per rule: "x / y / z", the medians over people.
std::string CutoffsTable(const CompareResult& result,
                         const std::vector<ChosenCutoff>& chosen);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_CUTOFFS_H_
