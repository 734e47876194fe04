#include "solvers/cameras/reduced_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/cameras/fit_terms.h"

namespace kinegraph {

ReducedSystem::ReducedSystem(const CameraRig& cameras,
                             const SceneSegments& segments,
                             std::vector<std::vector<int>> places,
                             const SegmentState& state_information)
    : cameras_(cameras),
      segments_(segments),
      places_(std::move(places)),
      state_information_(state_information) {
  for (const auto& list : places_) {
    begin_.push_back(size_);
    size_ += static_cast<Eigen::Index>(list.size());
  }
  information_ = Eigen::MatrixXd::Zero(size_, size_);
}

void ReducedSystem::Add(const MotionSegment& segment, const SegmentState& state,
                        const std::vector<CameraChange>& changes) {
  Eigen::Matrix<double, kSegmentSize, kSegmentSize> H =
      state_information_.asDiagonal();
  H.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(size_, kSegmentSize);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size_);
  SegmentState state_gradient = state_information_.cwiseProduct(state);
  for (const SegmentTerm& term :
       TermsOf(cameras_, changes, segment, state, segments_.noise_scale)) {
    const size_t v = term.view;
    const auto& A = term.by_state;
    H += term.weight * A.transpose() * A;
    state_gradient += term.weight * A.transpose() * term.residual;
    const auto count = static_cast<Eigen::Index>(places_[v].size());
    Eigen::MatrixXd B(2, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      B.col(i) = term.by_change.col(places_[v][static_cast<size_t>(i)]);
    }
    information_.block(begin_[v], begin_[v], count, count) +=
        term.weight * B.transpose() * B;
    cross.middleRows(begin_[v], count) += term.weight * B.transpose() * A;
    gradient.segment(begin_[v], count) +=
        term.weight * B.transpose() * term.residual;
  }
  const Eigen::MatrixXd solved = H.ldlt().solve(cross.transpose());
  information_ -= cross * solved;
  const auto block =
      static_cast<int64_t>(std::floor(segment.middle_s / BinLength(segments_)));
  auto [at, fresh] = scores_.try_emplace(block, gradient);
  if (!fresh) at->second += gradient;
  at->second -= solved.transpose() * state_gradient;
  if (common_offset_m_ > 0.0 || person_offset_m_ > 0.0) {
    AddOffsets(segment, state, changes, solved);
  }
}

void ReducedSystem::AddOffsets(const MotionSegment& segment,
                               const SegmentState& state,
                               const std::vector<CameraChange>& changes,
                               const Eigen::MatrixXd& solved) {
  for (const SegmentTerm& term :
       TermsOf(cameras_, changes, segment, state, segments_.noise_scale)) {
    const size_t v = term.view;
    // Of the residual, by an offset along the image's axes [m].
    const Eigen::Matrix2d by_offset = term.weight *
                                      term.by_state.leftCols<3>() *
                                      cameras_[v].R().topRows<2>().transpose();
    OffsetGradient gradient =
        -solved.transpose() * term.by_state.transpose() * by_offset;
    for (size_t i = 0; i < places_[v].size(); ++i) {
      gradient.row(begin_[v] + static_cast<Eigen::Index>(i)) +=
          term.by_change.col(places_[v][i]).transpose() * by_offset;
    }
    const auto view = static_cast<int>(v);
    const auto add = [&gradient](auto* sums, const auto& key) {
      auto [at, fresh] = sums->try_emplace(key, gradient);
      if (!fresh) at->second += gradient;
    };
    add(&by_joint_, std::array<int, 2>{segment.joint, view});
    add(&by_person_, std::array<int, 3>{segment.person, segment.joint, view});
  }
}

void ReducedSystem::SetLastingOffsets(double common_m, double person_m) {
  common_offset_m_ = common_m;
  person_offset_m_ = person_m;
}

Eigen::MatrixXd ReducedSystem::OffsetScores() const {
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(size_, size_);
  for (const auto& [key, gradient] : by_joint_) {
    meat += std::pow(common_offset_m_, 2) * gradient * gradient.transpose();
  }
  for (const auto& [key, gradient] : by_person_) {
    meat += std::pow(person_offset_m_, 2) * gradient * gradient.transpose();
  }
  return meat;
}

void ReducedSystem::AddPrior(const CameraChange& inverse_sigma,
                             const Eigen::MatrixXd& gauge, double gauge_sigma) {
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(gauge.rows(), size_);
  for (size_t v = 0; v < places_.size(); ++v) {
    for (size_t i = 0; i < places_[v].size(); ++i) {
      const Eigen::Index at = begin_[v] + static_cast<Eigen::Index>(i);
      const int place = places_[v][i];
      information_(at, at) += inverse_sigma[place] * inverse_sigma[place];
      if (gauge.rows() > 0) {
        held.col(at) =
            gauge.col(static_cast<Eigen::Index>(v) * kChangeSize + place);
      }
    }
  }
  information_ += held.transpose() * held / (gauge_sigma * gauge_sigma);
}

Eigen::VectorXd ReducedSystem::Gradient() const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(size_);
  for (const auto& [block, score] : scores_) sum += score;
  return sum;
}

Eigen::MatrixXd ReducedSystem::Inverse() const {
  return information_.ldlt().solve(Eigen::MatrixXd::Identity(size_, size_));
}

Eigen::MatrixXd ReducedSystem::Covariance() const {
  if (size_ == 0) return {};
  const Eigen::MatrixXd inverse = Inverse();
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(size_, size_);
  for (const auto& [block, score] : scores_) {
    meat += score * score.transpose();
  }
  // Few blocks make the sandwich thin: the usual factor of its degrees of
  // freedom, and never less than the inverse information itself.
  const auto blocks = static_cast<double>(scores_.size());
  meat *= blocks / std::max(1.0, blocks - 1.0);
  Eigen::MatrixXd covariance = inverse * (meat + OffsetScores()) * inverse;
  for (Eigen::Index i = 0; i < size_; ++i) {
    const double floor = inverse(i, i);
    const double stated = covariance(i, i);
    if (stated >= floor) continue;
    const double raise = std::sqrt(floor / std::max(stated, 1e-300));
    covariance.row(i) *= raise;
    covariance.col(i) *= raise;
  }
  return covariance;
}

double ReducedSystem::LargestCorrelation() const {
  if (size_ == 0) return 0.0;
  const Eigen::MatrixXd inverse = Inverse();
  std::vector<char> is_clock;
  for (const auto& list : places_) {
    for (const int place : list) {
      is_clock.push_back(place == kOffsetAt || place == kDriftAt);
    }
  }
  double largest = 0.0;
  for (Eigen::Index i = 0; i < size_; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      if (is_clock[static_cast<size_t>(i)] ==
          is_clock[static_cast<size_t>(j)]) {
        continue;
      }
      const double scale = std::sqrt(inverse(i, i) * inverse(j, j));
      if (scale > 0.0) {
        largest = std::max(largest, std::abs(inverse(i, j)) / scale);
      }
    }
  }
  return largest;
}

}  // namespace kinegraph
