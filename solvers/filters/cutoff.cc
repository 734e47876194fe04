#include "solvers/filters/cutoff.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

namespace kinegraph {
namespace {

constexpr int kCandidates = 45;  // in hundredths of the rate
constexpr double kLeastOfRate = 0.01;
constexpr double kMostOfRate = 0.45;

// Squared magnitude of the discrete Fourier transform, summed over columns. The
// values are zero-padded to at least twice their number.
std::vector<double> SquaredSpectrum(const Samples& values) {
  size_t length = 2;
  while (length < 2 * static_cast<size_t>(values.rows())) length *= 2;
  std::vector<double> power(length, 0.0);
  std::vector<double> padded(length);
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> transform;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    std::fill(padded.begin(), padded.end(), 0.0);
    std::copy(values.col(c).begin(), values.col(c).end(), padded.begin());
    transform.fwd(spectrum, padded);
    for (size_t i = 0; i < length; ++i) power[i] += std::norm(spectrum[i]);
  }
  return power;
}

// Residual of each candidate.
std::vector<double> Residuals(const LowPass& low_pass, const Samples& values) {
  std::vector<double> residuals;
  for (int k = 1; k <= kCandidates; ++k) {
    const Samples rest =
        values - low_pass.filter(0.01 * k * low_pass.rate_hz, values);
    residuals.push_back(
        std::sqrt(rest.squaredNorm() / static_cast<double>(values.rows())));
  }
  return residuals;
}

// Implements kWinter. This and the following functions return the cut-off in
// hundredths of the rate.
double Winter(const std::vector<double>& residuals) {
  constexpr int kLineFrom = 25;
  double mean_x = 0.0;
  double mean_y = 0.0;
  constexpr int kCount = kCandidates - kLineFrom + 1;
  for (int k = kLineFrom; k <= kCandidates; ++k) {
    mean_x += static_cast<double>(k) / kCount;
    mean_y += residuals[k - 1] / kCount;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (int k = kLineFrom; k <= kCandidates; ++k) {
    xx += (k - mean_x) * (k - mean_x);
    xy += (k - mean_x) * (residuals[k - 1] - mean_y);
  }
  const double noise = mean_y - xy / xx * mean_x;
  for (int k = 0; k < kCandidates; ++k) {
    if (residuals[k] > noise) continue;
    if (k == 0) return 1.0;
    return k + (residuals[k - 1] - noise) / (residuals[k - 1] - residuals[k]);
  }
  return kCandidates;
}

double Jackson(const std::vector<double>& residuals) {
  constexpr double kLimit = 0.05;
  std::vector<double> bends;  // at the candidates 2, 3, ...
  for (size_t k = 1; k + 1 < residuals.size(); ++k) {
    bends.push_back(residuals[k - 1] - 2.0 * residuals[k] + residuals[k + 1]);
  }
  const auto sharpest = std::max_element(bends.begin(), bends.end());
  const auto straight = std::find_if(sharpest, bends.end(), [&](double bend) {
    return bend <= kLimit * *sharpest;
  });
  return 2.0 + static_cast<double>(straight - bends.begin());
}

double Gcv(const LowPass& low_pass, const std::vector<double>& residuals) {
  constexpr int kFrequencies = 500;
  double best = 0.0;
  double least = 0.0;
  for (int k = 1; k <= kCandidates; ++k) {
    double gain = 0.0;
    for (int i = 0; i < kFrequencies; ++i) {
      gain += low_pass.gain((i + 0.5) / (2.0 * kFrequencies) * low_pass.rate_hz,
                            0.01 * k * low_pass.rate_hz) /
              kFrequencies;
    }
    const double score = std::pow(residuals[k - 1] / (1.0 - gain), 2);
    if (k > 1 && score >= least) continue;
    best = k;
    least = score;
  }
  return best;
}

double Challis(const LowPass& low_pass, const Samples& values) {
  double best = 0.0;
  double least = 0.0;
  for (int k = 2; k <= 50; ++k) {
    const Samples rest =
        values - low_pass.filter(0.005 * k * low_pass.rate_hz, values);
    // Wiener-Khinchin theorem: the autocorrelation is the transform of the
    // power spectrum.
    const std::vector<double> power = SquaredSpectrum(rest);
    std::vector<std::complex<double>> correlation;
    const std::vector<std::complex<double>> even(power.begin(), power.end());
    Eigen::FFT<double>().fwd(correlation, even);
    double sum = 0.0;
    for (const std::complex<double>& lag : correlation) {
      sum += std::abs(lag.real()) / correlation[0].real();
    }
    if (k > 2 && !(sum < least)) continue;
    best = 0.5 * k;
    least = sum;
  }
  return best;
}

double Yu(const LowPass& low_pass, const Samples& values) {
  const double r = low_pass.rate_hz;
  const double first_hz = std::clamp(0.071 * r - 0.00003 * r * r,
                                     kLeastOfRate * r, kMostOfRate * r);
  const double rest = (values - low_pass.filter(first_hz, values)).norm();
  const double whole = (values.rowwise() - values.colwise().mean()).norm();
  if (!(rest > 0.0)) return 100.0 * kMostOfRate;
  const double percent = 100.0 * rest / whole;
  return 100.0 * (0.06 - 0.000022 * r + 5.95 / percent / r);
}

double Power(double share, const Samples& values) {
  const Eigen::Index count = values.rows();
  Eigen::VectorXd trend(count);
  Eigen::VectorXd window(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    trend(i) = static_cast<double>(i) - 0.5 * static_cast<double>(count - 1);
    window(i) = 0.5 - 0.5 * std::cos(2.0 * M_PI * static_cast<double>(i) /
                                     static_cast<double>(count));
  }
  Samples rest = values.rowwise() - values.colwise().mean();
  rest -= trend * (trend.transpose() * rest) / trend.squaredNorm();
  rest = window.asDiagonal() * rest;
  const std::vector<double> power = SquaredSpectrum(rest);
  const size_t half = power.size() / 2;
  double total = 0.0;
  for (size_t i = 0; i <= half; ++i) total += power[i];
  double sum = 0.0;
  for (size_t i = 0; i <= half; ++i) {
    sum += power[i];
    if (sum < share * total) continue;
    // Interpolates between bins; a bin holds the power up to its own frequency.
    const double over = power[i] > 0.0 ? (sum - share * total) / power[i] : 0.0;
    return 100.0 * (static_cast<double>(i) - over) /
           static_cast<double>(power.size());
  }
  return 50.0;
}

}  // namespace

double ChooseCutoff(CutoffChoice rule, const LowPass& low_pass,
                    const Samples& values) {
  constexpr Eigen::Index kFewest = 10;
  if (values.rows() < kFewest) return kMostOfRate * low_pass.rate_hz;
  const auto percent = [&] {
    switch (rule) {
      case CutoffChoice::kChallis:
        return Challis(low_pass, values);
      case CutoffChoice::kYu:
        return Yu(low_pass, values);
      case CutoffChoice::kJackson:
        return Jackson(Residuals(low_pass, values));
      case CutoffChoice::kGcv:
        return Gcv(low_pass, Residuals(low_pass, values));
      case CutoffChoice::kPower95:
        return Power(0.95, values);
      case CutoffChoice::kPower99:
        return Power(0.99, values);
      default:
        return Winter(Residuals(low_pass, values));
    }
  }();
  return std::clamp(0.01 * percent, kLeastOfRate, kMostOfRate) *
         low_pass.rate_hz;
}

std::vector<double> ChooseCutoffs(CutoffChoice rule, CutoffPer per,
                                  const LowPass& low_pass,
                                  const Samples& values) {
  const auto columns = static_cast<size_t>(values.cols());
  if (per != CutoffPer::kAxis) {
    return std::vector<double>(columns, ChooseCutoff(rule, low_pass, values));
  }
  std::vector<double> cutoffs_hz;
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    cutoffs_hz.push_back(ChooseCutoff(rule, low_pass, values.col(c)));
  }
  return cutoffs_hz;
}

}  // namespace kinegraph
