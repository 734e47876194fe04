#include <algorithm>
#include <utility>

#include "core/io/text/joint_names.h"
#include "core/io/tracks/tree_motion.h"
#include "core/skeleton/anthropometry.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

// The name without "l_" or "r_".
std::string PartOf(const std::string& name) {
  const bool has_side = name.rfind("l_", 0) == 0 || name.rfind("r_", 0) == 0;
  return has_side ? name.substr(2) : name;
}

// 1 for left, -1 for right, 0 for the middle.
double SideOf(const std::string& name) {
  if (name.rfind("l_", 0) == 0) return 1.0;
  return name.rfind("r_", 0) == 0 ? -1.0 : 0.0;
}

// Anatomy of a part of the human body.
struct Part {
  const char* name;
  const char* parent;  // on the same side, otherwise in the middle
  // Direction from the parent in the rest pose, for the left side; x is
  // mirrored for the right side.
  double x, y, z;
  double stature_share;
};

// Assumes that a quarter of the foot lies behind the ankle, that half of the
// hand is the palm and that the nose is midway between chin and eyes.
constexpr Part kParts[] = {{"neck", "mid_hip", 0.0, 1.0, 0.0, kTrunkShare},
                           {"mid_hip", "neck", 0.0, -1.0, 0.0, kTrunkShare},
                           {"hip", "mid_hip", 1.0, 0.0, 0.0, 0.0955},
                           {"knee", "hip", 0.0, -1.0, 0.0, kThighShare},
                           {"ankle", "knee", 0.0, -1.0, 0.0, kShankShare},
                           {"heel", "ankle", 0.0, -1.0, -1.0, 0.054},
                           {"big_toe", "ankle", -0.1, -0.3, 1.0, 0.120},
                           {"small_toe", "ankle", 0.3, -0.3, 1.0, 0.120},
                           {"foot_index", "ankle", 0.0, -0.3, 1.0, 0.120},
                           {"shoulder", "neck", 1.0, 0.0, 0.0, 0.1295},
                           {"elbow", "shoulder", 1.0, 0.0, 0.0, kUpperArmShare},
                           {"wrist", "elbow", 1.0, 0.0, 0.0, kForearmShare},
                           {"thumb", "wrist", 0.7, 0.0, 0.7, 0.054},
                           {"index", "wrist", 1.0, 0.0, 0.25, 0.054},
                           {"pinky", "wrist", 1.0, 0.0, -0.25, 0.054},
                           {"hand_0", "wrist", 1.0, 0.0, 0.0, 0.0},
                           {"hand_1", "hand_0", 0.7, 0.0, 0.7, 0.018},
                           {"hand_2", "hand_1", 0.7, 0.0, 0.7, 0.018},
                           {"hand_3", "hand_2", 0.7, 0.0, 0.7, 0.018},
                           {"hand_4", "hand_3", 0.7, 0.0, 0.7, 0.018},
                           {"hand_5", "hand_0", 1.0, 0.0, 0.25, 0.054},
                           {"hand_9", "hand_0", 1.0, 0.0, 0.08, 0.054},
                           {"hand_13", "hand_0", 1.0, 0.0, -0.1, 0.054},
                           {"hand_17", "hand_0", 1.0, 0.0, -0.25, 0.054},
                           {"nose", "neck", 0.0, 0.6, 0.8, 0.085},
                           {"head_top", "neck", 0.0, 1.0, 0.0, 0.182},
                           {"ear", "eye", 0.4, -0.2, -0.9, 0.0},
                           {"eye", "nose", 0.6, 0.7, -0.3, 0.0},
                           {"eye_inner", "nose", 0.3, 0.8, -0.3, 0.0},
                           {"eye_outer", "nose", 0.7, 0.6, -0.4, 0.0},
                           {"mouth", "nose", 0.6, -0.7, -0.3, 0.0}};

const Part* FindPart(const std::string& ours) {
  const std::string name = PartOf(ours);
  for (const Part& part : kParts) {
    if (name == part.name) return &part;
  }
  return nullptr;
}

// A joint to attach to the tree.
struct Node {
  std::string name;
  std::string ours;  // kinegraph's name of it; "neck" for head_bottom
  std::vector<int> sources;
  int place = -1;  // index in the tree; -1: not attached yet
};

