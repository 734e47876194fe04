#include "solvers/filters/offline_filter.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/weighted_quantile.h"
#include "core/tracking/estimator.h"
#include "solvers/filters/classical.h"
#include "solvers/filters/cutoff.h"
#include "solvers/filters/kalman.h"
#include "solvers/filters/loess.h"
#include "solvers/filters/penalised.h"

namespace kinegraph {
namespace {

JointDerivatives DerivativesAt(const SegmentEstimate& estimate,
                               Eigen::Index row) {
  JointDerivatives derivatives;
  derivatives.velocity_m_s = estimate.velocities_m_s.row(row).transpose();
  if (estimate.accelerations_m_s2.rows() > 0) {
    derivatives.acceleration_m_s2 =
        estimate.accelerations_m_s2.row(row).transpose();
  }
  return derivatives;
}

class OfflineFilter final : public Estimator {
 public:
  OfflineFilter(const SceneModel& scene, const OfflineFilterOptions& options,
                JointPoints points, SegmentFilter filter)
      : scene_(scene),
        point_source_(std::move(points)),
        filter_(std::move(filter)),
        // Neighbouring frames are no gap. Half a frame of tolerance, as in
        // FrameClock.
        max_gap_s_(std::max(options.max_gap_s, 1.0 / scene.frame_rate_hz) +
                   0.5 / scene.frame_rate_hz),
        cutoff_per_(options.cutoff_per),
        samples_(scene.skeleton.joint_count()) {}

  void Add(const EstimatorFrame& frame) override {
    CHECK(collected_.empty() || frame.time > collected_.back().time);
    FinalPose& collected = collected_.emplace_back();
    collected.frame = frame.frame;
    collected.time = frame.time;
    DescribeViews(frame, scene_.kept_matches, &collected.person);
    collected.person.joints.resize(samples_.size());
    point_source_.Find(frame, &points_, &collected.person);
    for (size_t j = 0; j < samples_.size(); ++j) {
      if (points_[j])
        samples_[j].push_back({collected_.size() - 1, *points_[j]});
    }
    if (frame.has_initial) {
      last_ = frame.initial;
      last_time_ = frame.time;
    }
  }
  const Pose3d& Last() const override { return last_; }
  TimeNs LastTime() const override { return last_time_; }

  void Predict(TimeNs, Pose3d* pose) const override {
    ExpectUnmoved(last_, pose);
  }

  void ExtractFinals(std::vector<FinalPose>* finals) override {
    MoveFinals(&finals_, finals);
  }

  void Finish() override {
    std::vector<Piece> pieces;
    for (size_t j = 0; j < samples_.size(); ++j) Collect(j, &pieces);
    std::vector<SegmentEstimate> estimates;
    estimates.reserve(pieces.size());
    for (const Piece& piece : pieces) {
      estimates.push_back(filter_(piece.segment));
    }
    if (cutoff_per_ == CutoffPer::kBody) WithOneCutoff(&pieces, &estimates);
    for (size_t i = 0; i < pieces.size(); ++i) Write(pieces[i], estimates[i]);
    finals_ = std::move(collected_);
    collected_.clear();
  }

 private:
  struct Sample {
    size_t frame_idx = 0;  // index into collected_
    JointPoint point;
  };
  // Samples of a joint between two gaps.
  struct Piece {
    size_t joint_idx = 0;
    size_t frame_idx = 0;  // of its first frame
    JointSegment segment;
  };

  void Collect(size_t joint_idx, std::vector<Piece>* pieces) const {
    const std::vector<Sample>& samples = samples_[joint_idx];
    for (size_t first = 0, next = 0; first < samples.size(); first = next) {
      next = first + 1;
      while (next < samples.size() &&
             SecondsAt(samples[next].frame_idx) -
                     SecondsAt(samples[next - 1].frame_idx) <=
                 max_gap_s_) {
        ++next;
      }
      Piece& piece = pieces->emplace_back();
      piece.joint_idx = joint_idx;
      piece.frame_idx = samples[first].frame_idx;
      piece.segment = Segment(samples, first, next - 1);
      piece.segment.joint_class =
          scene_.skeleton.joint_class(static_cast<int>(joint_idx));
    }
  }

