// People of whom only a few joints are visible.
#ifndef KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_
#define KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_

namespace kinegraph {

// Of 17: the fewest joints that determine where a body is and which way it
// faces.
inline constexpr double kFewestJoints = 4.0;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_FEW_JOINTS_H_
