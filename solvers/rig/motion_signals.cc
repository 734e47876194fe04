#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/rig/view_pairs.h"

namespace kinegraph {
namespace {

constexpr double kSamplesPerSecond = 12.5;
constexpr double kLastingS = 0.8;  // what stays for longer says nothing

// Mean over samples k - reach .. k + reach that are finite.
Eigen::MatrixXf MovingMean(const Eigen::MatrixXf& values, int reach) {
  Eigen::MatrixXf mean(values.rows(), values.cols());
  for (Eigen::Index r = 0; r < values.rows(); ++r) {
    for (Eigen::Index k = 0; k < values.cols(); ++k) {
      const Eigen::Index from = std::max<Eigen::Index>(0, k - reach);
      const Eigen::Index to =
          std::min<Eigen::Index>(values.cols(), k + reach + 1);
      float sum = 0.0F;
      int count = 0;
      for (Eigen::Index i = from; i < to; ++i) {
        if (!std::isfinite(values(r, i))) continue;
        sum += values(r, i);
        ++count;
      }
      mean(r, k) = count > 0 ? sum / static_cast<float>(count) : 0.0F;
    }
  }
  return mean;
}

// The joints whose mean is the body's middle: shoulders and hips of people.
std::vector<int> MiddleOf(const std::vector<int>& joints,
                          const Skeleton& skeleton) {
  std::vector<int> middle;
  std::vector<int> all;
  for (size_t j = 0; j < joints.size(); ++j) {
    const JointClass kind = skeleton.joint_class(joints[j]);
    if (kind == JointClass::kShoulder || kind == JointClass::kHip) {
      middle.push_back(static_cast<int>(j));
    }
    all.push_back(static_cast<int>(j));
  }
  return middle.size() == 4 ? middle : all;
}

// Which way is up in a view's image: from hips to shoulders.
std::vector<Eigen::Vector2d> UpInViews(
    const std::vector<ViewTracklet>& tracklets, const std::vector<int>& joints,
    const Skeleton& skeleton, int view_count) {
  std::vector<Eigen::Vector2d> ups(static_cast<size_t>(view_count),
                                   Eigen::Vector2d::Zero());
  for (const ViewTracklet& tracklet : tracklets) {
    for (const NormalisedJoints& points : tracklet.joints) {
      Eigen::Vector2d up = Eigen::Vector2d::Zero();
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        const JointClass kind = skeleton.joint_class(joints[j]);
        if (kind == JointClass::kShoulder) up += points.col(j);
        if (kind == JointClass::kHip) up -= points.col(j);
      }
      if (up.allFinite() && up.norm() > 0.0) {
        ups[tracklet.view] += up.normalized();
      }
    }
  }
  for (Eigen::Vector2d& up : ups) {
    up = up.norm() > 0.0 ? up.normalized() : -Eigen::Vector2d::UnitY();
  }
  return ups;
}

}  // namespace

MotionSignals::MotionSignals(const std::vector<ViewTracklet>& tracklets,
                             const std::vector<int>& joints,
                             const Skeleton& skeleton, int view_count,
                             double frame_rate_hz) {
  step_ = std::max(
      1, static_cast<int>(std::lround(frame_rate_hz / kSamplesPerSecond)));
  const double per_second = frame_rate_hz / step_;
  least_samples_ = std::max(8, static_cast<int>(std::lround(per_second)));
  const int reach = std::max(2, static_cast<int>(kLastingS * per_second));
  const std::vector<int> middle = MiddleOf(joints, skeleton);
  const auto ups = UpInViews(tracklets, joints, skeleton, view_count);
  const auto count = static_cast<Eigen::Index>(joints.size());
  for (const ViewTracklet& tracklet : tracklets) {
    Signal signal;
    signal.first = (tracklet.first + step_ - 1) / step_;
    const int samples =
        std::max(0, (tracklet.end() - 1) / step_ - signal.first + 1);
    const Eigen::Vector2d up = ups[tracklet.view];
    const float missing = std::numeric_limits<float>::quiet_NaN();
    Eigen::MatrixXf x = Eigen::MatrixXf::Constant(count, samples, missing);
    Eigen::MatrixXf y = x;
    for (int k = 0; k < samples; ++k) {
      const int frame = (signal.first + k) * step_;
      if (!tracklet.SeenAt(frame)) continue;
      const NormalisedJoints& points = tracklet.At(frame);
      Eigen::Vector2d centre = Eigen::Vector2d::Zero();
      for (const int j : middle) centre += points.col(j);
      centre /= static_cast<double>(middle.size());
      for (Eigen::Index j = 0; j < count; ++j) {
        const Eigen::Vector2d off = (points.col(j) - centre) / tracklet.size;
        y(j, k) = static_cast<float>(off.dot(up));
        x(j, k) = static_cast<float>(off.x() * up.y() - off.y() * up.x());
      }
    }
    Eigen::MatrixXf speed = Eigen::MatrixXf::Constant(count, samples, missing);
    for (int k = 1; k + 1 < samples; ++k) {
      speed.col(k) = ((x.col(k + 1) - x.col(k - 1)).array().square() +
                      (y.col(k + 1) - y.col(k - 1)).array().square())
                         .sqrt();
    }
    signal.values.resize(2 * count, samples);
    signal.values.topRows(count) = y - MovingMean(y, reach);
    signal.values.bottomRows(count) = speed - MovingMean(speed, reach);
    signal.values = signal.values.array().isFinite().select(
        signal.values, Eigen::MatrixXf::Zero(2 * count, samples));
    signal.energy.assign(1, 0.0);
    for (int k = 0; k < samples; ++k) {
      signal.energy.push_back(signal.energy.back() +
                              signal.values.col(k).squaredNorm());
    }
    signals_.push_back(std::move(signal));
  }
}

MotionSignals::Likeness MotionSignals::Compare(size_t a, size_t b,
                                               int lag) const {
  const Signal& one = signals_[a];
  const Signal& other = signals_[b];
  const int begin = std::max(one.first, other.first - lag);
  const int end =
      std::min(one.first + static_cast<int>(one.values.cols()),
               other.first + static_cast<int>(other.values.cols()) - lag);
  Likeness likeness;
  if (end - begin < least_samples_) return likeness;
  likeness.samples = end - begin;
  const int at_one = begin - one.first;
  const int at_other = begin + lag - other.first;
  const double product =
      one.values.middleCols(at_one, end - begin)
          .cwiseProduct(other.values.middleCols(at_other, end - begin))
          .sum();
  const auto energy = [&](const Signal& signal, int at) {
    return signal.energy[at + end - begin] - signal.energy[at];
  };
  const double norm = std::sqrt(energy(one, at_one) * energy(other, at_other));
  if (norm > 0.0) likeness.correlation = product / norm;
  return likeness;
}

}  // namespace kinegraph
