#include "core/io/tracks/tree_motion.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"

namespace kinegraph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kShortest_m = 1e-6;  // a shorter bone has no direction

Vector3d Between(const Vector3d& a, const Vector3d& b, double share) {
  return a + share * (b - a);
}
Quaterniond Between(const Quaterniond& a, const Quaterniond& b, double share) {
  return a.slerp(share, b);
}

// Values of all rows: interpolated by Between between known rows, constant
// before the first and after the last known row, and `none` if no row is known.
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

// A direction in the rest pose and as observed.
struct Ray {
  Vector3d at_rest_m;
  Vector3d seen_m;
};

// Solves Wahba's problem: the proper rotation R that best satisfies R at_rest =
// seen over the rays. `prior` determines the rotation about the line of
// collinear rays and has negligible weight otherwise; without rays it is the
// result. nullopt if the rays are collinear or none and there is no prior.
std::optional<Quaterniond> Fit(const std::vector<Ray>& rays,
                               const Quaterniond* prior = nullptr) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double weight = 0.0;
  for (const Ray& ray : rays) {
    sum += ray.seen_m.normalized() * ray.at_rest_m.transpose();
    weight += ray.at_rest_m.norm();
  }
  constexpr double kWeak = 1e-6;  // an error of the order of 1e-3 mrad
  if (prior != nullptr) {
    sum += (rays.empty() ? 1.0 : kWeak * weight) * prior->toRotationMatrix();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Ratio of the second singular value to the first; at or below it the rays
  // count as collinear.
  constexpr double kSmallest = 0.01;
  if (prior == nullptr &&
      !(svd.singularValues()[1] > kSmallest * svd.singularValues()[0])) {
    return std::nullopt;
  }
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d sign(1.0, 1.0,
                             rotation.determinant() < 0.0 ? -1.0 : 1.0);
  return Quaterniond(Eigen::Matrix3d(svd.matrixU() * sign.asDiagonal() *
                                     svd.matrixV().transpose()));
}

class Solver {
 public:
  Solver(const JointTree& tree, const std::vector<const PersonPose*>& poses,
         const AxisMap& axes)
      : tree_(tree), row_count_(poses.size()) {
    motion_.rows.resize(row_count_);
    for (TreeMotion::Row& row : motion_.rows) {
      row.global.assign(tree.size(), Quaterniond::Identity());
      row.positions_m.assign(tree.size(), Vector3d::Zero());
      row.is_seen.resize(tree.size());
    }
    positions_.assign(tree.size(), Known(row_count_));
    is_ever_seen_.assign(tree.size(), false);
    for (size_t j = 0; j < tree.size(); ++j) {
      for (size_t r = 0; r < row_count_; ++r) {
        positions_[j][r] = PositionOf(tree[j], poses[r], axes);
        if (!positions_[j][r]) continue;
        motion_.rows[r].is_seen[j] = true;
        is_ever_seen_[j] = true;
      }
    }
    CountMissing(poses);
    for (size_t j = 1; j < tree.size(); ++j) {
      if (!is_ever_seen_[j]) PutOnLine(j);
    }
    motion_.offsets_m.assign(tree.size(), Vector3d::Zero());
    SetLengths();
  }

