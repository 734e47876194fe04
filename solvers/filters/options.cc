#include "solvers/filters/options.h"

namespace kinegraph {
namespace {

template <typename Options>
void DescribeIn(OptionVisitor& visitor, const std::string& table,
                Options* options) {
  visitor.Enter(table);
  options->Describe(visitor);
  visitor.Leave();
}

}  // namespace

void OfflineFilterOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("max_gap", &max_gap_s, NonNegative(), "s",
                 "longest gap between samples that is bridged");
  visitor.Choice("cutoff_per", &cutoff_per, {"axis", "joint", "body"},
                 "which signals share a cut-off chosen by a rule");
}

void RobustTriangulationOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("loss_scale", &loss_scale, Positive(), "sigmas",
                 "scale of the robust loss, as a residual");
}

void CentredGaussianOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("sigma", &sigma_s, Positive(), "s",
                 "standard deviation of the kernel");
}

void HampelMedianOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("hampel_window", &hampel_window_s, NonNegative(), "s",
                 "window in which outliers are sought");
  visitor.Number("hampel_threshold", &hampel_threshold, NonNegative(),
                 "standard deviations",
                 "distance from the median beyond which a value is an outlier");
  visitor.Number("median_window", &median_window_s, NonNegative(), "s",
                 "window of the moving median");
  visitor.Choice("window", &side, {"centred", "trailing"},
                 "trailing windows contain no later samples: causal");
}

void OneEuroOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("min_cutoff", &min_cutoff_hz, Positive(), "Hz",
                 "cut-off at rest");
  visitor.Number("beta", &beta_per_m, NonNegative(), "1/m",
                 "growth of the cut-off in Hz per m/s");
  visitor.Boolean("zero_phase", &zero_phase,
                  "forwards, then backwards: no lag, not causal");
}

void ButterworthOptions::Describe(OptionVisitor& visitor) {
  visitor.Integer("order", &order, Between(1, 8), "",
                  "order of each of the two passes");
  visitor.Choice("choice", &choice,
                 {"fixed", "winter", "challis", "yu", "jackson", "gcv",
                  "power95", "power99"},
                 "how the cut-off is chosen: fixed, or by a rule "
                 "(docs/filters.md)");
  visitor.Number("cutoff", &cutoff_hz, Positive(), "Hz",
                 "cut-off, below half the frame rate");
  visitor.Boolean("correct_cutoff", &correct_cutoff,
                  "the cut-off is where both passes together halve the power, "
                  "not each pass");
  visitor.Choice("on", &on, {"position", "speed"},
                 "signal to filter; filtered speeds are integrated again");
}

void SavitzkyGolayOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("window", &window_s, NonNegative(), "s",
                 "window, rounded to an odd number of frames");
  visitor.Integer("order", &order, Between(0, 10), "",
                  "order of the polynomials");
}

void SmoothingSplineOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("choice", &choice,
                 {"cutoff", "winter", "challis", "yu", "jackson", "gcv",
                  "power95", "power99", "lambda"},
                 "how the smoothness is chosen: by generalised "
                 "cross-validation, another rule, the cut-off or lambda");
  visitor.Number("cutoff", &cutoff_hz, Positive(), "Hz",
                 "frequency at which the amplitude is halved");
  visitor.Number("lambda", &lambda, Positive(), "",
                 "weight of the roughness, for samples one frame apart");
}

void WhittakerOptions::Describe(OptionVisitor& visitor) {
  visitor.Integer("order", &order, Between(2, 3), "",
                  "order of the differences");
}

void LoessOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("window", &window_s, NonNegative(), "s",
                 "window of the samples to which a polynomial is fitted");
  visitor.Integer("degree", &degree, Between(1, 2), "",
                  "degree of the polynomials");
  visitor.Integer("iterations", &iterations, Between(0, 20), "",
                  "number of fits that downweight outliers");
}

void TrendOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("lambda", &lambda_m, Positive(), "m",
                 "weight of changes of slope, for samples one frame apart");
}

void KalmanOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("motion", &motion,
                 {"constant_velocity", "constant_acceleration"},
                 "motion in the absence of process noise");
  visitor.Number("process_noise_scale", &process_noise_scale, Positive(), "",
                 "factor on the process noise, which follows from "
                 "graph.process_noise");
  visitor.Choice("measurement", &measurement, {"triangulation", "constant"},
                 "covariance of a sample: from its triangulation, or sigma");
  DescribeJointClasses(visitor, "sigma", &sigma_m, "m",
                       "constant measurement noise of each coordinate");
}

void FilterOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("filters");
  visitor.Choice("points", &points, {"dlt", "robust"},
                 "what filters smooth: joints triangulated by DLT after the "
                 "joints filter, or robustly");
  segments.Describe(visitor);
  DescribeIn(visitor, "robust_triangulation", &robust_triangulation);
  DescribeIn(visitor, "centred_gaussian", &centred_gaussian);
  DescribeIn(visitor, "hampel_median", &hampel_median);
  DescribeIn(visitor, "one_euro", &one_euro);
  DescribeIn(visitor, "butterworth", &butterworth);
  DescribeIn(visitor, "savitzky_golay", &savitzky_golay);
  DescribeIn(visitor, "smoothing_spline", &smoothing_spline);
  DescribeIn(visitor, "whittaker", &whittaker);
  DescribeIn(visitor, "loess", &loess);
  DescribeIn(visitor, "trend", &trend);
  DescribeIn(visitor, "kalman", &kalman);
  visitor.Leave();
}

void CausalGaussianOptions::Describe(OptionVisitor& visitor) {
  visitor.Boolean("smooth", &smooth, "smooth, or write the poses as they are");
  visitor.Number("sigma", &sigma_frames, Between(0.01, 20.0), "frames",
                 "standard deviation of the causal Gaussian over stored poses");
  visitor.Number("wrist_sigma", &wrist_sigma_frames, Between(0.01, 20.0),
                 "frames", "standard deviation for the wrists");
  visitor.Number("history", &history_frames, Positive(), "frames",
                 "older stored poses are dropped");
  visitor.Integer("velocity_differences", &velocity_differences,
                  Between(1, 1000), "poses",
                  "number of differences of stored poses that the velocity "
                  "averages");
  visitor.Choice("velocity", &velocity, {"over_time", "per_update"},
                 "metres per second, or per stored pose (authors' code)");
  visitor.Number("hold", &hold_frames, NonNegative(), "frames",
                 "how long an unseen joint keeps its own velocity before it "
                 "gets the body's; 0: for ever");
}

}  // namespace kinegraph
