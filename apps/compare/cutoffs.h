// What each rule of a cut-off chooses on a recording, joint by joint.
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

// By Butterworth as the configuration has it, of the points that it filters
// (filters.points), each joint's longest time without a gap. By person, joint
// and rule.
std::vector<ChosenCutoff> ChooseCutoffs(const CompareResult& result);

// A row a person, joint, axis ("x", "y", "z", "all") and rule.
std::string CutoffsCsv(const CompareResult& result,
                       const std::vector<ChosenCutoff>& chosen);
// A row a joint, a column a rule: "x / y / z", the medians of the people.
std::string CutoffsTable(const CompareResult& result,
                         const std::vector<ChosenCutoff>& chosen);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_CUTOFFS_H_
