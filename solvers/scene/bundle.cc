#include "solvers/scene/bundle.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "core/evaluation/bootstrap.h"
#include "solvers/ceres/ceres_loss.h"
#include "solvers/scene/fit_terms.h"

namespace kinegraph {
namespace {

// r = (project(change of camera, point at the capture) - u) / sigma       [2]
// Blocks: the stretch's state [9], the camera's change [11].
class SegmentFactor final
    : public ceres::SizedCostFunction<2, kSegmentSize, kChangeSize> {
 public:
  // All must outlive the factor.
  SegmentFactor(const Camera* camera, const Stretch* segment,
                const SegmentMeasurement* measurement, double noise_scale)
      : camera_(camera),
        segment_(segment),
        measurement_(measurement),
        noise_scale_(noise_scale) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const SegmentState> state(parameters[0]);
    const Eigen::Map<const CameraChange> change(parameters[1]);
    Eigen::Matrix<double, 2, kSegmentSize> by_state;
    Eigen::Matrix<double, 2, kChangeSize> by_change;
    const bool wants_state = jacobians != nullptr && jacobians[0] != nullptr;
    const bool wants_change = jacobians != nullptr && jacobians[1] != nullptr;
    const auto residual = SegmentResidual(
        *camera_, change, *segment_, state, *measurement_, noise_scale_,
        wants_state ? &by_state : nullptr, wants_change ? &by_change : nullptr);
    if (!residual.has_value()) return false;
    Eigen::Map<Eigen::Vector2d> r(residuals);
    r = *residual;
    if (wants_state) {
      Eigen::Map<Eigen::Matrix<double, 2, kSegmentSize, Eigen::RowMajor>> J(
          jacobians[0]);
      J = by_state;
    }
    if (wants_change) {
      Eigen::Map<Eigen::Matrix<double, 2, kChangeSize, Eigen::RowMajor>> J(
          jacobians[1]);
      J = by_change;
    }
    return true;
  }

 private:
  const Camera* camera_;
  const Stretch* segment_;
  const SegmentMeasurement* measurement_;
  double noise_scale_;
};

// r = x / sigma, element by element; an infinite sigma leaves an element out.
template <int kSize>
class ZeroPrior final : public ceres::SizedCostFunction<kSize, kSize> {
 public:
  explicit ZeroPrior(const Eigen::Matrix<double, kSize, 1>& inverse_sigma)
      : inverse_sigma_(inverse_sigma) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    using Vector = Eigen::Matrix<double, kSize, 1>;
    Eigen::Map<Vector> r(residuals);
    r = inverse_sigma_.cwiseProduct(Eigen::Map<const Vector>(parameters[0]));
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>> J(
          jacobians[0]);
      J = inverse_sigma_.asDiagonal();
    }
    return true;
  }

 private:
  Eigen::Matrix<double, kSize, 1> inverse_sigma_;
};

// Rows of the gauge, as a matrix on all changes below each other: mean rotation
// and mean translation (in the world) are zero, and the mean distance of the
// cameras from their middle stays.
Eigen::MatrixXd GaugeRows(const CameraRig& cameras,
                          const std::vector<char>& moves) {
  const auto views = static_cast<Eigen::Index>(cameras.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(7, views * kChangeSize);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) middle += camera.centre();
  middle /= static_cast<double>(views);
  double squares = 0.0;
  for (const Camera& camera : cameras) {
    squares += (camera.centre() - middle).squaredNorm();
  }
  for (Eigen::Index v = 0; v < views; ++v) {
    if (!moves[static_cast<size_t>(v)]) continue;
    const Camera& camera = cameras[static_cast<size_t>(v)];
    const double share = 1.0 / static_cast<double>(views);
    const Eigen::Index at = v * kChangeSize;
    rows.block<3, 3>(0, at + kRotationAt) = share * camera.R().transpose();
    rows.block<3, 3>(3, at + kCentreAt) = share * Eigen::Matrix3d::Identity();
    if (squares > 0.0) {
      rows.block<1, 3>(6, at + kCentreAt) =
          (camera.centre() - middle).transpose() / squares;
    }
  }
  return rows;
}

