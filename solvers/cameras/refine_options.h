// What of cameras and clocks is estimated from the people of a recording.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_
#define KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_

#include <string>
#include <vector>

#include "core/base/options.h"

namespace kinegraph {

enum class RefineKind { kOff, kShift, kRotation, kPose, kPoseFocal };
const std::vector<std::string>& RefineKindNames();

// Where the floor and the origin of the world come from.
enum class GroundKind { kOff, kFeet };
const std::vector<std::string>& GroundKindNames();

// Options of refinement, in the table "cameras" whose owner enters it.
struct RefineOptions {
  RefineKind refine = RefineKind::kOff;
  bool refine_clock = false;
  GroundKind ground = GroundKind::kOff;
  bool any() const { return refine != RefineKind::kOff || refine_clock; }

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_
