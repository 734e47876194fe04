#include "core/identity/bones.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

// Adults' bone lengths differ by about 4 % with their stature and by as much
// again bone by bone (Drillis and Contini's shares hold on average only).
constexpr double kStatureSigma = 0.04;
constexpr double kBoneSigma = 0.035;

constexpr double kPieceSeconds = 1.0;
constexpr size_t kMinFramesOfPiece = 3;
// Before anything was learnt: 3 %, about 1 cm, between pieces of one body.
constexpr double kDefaultPieceSigma = 0.03;
constexpr size_t kMinPiecesToLearn = 10;
// Errors that last (a view's bias, a posture) do not average out: never better
// than 1 % and 4 mm. On Shelf the medians of 3 s of one body differ by 1.2 % in
// thigh and upper arm, where those of a second alone would let expect 0.6 %.
// Detectors put shoulders and hips of one person closer or wider as they turn.
constexpr double kFloorSigma = 0.01;
constexpr double kFloor = 0.004;          // m
constexpr double kShouldersFloor = 0.01;  // m, of their distance
constexpr double kHipsFloor = 0.015;      // m

// A bone may be measured wrongly in one of two tracks, hidden for most of it or
// taken for another, and says nothing then: so often, and with such lengths.
constexpr double kWrongBone = 0.05;
constexpr double kWrongSigma = 0.25;
// Statures are summed over at so many places, to three sigmas on either side.
constexpr int kStatures = 25;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Limbs, shoulders, hips, and from shoulder to hip.
bool KeepsItsLength(const Skeleton& skeleton, const Bone& bone) {
  const auto counts = [&](int joint) {
    switch (skeleton.joint_class(joint)) {
      case JointClass::kShoulder:
      case JointClass::kElbow:
      case JointClass::kWrist:
      case JointClass::kHip:
      case JointClass::kKnee:
      case JointClass::kAnkle:
        return true;
      default:
        return false;
    }
  };
  return counts(bone.a) && counts(bone.b);
}

// What lasts of the errors of such a bone [m].
double FloorOf(const Skeleton& skeleton, const Bone& bone) {
  const JointClass a = skeleton.joint_class(bone.a);
  if (a != skeleton.joint_class(bone.b)) return kFloor;
  return a == JointClass::kHip ? kHipsFloor : kShouldersFloor;
}

double Density(double x, double variance) {
  return std::exp(-0.5 * x * x / variance) / std::sqrt(2.0 * M_PI * variance);
}

}  // namespace

void BoneSamples::Append(const BoneSamples& other) {
  log_length.resize(std::max(log_length.size(), other.log_length.size()));
  for (size_t i = 0; i < other.log_length.size(); ++i) {
    log_length[i].insert(log_length[i].end(), other.log_length[i].begin(),
                         other.log_length[i].end());
  }
}

BoneModel::BoneModel(const Skeleton& skeleton) {
  std::map<std::pair<int, int>, size_t> group_of;
  for (const Bone& bone : skeleton.bones()) {
    if (!KeepsItsLength(skeleton, bone)) continue;
    const auto key = std::minmax(bone.a, bone.b);
    const auto mirrored =
        std::minmax(skeleton.mirror(bone.a), skeleton.mirror(bone.b));
    const auto known = group_of.find(mirrored);
    if (known != group_of.end()) {
      groups_[known->second].bones.push_back(bone);
      continue;
    }
    group_of[key] = groups_.size();
    groups_.push_back({{bone}, FloorOf(skeleton, bone)});
  }
  piece_sigma_.assign(groups_.size(), kDefaultPieceSigma);
}

BoneSamples BoneModel::Measure(const Tracklet& tracklet) const {
  BoneSamples samples;
  samples.log_length.resize(groups_.size());
  for (size_t g = 0; g < groups_.size(); ++g) {
    std::vector<double> piece;
    TimeNs piece_begin = 0;
    const auto finish = [&] {
      if (piece.size() >= kMinFramesOfPiece) {
        samples.log_length[g].push_back(Median(piece));
      }
      piece.clear();
    };
    for (size_t k = tracklet.clean_begin(); k < tracklet.clean_end(); ++k) {
      const TrackletFrame& frame = tracklet.frames[k];
      if (!piece.empty() &&
          ToSeconds(frame.time - piece_begin) >= kPieceSeconds) {
        finish();
      }
      for (const Bone& bone : groups_[g].bones) {
        const Joint3d& a = frame.pose->joints[bone.a];
        const Joint3d& b = frame.pose->joints[bone.b];
        if (a.status != JointStatus::kObserved ||
            b.status != JointStatus::kObserved) {
          continue;
        }
        const double length_m = (a.position_m - b.position_m).norm();
        if (!(length_m > 0.0)) continue;
        if (piece.empty()) piece_begin = frame.time;
        piece.push_back(std::log(length_m));
      }
    }
    finish();
  }
  return samples;
}

