#include "solvers/cameras/reduced_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace kinegraph {
namespace {

// Sums that are empty at first.
void AddTo(const Eigen::MatrixXd& one, Eigen::MatrixXd* sum) {
  if (sum->size() == 0) *sum = Eigen::MatrixXd::Zero(one.rows(), one.cols());
  *sum += one;
}

void AddScore(int64_t block, const Eigen::VectorXd& score,
              std::map<int64_t, Eigen::VectorXd>* scores) {
  const auto [at, fresh] = scores->try_emplace(block, score);
  if (!fresh) at->second += score;
}

}  // namespace

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
  information_ = prior_scores_ = Eigen::MatrixXd::Zero(size_, size_);
}

void ReducedSystem::Add(const MotionSegment& segment, const SegmentState& state,
                        const std::vector<CameraChange>& changes) {
  Eigen::Matrix<double, kSegmentSize, kSegmentSize> H =
      state_information_.asDiagonal();
  H.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
  const bool has_offsets = offset_sigma_m_ > 0.0;
  const auto offset_count =
      has_offsets ? 2 * static_cast<Eigen::Index>(places_.size()) : 0;
  // Of the free parameters, then of the offsets.
  const Eigen::Index count = size_ + offset_count;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(count, kSegmentSize);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(count);
  SegmentState state_gradient = state_information_.cwiseProduct(state);
  for (const SegmentTerm& term :
       TermsOf(cameras_, changes, segment, state, segments_.noise_scale)) {
    const size_t v = term.view;
    const auto& A = term.by_state;
    H += term.weight * A.transpose() * A;
    state_gradient += term.weight * A.transpose() * term.residual;
    std::vector<Eigen::Index> at(places_[v].size());
    std::iota(at.begin(), at.end(), begin_[v]);
    Eigen::MatrixXd B(
        2, static_cast<Eigen::Index>(at.size()) + (has_offsets ? 2 : 0));
    for (size_t i = 0; i < at.size(); ++i) {
      B.col(static_cast<Eigen::Index>(i)) = term.by_change.col(places_[v][i]);
    }
    if (has_offsets) {
      B.rightCols<2>() = PxPerMetre(cameras_[v], segment) *
                         term.by_change.middleCols<2>(kShiftAt);
      const Eigen::Index offset = size_ + 2 * static_cast<Eigen::Index>(v);
      at.insert(at.end(), {offset, offset + 1});
    }
    information(at, at) += term.weight * B.transpose() * B;
    cross(at, Eigen::all) += term.weight * B.transpose() * A;
    gradient(at) += term.weight * B.transpose() * term.residual;
  }
  const Eigen::MatrixXd solved = H.ldlt().solve(cross.transpose());
  information -= cross * solved;
  gradient -= solved.transpose() * state_gradient;
  information_ += information.topLeftCorner(size_, size_);
  const auto block =
      static_cast<int64_t>(std::floor(segment.middle_s / BinLength(segments_)));
  AddScore(block, gradient.head(size_), &scores_);
  if (!has_offsets) return;
  Offsets& offsets = offsets_[{segment.person, segment.joint}];
  AddTo(information.topRightCorner(size_, offset_count), &offsets.cross);
  AddTo(information.bottomRightCorner(offset_count, offset_count),
        &offsets.information);
  AddScore(block, gradient.tail(offset_count), &offsets.scores);
}

void ReducedSystem::EliminateOffsets() {
  const double prior = 1.0 / (offset_sigma_m_ * offset_sigma_m_);
  for (auto& [key, one] : offsets_) {
    one.information.diagonal().array() += prior;
    const Eigen::MatrixXd gain =
        one.information.ldlt().solve(one.cross.transpose()).transpose();
    information_ -= gain * one.cross.transpose();
    prior_scores_ += prior * gain * gain.transpose();
    for (const auto& [block, score] : one.scores) {
      scores_.at(block) -= gain * score;
    }
  }
}

void ReducedSystem::AddPrior(const CameraChange& inverse_sigma,
                             const Eigen::MatrixXd& gauge, double gauge_sigma) {
  EliminateOffsets();
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
  Eigen::MatrixXd covariance = inverse * (meat + prior_scores_) * inverse;
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
      if (is_clock[i] == is_clock[j]) {
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
