#include "solvers/filters/segment_filters.h"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "solvers/filters/butterworth.h"
#include "solvers/filters/classical.h"
#include "solvers/filters/kalman.h"
#include "solvers/filters/smoothing_spline.h"

namespace kinegraph {
namespace {

void RequireBelowNyquist(const std::string& key, double frequency_hz,
                         double rate_hz) {
  if (frequency_hz < 0.5 * rate_hz) return;
  char text[120];
  std::snprintf(text, sizeof(text),
                "found %g Hz, allowed: below half the frame rate of %g Hz",
                frequency_hz, rate_hz);
  throw OptionError(key, text);
}

// Throws InputError naming `estimator` when a step of time is more than half a
// nominal frame longer or shorter than a frame: a frame was dropped, or the
// clock is not that of the frame rate. `times_s` ascend, from the track's first
// frame.
void RequireUniformTime(const std::string& estimator,
                        const std::vector<double>& times_s, double rate_hz) {
  // Frame times are rounded to nanoseconds.
  constexpr double kSlackS = 1e-6;
  for (size_t k = 1; k < times_s.size(); ++k) {
    const double step_s = times_s[k] - times_s[k - 1];
    if (std::abs(step_s - 1.0 / rate_hz) <= 0.5 / rate_hz + kSlackS) continue;
    char text[160];
    std::snprintf(text, sizeof(text),
                  "needs uniform time, found a step of %.4f s, %.4f s into the "
                  "track, where a frame is %.4f s (allowed: half a frame more "
                  "or less)",
                  step_s, times_s[k - 1], 1.0 / rate_hz);
    throw InputError("output.estimator '" + estimator + "' " + text);
  }
}

// Rows of the samples, and their times.
struct SampledRows {
  std::vector<double> times_s;
  Samples values;
};

SampledRows SamplesOf(const JointSegment& segment) {
  SampledRows rows;
  rows.values.resize(segment.positions_m.rows(), segment.positions_m.cols());
  Eigen::Index count = 0;
  for (size_t i = 0; i < segment.times_s.size(); ++i) {
    if (!segment.sampled[i]) continue;
    rows.times_s.push_back(segment.times_s[i]);
    rows.values.row(count++) =
        segment.positions_m.row(static_cast<Eigen::Index>(i));
  }
  rows.values.conservativeResize(count, Eigen::NoChange);
  return rows;
}

// Back to all frames; those between samples hold the last value.
Samples Hold(const JointSegment& segment, const Samples& values) {
  Samples held(segment.positions_m.rows(), values.cols());
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < held.rows(); ++i) {
    if (segment.sampled[static_cast<size_t>(i)]) ++next;
    held.row(i) = values.row(next - 1);
  }
  return held;
}

// `segment` with the class's constant for every sample's covariance.
JointSegment WithConstantNoise(const KalmanOptions& options,
                               JointSegment segment) {
  const double sigma_m = options.sigma_m[static_cast<int>(segment.joint_class)];
  for (Eigen::Matrix3d& covariance : segment.covariances_m2) {
    covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  }
  return segment;
}

// `run`: the filter or the smoother of kalman.h.
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
    SegmentEstimate estimate{segment.positions_m, {}};
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
        CentredGaussian(options.sigma_s, segment.times_s, segment.positions_m),
        {}};
  };
}

SegmentFilter HampelMedianFilter(const HampelMedianOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    if (options.side == WindowSide::kCentred) {
      return {HampelMedian(options, segment.times_s, segment.positions_m), {}};
    }
    const SampledRows rows = SamplesOf(segment);
    return {Hold(segment, HampelMedian(options, rows.times_s, rows.values)),
            {}};
  };
}

SegmentFilter OneEuroFilter(const OneEuroOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    const SampledRows rows = SamplesOf(segment);
    return {Hold(segment, OneEuro(options, rows.times_s, rows.values)), {}};
  };
}

SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz) {
  if (options.choice == CutoffChoice::kFixed) {
    RequireBelowNyquist("filters.butterworth.cutoff", options.cutoff_hz,
                        rate_hz);
  }
  return [options, rate_hz](const JointSegment& segment) -> SegmentEstimate {
    RequireUniformTime("butterworth", segment.times_s, rate_hz);
    return {ZeroPhaseButterworth(options, rate_hz, segment.positions_m), {}};
  };
}

SegmentFilter SavitzkyGolayFilter(const SavitzkyGolayOptions& options,
                                  double rate_hz) {
  const int length = SavitzkyGolayLength(options, rate_hz);
  const int order = static_cast<int>(options.order);
  return [=](const JointSegment& segment) -> SegmentEstimate {
    RequireUniformTime("savitzky_golay", segment.times_s, rate_hz);
    return {SavitzkyGolay(length, order, segment.positions_m), {}};
  };
}

SegmentFilter SmoothingSplineFilter(const SmoothingSplineOptions& options,
                                    double rate_hz) {
  if (options.choice == SmoothnessChoice::kCutoff) {
    RequireBelowNyquist("filters.smoothing_spline.cutoff", options.cutoff_hz,
                        rate_hz);
  }
  return [options](const JointSegment& segment) -> SegmentEstimate {
    const SampledRows rows = SamplesOf(segment);
    constexpr size_t kFewest = 5;
    const size_t count = rows.times_s.size();
    if (count < kFewest) return {segment.positions_m, {}};
    const double step_s = (rows.times_s.back() - rows.times_s.front()) /
                          static_cast<double>(count - 1);
    const double lambda_s3 = options.choice == SmoothnessChoice::kGcv
                                 ? ChooseLambdaByGcv(rows.times_s, rows.values)
                                 : LambdaOfCutoff(options.cutoff_hz, step_s);
    return {
        SmoothingSpline(lambda_s3, rows.times_s, rows.values, segment.times_s),
        {}};
  };
}

SegmentFilter KalmanPointFilter(const KalmanOptions& options) {
  return StateSpace(options, KalmanFilter);
}

SegmentFilter RtsPointSmoother(const KalmanOptions& options) {
  return StateSpace(options, RtsSmoother);
}

}  // namespace kinegraph
