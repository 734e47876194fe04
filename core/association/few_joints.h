// People of whom only a few joints are visible.
#ifndef KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_
#define KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_

namespace kinegraph {

// The fewest joints, of 17, that determine position and orientation of a body.
inline constexpr double kFewestJoints = 4.0;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_
