#include "core/identity/bones.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/base/weighted_quantile.h"
#include "core/skeleton/body_joints.h"

namespace kinegraph {
namespace {

// Adults' bone lengths differ by about 4 % with their stature, and by another
// 3.5 % from bone to bone (Drillis and Contini's shares are averages).
constexpr double kStatureSigma = 0.04;
constexpr double kBoneSigma = 0.035;

constexpr double kPieceSeconds = 1.0;
constexpr size_t kMinFramesOfPiece = 3;
// Default before learning: 3 %, about 1 cm, between intervals of one body.
constexpr double kDefaultPieceSigma = 0.03;
constexpr size_t kMinPiecesToLearn = 10;
// Correlation time of a joint's reported errors: over tracks of 1.5 to 8 s
// (people walking, two to six cameras, recorded motion), the medians of one
// body differ by a frame's reported standard deviation times sqrt(0.35 s /
// length of the shorter track), or by the floors below. With graph.bones all
// frames of a track share one length, so their own spread is no measure of its
// error.
constexpr double kErrorLasts = 0.35;  // s
// Lasting errors (a view's bias, a posture) do not average out, so the
// uncertainty of a length is at least 1 % and 4 mm. On Shelf the medians of 3 s
// of one body differ by 1.2 % in thigh and upper arm, where the spread within a
// second predicts 0.6 %. Detectors place a person's shoulders and hips closer
// together or further apart as the person turns.
constexpr double kFloorSigma = 0.01;
constexpr double kFloor = 0.004;          // m
constexpr double kShouldersFloor = 0.01;  // m, distance between the shoulders
constexpr double kHipsFloor = 0.015;      // m

// Prior probability that a bone is measured wrongly in one of two tracks,
// because it was mostly hidden or confused with another, and the standard
// deviation of the difference of such log lengths. Such a bone is no evidence.
constexpr double kWrongBone = 0.05;
constexpr double kWrongSigma = 0.25;
// The stature is integrated out numerically, at this many points within three
// sigmas.
constexpr int kStatures = 25;

// Variance of the bone's length from the two joints' covariances [m^2],
// assuming independent errors; 0: no covariances.
double StatedVariance(const PersonPose& pose, const Bone& bone) {
  if (pose.covariances.size() != pose.joints.size()) return 0.0;
  const auto& a = pose.covariances[bone.a];
  const auto& b = pose.covariances[bone.b];
  if (!a.has_value() || !b.has_value()) return 0.0;
  const Eigen::Vector3d along =
      (pose.joints[bone.a].position_m - pose.joints[bone.b].position_m)
          .normalized();
  return std::max(0.0, along.dot((*a + *b) * along));
}

// Mean interval between a tracklet's frames [s].
double FrameSeconds(const Tracklet& tracklet) {
  const size_t count = tracklet.frames.size();
  if (count < 2) return 0.0;
  return ToSeconds(tracklet.last().time - tracklet.first().time) /
         static_cast<double>(count - 1);
}

// Groups the frames of one bone into intervals of a second. Each with at least
// kMinFramesOfPiece frames becomes a piece.
class PieceMaker {
 public:
  PieceMaker(double frame_s, std::vector<BoneSamples::Piece>* to)
      : seconds_each_(frame_s), to_(to) {}

  void Add(TimeNs time, double length_m, double variance_m2) {
    if (!lengths_.empty() && ToSeconds(time - begin_) >= kPieceSeconds &&
        time != newest_) {
      Finish();
    }
    if (lengths_.empty()) begin_ = time;
    newest_ = time;
    lengths_.push_back(std::log(length_m));
    if (variance_m2 > 0.0) {
      variances_.push_back(variance_m2 / (length_m * length_m));
    }
  }

  void Finish() {
    if (lengths_.size() >= kMinFramesOfPiece) {
      BoneSamples::Piece piece;
      piece.log_length = Median(lengths_);
      piece.seconds = seconds_each_ * static_cast<double>(lengths_.size());
      if (2 * variances_.size() > lengths_.size()) {
        piece.stated_variance = Median(variances_) * kErrorLasts /
                                std::max(kErrorLasts, piece.seconds);
      }
      to_->push_back(piece);
    }
    lengths_.clear();
    variances_.clear();
  }