  void WithOneCutoff(std::vector<Piece>* pieces,
                     std::vector<SegmentEstimate>* estimates) const {
    std::vector<WeightedValue> chosen_hz;
    for (const SegmentEstimate& estimate : *estimates) {
      const auto frames = static_cast<double>(estimate.positions_m.rows());
      for (const double hz : estimate.cutoffs_hz) {
        chosen_hz.push_back({hz, frames});
      }
    }
    if (chosen_hz.empty()) return;
    const double median_hz = WeightedQuantile(std::move(chosen_hz), 0.5);
    for (size_t i = 0; i < pieces->size(); ++i) {
      (*pieces)[i].segment.cutoff_hz = median_hz;
      (*estimates)[i] = filter_((*pieces)[i].segment);
    }
  }

  void Write(const Piece& piece, const SegmentEstimate& estimate) {
    for (size_t i = 0; i < piece.segment.times_s.size(); ++i) {
      PersonPose& person = collected_[piece.frame_idx + i].person;
      Joint3d& joint = person.joints[piece.joint_idx];
      joint.position_m =
          estimate.positions_m.row(static_cast<Eigen::Index>(i)).transpose();
      joint.status = piece.segment.sampled[i] ? JointStatus::kObserved
                                              : JointStatus::kInferred;
      if (scene_.keep_derivatives && estimate.velocities_m_s.rows() > 0) {
        person.derivatives.resize(samples_.size());
        person.derivatives[piece.joint_idx] =
            DerivativesAt(estimate, static_cast<Eigen::Index>(i));
      }
      if (estimate.covariances_m2.empty()) continue;
      person.covariances.resize(samples_.size());
      person.covariances[piece.joint_idx] = estimate.covariances_m2[i];
    }
  }

  // The frames from sample `first` to sample `last`.
  JointSegment Segment(const std::vector<Sample>& samples, size_t first,
                       size_t last) const {
    const size_t begin = samples[first].frame_idx;
    const size_t count = samples[last].frame_idx - begin + 1;
    JointSegment segment;
    segment.times_s.resize(count);
    segment.positions_m.resize(static_cast<Eigen::Index>(count), 3);
    segment.sampled.assign(count, 0);
    segment.covariances_m2.assign(count, Eigen::Matrix3d::Identity());
    for (size_t i = 0; i < count; ++i)
      segment.times_s[i] = SecondsAt(begin + i);
    const auto place = [&](size_t frame_idx, const Eigen::Vector3d& point_m) {
      segment.positions_m.row(static_cast<Eigen::Index>(frame_idx - begin)) =
          point_m.transpose();
    };
    for (size_t s = first; s <= last; ++s) {
      const auto& [to_idx, to] = samples[s];
      segment.sampled[to_idx - begin] = 1;
      segment.covariances_m2[to_idx - begin] = to.covariance_m2;
      place(to_idx, to.position_m);
      if (s == first) continue;
      const auto& [from_idx, from] = samples[s - 1];
      for (size_t k = from_idx + 1; k < to_idx; ++k) {
        const double share = (SecondsAt(k) - SecondsAt(from_idx)) /
                             (SecondsAt(to_idx) - SecondsAt(from_idx));
        place(k, from.position_m + share * (to.position_m - from.position_m));
      }
    }
    return segment;
  }
  double SecondsAt(size_t frame_idx) const {
    return ToSeconds(collected_[frame_idx].time - collected_.front().time);
  }

