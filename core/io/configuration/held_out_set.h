// Reading the set of detections that held-out-camera errors are computed on.
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_HELD_OUT_SET_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_HELD_OUT_SET_H_

#include <string>
#include <vector>

#include "core/data/held_out.h"

namespace kinegraph {

// Reads {"confidence_at_least", "cap_px", "pairing_gate_m", "set": [{"camera",
// "frame", "detection", "person"}]}; a camera is a name or a number. With
// `view_names` each camera becomes the view of the same name, else the one with
// the same last integer in its name. Throws InputError naming the file.
HeldOutSet ReadHeldOutSet(const std::string& path,
                          const std::vector<std::string>& view_names = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_HELD_OUT_SET_H_
