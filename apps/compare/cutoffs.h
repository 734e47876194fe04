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
  // One per axis, then one for the three axes together [Hz].
  std::vector<double> cutoffs_hz;
};

// Applies every rule to the points that filters smooth (filters.points), for
// the configured Butterworth filter, but always on positions, in each joint's
// longest interval without a gap, if that lasts a second or more. In the order
// of person, joint and rule.
std::vector<ChosenCutoff> ChooseCutoffs(const CompareResult& result);

// One row per person, joint, axis ("x", "y", "z", "all") and rule.
std::string CutoffsCsv(const CompareResult& result,
                       const std::vector<ChosenCutoff>& chosen);
// One row per joint that has cut-offs, one column per rule: "x / y / z",
// medians over people.
std::string CutoffsTable(const CompareResult& result,
                         const std::vector<ChosenCutoff>& chosen);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_CUTOFFS_H_