  const SceneModel scene_;
  JointPoints point_source_;
  const SegmentFilter filter_;
  const double max_gap_s_;
  const CutoffPer cutoff_per_;
  std::vector<FinalPose> collected_;          // one per frame
  std::vector<std::vector<Sample>> samples_;  // by joint
  std::vector<FinalPose> finals_;
  std::vector<std::optional<JointPoint>> points_;  // scratch
  Pose3d last_;
  TimeNs last_time_ = 0;
};

}  // namespace

std::unique_ptr<Estimator> MakeOfflineFilter(
    const SceneModel& scene, const OfflineFilterOptions& options,
    JointPoints points, SegmentFilter filter) {
  CheckOptions(options);
  return std::make_unique<OfflineFilter>(scene, options, std::move(points),
                                         std::move(filter));
}

namespace {

void RequireBelowNyquist(const std::string& key, double frequency_hz,
                         double rate_hz) {
  if (frequency_hz < 0.5 * rate_hz) return;
  throw OptionError(
      key, fmt::format(
               "found {:g} Hz, allowed: below half the frame rate of {:g} Hz",
               frequency_hz, rate_hz));
}

// Throws InputError naming `estimator` when a time step differs from a nominal
// frame by more than half a frame: a frame was dropped, or the frame rate is
// wrong. `times_s` ascend, from the track's first frame.
void RequireUniformTime(const std::string& estimator,
                        const std::vector<double>& times_s, double rate_hz) {
  // Frame times are rounded to nanoseconds.
  constexpr double kSlackS = 1e-6;
  for (size_t k = 1; k < times_s.size(); ++k) {
    const double step_s = times_s[k] - times_s[k - 1];
    if (std::abs(step_s - 1.0 / rate_hz) <= 0.5 / rate_hz + kSlackS) continue;
    throw InputError(fmt::format(
        "output.estimator '{}' needs uniform frame times, found a step of "
        "{:.4f} s, {:.4f} s after the start of the track, expected {:.4f} s "
        "(give or take half a frame)",
        estimator, step_s, times_s[k - 1], 1.0 / rate_hz));
  }
}

// Frames per second of a segment: of its own times, or nominal if they agree.
double RateOf(const std::vector<double>& times_s, double nominal_hz) {
  // Rounded times and rates written with few digits agree.
  constexpr double kAgree = 0.005;
  const double span_s = times_s.back() - times_s.front();
  if (!(span_s > 0.0)) return nominal_hz;
  const double own_hz = static_cast<double>(times_s.size() - 1) / span_s;
  return std::abs(own_hz / nominal_hz - 1.0) <= kAgree ? nominal_hz : own_hz;
}

SampledRows SamplesOf(const JointSegment& segment) {
  return SampledRowsOf(segment.times_s, segment.sampled, segment.positions_m);
}

// Expands values of samples to all frames; frames between samples hold the last
// value.
Samples Hold(const JointSegment& segment, const Samples& values) {
  Samples held(segment.positions_m.rows(), values.cols());
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < held.rows(); ++i) {
    if (segment.sampled[i]) ++next;
    held.row(i) = values.row(next - 1);
  }
  return held;
}

// One cut-off per coordinate [Hz]: the segment's, if it has one, else chosen by
// the rule.
std::vector<double> CutoffsOf(CutoffChoice rule, CutoffPer per,
                              const LowPass& low_pass,
                              const JointSegment& segment) {
  if (!segment.cutoff_hz.has_value()) {
    return ChooseCutoffs(rule, per, low_pass, segment.positions_m);
  }
  return std::vector<double>(static_cast<size_t>(segment.positions_m.cols()),
                             *segment.cutoff_hz);
}

using MakeLowPass = LowPass (*)(const ButterworthOptions& options,
                                double rate_hz);

SegmentFilter Recursive(const std::string& name,
                        const ButterworthOptions& options, CutoffPer per,
                        double rate_hz, MakeLowPass make) {
  if (options.choice == CutoffChoice::kFixed) {
    RequireBelowNyquist("filters.butterworth.cutoff", options.cutoff_hz,
                        rate_hz);
  }
  return [=](const JointSegment& segment) -> SegmentEstimate {
    RequireUniformTime(name, segment.times_s, rate_hz);
    const double own_hz = RateOf(segment.times_s, rate_hz);
    LowPass low_pass = make(options, own_hz);
    // A cut-off may be too high for a segment whose own rate is below the
    // nominal one.
    low_pass.filter = [own_hz, filter = std::move(low_pass.filter)](
                          double cutoff_hz, const Samples& signal) {
      return filter(cutoff_hz < 0.5 * own_hz ? cutoff_hz : 0.45 * own_hz,
                    signal);
    };
    const Samples& values = segment.positions_m;
    if (options.choice == CutoffChoice::kFixed) {
      return {low_pass.filter(options.cutoff_hz, values)};
    }
    SegmentEstimate estimate = {
        values, {}, CutoffsOf(options.choice, per, low_pass, segment)};
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      estimate.positions_m.col(c) = low_pass.filter(
          estimate.cutoffs_hz[static_cast<size_t>(c)], values.col(c));
    }
    return estimate;
  };
}

// Writes a curve's fit to the columns from `first` on.
void WriteFit(const PenalisedCurve& curve, double lambda, Eigen::Index first,
              SegmentEstimate* estimate) {
  CurveDerivatives derivatives;
  const Samples values = curve.Fit(lambda, &derivatives);
  const auto place = [&](const Samples& from, Samples* to) {
    if (from.rows() == 0) return;
    to->conservativeResize(estimate->positions_m.rows(),
                           estimate->positions_m.cols());
    to->middleCols(first, from.cols()) = from;
  };
  place(values, &estimate->positions_m);
  place(derivatives.first, &estimate->velocities_m_s);
  place(derivatives.second, &estimate->accelerations_m_s2);
}

