#include "core/evaluation/correspondence.h"

#include <cmath>

#include "core/assignment/hungarian.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

// The first names of a list, for a message.
std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kShown = 4;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    text += (i == 0 ? "'" : ", '") + Printable(names[i]) + "'";
  }
  return text + (names.size() > kShown ? ", ..." : "");
}

// Mean of a measure of the difference, over the joints that both poses have.
template <typename Measure>
std::optional<double> MeanOf(const Pose3d& a, const Pose3d& b,
                             const JointPairs& joints, const Measure& measure) {
  double sum = 0.0;
  int count = 0;
  for (const JointPair& joint : joints) {
    const Joint3d& one = a[joint.a];
    const Joint3d& other = b[joint.b];
    if (!one.present() || !other.present()) continue;
    sum += measure(one.position_m - other.position_m);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace

const TrackFrame* FindFrame(const TrackSequence& tracks, int64_t frame) {
  const auto at = std::lower_bound(
      tracks.frames.begin(), tracks.frames.end(), frame,
      [](const TrackFrame& one, int64_t number) { return one.frame < number; });
  if (at == tracks.frames.end() || at->frame != frame) return nullptr;
  return &*at;
}

const std::vector<PersonPose>& PeopleOf(const TrackFrame* frame) {
  static const std::vector<PersonPose> kNobody;
  return frame == nullptr ? kNobody : frame->people;
}

JointPairs SameJoints(size_t count) {
  JointPairs joints;
  for (int j = 0; j < static_cast<int>(count); ++j) joints.push_back({j, j});
  return joints;
}

JointPairs CommonJoints(const Skeleton& a, const Skeleton& b) {
  JointPairs pairs;
  const std::vector<int> b_of_a = MapByName(b, a);
  for (int joint = 0; joint < a.joint_count(); ++joint) {
    if (b_of_a[joint] >= 0) pairs.push_back({joint, b_of_a[joint]});
  }
  return pairs;
}

void RequireCommonJoints(const Skeleton& a, const std::string& file_a,
                         const Skeleton& b, const std::string& file_b) {
  if (!CommonJoints(a, b).empty()) return;
  throw InputError(file_b, "",
                   "has no joint in common with " + file_a + ": it has " +
                       Listed(b.joints()) + ", the other " +
                       Listed(a.joints()));
}

JointPairs CommonBodyJoints(const Skeleton& a, const Skeleton& b) {
  const JointPairs common = CommonJoints(a, b);
  JointPairs body;
  for (const JointPair& pair : common) {
    if (IsBodyJoint(a.joint_class(pair.a))) body.push_back(pair);
  }
  return body.empty() ? common : body;
}

std::optional<double> MeanDistance(const Pose3d& a, const Pose3d& b,
                                   const JointPairs& joints) {
  return MeanOf(a, b, joints,
                [](const auto& difference) { return difference.norm(); });
}

std::optional<double> MeanSquaredDistance(const Pose3d& a, const Pose3d& b,
                                          const JointPairs& joints) {
  return MeanOf(a, b, joints, [](const auto& difference) {
    return difference.squaredNorm();
  });
}

std::vector<CostPair> MatchOneToOne(const Eigen::MatrixXd& cost, double gate) {
  const int rows = static_cast<int>(cost.rows());
  const int columns = static_cast<int>(cost.cols());
  const auto allowed = [&](int r, int c) {
    return std::isfinite(cost(r, c)) && cost(r, c) <= gate;
  };
  // A forbidden pair costs more than all allowed pairs together, so the best
  // assignment contains as few forbidden pairs as possible.
  double forbidden = 1.0;
  std::vector<double> entries;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      if (allowed(r, c)) forbidden += std::abs(cost(r, c));
      entries.push_back(allowed(r, c) ? cost(r, c) : kNan);
    }
  }
  for (double& entry : entries) {
    if (std::isnan(entry)) entry = forbidden;
  }
  std::vector<int> column_of_row;
  HungarianSolver().Minimise(entries, rows, columns, &column_of_row);
  std::vector<CostPair> pairs;
  for (int r = 0; r < rows; ++r) {
    const int c = column_of_row[r];
    if (c >= 0 && allowed(r, c)) pairs.push_back({r, c, cost(r, c)});
  }
  return pairs;
}

Eigen::MatrixXd PersonDistances(const std::vector<PersonPose>& a,
                                const std::vector<PersonPose>& b,
                                const JointPairs& joints) {
  Eigen::MatrixXd distances(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t k = 0; k < b.size(); ++k) {
      distances(i, k) =
          MeanDistance(a[i].joints, b[k].joints, joints).value_or(kNan);
    }
  }
  return distances;
}

std::vector<PersonPair> PairPeople(const FramePairing& frames,
                                   const JointPairs& joints, double gate_m) {
  std::vector<PersonPair> pairs;
  for (const FramePair& both : frames.pairs) {
    if (both.truth == nullptr) continue;
    const size_t first = pairs.size();
    for (const PersonPose& person : both.truth->people) {
      pairs.push_back({both.frame, &person, nullptr});
    }
    const std::vector<PersonPose>& found = PeopleOf(both.tracks);
    for (const CostPair& pair : MatchOneToOne(
             PersonDistances(both.truth->people, found, joints), gate_m)) {
      pairs[first + pair.row].found = &found[pair.column];
    }
  }
  return pairs;
}

std::vector<PersonPair> PairPeople(const TrackSequence& truth,
                                   const TrackSequence& tracks,
                                   const JointPairs& joints, double gate_m,
                                   const std::vector<FrameRange>& ranges) {
  return PairPeople(PairFrames(truth, tracks, ranges), joints, gate_m);
}

}  // namespace kinegraph
