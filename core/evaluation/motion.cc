#include "core/evaluation/motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/tapered_transform.h"

namespace kinegraph {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// Limbs, shoulder and hip girdles, and the sides of the trunk.
constexpr std::array<std::pair<const char*, const char*>, 12> kBodyBones = {{
    {"l_shoulder", "l_elbow"},
    {"r_shoulder", "r_elbow"},
    {"l_elbow", "l_wrist"},
    {"r_elbow", "r_wrist"},
    {"l_hip", "l_knee"},
    {"r_hip", "r_knee"},
    {"l_knee", "l_ankle"},
    {"r_knee", "r_ankle"},
    {"l_shoulder", "r_shoulder"},
    {"l_hip", "r_hip"},
    {"l_shoulder", "l_hip"},
    {"r_shoulder", "r_hip"},
}};

std::vector<int> BodyJoints(const Skeleton& skeleton) {
  std::vector<int> joints;
  for (const JointPair& pair : CommonBodyJoints(skeleton, skeleton)) {
    joints.push_back(pair.a);
  }
  return joints;
}

void RequireRate(double rate_hz, const char* what) {
  if (rate_hz > 0.0) return;
  throw OptionError("frame rate", std::string("must be known for ") + what);
}

using Poses = std::map<int64_t, const Pose3d*>;  // of a person, by frame

std::map<TrackId, Poses> PosesByIdentity(
    const TrackSequence& tracks, const std::vector<FrameRange>& frames = {}) {
  std::map<TrackId, Poses> people;
  for (const TrackFrame& frame : tracks.frames) {
    if (!ContainsFrame(frames, frame.frame)) continue;
    for (const PersonPose& person : frame.people) {
      people[person.id][frame.frame] = &person.joints;
    }
  }
  return people;
}

// nullptr if there is none.
const Pose3d* PoseAt(const Poses& poses, int64_t frame) {
  const auto at = poses.find(frame);
  return at == poses.end() ? nullptr : at->second;
}

// ---- Jitter and bone lengths ------------------------------------------------

// Weights of a finite difference, up to the sign: 1, -2, 1 for order 2.
std::vector<double> DifferenceWeights(int order) {
  std::vector<double> weights = {1.0};
  for (int i = 0; i < order; ++i) {
    std::vector<double> next(weights.size() + 1, 0.0);
    for (size_t k = 0; k < weights.size(); ++k) {
      next[k] += weights[k];
      next[k + 1] -= weights[k];
    }
    weights = next;
  }
  return weights;
}

// Over the joints that are observed in all of the poses (nullptr: no pose): the
// sum of `scale` times the norm of the weighted sum of a joint's positions, and
// the number of joints.
RatioUnit Difference(const std::vector<const Pose3d*>& poses,
                     const std::vector<double>& weights,
                     const std::vector<int>& joints, double scale) {
  RatioUnit unit;
  for (const int j : joints) {
    const bool observed =
        std::all_of(poses.begin(), poses.end(), [&](const Pose3d* pose) {
          return pose != nullptr && (*pose)[j].status == JointStatus::kObserved;
        });
    if (!observed) continue;
    Vector3d difference = Vector3d::Zero();
    for (size_t i = 0; i < poses.size(); ++i) {
      difference += weights[i] * (*poses[i])[j].position_m;
    }
    unit.Add(scale * difference.norm());
  }
  return unit;
}

void AddAcceleration(const std::map<TrackId, Poses>& people,
                     const std::vector<int>& joints, double frame_rate_hz,
                     const BootstrapOptions& options, MotionResult* result) {
  const std::vector<double> weights = DifferenceWeights(2);
  std::vector<RatioSeries> all;
  for (const auto& [id, poses] : people) {
    RatioSeries& series = all.emplace_back();
    for (const auto& [frame, pose] : poses) {
      const Pose3d* before = PoseAt(poses, frame - 1);
      const Pose3d* after = PoseAt(poses, frame + 1);
      if (before == nullptr || after == nullptr) continue;
      RatioUnit unit = Difference({after, pose, before}, weights, joints, 1.0);
      unit.sum *= frame_rate_hz * frame_rate_hz;
      series.push_back(unit);
      result->acceleration_count += static_cast<int64_t>(unit.weight);
    }
  }
  result->acceleration_m_s2 = PooledRatio(all);
  result->acceleration_interval = RatioInterval(PooledRatio, all, options);
}

void AddBoneSpread(const std::map<TrackId, Poses>& people,
                   const Skeleton& skeleton, MotionResult* result) {
  std::vector<double> spreads;
  for (const auto& [id, poses] : people) {
    for (const auto& [name_a, name_b] : kBodyBones) {
      const int a = skeleton.IndexOf(name_a);
      const int b = skeleton.IndexOf(name_b);
      if (a < 0 || b < 0) continue;
      std::vector<double> lengths;
      for (const auto& [frame, pose] : poses) {
        if (!(*pose)[a].present() || !(*pose)[b].present()) continue;
        lengths.push_back(
            ((*pose)[a].position_m - (*pose)[b].position_m).norm());
      }
      if (lengths.size() >= 2) spreads.push_back(StandardDeviation(lengths));
    }
  }
  result->bone_count = static_cast<int64_t>(spreads.size());
  result->bone_length_spread_m = Mean(spreads);
}

// ---- Smoothness -------------------------------------------------------------

// The poses of each person's frames; null where the tracks have none.
std::vector<std::vector<const Pose3d*>> PosesOf(
    const TrackSequence& tracks, const std::vector<PersonFrames>& people) {
  std::map<TrackId, Poses> by_identity = PosesByIdentity(tracks);
  std::vector<std::vector<const Pose3d*>> poses;
  for (const PersonFrames& person : people) {
    poses.emplace_back();
    for (const int64_t frame : person.frames) {
      poses.back().push_back(PoseAt(by_identity[person.id], frame));
    }
  }
  return poses;
}

// Whether `count` frames from `first` on are consecutive.
bool Consecutive(const std::vector<int64_t>& frames, size_t first,
                 size_t count) {
  return first + count <= frames.size() &&
         frames[first + count - 1] - frames[first] ==
             static_cast<int64_t>(count) - 1;
}

// Power of one joint over a segment, in the bins of the transform; nullopt when
// a position is missing.
std::optional<double> SegmentPower(const std::vector<const Pose3d*>& poses,
                                   size_t first, int joint,
                                   const TaperedTransform& transform) {
  MatrixXd positions(transform.length(), 3);
  for (int i = 0; i < transform.length(); ++i) {
    const Pose3d* pose = poses[first + i];
    if (pose == nullptr || !(*pose)[joint].present()) return std::nullopt;
    positions.row(i) = (*pose)[joint].position_m.transpose();
  }
  return transform(std::move(positions)).squaredNorm();
}

// ---- Delay ------------------------------------------------------------------

// Displacement from one pose to another; nullopt where one is missing.
std::optional<Vector3d> MotionOf(const Pose3d* a, const Pose3d* b, int joint) {
  if (a == nullptr || b == nullptr) return std::nullopt;
  if (!(*a)[joint].present() || !(*b)[joint].present()) return std::nullopt;
  return (*b)[joint].position_m - (*a)[joint].position_m;
}

// Sums for shifts of -reach .. reach frames, over the same samples for all.
struct Correlation {
  std::vector<double> product;  // reference at t, tracks at t + shift
  std::vector<double> energy;   // of the tracks there