 private:
  double seconds_each_;
  std::vector<BoneSamples::Piece>* to_;
  std::vector<double> lengths_;    // as logarithms
  std::vector<double> variances_;  // of lengths_
  TimeNs begin_ = 0;
  TimeNs newest_ = 0;
};

// Whether a bone is used (BoneModel::BoneModel). In a skeleton of few joints,
// such as the top and the bottom of a person's bounding box, every bone is
// used: there it measures the person's height.
bool KeepsItsLength(const Skeleton& skeleton, const Bone& bone) {
  constexpr int kFewJoints = 3;
  if (skeleton.joint_count() <= kFewJoints) return true;
  return IsBodyJoint(skeleton.joint_class(bone.a)) &&
         IsBodyJoint(skeleton.joint_class(bone.b));
}

// Least error of the length of a bone that keeps its length [m]. A bone
// between other joints of one class, such as the top and the bottom of a box,
// has that of the shoulders.
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
  of_bone.resize(std::max(of_bone.size(), other.of_bone.size()));
  for (size_t i = 0; i < other.of_bone.size(); ++i) {
    of_bone[i].insert(of_bone[i].end(), other.of_bone[i].begin(),
                      other.of_bone[i].end());
  }
}

BoneModel::BoneModel(const Skeleton& skeleton) {
  for (const Bone& bone : skeleton.bones()) {
    if (!KeepsItsLength(skeleton, bone)) continue;
    bones_.push_back({bone, FloorOf(skeleton, bone)});
  }
  piece_sigma_.assign(bones_.size(), kDefaultPieceSigma);
}

BoneSamples BoneModel::Measure(const Tracklet& tracklet) const {
  BoneSamples samples;
  samples.of_bone.resize(bones_.size());
  const double frame_s = FrameSeconds(tracklet);
  for (size_t g = 0; g < bones_.size(); ++g) {
    PieceMaker maker(frame_s, &samples.of_bone[g]);
    for (size_t k = tracklet.clean_begin(); k < tracklet.clean_end(); ++k) {
      const TrackletFrame& frame = tracklet.frames[k];
      const Bone& bone = bones_[g].bone;
      const Joint3d& a = frame.pose->joints[bone.a];
      const Joint3d& b = frame.pose->joints[bone.b];
      if (a.status != JointStatus::kObserved ||
          b.status != JointStatus::kObserved) {
        continue;
      }
      const double length_m = (a.position_m - b.position_m).norm();
      if (!(length_m > 0.0)) continue;
      maker.Add(frame.time, length_m, StatedVariance(*frame.pose, bone));
    }
    maker.Finish();
  }
  return samples;
}

void BoneModel::Learn(const std::vector<BoneSamples>& tracklets) {
  for (size_t g = 0; g < bones_.size(); ++g) {
    std::vector<double> deviations;
    for (const BoneSamples& samples : tracklets) {
      const std::vector<BoneSamples::Piece>& pieces = samples.of_bone[g];
      if (pieces.size() < 3) continue;
      std::vector<double> lengths;
      lengths.reserve(pieces.size());
      for (const BoneSamples::Piece& piece : pieces) {
        lengths.push_back(piece.log_length);
      }
      const double median = Median(lengths);
      for (const double length : lengths) {
        deviations.push_back(std::abs(length - median));
      }
    }
    if (deviations.size() < kMinPiecesToLearn) continue;
    // For a normal distribution the median absolute deviation is 0.6745 sigma.
    piece_sigma_[g] = std::max(kFloorSigma, Median(deviations) / 0.6745);
  }
}

double BoneModel::VarianceOf(const BoneSamples::Piece& piece,
                             size_t bone) const {
  constexpr double kLeastSeconds = 0.1;
  const double learnt = piece_sigma_[bone] * piece_sigma_[bone] *
                        kPieceSeconds /
                        std::clamp(piece.seconds, kLeastSeconds, kPieceSeconds);
  return std::max(learnt, piece.stated_variance);
}

std::optional<BoneModel::Length> BoneModel::LengthOf(const BoneSamples& samples,
                                                     size_t bone) const {
  if (bone >= samples.of_bone.size()) return std::nullopt;
  const std::vector<BoneSamples::Piece>& pieces = samples.of_bone[bone];
  if (pieces.empty()) return std::nullopt;
  std::vector<WeightedValue> weighted;
  double information = 0.0;
  for (const BoneSamples::Piece& piece : pieces) {
    weighted.emplace_back(piece.log_length, 1.0 / VarianceOf(piece, bone));
    information += weighted.back().second;
  }
  // The variance of a median of many values is pi / 2 times that of their mean.
  const double of_median = pieces.size() < 3 ? 1.0 : 0.5 * M_PI;
  Length length;
  length.log_length = WeightedMedian(std::move(weighted));
  const double floor =
      std::max(kFloorSigma, bones_[bone].floor_m / std::exp(length.log_length));
  length.variance = of_median / information + floor * floor;
  return length;
}

double BoneModel::LogRatio(const BoneSamples& a, const BoneSamples& b) const {
  constexpr double kMost = 4.0 * kWrongSigma;
  std::vector<double> difference;
  std::vector<double> variance;
  for (size_t g = 0; g < bones_.size(); ++g) {
    const auto one = LengthOf(a, g);
    const auto other = LengthOf(b, g);
    if (!one || !other) continue;
    // Clamped: beyond what one body explains, a larger difference is no further
    // evidence.
    difference.push_back(
        std::clamp(one->log_length - other->log_length, -kMost, kMost));
    variance.push_back(one->variance + other->variance);
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
  // Two people drawn from the population differ by a stature, shared by all
  // bones, and in each bone.
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
  for (size_t g = 0; g < bones_.size(); ++g) {
    const auto one = LengthOf(a, g);
    const auto other = LengthOf(b, g);
    if (!one || !other) continue;
    sum_m += std::abs(std::exp(one->log_length) - std::exp(other->log_length));
    ++count;
  }
  return count == 0 ? 0.0 : sum_m / count;
}

}  // namespace kinegraph