// r = rows * changes / sigma.
class GaugeFactor final : public ceres::CostFunction {
 public:
  explicit GaugeFactor(Eigen::MatrixXd rows) : rows_(std::move(rows)) {
    set_num_residuals(static_cast<int>(rows_.rows()));
    for (Eigen::Index v = 0; v < rows_.cols() / kChangeSize; ++v) {
      mutable_parameter_block_sizes()->push_back(kChangeSize);
    }
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    Eigen::Map<Eigen::VectorXd> r(residuals, rows_.rows());
    r.setZero();
    for (Eigen::Index v = 0; v < rows_.cols() / kChangeSize; ++v) {
      const auto block = rows_.middleCols(v * kChangeSize, kChangeSize);
      r += block * Eigen::Map<const CameraChange>(parameters[v]);
      if (jacobians == nullptr || jacobians[v] == nullptr) continue;
      Eigen::Map<
          Eigen::Matrix<double, Eigen::Dynamic, kChangeSize, Eigen::RowMajor>>
          J(jacobians[v], rows_.rows(), kChangeSize);
      J = block;
    }
    return true;
  }

 private:
  Eigen::MatrixXd rows_;
};

// A hundredth of a millimetre and of a milliradian: far below what any take
// says, far above rounding.
constexpr double kGaugeSigma = 1e-5;

CameraChange InverseSigmas(const BundleOptions& options) {
  CameraChange inverse;
  inverse.segment<3>(kRotationAt).setConstant(1.0 / options.rotation_sigma_rad);
  inverse.segment<3>(kCentreAt).setConstant(1.0 / options.centre_sigma_m);
  inverse.segment<2>(kShiftAt).setConstant(1.0 / options.shift_sigma_px);
  inverse[kFocalAt] = 1.0 / options.focal_sigma;
  inverse[kOffsetAt] = 1.0 / options.offset_sigma_s;
  inverse[kDriftAt] = 1.0 / options.drift_sigma;
  return inverse;
}

SegmentState StateInverseSigmas(const SegmentOptions& options) {
  SegmentState inverse = SegmentState::Zero();
  inverse.segment<3>(3).setConstant(1.0 / options.velocity_sigma_mps);
  inverse.segment<3>(6).setConstant(1.0 / options.acceleration_sigma_mps2);
  return inverse;
}

// Places of the changes that are estimated: one list a view.
std::vector<std::vector<int>> FreePlaces(size_t views,
                                         const FreeParameters& free,
                                         const std::vector<char>& moves) {
  std::vector<std::vector<int>> places(views);
  FreeParameters reference = free;
  reference.offset = reference.drift = false;
  for (size_t v = 0; v < views; ++v) {
    if (moves[v]) places[v] = (v == 0 ? reference : free).Places();
  }
  return places;
}

// The reduced system of the free parameters at a solution, block of time by
// block of time, and from it covariance and correlations.
class ReducedSystem {
 public:
  ReducedSystem(const CameraRig& cameras, const SceneSegments& segments,
                std::vector<std::vector<int>> places,
                const BundleOptions& options)
      : cameras_(cameras),
        segments_(segments),
        places_(std::move(places)),
        options_(options) {
    for (const auto& list : places_) {
      begin_.push_back(size_);
      size_ += static_cast<Eigen::Index>(list.size());
    }
    information_ = Eigen::MatrixXd::Zero(size_, size_);
  }

