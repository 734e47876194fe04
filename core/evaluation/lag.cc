#include "core/evaluation/lag.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// The poses of a person, one a frame number from the first on; null: none.
class PoseByFrame {
 public:
  void Add(int64_t frame, const Pose3d* pose) {
    if (poses_.empty()) first_ = frame;
    poses_.resize(static_cast<size_t>(frame - first_), nullptr);
    poses_.push_back(pose);
  }
  // Position after minus position before a frame; nullopt where one is missing.
  std::optional<Eigen::Vector3d> Motion(int64_t frame, int joint) const {
    const Joint3d* a = Find(frame - 1, joint);
    const Joint3d* b = Find(frame + 1, joint);
    if (a == nullptr || b == nullptr) return std::nullopt;
    return b->position_m - a->position_m;
  }

 private:
  const Joint3d* Find(int64_t frame, int joint) const {
    const int64_t at = frame - first_;
    if (at < 0 || at >= static_cast<int64_t>(poses_.size())) return nullptr;
    const Pose3d* pose = poses_[static_cast<size_t>(at)];
    if (pose == nullptr || !(*pose)[joint].present()) return nullptr;
    return &(*pose)[joint];
  }

  int64_t first_ = 0;
  std::vector<const Pose3d*> poses_;
};

std::map<TrackId, PoseByFrame> PosesByIdentity(const TrackSequence& tracks) {
  std::map<TrackId, PoseByFrame> people;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      people[person.id].Add(frame.frame, &person.joints);
    }
  }
  return people;
}

// Sums for shifts of -reach .. reach frames, over the same places for all.
struct Correlation {
  std::vector<double> product;  // reference at t, tracks at t + shift
  std::vector<double> energy;   // of the tracks there

  explicit Correlation(int reach)
      : product(2 * reach + 1, 0.0), energy(2 * reach + 1, 0.0) {}

  void Add(const Eigen::Vector3d& reference,
           const std::vector<Eigen::Vector3d>& shifted) {
    for (size_t i = 0; i < shifted.size(); ++i) {
      product[i] += reference.dot(shifted[i]);
      energy[i] += shifted[i].squaredNorm();
    }
  }
  double At(size_t i) const {
    return energy[i] > 0.0 ? product[i] / std::sqrt(energy[i]) : 0.0;
  }
};

}  // namespace

std::optional<double> EstimateLag(const TrackSequence& reference,
                                  const TrackSequence& tracks, double rate_hz,
                                  const LagOptions& options) {
  if (!(rate_hz > 0.0)) {
    throw OptionError("frame rate", "must be known for a lag");
  }
  const int reach =
      std::max(2, static_cast<int>(std::ceil(options.max_lag_s * rate_hz)));
  const JointPairs joints =
      CommonBodyJoints(reference.header.skeleton, tracks.header.skeleton);
  const auto true_people = PosesByIdentity(reference);
  const auto found_people = PosesByIdentity(tracks);
  Correlation correlation(reach);
  std::vector<Eigen::Vector3d> shifted;
  for (const TrackFrame& frame : reference.frames) {
    if (!ContainsFrame(options.frames, frame.frame)) continue;
    const TrackFrame* found = FindFrame(tracks, frame.frame);
    if (found == nullptr) continue;
    for (const CostPair& pair :
         MatchOneToOne(PersonDistances(frame.people, found->people, joints),
                       kPersonGateM)) {
      const PoseByFrame& truth = true_people.at(frame.people[pair.row].id);
      const PoseByFrame& poses = found_people.at(found->people[pair.column].id);
      for (const JointPair& joint : joints) {
        const auto expected = truth.Motion(frame.frame, joint.a);
        if (!expected.has_value()) continue;
        shifted.clear();
        for (int k = -reach; k <= reach; ++k) {
          const auto motion = poses.Motion(frame.frame + k, joint.b);
          if (!motion.has_value()) break;
          shifted.push_back(*motion);
        }
        if (static_cast<int>(shifted.size()) != 2 * reach + 1) continue;
        correlation.Add(*expected, shifted);
      }
    }
  }
  size_t best = 0;
  const size_t count = correlation.product.size();
  for (size_t i = 1; i < count; ++i) {
    if (correlation.At(i) > correlation.At(best)) best = i;
  }
  // At an end there is no maximum.
  if (best == 0 || best + 1 == count || !(correlation.At(best) > 0.0)) {
    return std::nullopt;
  }
  const double before = correlation.At(best - 1);
  const double at = correlation.At(best);
  const double after = correlation.At(best + 1);
  const double bend = before - 2.0 * at + after;
  const double fraction = bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
  return (static_cast<double>(best) - reach + fraction) / rate_hz;
}

}  // namespace kinegraph
