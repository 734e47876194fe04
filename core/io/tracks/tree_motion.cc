#include "core/io/tracks/tree_motion.h"

#include <Eigen/SVD>
#include <algorithm>
#include <optional>

namespace kinegraph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kShortest_m = 1e-6;  // of which a direction is taken

Vector3d Between(const Vector3d& a, const Vector3d& b, double share) {
  return a + share * (b - a);
}
Quaterniond Between(const Quaterniond& a, const Quaterniond& b, double share) {
  return a.slerp(share, b);
}

// Values of all rows: between known ones by Between, before the first and after
// the last as these, `none` where no row is known.
template <typename Value>
std::vector<Value> Fill(const std::vector<std::optional<Value>>& known,
                        const Value& none) {
  std::vector<Value> values(known.size(), none);
  std::optional<size_t> last;
  for (size_t r = 0; r < known.size(); ++r) {
    if (!known[r]) {
      if (last) values[r] = *known[*last];
      continue;
    }
    values[r] = *known[r];
    const size_t first = last ? *last + 1 : 0;
    for (size_t gap = first; gap < r; ++gap) {
      values[gap] = last ? Between(*known[*last], *known[r],
                                   static_cast<double>(gap - *last) /
                                       static_cast<double>(r - *last))
                         : *known[r];
    }
    last = r;
  }
  return values;
}

// The rotation that leads the `from` to the `to` best; nullopt when they do not
// determine one.
std::optional<Quaterniond> Fit(const std::vector<Vector3d>& from,
                               const std::vector<Vector3d>& to) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    sum += to[i].normalized() * from[i].normalized().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  constexpr double kSmallest = 0.01;  // all on one line
  if (!(svd.singularValues()[1] > kSmallest * svd.singularValues()[0])) {
    return std::nullopt;
  }
  const Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
  Eigen::Vector3d sign(1.0, 1.0, turn.determinant() < 0.0 ? -1.0 : 1.0);
  return Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() *
                                     svd.matrixV().transpose()));
}

class Solver {
 public:
  Solver(const JointTree& tree, const std::vector<const PersonPose*>& poses,
         const AxisMap& axes)
      : tree_(tree), row_count_(poses.size()) {
    positions_.resize(tree.size());
    for (size_t j = 0; j < tree.size(); ++j) {
      for (const PersonPose* pose : poses) {
        positions_[j].push_back(PositionOf(tree[j], pose, axes));
        if (pose != nullptr && !positions_[j].back() && !tree[j].is_pivot) {
          ++motion_.filled;
        }
      }
    }
    is_seen_ = positions_;
    // Who is never seen lies on the parent, so that what hangs there goes on.
    for (size_t j = 1; j < tree.size(); ++j) {
      if (std::none_of(positions_[j].begin(), positions_[j].end(),
                       [](const auto& at) { return at.has_value(); })) {
        positions_[j] = positions_[static_cast<size_t>(tree[j].parent)];
      }
    }
    motion_.offsets_m.assign(tree.size(), Vector3d::Zero());
    for (size_t j = 1; j < tree.size(); ++j) {
      motion_.offsets_m[j] = MedianLength(j) * tree[j].rest_direction;
    }
    for (size_t j = 0; j < tree.size(); ++j) Shape(j);
    motion_.rows.resize(row_count_);
    for (TreeMotion::Row& row : motion_.rows) {
      row.global.resize(tree.size());
      row.positions_m.resize(tree.size());
      row.is_seen.resize(tree.size());
    }
  }

  TreeMotion Solve() {
    for (size_t j = 0; j < tree_.size(); ++j) {
      Place(j);
      Turn(j);
    }
    return std::move(motion_);
  }

 private:
  using Known = std::vector<std::optional<Vector3d>>;

  static std::optional<Vector3d> PositionOf(const TreeJoint& joint,
                                            const PersonPose* pose,
                                            const AxisMap& axes) {
    if (pose == nullptr) return std::nullopt;
    Vector3d sum = Vector3d::Zero();
    for (const int source : joint.sources) {
      const Joint3d& at = pose->joints[static_cast<size_t>(source)];
      if (!at.present()) return std::nullopt;
      sum += at.position_m;
    }
    return axes.Apply(sum / static_cast<double>(joint.sources.size()));
  }