class TreeMaker {
 public:
  TreeMaker(const Skeleton& skeleton, const std::vector<bool>& is_seen)
      : skeleton_(skeleton), is_seen_(is_seen) {
    const Skeleton named = WithOurNames(skeleton);
    is_human_ = IsHuman(named);
    for (size_t j = 0; j < skeleton.joints().size(); ++j) {
      std::string ours = named.joints()[j];
      if (ours == "head_bottom") ours = "neck";
      nodes_.push_back({skeleton.joints()[j], ours, {static_cast<int>(j)}});
    }
    by_body_ = is_human_ && !(IsTree() && NodeOf("mid_hip") != nullptr);
    if (!by_body_) return;
    AddMiddle("mid_hip", "hip");
    AddMiddle("neck", "shoulder");
  }

  JointTree Make() {
    Place(RootNode(), 0);
    while ((by_body_ && PlaceByBody()) || PlaceByBones()) {
    }
    for (Node& node : nodes_) {
      if (node.place >= 0) continue;
      // Points of the head without a bone are children of the nose, other
      // joints of the root.
      const int nose = PlaceOf("nose");
      const bool is_face = is_human_ && IsHead(node) && nose >= 0;
      Place(&node, is_face ? nose : 0);
      tree_.back().is_held = is_face;
    }
    for (const Node& node : nodes_) {
      if (SideOf(node.ours) == 0.0) continue;
      tree_[static_cast<size_t>(node.place)].mirror =
          PlaceOf((SideOf(node.ours) > 0.0 ? "r_" : "l_") + PartOf(node.ours));
    }
    const int left = PlaceOf("l_shoulder");
    const int right = PlaceOf("r_shoulder");
    if (is_human_ && left > 0 && right > 0) {
      const size_t chest = tree_[static_cast<size_t>(left)].parent;
      tree_[chest].is_chest = tree_[static_cast<size_t>(right)].parent == chest;
    }
    return std::move(tree_);
  }

 private:
  static bool IsHead(const Node& node) {
    return ClassOfJoint(node.ours) == JointClass::kHead;
  }

  Node* NodeOf(const std::string& ours) {
    for (Node& node : nodes_) {
      if (node.ours == ours) return &node;
    }
    return nullptr;
  }

  // Index in the tree; -1 if it is not attached.
  int PlaceOf(const std::string& ours) {
    const Node* node = NodeOf(ours);
    return node == nullptr ? -1 : node->place;
  }

  // Whether the bones connect all joints without a cycle.
  bool IsTree() const {
    const auto& bones = skeleton_.bones();
    if (bones.size() + 1 != skeleton_.joints().size()) return false;
    std::vector<bool> reached(skeleton_.joints().size(), false);
    reached[0] = true;
    for (size_t round = 0; round < bones.size(); ++round) {
      for (const Bone& bone : bones) {
        const auto a = static_cast<size_t>(bone.a);
        const auto b = static_cast<size_t>(bone.b);
        reached[a] = reached[b] = reached[a] || reached[b];
      }
    }
    return std::count(reached.begin(), reached.end(), false) == 0;
  }

  void AddMiddle(const std::string& name, const std::string& part) {
    const Node* left = NodeOf("l_" + part);
    const Node* right = NodeOf("r_" + part);
    if (NodeOf(name) != nullptr || left == nullptr || right == nullptr) return;
    nodes_.push_back({name, name, {left->sources[0], right->sources[0]}});
  }

  bool IsSeen(const Node& node) const {
    return std::all_of(node.sources.begin(), node.sources.end(), [this](int j) {
      return is_seen_[static_cast<size_t>(j)];
    });
  }

  Node* RootNode() {
    for (const char* const name : {"mid_hip", "neck"}) {
      Node* node = is_human_ ? NodeOf(name) : nullptr;
      if (node != nullptr && IsSeen(*node)) return node;
    }
    std::vector<int> bones(nodes_.size(), 0);
    for (const Bone& bone : skeleton_.bones()) {
      ++bones[static_cast<size_t>(bone.a)];
      ++bones[static_cast<size_t>(bone.b)];
    }
    for (size_t n = 0; n < nodes_.size(); ++n) {
      if (!IsSeen(nodes_[n])) bones[n] -= static_cast<int>(nodes_.size());
    }
    return &nodes_[static_cast<size_t>(
        std::max_element(bones.begin(), bones.end()) - bones.begin())];
  }

