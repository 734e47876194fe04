#include "core/identity/bones.h"

#include <Eigen/Cholesky>
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
// than 1 %. On Shelf the medians of 3 s of one body differ by 1.2 % in thigh
// and upper arm, where those of a second alone would let expect 0.6 %.
constexpr double kFloorSigma = 0.01;

// Odds of a bone that is measured wrongly in one of two tracks, hidden for most
// of it or taken for another.
constexpr double kWrongBone = 0.05;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool KeepsItsLength(const Skeleton& skeleton, const Bone& bone) {
  const auto moves = [&](int joint) {
    switch (skeleton.joint_class(joint)) {
      case JointClass::kShoulder:
      case JointClass::kElbow:
      case JointClass::kWrist:
      case JointClass::kHip:
      case JointClass::kKnee:
      case JointClass::kAnkle:
        return false;
      default:
        return true;
    }
  };
  if (moves(bone.a) || moves(bone.b)) return false;
  // The spine bends between shoulder and hip.
  const auto is = [&](JointClass one, JointClass other) {
    return skeleton.joint_class(bone.a) == one &&
           skeleton.joint_class(bone.b) == other;
  };
  return !is(JointClass::kShoulder, JointClass::kHip) &&
         !is(JointClass::kHip, JointClass::kShoulder);
}

// log of a normal density at `x`, without its constant.
double LogNormal(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::VectorXd whitened = factor.matrixL().solve(x);
  double log_determinant = 0.0;
  for (int i = 0; i < x.size(); ++i) {
    log_determinant += 2.0 * std::log(factor.matrixLLT()(i, i));
  }
  return -0.5 * (log_determinant + whitened.squaredNorm());
}

// How much better one body explains the differences than two do.
double LogRatioOf(const std::vector<double>& difference,
                  const std::vector<double>& variance) {
  if (difference.empty()) return 0.0;
  const auto count = static_cast<Eigen::Index>(difference.size());
  const Eigen::VectorXd x =
      Eigen::Map<const Eigen::VectorXd>(difference.data(), count);
  const Eigen::MatrixXd same =
      Eigen::Map<const Eigen::VectorXd>(variance.data(), count).asDiagonal();
  // Two people drawn from the population: twice its covariance.
  Eigen::MatrixXd different = same;
  different.diagonal().array() += 2.0 * kBoneSigma * kBoneSigma;
  different.array() += 2.0 * kStatureSigma * kStatureSigma;
  return LogNormal(x, same) - LogNormal(x, different);
}

std::vector<double> Without(std::vector<double> values, size_t index) {
  values.erase(values.begin() + static_cast<long>(index));
  return values;
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
    groups_.push_back({{bone}});
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
  length.variance =
      of_median * piece_sigma_[bone] * piece_sigma_[bone] / count +
      kFloorSigma * kFloorSigma;
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
  const double all = LogRatioOf(difference, variance);
  double sum = 1.0;  // of exponentials, as shares of the highest
  double highest = all;
  // One bone may be measured wrongly, and then says nothing.
  for (size_t left_out = 0; left_out < difference.size(); ++left_out) {
    const double rest =
        std::log(kWrongBone) +
        LogRatioOf(Without(difference, left_out), Without(variance, left_out));
    sum = rest > highest ? sum * std::exp(highest - rest) + 1.0
                         : sum + std::exp(rest - highest);
    highest = std::max(highest, rest);
  }
  return highest + std::log(sum) -
         std::log1p(kWrongBone * static_cast<double>(difference.size()));
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
