// Formats the report of a run for users and programs.
#ifndef KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_
#define KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/io/text/json.h"
#include "solvers/noise/learnt_noise.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/recording_report.h"
#include "solvers/session/session.h"

namespace kinegraph {

// Replaces the placeholders in fixes (solvers/scene/doctor.h): RECORDING by
// `recording`, the flags of the recording's files; INPUTS by these and
// `configuration`; kUseCorrected by --cameras with the path `corrected`, or by
// nothing if that is empty.
void NameInputs(const std::string& recording, const std::string& configuration,
                const std::string& corrected, std::vector<Finding>* findings);
// ` --name=value`, with the value quoted if a shell requires it; empty without
// a value.
std::string Flag(const std::string& name, const std::string& value);

// Lines of at most 98 columns for a terminal. A warning is followed by its
// remedy, unless the next warning has the same one; commands are not wrapped.
std::string ReportText(const RecordingReport& report);
std::string WarningsText(const RecordingReport& report);

// NAME.summary.json. `learnt`: what the estimators learnt from the recording.
std::string ReportJson(const RecordingReport& report, const RunSummary& run,
                       const LearntNoise& learnt);

// The steps of refinement with each decision and its reason; each camera's
// change with its standard deviation in degrees, millimetres, pixels, per cent,
// milliseconds, parts per million; the resulting displacement, rotation and
// scale of the world; and the floor, if it was determined. From this, a later
// run can repeat the refinement.
std::string RefinementJson(const ReadyRecording& recording);
// The part that a later run needs.
std::string RefinementJson(const RefinementRecord& record);

// The matrix as a list of its rows.
Json RowsJson(const Eigen::MatrixXd& matrix);

// One line per step, "rotation: accepted, held-out residual 7.31 px instead of
// 9.02 px", and lines for whole-frame clock offsets, the changed world frame
// and the floor.
std::string RefinementText(const ReadyRecording& recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_RECORDING_OUTPUT_H_
