#include "core/io/tracks/joint_tree.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/io/text/joint_names.h"

namespace kinegraph {
namespace {

// Without "l_" or "r_".
std::string PartOf(const std::string& name) {
  const bool has_side = name.rfind("l_", 0) == 0 || name.rfind("r_", 0) == 0;
  return has_side ? name.substr(2) : name;
}

// 1 for the left, -1 for the right, 0 for the middle.
double SideOf(const std::string& name) {
  if (name.rfind("l_", 0) == 0) return 1.0;
  return name.rfind("r_", 0) == 0 ? -1.0 : 0.0;
}

// What a part of the body hangs on: a part of the same side, else of the
// middle.
const std::map<std::string, std::string>& ParentParts() {
  static const std::map<std::string, std::string> kParts = {
      {"neck", "mid_hip"},    {"hip", "mid_hip"},      {"knee", "hip"},
      {"ankle", "knee"},      {"heel", "ankle"},       {"big_toe", "ankle"},
      {"small_toe", "ankle"}, {"foot_index", "ankle"}, {"shoulder", "neck"},
      {"elbow", "shoulder"},  {"wrist", "elbow"},      {"hand_0", "wrist"},
      {"nose", "neck"},       {"head_top", "neck"},    {"ear", "eye"},
      {"eye", "nose"},        {"eye_inner", "nose"},   {"eye_outer", "nose"},
      {"mouth", "nose"}};
  return kParts;
}

Eigen::Vector3d RestDirection(const std::string& name) {
  const double side = SideOf(name);
  const std::map<std::string, Eigen::Vector3d> kDirections = {
      {"hip", {side, 0.0, 0.0}},
      {"knee", {0.0, -1.0, 0.0}},
      {"ankle", {0.0, -1.0, 0.0}},
      {"heel", {0.0, -1.0, -1.0}},
      {"big_toe", {-0.1 * side, -0.3, 1.0}},
      {"small_toe", {0.3 * side, -0.3, 1.0}},
      {"foot_index", {0.0, -0.3, 1.0}},
      {"shoulder", {side, 0.0, 0.0}},
      {"elbow", {side, 0.0, 0.0}},
      {"wrist", {side, 0.0, 0.0}},
      {"nose", {0.0, 0.6, 0.8}},
      {"eye", {0.6 * side, 0.7, -0.3}},
      {"ear", {0.4 * side, -0.2, -0.9}},
      {"mouth", {0.6 * side, -0.7, -0.3}}};
  const auto known = kDirections.find(PartOf(name));
  if (known != kDirections.end()) return known->second.normalized();
  if (PartOf(name).rfind("hand_", 0) == 0) return {side, 0.0, 0.0};
  return Eigen::Vector3d::UnitY();
}

// A joint that is to hang somewhere.
struct Node {
  std::string name;
  std::string ours;  // its name as we call it
  std::vector<int> sources;
  bool is_placed = false;
};

class TreeMaker {
 public:
  explicit TreeMaker(const Skeleton& skeleton) : skeleton_(skeleton) {
    for (int j = 0; j < skeleton.joint_count(); ++j) {
      const std::string& name = skeleton.joints()[static_cast<size_t>(j)];
      std::string ours = JointNameOf(name);
      if (ours == "head_bottom") ours = "neck";
      nodes_.push_back({name, ours, {j}});
    }
    AddMiddle("mid_hip", "hip");
    AddMiddle("neck", "shoulder");
  }

