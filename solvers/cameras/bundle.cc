#include "solvers/cameras/bundle.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "solvers/ceres/ceres_factor.h"

namespace kinegraph {
namespace {

// Pixels per metre perpendicular to the ray at the segment's initial position.
// Constant during the solve: if it followed the estimate, the prior on the
// offsets would favour smaller people and thus longer focal lengths.
double PxPerMetre(const Camera& camera, const MotionSegment& segment) {
  constexpr double kLeastDepthM = 0.1;
  return camera.focal_px() /
         std::max(kLeastDepthM, camera.Depth(PositionOf(segment)));
}

// r = (project(changed camera, point at capture) + PxPerMetre * offset - u) /
// sigma [2]. Blocks: the segment's state [9], the camera's change [13] and the
// detector's constant offset [2, m perpendicular to the ray].
class SegmentFactor final
    : public ceres::SizedCostFunction<2, kSegmentSize, kChangeSize, 2> {
 public:
  // All arguments must outlive the factor.
  SegmentFactor(const Camera* camera, const MotionSegment* segment,
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
    const double by_offset = PxPerMetre(*camera_, *segment_) /
                             (measurement_->sigma_px * noise_scale_);
    r = *residual +
        by_offset * Eigen::Map<const Eigen::Vector2d>(parameters[2]);
    if (jacobians != nullptr && jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix2d> J(jacobians[2]);
      J = by_offset * Eigen::Matrix2d::Identity();
    }
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
  const MotionSegment* segment_;
  const SegmentMeasurement* measurement_;
  double noise_scale_;
};

// r = x / sigma per element; an infinite sigma removes an element.
ceres::CostFunction* ZeroPrior(const Eigen::VectorXd& inverse_sigma) {
  return new ceres::NormalPrior(inverse_sigma.asDiagonal(),
                                Eigen::VectorXd::Zero(inverse_sigma.size()));
}

// Rows of the gauge, to be multiplied by the stacked changes of all cameras:
// they keep the mean rotation and the mean translation (in the world) zero, and
// the root mean square distance of the cameras from their centroid constant.
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
    if (!moves[v]) continue;
    const Camera& camera = cameras[v];
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

// r = rows * changes; the caller has divided the rows by their sigma.
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

// 0.01 mm, 0.01 mrad and a relative change of scale of 1e-5: far below the
// accuracy of any recording, far above rounding errors.
constexpr double kGaugeSigma = 1e-5;

CameraChange InverseSigmas(const BundleOptions& options) {
  CameraChange inverse;
  inverse.segment<3>(kRotationAt).setConstant(1.0 / options.rotation_sigma_rad);
  inverse.segment<3>(kCentreAt).setConstant(1.0 / options.centre_sigma_m);
  inverse.segment<2>(kShiftAt).setConstant(1.0 / options.shift_sigma_px);
  inverse[kFocalAt] = 1.0 / options.focal_sigma;
  inverse[kLensAt] = inverse[kLensK2At] = 1.0 / options.lens_sigma;
  inverse[kOffsetAt] = 1.0 / options.offset_sigma_s;
  inverse[kDriftAt] = 1.0 / options.drift_sigma;
  return inverse;
}

// Factor on the prior's information (BundleOptions::samples_at_once).
double TimesCounted(int place, double samples_at_once) {
  const bool is_once = place == kOffsetAt || place == kDriftAt;
  return is_once ? 1.0 : samples_at_once;
}

// Indices of the estimated changes, one list per view.
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

// Owns the Ceres problem and the memory of its blocks.
class BundleProblem {
 public:
  BundleProblem(const CameraRig& cameras, const SceneSegments& segments,
                const std::vector<std::vector<int>>& places,
                const std::vector<CameraChange>& start,
                const BundleOptions& options)
      : cameras_(cameras), segments_(segments), changes_(start) {
    states_.resize(segments.segments.size());
    for (const MotionSegment& segment : segments.segments) {
      for (const SegmentMeasurement& one : segment.measurements) {
        offset_at_.try_emplace(KeyOf(segment, one), offset_at_.size());
      }
    }
    offsets_.assign(offset_at_.size(), Eigen::Vector2d::Zero());
    AddSegments(options);
    AddOffsets(options);
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
    solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    solver.linear_solver_ordering.reset(ordering_.release());
    solver.num_threads = 1;  // keeps the order of summation
    solver.logging_type = ceres::SILENT;
    solver.max_num_iterations = max_iterations;
    solver.function_tolerance = 1e-9;
    solver.parameter_tolerance = 1e-10;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    result->usable = summary.IsSolutionUsable();
    result->changes = changes_;
  }

  const std::vector<SegmentState>& states() const { return states_; }

  // The segment with the estimated detector offsets subtracted.
  MotionSegment WithoutOffsets(size_t index) const {
    MotionSegment segment = segments_.segments[index];
    for (SegmentMeasurement& measurement : segment.measurements) {
      measurement.px -= PxPerMetre(cameras_[measurement.view_idx], segment) *
                        offsets_[offset_at_.at(KeyOf(segment, measurement))];
    }
    return segment;
  }

 private:
  void AddSegments(const BundleOptions& options) {
    const SegmentState state_sigmas =
        PriorInformation(options.segments).cwiseSqrt();
    for (size_t s = 0; s < segments_.segments.size(); ++s) {
      const MotionSegment& segment = segments_.segments[s];
      states_[s] = segment.state;
      // Measurements without an image are skipped, because Ceres rejects a
      // start without finite residuals.
      bool added = false;
      for (const SegmentMeasurement& measurement : segment.measurements) {
        const auto v = static_cast<size_t>(measurement.view_idx);
        if (!SegmentResidual(cameras_[v], changes_[v], segment, states_[s],
                             measurement, segments_.noise_scale)
                 .has_value()) {
          continue;
        }
        problem_.AddResidualBlock(
            new SegmentFactor(&cameras_[v], &segment, &measurement,
                              segments_.noise_scale),
            MakeCeresLoss(kSceneLoss, kSceneLossScale), states_[s].data(),
            changes_[v].data(),
            offsets_[offset_at_.at(KeyOf(segment, measurement))].data());
        added = true;
      }
      if (!added) continue;
      problem_.AddResidualBlock(ZeroPrior(state_sigmas), nullptr,
                                states_[s].data());
      ordering_->AddElementToGroup(states_[s].data(), 0);
      if (options.hold_velocities) {
        problem_.SetManifold(
            states_[s].data(),
            new ceres::SubsetManifold(kSegmentSize, {3, 4, 5, 6, 7, 8}));
      }
    }
  }

  void AddOffsets(const BundleOptions& options) {
    for (Eigen::Vector2d& offset : offsets_) {
      problem_.AddParameterBlock(offset.data(), 2);
      ordering_->AddElementToGroup(offset.data(), 1);
      if (options.lasting_offset_m > 0.0) {
        problem_.AddResidualBlock(ZeroPrior(Eigen::Vector2d::Constant(
                                      1.0 / options.lasting_offset_m)),
                                  nullptr, offset.data());
      } else {
        problem_.SetParameterBlockConstant(offset.data());
      }
    }
  }

  void AddCameras(const std::vector<std::vector<int>>& places,
                  const BundleOptions& options) {
    CameraChange inverse = InverseSigmas(options);
    for (int i = 0; i < kChangeSize; ++i) {
      inverse[i] *= std::sqrt(TimesCounted(i, options.samples_at_once));
    }
    for (size_t v = 0; v < changes_.size(); ++v) {
      problem_.AddParameterBlock(changes_[v].data(), kChangeSize);
      ordering_->AddElementToGroup(changes_[v].data(), 2);
      if (places[v].empty() || options.hold_cameras) {
        problem_.SetParameterBlockConstant(changes_[v].data());
        continue;
      }
      std::vector<int> constant;
      for (int i = 0; i < kChangeSize; ++i) {
        if (std::count(places[v].begin(), places[v].end(), i) == 0) {
          constant.push_back(i);
        }
      }
      problem_.SetManifold(changes_[v].data(),
                           new ceres::SubsetManifold(kChangeSize, constant));
      CameraChange mean = CameraChange::Zero();
      if (!options.focal_prior.empty()) mean[kFocalAt] = options.focal_prior[v];
      problem_.AddResidualBlock(
          new ceres::NormalPrior(inverse.asDiagonal(), mean), nullptr,
          changes_[v].data());
    }
  }

  // Person, joint and view.
  static std::array<int, 3> KeyOf(const MotionSegment& segment,
                                  const SegmentMeasurement& measurement) {
    return {segment.person, segment.joint, measurement.view_idx};
  }

  const CameraRig& cameras_;
  const SceneSegments& segments_;
  // Ceres orders the blocks of one elimination group by their addresses, and
  // the rounding of sums depends on that order. One array per group makes it
  // independent of the allocator.
  std::vector<SegmentState> states_;
  std::vector<Eigen::Vector2d> offsets_;
  std::vector<CameraChange> changes_;
  std::map<std::array<int, 3>, size_t> offset_at_;
  std::unique_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_unique<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_;
};

// The offsets' actual variance is estimated from the recording: the sum of
// their squares over the number of components that the recording determines
// (MacKay, Bayesian Interpolation, 1992). The assumed variance counts as this
// many components; a person seen by four views has about a hundred.
constexpr double kAssumedOffsets = 20.0;
// Share of that variance that is common to all joints of a person in a view.
// Cameras absorb this part, so a recording does not determine it. With the
// published cameras it is 0.08 (Panoptic's pizza), 0.14 (Shelf) and 0.24 (a
// seated person 0.9 m from Caliscope's cameras): research/lasting_errors.py.
constexpr double kCommonShare = 0.15;

// Treats an empty sum as zero.
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

double BundleResult::Sigma(size_t view, int place) const {
  Eigen::Index at = 0;
  for (size_t v = 0; v <= view; ++v) {
    for (const int one : places[v]) {
      if (v == view && one == place) {
        return std::sqrt(std::max(0.0, covariance(at, at)));
      }
      ++at;
    }
  }
  return 0.0;
}

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
  // With fixed centres there is no gauge freedom.
  const bool holds_gauge =
      free.centre && std::count(moving.begin(), moving.end(), 1) ==
                         static_cast<long>(moving.size());
  const Eigen::MatrixXd gauge =
      holds_gauge ? GaugeRows(cameras, moving) : Eigen::MatrixXd(0, 0);
  if (holds_gauge) problem.AddGauge(gauge);
  problem.Solve(options.max_iterations, &result);
  if (!result.usable || !options.wants_covariance) return result;
  ReducedSystem reduced(cameras, segments, places,
                        PriorInformation(options.segments),
                        options.lasting_offset_m);
  for (size_t s = 0; s < segments.segments.size(); ++s) {
    reduced.Add(problem.WithoutOffsets(s), problem.states()[s], result.changes);
  }
  reduced.AddPrior(InverseSigmas(options), options.samples_at_once, gauge,
                   kGaugeSigma);
  result.covariance = reduced.Covariance();
  result.largest_correlation = reduced.LargestCorrelation();
  result.samples_at_once = std::max(1.0, reduced.SamplesAtOnce());
  return result;
}

ReducedSystem::ReducedSystem(const CameraRig& cameras,
                             const SceneSegments& segments,
                             std::vector<std::vector<int>> places,
                             const SegmentState& state_information,
                             double offset_sigma_m)
    : cameras_(cameras),
      segments_(segments),
      places_(std::move(places)),
      state_information_(state_information),
      offset_sigma_m_(offset_sigma_m) {
  for (const auto& list : places_) {
    begin_.push_back(size_);
    size_ += static_cast<Eigen::Index>(list.size());
  }
  information_ = measured_ = prior_scores_ =
      Eigen::MatrixXd::Zero(size_, size_);
}

void ReducedSystem::Add(const MotionSegment& segment, const SegmentState& state,
                        const std::vector<CameraChange>& changes) {
  Eigen::Matrix<double, kSegmentSize, kSegmentSize> H =
      state_information_.asDiagonal();
  H.topLeftCorner<3, 3>().diagonal().array() += kPositionInformation;
  const bool has_offsets = offset_sigma_m_ > 0.0;
  const auto offset_count =
      has_offsets ? 2 * static_cast<Eigen::Index>(places_.size()) : 0;
  // The free parameters, then the offsets.
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
  const int64_t block = BinOf(segments_, segment);
  AddScore(block, gradient.head(size_), &scores_);
  if (!has_offsets) return;
  Offsets& offsets = offsets_[{segment.person, segment.joint}];
  AddTo(information.topRightCorner(size_, offset_count), &offsets.cross);
  AddTo(information.bottomRightCorner(offset_count, offset_count),
        &offsets.information);
  AddScore(block, gradient.tail(offset_count), &offsets.scores);
}

void ReducedSystem::AddPrior(const CameraChange& inverse_sigma,
                             double samples_at_once,
                             const Eigen::MatrixXd& gauge, double gauge_sigma) {
  // Eliminate the detector's offsets first.
  const double prior = 1.0 / (offset_sigma_m_ * offset_sigma_m_);
  double squares = kAssumedOffsets;  // in units of the prior's variance
  double determined = kAssumedOffsets;
  // Score covariance of offsets with the prior's variance that are independent,
  // and that are the same for all joints of a person in a view.
  Eigen::MatrixXd independent = Eigen::MatrixXd::Zero(size_, size_);
  Eigen::MatrixXd common = independent;
  Eigen::MatrixXd of_person;  // sum of the gains of a person's joints
  for (auto one = offsets_.begin(); one != offsets_.end(); ++one) {
    auto& [cross, information, scores] = one->second;
    const Eigen::Index count = information.rows();
    information.diagonal().array() += prior;
    const Eigen::MatrixXd posterior =
        information.ldlt().solve(Eigen::MatrixXd::Identity(count, count));
    const Eigen::MatrixXd gain = cross * posterior;
    information_ -= gain * cross.transpose();
    independent += prior * gain * gain.transpose();
    AddTo(gain, &of_person);
    const auto next = std::next(one);
    if (next == offsets_.end() || next->first[0] != one->first[0]) {
      common += prior * of_person * of_person.transpose();
      of_person.resize(0, 0);
    }
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(count);
    for (const auto& [block, score] : scores) {
      scores_.at(block) -= gain * score;
      sum += score;
    }
    // At the minimum the offset is the negative sum of its scores divided by
    // the prior's information.
    squares += sum.squaredNorm() / prior;
    determined += static_cast<double>(count) - prior * posterior.trace();
  }
  measured_ = information_ - independent;
  prior_scores_ += squares / determined *
                   ((1.0 - kCommonShare) * independent + kCommonShare * common);
  Eigen::MatrixXd held = Eigen::MatrixXd::Zero(gauge.rows(), size_);
  for (size_t v = 0; v < places_.size(); ++v) {
    for (size_t i = 0; i < places_[v].size(); ++i) {
      const Eigen::Index at = begin_[v] + static_cast<Eigen::Index>(i);
      const int place = places_[v][i];
      const double information = inverse_sigma[place] * inverse_sigma[place];
      const double times = TimesCounted(place, samples_at_once);
      information_(at, at) += times * information;
      // The score of a prior multiplied by n has n^2 times its information as
      // variance; if the prior dominates, the sandwich then equals the prior's
      // covariance for any n.
      prior_scores_(at, at) += times * times * information;
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
  // The sandwich in units of the inverse information, whose root is L;
  // eigenvalues below 1 are raised to 1.
  const Eigen::MatrixXd L = Inverse().llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> units(
      L.transpose() * (ScoreVariance() + prior_scores_) * L);
  const Eigen::MatrixXd root = L * units.eigenvectors();
  return root * units.eigenvalues().cwiseMax(1.0).asDiagonal() *
         root.transpose();
}

Eigen::MatrixXd ReducedSystem::BlockVariance() const {
  Eigen::MatrixXd variance = Eigen::MatrixXd::Zero(size_, size_);
  for (const auto& [block, score] : scores_) {
    variance += score * score.transpose();
  }
  const auto blocks = static_cast<double>(scores_.size());
  return blocks / std::max(1.0, blocks - 1.0) * variance;
}

double ReducedSystem::SamplesAtOnce() const {
  if (size_ == 0) return 1.0;
  const Eigen::MatrixXd inverse = Inverse();
  return (inverse * BlockVariance()).trace() /
         std::max(1e-300, (inverse * measured_).trace());
}

Eigen::MatrixXd ReducedSystem::ScoreVariance() const {
  // Shrinkage towards a multiple of the measurements' information, which counts
  // as many blocks as there are parameters: the mean under an inverse Wishart
  // prior. In units of the inverse information both have the same trace.
  const auto blocks = static_cast<double>(scores_.size());
  const auto parameters = static_cast<double>(size_);
  return (blocks * BlockVariance() + parameters * SamplesAtOnce() * measured_) /
         (blocks + parameters);
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
      if (is_clock[i] == is_clock[j]) continue;
      const double scale = std::sqrt(inverse(i, i) * inverse(j, j));
      if (scale > 0.0) {
        largest = std::max(largest, std::abs(inverse(i, j)) / scale);
      }
    }
  }
  return largest;
}

}  // namespace kinegraph