  void Add(const Stretch& segment, const SegmentState& state,
           const std::vector<CameraChange>& changes) {
    Eigen::Matrix<double, kSegmentSize, kSegmentSize> H =
        StateInverseSigmas(options_.segments).cwiseAbs2().asDiagonal();
    H.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
    Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(size_, kSegmentSize);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size_);
    SegmentState state_gradient =
        StateInverseSigmas(options_.segments).cwiseAbs2().cwiseProduct(state);
    for (const SegmentMeasurement& measurement : segment.measurements) {
      const auto v = static_cast<size_t>(measurement.view_idx);
      Eigen::Matrix<double, 2, kSegmentSize> A;
      Eigen::Matrix<double, 2, kChangeSize> all;
      const auto r =
          SegmentResidual(cameras_[v], changes[v], segment, state, measurement,
                          segments_.noise_scale, &A, &all);
      if (!r.has_value()) continue;
      const double weight =
          EvaluateLoss(kSceneLoss, kSceneLossScale, r->squaredNorm()).first;
      H += weight * A.transpose() * A;
      state_gradient += weight * A.transpose() * *r;
      const auto count = static_cast<Eigen::Index>(places_[v].size());
      Eigen::MatrixXd B(2, count);
      for (Eigen::Index i = 0; i < count; ++i) {
        B.col(i) = all.col(places_[v][static_cast<size_t>(i)]);
      }
      information_.block(begin_[v], begin_[v], count, count) +=
          weight * B.transpose() * B;
      cross.middleRows(begin_[v], count) += weight * B.transpose() * A;
      gradient.segment(begin_[v], count) += weight * B.transpose() * *r;
    }
    const Eigen::MatrixXd solved = H.ldlt().solve(cross.transpose());
    information_ -= cross * solved;
    const auto block = static_cast<int64_t>(
        std::floor(segment.middle_s / BinLength(segments_)));
    auto [at, fresh] = scores_.try_emplace(block, gradient);
    if (!fresh) at->second += gradient;
    at->second -= solved.transpose() * state_gradient;
  }

  // The prior and, with `gauge` rows, what is held.
  void AddPrior(const CameraChange& inverse_sigma,
                const Eigen::MatrixXd& gauge) {
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
    information_ += held.transpose() * held / (kGaugeSigma * kGaugeSigma);
  }

  void Finish(BundleResult* result) const {
    if (size_ == 0) return;
    const Eigen::MatrixXd inverse =
        information_.ldlt().solve(Eigen::MatrixXd::Identity(size_, size_));
    Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(size_, size_);
    for (const auto& [block, score] : scores_) {
      meat += score * score.transpose();
    }
    // Few blocks make the sandwich thin: the usual factor of its degrees of
    // freedom, and never less than the inverse information itself.
    const auto blocks = static_cast<double>(scores_.size());
    meat *= blocks / std::max(1.0, blocks - 1.0);
    result->covariance = inverse * meat * inverse;
    for (Eigen::Index i = 0; i < size_; ++i) {
      const double floor = inverse(i, i);
      const double stated = result->covariance(i, i);
      if (stated >= floor) continue;
      const double raise = std::sqrt(floor / std::max(stated, 1e-300));
      result->covariance.row(i) *= raise;
      result->covariance.col(i) *= raise;
    }
    result->largest_correlation = LargestCorrelation(inverse);
  }

 private:
  double LargestCorrelation(const Eigen::MatrixXd& inverse) const {
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

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  std::vector<std::vector<int>> places_;
  const BundleOptions& options_;
  std::vector<Eigen::Index> begin_;
  Eigen::Index size_ = 0;
  Eigen::MatrixXd information_;
  std::map<int64_t, Eigen::VectorXd> scores_;
};

// Holds the Ceres problem and what its blocks point at.
class BundleProblem {
 public:
  BundleProblem(const CameraRig& cameras, const SceneSegments& segments,
                const std::vector<std::vector<int>>& places,
                const std::vector<CameraChange>& start,
                const BundleOptions& options)
      : cameras_(cameras), segments_(segments), changes_(start) {
    states_.resize(segments.segments.size());
    AddSegments(options);
    AddCameras(places, options);
  }

  void AddGauge(const Eigen::MatrixXd& rows) {
    std::vector<double*> blocks;
    for (CameraChange& change : changes_) blocks.push_back(change.data());
    problem_.AddResidualBlock(new GaugeFactor(rows / kGaugeSigma), nullptr,
                              blocks);
  }

  void Solve(int max_iterations, BundleResult* result) {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_SCHUR;
    solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
    solver.linear_solver_ordering.reset(ordering_.release());
    solver.num_threads = 1;  // the same sums in the same order
    solver.logging_type = ceres::SILENT;
    solver.max_num_iterations = max_iterations;
    solver.function_tolerance = 1e-9;
    solver.parameter_tolerance = 1e-10;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    result->usable = summary.IsSolutionUsable();
    result->iterations = static_cast<int>(summary.iterations.size());
    result->changes = changes_;
  }

  const std::vector<SegmentState>& states() const { return states_; }

