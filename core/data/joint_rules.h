// Positions of joint centres relative to the markers on a body.
#ifndef KINEGRAPH_CORE_DATA_JOINT_RULES_H_
#define KINEGRAPH_CORE_DATA_JOINT_RULES_H_

#include <string>
#include <vector>

namespace kinegraph {

// How the hip centre is derived from the pelvis.
enum class HipRule {
  kNone,        // the joint is not derived from the pelvis
  kHarrington,  // Harrington et al. 2007, by width and depth of the pelvis
  kBell,        // Bell et al. 1990, by its width
  kFunctional,  // the centre of rotation of the thigh's markers
};

// One joint. Names refer to markers, or to joints that earlier rules define.
struct JointRule {
  std::string joint;  // name in kinegraph's skeletons: "l_knee"
  // The joint is at the mean of these markers; for kFunctional they are the
  // markers of the thigh.
  std::vector<std::string> markers;
  // Two markers: the joint is offset by `by_m` in the direction from the first
  // to the second. Empty: no offset.
  std::vector<std::string> along;
  double by_m = 0.0;
  HipRule hip = HipRule::kNone;
  std::vector<std::string> asis;  // left and right
  std::vector<std::string> psis;  // both, or the sacrum between them
  // True if the markers lie on opposite sides of the joint or are joint centres
  // of another program's model, and for every rule of a configuration; false
  // for a single marker near the joint and for a built-in hip regression.
  // Pooled errors include only joints for which it is true, if there are any.
  bool is_centre = false;
};

// If several rules define one joint, the first whose markers all exist applies.
struct MarkerSet {
  std::string name;
  std::vector<JointRule> rules;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_JOINT_RULES_H_