  explicit Correlation(int reach)
      : product(2 * reach + 1, 0.0), energy(2 * reach + 1, 0.0) {}

  void Add(const Vector3d& reference, const std::vector<Vector3d>& shifted) {
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

MotionResult EvaluateMotion(const TrackSequence& tracks, double frame_rate_hz,
                            const MotionOptions& options,
                            const BootstrapOptions& bootstrap) {
  RequireRate(frame_rate_hz, "an acceleration");
  const auto people = PosesByIdentity(tracks, options.frames);
  MotionResult result;
  AddAcceleration(people, BodyJoints(tracks.header.skeleton), frame_rate_hz,
                  bootstrap, &result);
  AddBoneSpread(people, tracks.header.skeleton, &result);
  return result;
}

Share EvaluateCoverage(const TrackSequence& truth, const TrackSequence& tracks,
                       const std::vector<FrameRange>& frames) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  Share covered;
  for (const FramePair& both : PairFrames(truth, tracks, frames).pairs) {
    if (both.truth == nullptr) continue;
    const MatrixXd distances_m =
        PersonDistances(both.truth->people, PeopleOf(both.tracks), joints);
    for (int i = 0; i < distances_m.rows(); ++i) {
      covered.Add((distances_m.row(i).array() <= kPersonGateM).any());
    }
  }
  return covered;
}

std::vector<PersonFrames> PersonFramesOf(const TrackSequence& tracks) {
  std::vector<PersonFrames> people;
  for (const auto& [id, poses] : PosesByIdentity(tracks)) {
    people.push_back({id, {}});
    for (const auto& [frame, pose] : poses) {
      people.back().frames.push_back(frame);
    }
  }
  return people;
}

std::vector<RatioSeries> DifferenceSeries(
    const TrackSequence& tracks, const std::vector<PersonFrames>& people,
    int order, double rate_hz) {
  const std::vector<int> joints = BodyJoints(tracks.header.skeleton);
  const std::vector<double> weights = DifferenceWeights(order);
  const double scale = std::pow(rate_hz, order);
  const auto poses_of = PosesOf(tracks, people);
  std::vector<RatioSeries> all;
  for (size_t p = 0; p < people.size(); ++p) {
    const PersonFrames& person = people[p];
    const std::vector<const Pose3d*>& poses = poses_of[p];
    RatioSeries series(person.frames.size());
    for (size_t k = 0; k < series.size(); ++k) {
      if (!Consecutive(person.frames, k, weights.size())) continue;
      const auto first = poses.begin() + static_cast<std::ptrdiff_t>(k);
      series[k] = Difference(
          {first, first + static_cast<std::ptrdiff_t>(weights.size())}, weights,
          joints, scale);
    }
    all.push_back(std::move(series));
  }
  return all;
}

std::vector<RatioSeries> PowerSeries(const TrackSequence& tracks,
                                     const std::vector<PersonFrames>& people,
                                     double rate_hz) {
  // Voluntary movement has little power above this frequency.
  constexpr double kCutoffHz = 6.0;
  constexpr double kSegmentS = 2.0;  // frequency resolution: 1 / kSegmentS
  std::vector<RatioSeries> all(people.size());
  if (rate_hz <= 2.0 * kCutoffHz) return all;
  // The length of a segment is even, so that segments overlap by exactly half.
  const int half =
      std::max(2, static_cast<int>(std::lround(0.5 * kSegmentS * rate_hz)));
  const int length = 2 * half;
  const std::vector<int> joints = BodyJoints(tracks.header.skeleton);
  const auto poses_of = PosesOf(tracks, people);
  const TaperedTransform high_pass(
      length, static_cast<int>(std::floor(kCutoffHz * length / rate_hz)) + 1);
  for (size_t p = 0; p < people.size(); ++p) {
    const PersonFrames& person = people[p];
    const std::vector<const Pose3d*>& poses = poses_of[p];
    size_t first = 0;
    while (first + static_cast<size_t>(length) <= person.frames.size()) {
      if (!Consecutive(person.frames, first, static_cast<size_t>(length))) {
        ++first;
        continue;
      }
      RatioUnit unit;
      for (const int j : joints) {
        const auto power = SegmentPower(poses, first, j, high_pass);
        if (power) unit.Add(*power);
      }
      all[p].push_back(unit);
      first += static_cast<size_t>(half);
    }
  }
  return all;
}

std::optional<double> EstimateLag(const TrackSequence& reference,
                                  const TrackSequence& tracks, double rate_hz,
                                  const std::vector<FrameRange>& frames) {
  constexpr double kMaxLagS = 0.4;
  RequireRate(rate_hz, "a lag");
  const int reach =
      std::max(2, static_cast<int>(std::ceil(kMaxLagS * rate_hz)));
  const JointPairs joints =
      CommonBodyJoints(reference.header.skeleton, tracks.header.skeleton);
  // The frames that both have may be several frames of the tracks apart:
  // displacements are taken over `stride`, their least distance.
  const FramePairing pairing = PairFrames(reference, tracks);
  std::map<TrackId, Poses> true_people;
  int64_t stride = 0;
  std::optional<int64_t> last;  // frame that both have
  for (const FramePair& both : pairing.pairs) {
    if (both.truth == nullptr) continue;
    for (const PersonPose& person : both.truth->people) {
      true_people[person.id][both.frame] = &person.joints;
    }
    if (both.tracks == nullptr) continue;
    const int64_t step = both.frame - last.value_or(both.frame);
    if (step > 0 && (stride == 0 || step < stride)) stride = step;
    last = both.frame;
  }
  const auto found_people = PosesByIdentity(tracks);
  Correlation correlation(reach);
  std::vector<const Pose3d*> from, to;
  std::vector<Vector3d> shifted;
  for (const PersonPair& pair : PairPeople(pairing, joints, kPersonGateM)) {
    if (pair.found == nullptr || !ContainsFrame(frames, pair.frame)) continue;
    const Poses& truth = true_people.at(pair.truth->id);
    const Pose3d* before = PoseAt(truth, pair.frame - stride);
    const Pose3d* after = PoseAt(truth, pair.frame + stride);
    const Poses& found = found_people.at(pair.found->id);
    from.clear();
    to.clear();
    for (int k = -reach; k <= reach; ++k) {
      from.push_back(PoseAt(found, pair.frame + k - stride));
      to.push_back(PoseAt(found, pair.frame + k + stride));
    }
    for (const JointPair& joint : joints) {
      const auto expected = MotionOf(before, after, joint.a);
      if (!expected.has_value()) continue;
      shifted.clear();
      for (size_t k = 0; k < from.size(); ++k) {
        const auto motion = MotionOf(from[k], to[k], joint.b);
        if (!motion.has_value()) break;
        shifted.push_back(*motion);
      }
      if (shifted.size() != from.size()) continue;
      correlation.Add(*expected, shifted);
    }
  }
  size_t best = 0;
  const size_t count = correlation.product.size();
  for (size_t i = 1; i < count; ++i) {
    if (correlation.At(i) > correlation.At(best)) best = i;
  }
  // A maximum at an end may not be a local maximum.
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
