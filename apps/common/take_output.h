// A run's report, for people and for programs.
#ifndef KINEGRAPH_APPS_COMMON_TAKE_OUTPUT_H_
#define KINEGRAPH_APPS_COMMON_TAKE_OUTPUT_H_

#include <string>

#include "solvers/noise/take_notes.h"
#include "solvers/session/session.h"
#include "solvers/session/take_report.h"

namespace kinegraph {

// Several lines for a terminal, at most 100 columns; a warning is a line and
// one of what to try.
std::string ReportText(const TakeReport& report);
std::string WarningsText(const TakeReport& report);

// NAME.summary.json. `learnt`: what the estimators learnt from the take.
std::string ReportJson(const TakeReport& report, const RunSummary& run,
                       const LearntNoise& learnt);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_TAKE_OUTPUT_H_
