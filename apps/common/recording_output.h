// A run's report, for people and for programs.
#ifndef KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_
#define KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_

#include <string>

#include "solvers/noise/recording_notes.h"
#include "solvers/session/recording_report.h"
#include "solvers/session/session.h"

namespace kinegraph {

// Several lines for a terminal, at most 100 columns; a warning is a line and
// one of what to try.
std::string ReportText(const RecordingReport& report);
std::string WarningsText(const RecordingReport& report);

// NAME.summary.json. `learnt`: what the estimators learnt from the recording.
std::string ReportJson(const RecordingReport& report, const RunSummary& run,
                       const LearntNoise& learnt);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_