  // From the parent to the joint; nullopt where one of them is missing.
  std::optional<Vector3d> BoneAt(size_t joint, size_t row) const {
    const auto parent = static_cast<size_t>(tree_[joint].parent);
    if (!positions_[joint][row] || !positions_[parent][row]) {
      return std::nullopt;
    }
    const Vector3d bone = *positions_[joint][row] - *positions_[parent][row];
    if (bone.norm() < kShortest_m) return std::nullopt;
    return bone;
  }

  double MedianLength(size_t joint) const {
    std::vector<double> lengths_m;
    for (size_t r = 0; r < row_count_; ++r) {
      if (const auto bone = BoneAt(joint, r)) lengths_m.push_back(bone->norm());
    }
    if (lengths_m.empty()) return 0.0;
    const auto middle =
        lengths_m.begin() + static_cast<long>(lengths_m.size() / 2);
    std::nth_element(lengths_m.begin(), middle, lengths_m.end());
    return *middle;
  }

  // The ends of the bones that turn a joint.
  std::vector<size_t> EndsOf(size_t joint) const {
    std::vector<size_t> ends;
    for (const int child : tree_[joint].children) {
      auto end = static_cast<size_t>(child);
      if (tree_[end].is_pivot) {
        end = static_cast<size_t>(tree_[end].children.front());
      }
      if (tree_[joint].is_chest && tree_[end].is_head) continue;
      ends.push_back(end);
    }
    return ends;
  }

  bool FitsSeveral(size_t joint) const {
    return tree_[joint].children.size() > 1;
  }

  // The best rotation of a joint where several bones begin.
  std::optional<Quaterniond> FitAt(size_t joint, size_t row) const {
    std::vector<Vector3d> at_rest;
    std::vector<Vector3d> seen;
    for (const size_t end : EndsOf(joint)) {
      const auto bone = BoneAt(end, row);
      if (!bone || motion_.offsets_m[end].norm() < kShortest_m) continue;
      at_rest.push_back(motion_.offsets_m[end]);
      seen.push_back(*bone);
    }
    if (tree_[joint].is_chest) {
      const auto bone = BoneAt(joint, row);
      if (bone && motion_.offsets_m[joint].norm() >= kShortest_m) {
        at_rest.push_back(-motion_.offsets_m[joint]);
        seen.push_back(-*bone);
      }
    }
    if (at_rest.size() < 2) return std::nullopt;
    return Fit(at_rest, seen);
  }

  // Gives the bones that begin at a joint the mean shape that they have in the
  // take, where there are several: fit, mean, and again.
  void Shape(size_t joint) {
    if (!FitsSeveral(joint)) return;
    constexpr int kRounds = 5;
    for (int round = 0; round < kRounds; ++round) {
      std::vector<Vector3d> sums(tree_.size(), Vector3d::Zero());
      for (size_t r = 0; r < row_count_; ++r) {
        const auto turn = FitAt(joint, r);
        if (!turn) continue;
        for (const size_t end : EndsOf(joint)) {
          const auto bone = BoneAt(end, r);
          if (bone) sums[end] += turn->conjugate() * bone->normalized();
        }
      }
      for (const size_t end : EndsOf(joint)) {
        // A bone that a pivot turns keeps the direction of the rest pose.
        const bool has_pivot =
            tree_[static_cast<size_t>(tree_[end].parent)].is_pivot;
        if (has_pivot || sums[end].norm() < kShortest_m) continue;
        motion_.offsets_m[end] =
            motion_.offsets_m[end].norm() * sums[end].normalized();
      }
    }
  }

