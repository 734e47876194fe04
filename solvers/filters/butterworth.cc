#include "solvers/filters/butterworth.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

// tan of half the digital angle: the analogue frequency that the bilinear
// transform maps there.
double Prewarp(double frequency_hz, double rate_hz) {
  return std::tan(M_PI * frequency_hz / rate_hz);
}

// One pass in place, transposed direct form II, each section at rest at the
// first value.
void RunThrough(const std::vector<FilterSection>& sections,
                Eigen::VectorXd* signal) {
  for (const FilterSection& s : sections) {
    const double first = (*signal)(0);
    double z1 = first * (1.0 - s.b0);
    double z2 = first * (s.b2 - s.a2);
    for (double& value : *signal) {
      const double in = value;
      value = s.b0 * in + z1;
      z1 = s.b1 * in - s.a1 * value + z2;
      z2 = s.b2 * in - s.a2 * value;
    }
  }
}

}  // namespace

std::vector<FilterSection> ButterworthLowPass(int order, double cutoff_hz,
                                              double rate_hz) {
  const double w = Prewarp(cutoff_hz, rate_hz);
  std::vector<FilterSection> sections;
  for (int k = 0; k < order / 2; ++k) {
    const double damping = 2.0 * std::sin(M_PI * (2 * k + 1) / (2.0 * order));
    const double a0 = 1.0 + damping * w + w * w;
    const double b0 = w * w / a0;
    sections.push_back({b0, 2.0 * b0, b0, 2.0 * (w * w - 1.0) / a0,
                        (1.0 - damping * w + w * w) / a0});
  }
  if (order % 2 == 1) {
    const double b0 = w / (1.0 + w);
    sections.push_back({b0, b0, 0.0, (w - 1.0) / (w + 1.0), 0.0});
  }
  return sections;
}

double TwoPassCutoff(int order, double cutoff_hz, double rate_hz) {
  // Both passes: 1 / (1 + r^2n), r the ratio of analogue frequencies, is
  // 1 / sqrt(2) at r = (sqrt(2) - 1)^(1/2n).
  const double ratio = std::pow(std::sqrt(2.0) - 1.0, 0.5 / order);
  return std::atan(Prewarp(cutoff_hz, rate_hz) / ratio) * rate_hz / M_PI;
}

Samples FiltFilt(const std::vector<FilterSection>& sections,
                 const Samples& values, int padding) {
  const Eigen::Index count = values.rows();
  if (count < 2) return values;
  const Eigen::Index pad = std::min<Eigen::Index>(padding, count - 1);
  Samples filtered(count, values.cols());
  Eigen::VectorXd padded(count + 2 * pad);
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    const auto column = values.col(c);
    padded.segment(pad, count) = column;
    for (Eigen::Index k = 1; k <= pad; ++k) {
      padded(pad - k) = 2.0 * column(0) - column(k);
      padded(pad + count - 1 + k) =
          2.0 * column(count - 1) - column(count - 1 - k);
    }
    for (int pass = 0; pass < 2; ++pass) {
      RunThrough(sections, &padded);
      padded.reverseInPlace();
    }
    filtered.col(c) = padded.segment(pad, count);
  }
  return filtered;
}

double ResidualAnalysisCutoff(const ButterworthOptions& options, double rate_hz,
                              const Samples& values) {
  constexpr int kCandidates = 45;
  constexpr int kLineFrom = 25;
  ButterworthOptions tried = options;
  tried.choice = CutoffChoice::kFixed;
  std::vector<double> cutoffs;
  std::vector<double> residuals;
  for (int k = 1; k <= kCandidates; ++k) {
    tried.cutoff_hz = 0.01 * k * rate_hz;
    cutoffs.push_back(tried.cutoff_hz);
    const Samples rest = values - ZeroPhaseButterworth(tried, rate_hz, values);
    residuals.push_back(
        std::sqrt(rest.squaredNorm() / static_cast<double>(values.rows())));
  }
  double mean_x = 0.0;
  double mean_y = 0.0;
  const int count = kCandidates - kLineFrom + 1;
  for (int k = kLineFrom - 1; k < kCandidates; ++k) {
    mean_x += cutoffs[k] / count;
    mean_y += residuals[k] / count;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (int k = kLineFrom - 1; k < kCandidates; ++k) {
    xx += (cutoffs[k] - mean_x) * (cutoffs[k] - mean_x);
    xy += (cutoffs[k] - mean_x) * (residuals[k] - mean_y);
  }
  const double noise = mean_y - xy / xx * mean_x;
  for (int k = 0; k < kCandidates; ++k) {
    if (residuals[k] > noise) continue;
    if (k == 0) return cutoffs[0];
    const double share =
        (residuals[k - 1] - noise) / (residuals[k - 1] - residuals[k]);
    return cutoffs[k - 1] + share * (cutoffs[k] - cutoffs[k - 1]);
  }
  return cutoffs.back();
}

Samples ZeroPhaseButterworth(const ButterworthOptions& options, double rate_hz,
                             const Samples& values) {
  const int order = static_cast<int>(options.order);
  double cutoff_hz = options.choice == CutoffChoice::kResidualAnalysis
                         ? ResidualAnalysisCutoff(options, rate_hz, values)
                         : options.cutoff_hz;
  if (options.correct_cutoff) {
    cutoff_hz = TwoPassCutoff(order, cutoff_hz, rate_hz);
  }
  return FiltFilt(ButterworthLowPass(order, cutoff_hz, rate_hz), values,
                  3 * (order + 1));
}

}  // namespace kinegraph