  void Place(Node* node, int parent) {
    node->place = static_cast<int>(tree_.size());
    TreeJoint joint;
    joint.name = node->name;
    joint.parent = static_cast<size_t>(parent);
    joint.sources = node->sources;
    joint.is_head = is_human_ && IsHead(*node);
    if (!tree_.empty()) {
      if (is_human_) AddAnatomy(node->ours, &joint);
      tree_[joint.parent].children.push_back(tree_.size());
    }
    tree_.push_back(std::move(joint));
  }

  static void AddAnatomy(const std::string& ours, TreeJoint* joint) {
    const double side = SideOf(ours);
    if (const Part* part = FindPart(ours)) {
      joint->rest_direction =
          Eigen::Vector3d(side * part->x, part->y, part->z).normalized();
      joint->stature_share = part->stature_share;
    } else if (PartOf(ours).rfind("hand_", 0) == 0) {
      joint->rest_direction = {side, 0.0, 0.0};
      // The three bones of a finger together are half as long as the hand.
      joint->stature_share = 0.018;
    }
  }

  bool PlaceByBody() {
    bool any = false;
    for (Node& node : nodes_) {
      const Part* part = node.place >= 0 ? nullptr : FindPart(node.ours);
      if (part == nullptr) continue;
      const std::string side =
          SideOf(node.ours) == 0.0 ? "" : node.ours.substr(0, 2);
      const int of_side = PlaceOf(side + part->parent);
      const int parent = of_side >= 0 ? of_side : PlaceOf(part->parent);
      if (parent < 0) continue;
      Place(&node, parent);
      any = true;
    }
    return any;
  }

  // Attaches one joint by a bone, after which attachment by anatomy is tried
  // again. Returns false if no bone leads to a joint that is not attached.
  bool PlaceByBones() {
    for (const Bone& bone : skeleton_.bones()) {
      Node* a = &nodes_[static_cast<size_t>(bone.a)];
      Node* b = &nodes_[static_cast<size_t>(bone.b)];
      if ((a->place < 0) == (b->place < 0)) continue;
      a->place < 0 ? Place(a, b->place) : Place(b, a->place);
      return true;
    }
    return false;
  }

  const Skeleton& skeleton_;
  const std::vector<bool>& is_seen_;
  bool is_human_ = false;
  bool by_body_ = false;     // bones are completed by anatomy
  std::vector<Node> nodes_;  // the skeleton's joints, then added centres
  JointTree tree_;
};

// Whether the joint ends one of the last bones of a head, hand or foot, which
// do not rotate about their common joint.
bool IsRigidEnd(const JointTree& tree, const TreeJoint& joint) {
  if (!joint.children.empty()) return false;
  if (joint.is_head) return !tree[joint.parent].is_chest;
  const JointClass kind = ClassOfJoint(JointNameOf(joint.name));
  return !joint.rest_direction.isZero() &&
         (kind == JointClass::kFoot || kind == JointClass::kOther);
}

// The tree with pivots. Indices of joints change: a pivot is inserted before
// the end of its bone.
JointTree WithPivots(const JointTree& tree) {
  JointTree result;
  std::vector<size_t> place(tree.size(), 0);
  for (size_t j = 0; j < tree.size(); ++j) {
    TreeJoint joint = tree[j];
    joint.children.clear();
    if (j > 0) {
      const TreeJoint& parent = tree[joint.parent];
      joint.parent = place[joint.parent];
      if (parent.children.size() > 1 && !IsRigidEnd(tree, tree[j])) {
        TreeJoint pivot;
        pivot.name = parent.name + "_to_" + joint.name;
        pivot.parent = joint.parent;
        pivot.sources = parent.sources;
        pivot.is_pivot = true;
        pivot.is_held = joint.is_held;
        joint.parent = result.size();
        result.push_back(std::move(pivot));
      }
    }
    place[j] = result.size();
    result.push_back(std::move(joint));
  }
  for (size_t j = 0; j < result.size(); ++j) {
    TreeJoint& joint = result[j];
    if (joint.mirror >= 0) {
      joint.mirror = static_cast<int>(place[static_cast<size_t>(joint.mirror)]);
    }
    if (j > 0) result[joint.parent].children.push_back(j);
  }
  return result;
}

}  // namespace

JointTree MakeJointTree(const Skeleton& skeleton,
                        const std::vector<bool>& is_seen, bool pivots) {
  JointTree tree = TreeMaker(skeleton, is_seen).Make();
  return pivots ? WithPivots(tree) : tree;
}

}  // namespace kinegraph
