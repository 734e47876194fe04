// Small files that accompany a recording: the set of detections on which errors
// of held-out cameras are computed, a detector's bias, and a user's definitions
// of joints.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_RECORDING_FILES_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_RECORDING_FILES_H_

#include <string>
#include <vector>

#include "core/data/held_out.h"
#include "core/data/joint_rules.h"
#include "core/data/view_bias.h"

namespace kinegraph {

// Reads {"confidence_at_least", "cap_px", "pairing_gate_m", "set": [{"camera",
// "frame", "detection", "person"}]}; a camera is a name or a number. If
// `view_names` are given, each camera is replaced by the view of the same name
// or, if there is none, by the only view whose name has the same last integer.
// Throws InputError naming the file, also for a camera without such a view.
HeldOutSet ReadHeldOutSet(const std::string& path,
                          const std::vector<std::string>& view_names = {});

// Writes NAME.bias.json: coefficients of a detector's bias, and the evidence
// for using them. {"kinegraph_bias": 1, "azimuth_deg", "joints": [{"joint",
// "used", "observations", "gain", "gain_error", "across_m": [10 numbers],
// "along_m": [10 numbers]}]}. `tracks`: the fingerprint of the tracks to which
// the file belongs (side_files.h), or empty.
void WriteViewBias(const std::string& path, const ViewBias& bias,
                   const std::string& tracks = "");

// Throws InputError naming file and key for anything invalid.
ViewBias ReadViewBias(const std::string& path);

// Reads a user's definition of joints by the markers of a laboratory:
// [joints.NAME] with one of `middle_of`, `marker`, `regression`, `functional`
// (docs/validate.md). Throws InputError naming file and key.
MarkerSet ReadJointRules(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_RECORDING_FILES_H_
