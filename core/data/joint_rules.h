// Where the joints' centres lie among the markers on a body.
#ifndef KINEGRAPH_CORE_DATA_JOINT_RULES_H_
#define KINEGRAPH_CORE_DATA_JOINT_RULES_H_

#include <string>
#include <vector>

namespace kinegraph {

// How the centre of a hip follows from the pelvis.
enum class HipRule {
  kNone,        // the joint is no such hip
  kHarrington,  // Harrington et al. 2007, by width and depth of the pelvis
  kBell,        // Bell et al. 1990, by its width
  kFunctional,  // the point about which the thigh's markers turn
};

// One joint. Names are those of markers, or of joints that rules before this
// one define.
struct JointRule {
  std::string joint;                 // ours: "l_knee"
  std::vector<std::string> markers;  // their mean; of kFunctional the thigh's
  // Then moved by `by_m` in the direction from the first of these to the
  // second; empty: not moved.
  std::vector<std::string> along;
  double by_m = 0.0;
  HipRule hip = HipRule::kNone;
  std::vector<std::string> asis;  // the left and the right one
  std::vector<std::string> psis;  // both, or the sacrum between them
  // The markers stand on both sides of the joint, or the point is its centre
  // by construction: the joints whose errors are pooled.
  bool is_centre = false;
};

// Of several rules for one joint the first whose markers are all there holds.
struct MarkerSet {
  std::string name;
  std::vector<JointRule> rules;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_JOINT_RULES_H_