 private:
  void AddSegments(const BundleOptions& options) {
    const SegmentState state_sigmas = StateInverseSigmas(options.segments);
    for (size_t s = 0; s < segments_.segments.size(); ++s) {
      const Stretch& segment = segments_.segments[s];
      states_[s] = segment.state;
      // The start must have an image in every view, else Ceres refuses it.
      bool added = false;
      for (const SegmentMeasurement& measurement : segment.measurements) {
        const auto v = static_cast<size_t>(measurement.view_idx);
        if (!SegmentResidual(cameras_[v], changes_[v], segment, states_[s],
                             measurement, segments_.noise_scale, nullptr,
                             nullptr)
                 .has_value()) {
          continue;
        }
        problem_.AddResidualBlock(
            new SegmentFactor(&cameras_[v], &segment, &measurement,
                              segments_.noise_scale),
            MakeCeresLoss(kSceneLoss, kSceneLossScale, 1.0), states_[s].data(),
            changes_[v].data());
        added = true;
      }
      if (!added) continue;
      problem_.AddResidualBlock(new ZeroPrior<kSegmentSize>(state_sigmas),
                                nullptr, states_[s].data());
      ordering_->AddElementToGroup(states_[s].data(), 0);
    }
  }

  void AddCameras(const std::vector<std::vector<int>>& places,
                  const BundleOptions& options) {
    const CameraChange inverse = InverseSigmas(options);
    for (size_t v = 0; v < changes_.size(); ++v) {
      problem_.AddParameterBlock(changes_[v].data(), kChangeSize);
      ordering_->AddElementToGroup(changes_[v].data(), 1);
      if (places[v].empty()) {
        problem_.SetParameterBlockConstant(changes_[v].data());
        continue;
      }
      std::vector<int> constant;
      for (int i = 0; i < kChangeSize; ++i) {
        if (std::find(places[v].begin(), places[v].end(), i) ==
            places[v].end()) {
          constant.push_back(i);
        }
      }
      if (!constant.empty()) {
        problem_.SetManifold(changes_[v].data(),
                             new ceres::SubsetManifold(kChangeSize, constant));
      }
      problem_.AddResidualBlock(new ZeroPrior<kChangeSize>(inverse), nullptr,
                                changes_[v].data());
    }
  }

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  std::vector<CameraChange> changes_;
  std::vector<SegmentState> states_;
  std::unique_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_unique<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_;
};

}  // namespace

BundleResult AdjustBundle(const CameraRig& cameras,
                          const SceneSegments& segments,
                          const FreeParameters& free,
                          const std::vector<CameraChange>& start,
                          const BundleOptions& options,
                          const std::vector<char>& moves) {
  const std::vector<char> moving =
      moves.empty() ? std::vector<char>(cameras.size(), 1) : moves;
  const auto places = FreePlaces(cameras.size(), free, moving);
  BundleResult result;
  result.changes = start;
  result.places = places;
  if (segments.segments.empty()) return result;
  BundleProblem problem(cameras, segments, places, start, options);
  // With the centres fixed nothing is left free as a whole.
  const bool holds_gauge =
      free.centre && std::count(moving.begin(), moving.end(), 1) ==
                         static_cast<long>(moving.size());
  const Eigen::MatrixXd gauge =
      holds_gauge ? GaugeRows(cameras, moving) : Eigen::MatrixXd(0, 0);
  if (holds_gauge) problem.AddGauge(gauge);
  problem.Solve(options.max_iterations, &result);
  if (!result.usable) return result;
  ReducedSystem reduced(cameras, segments, places, options);
  for (size_t s = 0; s < segments.segments.size(); ++s) {
    reduced.Add(segments.segments[s], problem.states()[s], result.changes);
  }
  reduced.AddPrior(InverseSigmas(options), gauge);
  reduced.Finish(&result);
  return result;
}

namespace {

// Segments come nearly in order.
double FirstMiddle(const SceneSegments& segments) {
  double first = segments.segments.front().middle_s;
  for (const Stretch& segment : segments.segments) {
    first = std::min(first, segment.middle_s);
  }
  return first;
}

}  // namespace