std::vector<std::vector<double>> BoneModel::LogLengths(
    const Tracklet& tracklet) const {
  std::vector<std::vector<double>> lengths(groups_.size());
  for (size_t k = tracklet.clean_begin(); k < tracklet.clean_end(); ++k) {
    const Pose3d& pose = tracklet.frames[k].pose->joints;
    for (size_t g = 0; g < groups_.size(); ++g) {
      for (const Bone& bone : groups_[g].bones) {
        const Joint3d& a = pose[bone.a];
        const Joint3d& b = pose[bone.b];
        const double length_m = (a.position_m - b.position_m).norm();
        if (a.status == JointStatus::kObserved &&
            b.status == JointStatus::kObserved && length_m > 0.0) {
          lengths[g].push_back(std::log(length_m));
        }
      }
    }
  }
  return lengths;
}

void BoneModel::Learn(const std::vector<BoneSamples>& tracklets) {
  for (size_t g = 0; g < groups_.size(); ++g) {
    std::vector<double> deviations;
    for (const BoneSamples& samples : tracklets) {
      const std::vector<double>& pieces = samples.log_length[g];
      if (pieces.size() < 3) continue;
      const double median = Median(pieces);
      for (const double piece : pieces) {
        deviations.push_back(std::abs(piece - median));
      }
    }
    if (deviations.size() < kMinPiecesToLearn) continue;
    // Of a normal distribution the median deviation is 0.6745 sigma.
    piece_sigma_[g] = std::max(kFloorSigma, Median(deviations) / 0.6745);
  }
}

BoneModel::Length BoneModel::LengthOf(const BoneSamples& samples,
                                      size_t bone) const {
  Length length;
  if (bone >= samples.log_length.size()) return length;
  const std::vector<double>& pieces = samples.log_length[bone];
  if (pieces.empty()) return length;
  const auto count = static_cast<double>(pieces.size());
  // A median of many varies more than their mean, by pi / 2.
  const double of_median = count < 3.0 ? 1.0 : 0.5 * M_PI;
  length.known = true;
  length.log_length = Median(pieces);
  const double floor = std::max(
      kFloorSigma, groups_[bone].floor_m / std::exp(length.log_length));
  length.variance =
      of_median * piece_sigma_[bone] * piece_sigma_[bone] / count +
      floor * floor;
  return length;
}

double BoneModel::LogRatio(const BoneSamples& a, const BoneSamples& b) const {
  std::vector<double> difference;
  std::vector<double> variance;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Length one = LengthOf(a, g);
    const Length other = LengthOf(b, g);
    if (!one.known || !other.known) continue;
    difference.push_back(one.log_length - other.log_length);
    variance.push_back(one.variance + other.variance);
  }
  const auto likelihood = [&](double stature, double two_bodies) {
    double product = 1.0;
    for (size_t i = 0; i < difference.size(); ++i) {
      product *= (1.0 - kWrongBone) * Density(difference[i] - stature,
                                              variance[i] + two_bodies) +
                 kWrongBone * Density(difference[i], kWrongSigma * kWrongSigma);
    }
    return product;
  };
  // Two people drawn from the population differ by a stature, which all bones
  // share, and bone by bone.
  const double sigma = std::sqrt(2.0) * kStatureSigma;
  const double step = 6.0 * sigma / (kStatures - 1);
  double two = 0.0;
  for (int k = 0; k < kStatures; ++k) {
    const double stature = -3.0 * sigma + k * step;
    two += step * Density(stature, sigma * sigma) *
           likelihood(stature, 2.0 * kBoneSigma * kBoneSigma);
  }
  return difference.empty() ? 0.0 : std::log(likelihood(0.0, 0.0) / two);
}

double BoneModel::MeanDifference(const BoneSamples& a,
                                 const BoneSamples& b) const {
  double sum_m = 0.0;
  int count = 0;
  for (size_t g = 0; g < groups_.size(); ++g) {
    const Length one = LengthOf(a, g);
    const Length other = LengthOf(b, g);
    if (!one.known || !other.known) continue;
    sum_m += std::abs(std::exp(one.log_length) - std::exp(other.log_length));
    ++count;
  }
  return count == 0 ? 0.0 : sum_m / count;
}

}  // namespace kinegraph
