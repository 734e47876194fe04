// The pictures of a comparison.
#ifndef KINEGRAPH_APPS_COMPARE_PLOTS_H_
#define KINEGRAPH_APPS_COMPARE_PLOTS_H_

#include <string>
#include <vector>

#include "apps/compare/results.h"

namespace kinegraph {

// What is drawn where not all strategies fit.
struct PlotChoice {
  std::vector<std::string> strategies;  // by name; those that are there
  std::string joint = "r_wrist";
};

// Writes SVG files into `folder` and returns their names.
std::vector<std::string> WriteComparePlots(const CompareResult& result,
                                           const PlotChoice& choice,
                                           const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_PLOTS_H_