  JointTree Make() {
    Place(RootNode(), -1);
    while (PlaceByBody() || PlaceByBones()) {
    }
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].is_placed) continue;
      const int nose = PlaceOf("nose");
      const bool is_head = ClassOfJoint(nodes_[n].ours) == JointClass::kHead;
      Place(n, is_head && nose >= 0 ? nose : 0);
    }
    return std::move(tree_);
  }

 private:
  int NodeOf(const std::string& ours) const {
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].ours == ours) return static_cast<int>(n);
    }
    return -1;
  }

  // In the tree; -1 when it is not placed.
  int PlaceOf(const std::string& ours) const {
    const int node = NodeOf(ours);
    return node < 0                         ? -1
           : place_of_node_.count(node) > 0 ? place_of_node_.at(node)
                                            : -1;
  }

  void AddMiddle(const std::string& name, const std::string& part) {
    const int left = NodeOf("l_" + part);
    const int right = NodeOf("r_" + part);
    if (NodeOf(name) >= 0 || left < 0 || right < 0) return;
    nodes_.push_back({name,
                      name,
                      {nodes_[static_cast<size_t>(left)].sources[0],
                       nodes_[static_cast<size_t>(right)].sources[0]}});
  }

  size_t RootNode() const {
    const int hips = NodeOf("mid_hip");
    if (hips >= 0) return static_cast<size_t>(hips);
    std::vector<int> bones(nodes_.size(), 0);
    for (const Bone& bone : skeleton_.bones()) {
      ++bones[static_cast<size_t>(bone.a)];
      ++bones[static_cast<size_t>(bone.b)];
    }
    return static_cast<size_t>(std::max_element(bones.begin(), bones.end()) -
                               bones.begin());
  }

  void Place(size_t node, int parent) {
    const int place = static_cast<int>(tree_.size());
    nodes_[node].is_placed = true;
    place_of_node_[static_cast<int>(node)] = place;
    TreeJoint joint;
    joint.name = nodes_[node].name;
    joint.parent = parent;
    joint.sources = nodes_[node].sources;
    joint.is_chest = parent >= 0 && nodes_[node].ours == "neck";
    joint.is_head = ClassOfJoint(nodes_[node].ours) == JointClass::kHead;
    if (parent >= 0) {
      joint.rest_direction = RestDirection(nodes_[node].ours);
      tree_[static_cast<size_t>(parent)].children.push_back(place);
    }
    tree_.push_back(std::move(joint));
  }

  bool PlaceByBody() {
    bool any = false;
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (nodes_[n].is_placed) continue;
      const std::string& ours = nodes_[n].ours;
      const auto part = ParentParts().find(PartOf(ours));
      if (part == ParentParts().end()) continue;
      const std::string side = SideOf(ours) == 0.0 ? "" : ours.substr(0, 2);
      const int of_side = PlaceOf(side + part->second);
      const int parent = of_side >= 0 ? of_side : PlaceOf(part->second);
      if (parent < 0) continue;
      Place(n, parent);
      any = true;
    }
    return any;
  }

  // One bone; the body goes first again then.
  bool PlaceByBones() {
    for (const Bone& bone : skeleton_.bones()) {
      for (const auto& [from, to] :
           {std::pair{bone.a, bone.b}, std::pair{bone.b, bone.a}}) {
        if (place_of_node_.count(from) == 0 || place_of_node_.count(to) > 0) {
          continue;
        }
        Place(static_cast<size_t>(to), place_of_node_.at(from));
        return true;
      }
    }
    return false;
  }

  const Skeleton& skeleton_;
  std::vector<Node> nodes_;  // those of the skeleton first
  std::map<int, int> place_of_node_;
  JointTree tree_;
};

// Places of the joints change: a pivot comes right before its bone's end.
JointTree WithPivots(const JointTree& tree) {
  JointTree result;
  std::vector<int> place(tree.size(), -1);
  for (size_t j = 0; j < tree.size(); ++j) {
    TreeJoint joint = tree[j];
    joint.children.clear();
    if (joint.parent >= 0) {
      const TreeJoint& parent = tree[static_cast<size_t>(joint.parent)];
      joint.parent = place[static_cast<size_t>(joint.parent)];
      if (parent.children.size() > 1 && !tree[j].children.empty()) {
        TreeJoint pivot;
        pivot.name = parent.name + "_to_" + joint.name;
        pivot.parent = joint.parent;
        pivot.sources = parent.sources;
        pivot.is_pivot = true;
        joint.parent = static_cast<int>(result.size());
        result.push_back(std::move(pivot));
      }
    }
    place[j] = static_cast<int>(result.size());
    result.push_back(std::move(joint));
  }
  for (size_t j = 1; j < result.size(); ++j) {
    result[static_cast<size_t>(result[j].parent)].children.push_back(
        static_cast<int>(j));
  }
  return result;
}

}  // namespace

JointTree MakeJointTree(const Skeleton& skeleton, bool pivots) {
  JointTree tree = TreeMaker(skeleton).Make();
  return pivots ? WithPivots(tree) : tree;
}

}  // namespace kinegraph