  // Positions of a joint in all rows, where its parent is known already.
  void Place(size_t joint) {
    const int parent = tree_[joint].parent;
    for (size_t r = 0; r < row_count_; ++r) {
      motion_.rows[r].is_seen[joint] = is_seen_[joint][r].has_value();
    }
    Known in_parent(row_count_);
    for (size_t r = 0; r < row_count_; ++r) {
      const auto& seen = positions_[joint][r];
      if (!seen) continue;
      in_parent[r] = *seen;
      if (parent < 0) continue;
      const TreeMotion::Row& row = motion_.rows[r];
      const auto p = static_cast<size_t>(parent);
      in_parent[r] = row.global[p].conjugate() * (*seen - row.positions_m[p]);
    }
    const std::vector<Vector3d> filled =
        Fill(in_parent, motion_.offsets_m[joint]);
    for (size_t r = 0; r < row_count_; ++r) {
      TreeMotion::Row& row = motion_.rows[r];
      if (parent < 0) {
        row.positions_m[joint] = filled[r];
        continue;
      }
      const auto p = static_cast<size_t>(parent);
      row.positions_m[joint] = positions_[joint][r].value_or(
          row.positions_m[p] + row.global[p] * filled[r]);
    }
  }

  // Rotations of a joint in all rows.
  void Turn(size_t joint) {
    const int parent = tree_[joint].parent;
    const auto global_of_parent = [&](size_t r) {
      return parent < 0 ? Quaterniond::Identity()
                        : motion_.rows[r].global[static_cast<size_t>(parent)];
    };
    std::vector<std::optional<Quaterniond>> local(row_count_);
    for (size_t r = 0; r < row_count_; ++r) {
      const Quaterniond above = global_of_parent(r);
      if (FitsSeveral(joint)) {
        if (const auto turn = FitAt(joint, r))
          local[r] = above.conjugate() * *turn;
      } else if (tree_[joint].children.size() == 1) {
        const auto end = static_cast<size_t>(tree_[joint].children.front());
        const auto bone = BoneAt(end, r);
        if (bone && motion_.offsets_m[end].norm() >= kShortest_m) {
          local[r] = Quaterniond::FromTwoVectors(motion_.offsets_m[end],
                                                 above.conjugate() * *bone);
        }
      } else {
        local[r] = Quaterniond::Identity();
      }
    }
    const std::vector<Quaterniond> filled =
        Fill(local, Quaterniond::Identity());
    for (size_t r = 0; r < row_count_; ++r) {
      motion_.rows[r].global[joint] =
          (global_of_parent(r) * filled[r]).normalized();
    }
  }

  const JointTree& tree_;
  const size_t row_count_;
  std::vector<Known> positions_;  // [joint][row]
  std::vector<Known> is_seen_;    // as the tracks have them
  TreeMotion motion_;
};

}  // namespace

TreeMotion SolveTreeMotion(const JointTree& tree,
                           const std::vector<const PersonPose*>& poses,
                           const AxisMap& axes) {
  return Solver(tree, poses, axes).Solve();
}

Quaterniond TreeMotion::Local(const JointTree& tree, size_t row,
                              size_t joint) const {
  const int parent = tree[joint].parent;
  if (parent < 0) return rows[row].global[joint];
  return rows[row].global[static_cast<size_t>(parent)].conjugate() *
         rows[row].global[joint];
}

std::vector<Vector3d> TreeMotion::Rigid(const JointTree& tree,
                                        size_t row_idx) const {
  const Row& row = rows[row_idx];
  std::vector<Vector3d> positions_m(tree.size());
  positions_m[0] = row.positions_m[0];
  Vector3d shift = Vector3d::Zero();
  int count = 0;
  for (size_t j = 1; j < tree.size(); ++j) {
    const auto parent = static_cast<size_t>(tree[j].parent);
    positions_m[j] = positions_m[parent] + row.global[parent] * offsets_m[j];
    if (!row.is_seen[j]) continue;
    shift += row.positions_m[j] - positions_m[j];
    ++count;
  }
  if (row.is_seen[0] || count == 0) return positions_m;
  for (Vector3d& position_m : positions_m) position_m += shift / count;
  return positions_m;
}

}  // namespace kinegraph