  TreeMotion Solve() {
    for (size_t j = 0; j < tree_.size(); ++j) {
      SetPositions(j);
      SetRestDirections(j);
      SetRotations(j);
      if (j == 0) PlaceRootByNeighbours();
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

  void CountMissing(const std::vector<const PersonPose*>& poses) {
    for (size_t j = 0; j < tree_.size(); ++j) {
      if (tree_[j].is_pivot) continue;
      if (!is_ever_seen_[j]) {
        motion_.never_seen.push_back(j);
        continue;
      }
      if (tree_[j].sources.size() > 1) continue;  // the mean of several joints
      for (size_t r = 0; r < row_count_; ++r) {
        if (poses[r] != nullptr && !positions_[j][r]) ++motion_.filled;
      }
    }
  }

  // The nearest descendant that was ever seen, and its distance in bones; 0
  // bones if there is none.
  std::pair<size_t, int> SeenBelow(size_t joint) const {
    std::pair<size_t, int> best = {0, 0};
    for (const size_t c : tree_[joint].children) {
      std::pair<size_t, int> one = {c, 1};
      if (tree_[c].is_pivot || !is_ever_seen_[c]) {
        one = SeenBelow(c);
        if (one.second > 0 && !tree_[c].is_pivot) ++one.second;
      }
      if (one.second > 0 && (best.second == 0 || one.second < best.second)) {
        best = one;
      }
    }
    return best;
  }

  // Places a joint that was never seen on the line between its parent and the
  // nearest descendant that was seen.
  void PutOnLine(size_t joint) {
    const Known& above = positions_[tree_[joint].parent];
    if (tree_[joint].is_pivot) {
      positions_[joint] = above;
      return;
    }
    const auto [below, bones] = SeenBelow(joint);
    if (bones == 0) return;
    for (size_t r = 0; r < row_count_; ++r) {
      const auto& end = positions_[below][r];
      if (!above[r] || !end) continue;
      positions_[joint][r] = Between(*above[r], *end, 1.0 / (1.0 + bones));
    }
  }

  // Vector from the parent to the joint; nullopt if either is missing or the
  // bone is shorter than kShortest_m.
  std::optional<Vector3d> BoneAt(size_t joint, size_t row) const {
    const size_t parent = tree_[joint].parent;
    if (!positions_[joint][row] || !positions_[parent][row]) {
      return std::nullopt;
    }
    const Vector3d bone = *positions_[joint][row] - *positions_[parent][row];
    if (bone.norm() < kShortest_m) return std::nullopt;
    return bone;
  }

  // Median length of the bone to the joint [m]; 0 if both ends were seen but
  // never kShortest_m apart, nullopt if they were never seen in the same row.
  std::optional<double> MedianLength(size_t joint) const {
    std::vector<double> lengths_m;
    for (size_t r = 0; r < row_count_; ++r) {
      if (const auto bone = BoneAt(joint, r)) lengths_m.push_back(bone->norm());
    }
    if (!lengths_m.empty()) return Median(std::move(lengths_m));
    const Known& above = positions_[tree_[joint].parent];
    for (size_t r = 0; r < row_count_; ++r) {
      if (positions_[joint][r] && above[r]) return 0.0;  // at its parent
    }
    return std::nullopt;
  }

  void SetLengths() {
    lengths_m_.assign(tree_.size(), 0.0);
    std::vector<std::optional<double>> known(tree_.size());
    std::vector<double> all_m;
    // Sums of lengths and shares over the bones that imply the stature.
    double length_m = 0.0;
    double share = 0.0;
    for (size_t j = 1; j < tree_.size(); ++j) {
      if (tree_[j].is_pivot) continue;
      known[j] = MedianLength(j);
      if (!known[j] || *known[j] == 0.0) continue;
      all_m.push_back(*known[j]);
      if (tree_[j].stature_share > 0.0) length_m += *known[j];
      share += tree_[j].stature_share;
    }
    constexpr double kNominal_m = 0.05;  // if nothing is known
    const double other_m =
        all_m.empty() ? kNominal_m : 0.2 * Median(std::move(all_m));
    const double stature_m = share > 0.0 ? length_m / share : 0.0;
    for (size_t j = 1; j < tree_.size(); ++j) {
      if (tree_[j].is_pivot) continue;
      const int mirror = tree_[j].mirror;
      const double by_stature_m = stature_m * tree_[j].stature_share;
      lengths_m_[j] = known[j] ? *known[j]
                      : mirror >= 0 && known[static_cast<size_t>(mirror)]
                          ? *known[static_cast<size_t>(mirror)]
                      : by_stature_m > 0.0 ? by_stature_m
                                           : other_m;
      motion_.offsets_m[j] = lengths_m_[j] * tree_[j].rest_direction;
    }
  }

  // The ends of the bones that begin at a joint.
  std::vector<size_t> EndsOf(size_t joint) const {
    std::vector<size_t> ends;
    for (const size_t child : tree_[joint].children) {
      ends.push_back(tree_[child].is_pivot ? tree_[child].children.front()
                                           : child);
    }
    return ends;
  }

  // A bone at a joint: one that begins there or, for a chest, the bone to its
  // parent.
  struct Spoke {
    size_t bone;       // index of the bone's child joint
    size_t other;      // the joint at its other end
    double length_m;   // negated if the bone leads to the parent
    Vector3d* rest_m;  // from the joint to `other` in the rest pose
    bool turns;        // contributes to the joint's rotation
    bool is_back;
  };
  std::vector<Spoke> SpokesOf(size_t joint) {
    std::vector<Spoke> spokes;
    for (const size_t end : EndsOf(joint)) {
      const bool turns = tree_[end].is_held && lengths_m_[end] >= kShortest_m &&
                         !(tree_[joint].is_chest && tree_[end].is_head);
      spokes.push_back({end, end, lengths_m_[end], &motion_.offsets_m[end],
                        turns, /*is_back=*/false});
    }
    if (tree_[joint].is_chest && joint > 0) {
      spokes.push_back({joint, tree_[joint].parent, -lengths_m_[joint],
                        &back_m_, /*turns=*/true,
                        /*is_back=*/true});
    }
    return spokes;
  }

  // The rays to which the rotation of a joint with several bones is fitted. If
  // the joint itself is missing, they begin at the mean of its neighbours.
  std::vector<Ray> RaysAt(size_t joint, const std::vector<Spoke>& spokes,
                          size_t row) const {
    std::vector<Ray> points;  // seen_m: the position, not yet a direction
    for (const Spoke& spoke : spokes) {
      const auto& at = positions_[spoke.other][row];
      if (spoke.turns && at && spoke.rest_m->norm() >= kShortest_m) {
        points.push_back({*spoke.rest_m, *at});
      }
    }
    Ray centre = {Vector3d::Zero(), Vector3d::Zero()};
    if (positions_[joint][row]) {
      centre.seen_m = *positions_[joint][row];
    } else {
      const auto count = static_cast<double>(points.size());
      for (const Ray& point : points) {
        centre.at_rest_m += point.at_rest_m / count;
        centre.seen_m += point.seen_m / count;
      }
    }
    std::vector<Ray> rays;
    for (const Ray& point : points) {
      const Ray ray = {point.at_rest_m - centre.at_rest_m,
                       point.seen_m - centre.seen_m};
      const bool has_direction = ray.at_rest_m.norm() >= kShortest_m &&
                                 ray.seen_m.norm() >= kShortest_m;
      if (has_direction) rays.push_back(ray);
    }
    return rays;
  }

  // The row in which most bones of a joint were seen and, among these rows, the
  // one with lengths nearest to the medians, to avoid outliers.
  size_t TypicalRow(const std::vector<Spoke>& spokes) const {
    size_t best = 0;
    size_t most = 0;
    double least_m = 0.0;
    for (size_t r = 0; r < row_count_; ++r) {
      size_t count = 0;
      double off_m = 0.0;
      for (const Spoke& spoke : spokes) {
        const auto bone = BoneAt(spoke.bone, r);
        if (!bone) continue;
        ++count;
        off_m += std::abs(bone->norm() - std::abs(spoke.length_m));
      }
      if (count > most || (count == most && count > 0 && off_m < least_m)) {
        best = r;
        most = count;
        least_m = off_m;
      }
    }
    return best;
  }

  // The rotation of the joint's parent; for the root the identity until
  // SetRotations(0).
  const Quaterniond& Above(size_t joint, size_t row) const {
    return motion_.rows[row].global[tree_[joint].parent];
  }

  // Sets the rest directions of the bones that begin at a joint. A single bone
  // gets the direction by its name or, without one, its direction relative to
  // the parent in a typical row; several bones get their mean shape, rotated to
  // the directions by name. A bone without any direction extends the bone that
  // ends at the joint or, if there is none, points along y.
  void SetRestDirections(size_t joint) {
    if (tree_[joint].children.empty()) return;
    const std::vector<Spoke> spokes = SpokesOf(joint);
    const size_t typical = TypicalRow(spokes);
    const Quaterniond above = Above(joint, typical);
    if (tree_[joint].children.size() > 1) {
      ShapeSeveral(joint, spokes, typical, above.conjugate());
    } else {
      const Spoke& spoke = spokes.front();
      const auto bone = BoneAt(spoke.bone, typical);
      if (bone && spoke.rest_m->isZero()) {
        *spoke.rest_m =
            spoke.length_m * (above.conjugate() * *bone).normalized();
      }
    }
    const size_t from = tree_[joint].is_pivot ? tree_[joint].parent : joint;
    const Vector3d along = motion_.offsets_m[from];
    for (const Spoke& spoke : spokes) {
      if (spoke.is_back || !spoke.rest_m->isZero()) continue;
      *spoke.rest_m = spoke.length_m *
                      (along.isZero() ? Vector3d::UnitY() : along.normalized());
    }
  }

  // Sets the rest directions of several bones that begin at a joint: their mean
  // shape, rotated to the directions by name. Where the names do not determine
  // the rotation, it is the one relative to the joint's parent in the typical
  // row.
  void ShapeSeveral(size_t joint, const std::vector<Spoke>& spokes,
                    size_t typical, const Quaterniond& as_seen) {
    // Directions by name, before the shape replaces them.
    std::vector<Vector3d> named;
    for (const Spoke& spoke : spokes) {
      named.push_back(spoke.is_back ? Vector3d(-motion_.offsets_m[joint])
                                    : *spoke.rest_m);
      const auto bone = BoneAt(spoke.bone, typical);
      *spoke.rest_m = bone ? Vector3d(spoke.length_m * bone->normalized())
                           : Vector3d::Zero();
    }
    AverageShape(joint, spokes);
    std::vector<Ray> rays;
    for (size_t s = 0; s < spokes.size(); ++s) {
      if (spokes[s].turns && spokes[s].rest_m->norm() >= kShortest_m &&
          named[s].norm() >= kShortest_m) {
        rays.push_back({*spokes[s].rest_m, named[s]});
      }
    }
    const Quaterniond rotation = *Fit(rays, &as_seen);
    for (size_t s = 0; s < spokes.size(); ++s) {
      Vector3d& rest_m = *spokes[s].rest_m;
      const bool is_unseen = !spokes[s].is_back && rest_m.isZero();
      rest_m = is_unseen ? named[s] : Vector3d(rotation * rest_m);
    }
  }

  // Mean shape of the bones: alternates between fitting the rotation of each
  // row and averaging the directions.
  void AverageShape(size_t joint, const std::vector<Spoke>& spokes) {
    constexpr int kRounds = 3;
    // A uniform sample of the recording, except in the last round.
    constexpr size_t kMostRows = 500;
    for (int round = 1; round <= kRounds; ++round) {
      const size_t step = round < kRounds ? 1 + row_count_ / kMostRows : 1;
      std::vector<Vector3d> sums(spokes.size(), Vector3d::Zero());
      for (size_t r = 0; r < row_count_; r += step) {
        const auto rotation = Fit(RaysAt(joint, spokes, r));
        if (!rotation) continue;
        for (size_t s = 0; s < spokes.size(); ++s) {
          const auto bone = BoneAt(spokes[s].bone, r);
          if (bone) sums[s] += rotation->conjugate() * bone->normalized();
        }
      }
      for (size_t s = 0; s < spokes.size(); ++s) {
        if (sums[s].norm() < kShortest_m) continue;
        *spokes[s].rest_m = spokes[s].length_m * sums[s].normalized();
      }
    }
  }

  // Sets the positions of a joint in all rows, after its parent's.
  void SetPositions(size_t joint) {
    const size_t p = tree_[joint].parent;
    Known in_parent(row_count_);
    for (size_t r = 0; r < row_count_; ++r) {
      const auto& seen = positions_[joint][r];
      const TreeMotion::Row& row = motion_.rows[r];
      if (!seen) continue;
      in_parent[r] = row.global[p].conjugate() * (*seen - row.positions_m[p]);
    }
    const std::vector<Vector3d> filled =
        Fill(in_parent, motion_.offsets_m[joint]);
    for (size_t r = 0; r < row_count_; ++r) {
      TreeMotion::Row& row = motion_.rows[r];
      row.positions_m[joint] = positions_[joint][r].value_or(
          row.positions_m[p] + row.global[p] * filled[r]);
    }
  }

  // Places a missing root where its neighbours fit best.
  void PlaceRootByNeighbours() {
    for (size_t r = 0; r < row_count_; ++r) {
      if (positions_[0][r]) continue;
      TreeMotion::Row& row = motion_.rows[r];
      Vector3d sum = Vector3d::Zero();
      int count = 0;
      for (const size_t end : EndsOf(0)) {
        if (!positions_[end][r] || !tree_[end].is_held) continue;
        sum += *positions_[end][r] - row.global[0] * motion_.offsets_m[end];
        ++count;
      }
      if (count > 0) row.positions_m[0] = sum / count;
    }
  }

  // Sets the rotations of a joint in all rows.
  void SetRotations(size_t joint) {
    std::vector<std::optional<Quaterniond>> local(row_count_);
    std::vector<std::vector<Ray>> too_few(row_count_);
    const std::vector<Spoke> spokes = SpokesOf(joint);
    for (size_t r = 0; r < row_count_; ++r) {
      const Quaterniond above = Above(joint, r);
      if (tree_[joint].children.size() > 1) {
        std::vector<Ray> rays = RaysAt(joint, spokes, r);
        if (const auto rotation = Fit(rays)) {
          local[r] = above.conjugate() * *rotation;
        } else {
          too_few[r] = std::move(rays);
        }
      } else if (tree_[joint].children.size() == 1) {
        const size_t end = tree_[joint].children.front();
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
      Quaterniond rotation = Above(joint, r) * filled[r];
      if (!too_few[r].empty()) rotation = *Fit(too_few[r], &rotation);
      motion_.rows[r].global[joint] = rotation.normalized();
    }
  }

  const JointTree& tree_;
  const size_t row_count_;
  std::vector<Known> positions_;  // [joint][row]
  std::vector<bool> is_ever_seen_;
  std::vector<double> lengths_m_;  // of the bone to each joint
  // Vector from the chest to its parent in the rest pose, by the chest's mean
  // shape.
  Vector3d back_m_ = Vector3d::Zero();
  TreeMotion motion_;
};

constexpr size_t kMostJointsNamed = 30;

// "l_knee, r_knee and 3 more".
std::string Listed(const std::vector<std::string>& names, size_t most) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > most) {
    text += " and " + std::to_string(names.size() - most) + " more";
  }
  return text;
}

}  // namespace