FitError MeasureFit(const CameraRig& cameras, const SceneSegments& segments,
                    const std::vector<CameraChange>& changes,
                    const BundleOptions& options, double cap_px) {
  FitError error;
  if (segments.segments.empty()) return error;
  const double first = FirstMiddle(segments);
  const double bin_s = BinLength(segments);
  const auto BinOf = [&](const Stretch& segment) {
    return static_cast<size_t>(std::floor((segment.middle_s - first) / bin_s));
  };
  size_t bins = 0;
  for (const Stretch& segment : segments.segments) {
    bins = std::max(bins, BinOf(segment) + 1);
  }
  error.sum_px.assign(cameras.size(), std::vector<double>(bins, 0.0));
  error.count = error.sum_px;
  for (const Stretch& segment : segments.segments) {
    SegmentState state = segment.state;
    const bool solved =
        SolveSegment(cameras, changes, segment, segments.noise_scale,
                     options.segments, &state);
    const size_t bin = BinOf(segment);
    for (const SegmentMeasurement& measurement : segment.measurements) {
      const auto v = static_cast<size_t>(measurement.view_idx);
      double distance_px = cap_px;
      if (solved) {
        const auto r = SegmentResidual(cameras[v], changes[v], segment, state,
                                       measurement, 1.0, nullptr, nullptr);
        if (r.has_value()) {
          distance_px = std::min(cap_px, r->norm() * measurement.sigma_px);
        }
      }
      error.sum_px[v][bin] += distance_px;
      error.count[v][bin] += 1.0;
    }
  }
  return error;
}

double BinLength(const SceneSegments& segments) {
  return std::min(1.0, std::max(0.2, segments.span_s / 20.0));
}

void FitError::Append(const FitError& other) {
  if (sum_px.empty()) {
    *this = other;
    return;
  }
  for (size_t v = 0; v < other.sum_px.size(); ++v) {
    sum_px[v].insert(sum_px[v].end(), other.sum_px[v].begin(),
                     other.sum_px[v].end());
    count[v].insert(count[v].end(), other.count[v].begin(),
                    other.count[v].end());
  }
}

double FitError::MeanPx() const {
  double sum = 0.0;
  double all = 0.0;
  for (size_t v = 0; v < sum_px.size(); ++v) {
    for (size_t s = 0; s < sum_px[v].size(); ++s) {
      sum += sum_px[v][s];
      all += count[v][s];
    }
  }
  return all > 0.0 ? sum / all : 0.0;
}

double FitError::MeanPx(int view) const {
  double sum = 0.0;
  double all = 0.0;
  const auto v = static_cast<size_t>(view);
  for (size_t s = 0; v < sum_px.size() && s < sum_px[v].size(); ++s) {
    sum += sum_px[v][s];
    all += count[v][s];
  }
  return all > 0.0 ? sum / all : 0.0;
}

FitGain CompareFits(const FitError& before, const FitError& after, int view) {
  FitGain gain;
  gain.before_px = view < 0 ? before.MeanPx() : before.MeanPx(view);
  gain.after_px = view < 0 ? after.MeanPx() : after.MeanPx(view);
  RatioSeries series_before;
  RatioSeries series_after;
  const size_t bins = before.sum_px.empty() ? 0 : before.sum_px[0].size();
  for (size_t s = 0; s < bins; ++s) {
    RatioUnit unit_before;
    RatioUnit unit_after;
    for (size_t v = 0; v < before.sum_px.size(); ++v) {
      if (view >= 0 && v != static_cast<size_t>(view)) continue;
      unit_before.sum += before.sum_px[v][s];
      unit_before.weight += before.count[v][s];
      unit_after.sum += after.sum_px[v][s];
      unit_after.weight += after.count[v][s];
    }
    if (!(unit_before.weight > 0.0)) continue;
    series_before.push_back(unit_before);
    series_after.push_back(unit_after);
  }
  if (series_before.size() < 2) return gain;
  BootstrapOptions options;
  options.block_length = 2;  // bins
  options.resamples = 1000;
  const Interval interval =
      PairedPooledInterval({series_before}, {series_after}, options);
  gain.low_px = interval.low;
  gain.high_px = interval.high;
  return gain;
}

SceneSegments HalfOf(const SceneSegments& segments, int half) {
  SceneSegments part = segments;
  const size_t middle = segments.segments.size() / 2;
  const auto begin = segments.segments.begin();
  const auto split = begin + static_cast<std::ptrdiff_t>(middle);
  part.segments.assign(half == 0 ? begin : split,
                       half == 0 ? split : segments.segments.end());
  return part;
}

}  // namespace kinegraph