using MakeCurve = std::function<std::unique_ptr<PenalisedCurve>(
    const std::vector<double>& times_s, const std::vector<char>& sampled,
    const Samples& values)>;

// `rough`: the derivative that measures roughness.
SegmentFilter Penalised(const SmoothingSplineOptions& options, double rate_hz,
                        CutoffPer per, int rough, MakeCurve make) {
  if (options.choice == CutoffChoice::kFixed) {
    RequireBelowNyquist("filters.smoothing_spline.cutoff", options.cutoff_hz,
                        rate_hz);
  }
  return [=, make = std::move(make)](
             const JointSegment& segment) -> SegmentEstimate {
    const auto count =
        std::count(segment.sampled.begin(), segment.sampled.end(), 1);
    if (count < 2 * rough + 1) return {segment.positions_m};
    const auto curve_of = [&](const Samples& values) {
      return make(segment.times_s, segment.sampled, values);
    };
    const auto all = curve_of(segment.positions_m);
    SegmentEstimate estimate = {segment.positions_m};
    if (options.choice == CutoffChoice::kFixed ||
        options.choice == CutoffChoice::kLambda) {
      WriteFit(*all,
               options.choice == CutoffChoice::kLambda
                   ? options.lambda
                   : all->LambdaOf(options.cutoff_hz),
               0, &estimate);
      return estimate;
    }
    const Eigen::Index columns = segment.positions_m.cols();
    if (options.choice != CutoffChoice::kGcv || segment.cutoff_hz.has_value()) {
      LowPass low_pass;
      low_pass.rate_hz = RateOf(segment.times_s, rate_hz);
      low_pass.filter = [&](double cutoff_hz, const Samples& values) {
        const auto curve = curve_of(values);
        return curve->Fit(curve->LambdaOf(cutoff_hz));
      };
      estimate.cutoffs_hz = CutoffsOf(options.choice, per, low_pass, segment);
    } else if (per != CutoffPer::kAxis) {
      const double lambda = all->BestLambda();
      WriteFit(*all, lambda, 0, &estimate);
      estimate.cutoffs_hz.assign(static_cast<size_t>(columns),
                                 all->CutoffOf(lambda));
      return estimate;
    } else {
      for (Eigen::Index c = 0; c < columns; ++c) {
        const auto curve = curve_of(segment.positions_m.col(c));
        estimate.cutoffs_hz.push_back(curve->CutoffOf(curve->BestLambda()));
      }
    }
    for (Eigen::Index c = 0; c < columns; ++c) {
      const auto curve = curve_of(segment.positions_m.col(c));
      WriteFit(*curve,
               curve->LambdaOf(estimate.cutoffs_hz[static_cast<size_t>(c)]), c,
               &estimate);
    }
    return estimate;
  };
}

// `segment` with the constant covariance of the joint class for every sample.
JointSegment WithConstantNoise(const KalmanOptions& options,
                               JointSegment segment) {
  const double sigma_m = options.sigma_m[static_cast<int>(segment.joint_class)];
  for (Eigen::Matrix3d& covariance : segment.covariances_m2) {
    covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  }
  return segment;
}

// `run`: the filter or one of the two smoothers of kalman.h.
using StateSpaceRun = SegmentEstimate (*)(const PointModel&,
                                          const JointSegment&);
SegmentFilter StateSpace(const KalmanOptions& options, StateSpaceRun run) {
  return [options, run](const JointSegment& segment) {
    const PointModel model = ModelOf(options, segment.joint_class);
    return options.measurement == MeasurementNoise::kConstant
               ? run(model, WithConstantNoise(options, segment))
               : run(model, segment);
  };
}

}  // namespace

SegmentFilter PointsAsTheyAre(PointCovariances covariances) {
  return [covariances](const JointSegment& segment) {
    SegmentEstimate estimate = {segment.positions_m};
    if (covariances == PointCovariances::kOff) return estimate;
    estimate.covariances_m2.resize(segment.times_s.size());
    for (size_t i = 0; i < segment.times_s.size(); ++i) {
      if (!segment.sampled[i]) continue;
      estimate.covariances_m2[i] = segment.covariances_m2[i];
    }
    return estimate;
  };
}

SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    return {
        CentredGaussian(options.sigma_s, segment.times_s, segment.positions_m)};
  };
}

SegmentFilter HampelMedianFilter(const HampelMedianOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    if (options.side == WindowSide::kCentred) {
      return {HampelMedian(options, segment.times_s, segment.positions_m)};
    }
    const SampledRows rows = SamplesOf(segment);
    return {Hold(segment, HampelMedian(options, rows.times, rows.values))};
  };
}

SegmentFilter OneEuroFilter(const OneEuroOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    const SampledRows rows = SamplesOf(segment);
    return {Hold(segment, OneEuro(options, rows.times, rows.values))};
  };
}

SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz, CutoffPer per) {
  return Recursive("butterworth", options, per, rate_hz, ZeroPhaseButterworth);
}

SegmentFilter CriticallyDampedFilter(const ButterworthOptions& options,
                                     double rate_hz, CutoffPer per) {
  return Recursive("critically_damped", options, per, rate_hz,
                   ZeroPhaseCriticallyDamped);
}

SegmentFilter SavitzkyGolayFilter(const SavitzkyGolayOptions& options,
                                  double rate_hz) {
  const int order = static_cast<int>(options.order);
  return [=](const JointSegment& segment) -> SegmentEstimate {
    RequireUniformTime("savitzky_golay", segment.times_s, rate_hz);
    const int length =
        SavitzkyGolayLength(options, RateOf(segment.times_s, rate_hz));
    return {SavitzkyGolay(length, order, segment.positions_m)};
  };
}

SegmentFilter LoessFilter(const LoessOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    const SampledRows rows = SamplesOf(segment);
    const size_t count = rows.times.size();
    const int degree = static_cast<int>(options.degree);
    if (count < static_cast<size_t>(degree) + 2) return {segment.positions_m};
    const int neighbours =
        std::max(degree + 2, static_cast<int>(std::lround(std::min(
                                 options.window_s / MeanStep(rows.times),
                                 static_cast<double>(count)))));
    return {Loess(neighbours, degree, static_cast<int>(options.iterations),
                  rows.times, rows.values, segment.times_s)};
  };
}

SegmentFilter TrendPointFilter(const TrendOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    const SampledRows rows = SamplesOf(segment);
    const Samples trend =
        TrendFilter(options.lambda_m, rows.times, rows.values);
    // Linear between samples, like the trend itself.
    SegmentEstimate estimate = {segment.positions_m};
    Eigen::Index next = 0;
    for (Eigen::Index i = 0; i < estimate.positions_m.rows(); ++i) {
      const double time_s = segment.times_s[static_cast<size_t>(i)];
      while (rows.times[static_cast<size_t>(next)] < time_s) ++next;
      const double end_s = rows.times[static_cast<size_t>(next)];
      estimate.positions_m.row(i) = trend.row(next);
      if (end_s == time_s) continue;
      const double begin_s = rows.times[static_cast<size_t>(next) - 1];
      estimate.positions_m.row(i) -= (end_s - time_s) / (end_s - begin_s) *
                                     (trend.row(next) - trend.row(next - 1));
    }
    return estimate;
  };
}

SegmentFilter SmoothingSplineFilter(const SmoothingSplineOptions& options,
                                    double rate_hz, CutoffPer per) {
  return Penalised(options, rate_hz, per, 2, MakeCubicSpline);
}

SegmentFilter QuinticSplineFilter(const SmoothingSplineOptions& options,
                                  double rate_hz, CutoffPer per) {
  return Penalised(options, rate_hz, per, 3, MakeQuinticSpline);
}

SegmentFilter WhittakerFilter(const WhittakerOptions& options, double rate_hz,
                              CutoffPer per) {
  const int order = static_cast<int>(options.order);
  return Penalised(
      options.smoothness, rate_hz, per, order,
      [order](const auto& times_s, const auto& sampled, const auto& values) {
        return MakeWhittaker(order, times_s, sampled, values);
      });
}

SegmentFilter KalmanPointFilter(const KalmanOptions& options) {
  return StateSpace(options, KalmanFilter);
}

SegmentFilter RtsPointSmoother(const KalmanOptions& options) {
  return StateSpace(options, RtsSmoother);
}

SegmentFilter StudentTPointSmoother(const KalmanOptions& options) {
  return StateSpace(options, StudentTSmoother);
}

}  // namespace kinegraph
