// NAME.bias.json: coefficients of a detector's bias, and how they were decided.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_VIEW_BIAS_FILE_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_VIEW_BIAS_FILE_H_

#include <string>

#include "core/data/view_bias.h"

namespace kinegraph {

// {"kinegraph_bias": 1, "azimuth_deg", "joints": [{"joint", "used",
// "observations", "gain", "gain_error", "across_m": [10 numbers], "along_m"}]}
// `tracks`: the fingerprint of the tracks beside it (side_files.h), or empty.
void WriteViewBias(const std::string& path, const ViewBias& bias,
                   const std::string& tracks = "");

// Throws InputError naming file and key for whatever is not such a file.
ViewBias ReadViewBias(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_VIEW_BIAS_FILE_H_
