// Parameters of the cameras that are refined from a recording's people.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_
#define KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_

#include "core/base/options.h"

namespace kinegraph {

enum class RefineKind { kOff, kShift, kRotation, kPose, kPoseFocal };

// Source of the world's floor and origin.
enum class GroundKind { kOff, kFeet };

// Options of refinement, part of the table "cameras".
struct RefineOptions {
  RefineKind refine = RefineKind::kOff;
  bool refine_clock = false;
  GroundKind ground = GroundKind::kOff;
  bool any() const { return refine != RefineKind::kOff || refine_clock; }

  void Describe(OptionVisitor& visitor);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_REFINE_OPTIONS_H_