void TreeLosses::See(const JointTree& tree, const TreeMotion& motion,
                     const std::string& person) {
  filled_ += motion.filled;
  std::vector<std::string> joints;
  for (const size_t j : motion.never_seen) {
    // Means of several joints are not joints of the skeleton.
    if (tree[j].sources.size() > 1) continue;
    joints.push_back(tree[j].name);
    by_stature_ = by_stature_ || tree[j].stature_share > 0.0;
  }
  people_[Listed(joints, kMostJointsNamed)].push_back(person);
}

void TreeLosses::Note(const JointTree& tree, LostFields* lost_fields) const {
  if (filled_ > 0) {
    lost_fields->push_back(std::to_string(filled_) +
                           " missing joints were interpolated in time");
  }
  constexpr size_t kMostLines = 5;
  constexpr size_t kMostPeopleNamed = 10;
  size_t lines = 0;
  for (const auto& [joints, people] : people_) {
    if (joints.empty()) continue;
    if (++lines > kMostLines) {
      lost_fields->push_back(
          "other people lack other joints for the whole recording");
      break;
    }
    lost_fields->push_back(
        "joints never seen" +
        (people_.size() == 1 ? ""
                             : " (" + Listed(people, kMostPeopleNamed) + ")") +
        ": " + joints +
        "; they are in the rest pose or on the line to the next joint that is "
        "seen, with the other side's lengths or " +
        (by_stature_ ? "lengths by stature (Drillis and Contini, 1966)"
                     : "a fifth of the median bone"));
  }
  std::vector<std::string> points;
  for (const TreeJoint& joint : tree) {
    if (!joint.is_held && !joint.is_pivot) points.push_back(joint.name);
  }
  if (points.empty()) return;
  lost_fields->push_back("no bone connects " +
                         Listed(points, kMostJointsNamed) +
                         ": written as points below " + tree.front().name);
}

TreeMotion SolveTreeMotion(const JointTree& tree,
                           const std::vector<const PersonPose*>& poses,
                           const AxisMap& axes) {
  return Solver(tree, poses, axes).Solve();
}

Quaterniond TreeMotion::Local(const JointTree& tree, size_t row,
                              size_t joint) const {
  const std::vector<Quaterniond>& global = rows[row].global;
  if (joint == 0) return global[joint];
  return global[tree[joint].parent].conjugate() * global[joint];
}

std::vector<Vector3d> TreeMotion::Rigid(const JointTree& tree,
                                        size_t row_idx) const {
  const Row& row = rows[row_idx];
  std::vector<Vector3d> positions_m(tree.size());
  positions_m[0] = row.positions_m[0];
  Vector3d shift = Vector3d::Zero();
  int count = 0;
  for (size_t j = 1; j < tree.size(); ++j) {
    const size_t parent = tree[j].parent;
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
