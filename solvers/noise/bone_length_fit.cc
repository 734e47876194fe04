#include "solvers/noise/bone_length_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/weighted_quantile.h"

namespace kinegraph {
namespace {

// Of chi-square with one degree of freedom.
constexpr double kUpperQuartile = 1.3233;
// Quantile 0.3 of chi-square (Wilson and Hilferty 1931): within 1 % from one
// degree of freedom on.
double LowChiSquare(int freedom) {
  constexpr double kNormal = -0.5244;  // of the standard normal at 0.3
  const double spread = 2.0 / (9.0 * freedom);
  const double root = 1.0 - spread + kNormal * std::sqrt(spread);
  return freedom * root * root * root;
}

// How right the modelled noise is: factor on its variance.
double NoiseScale(const std::vector<BoneObservation>& looks) {
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.emplace_back(look.square / LowChiSquare(look.freedom), look.freedom);
  }
  return std::max(1e-6, WeightedQuantile(std::move(values), 0.3));
}

double Length(const BoneObservation& look, double scale) {
  return look.distance_m - scale * look.added_m;
}

// What keeps the variance of exact looks above zero [m^2].
constexpr double kLeastVariance = 1e-8;

// Upper quartile of the looks' squared deviations, were the spread's variance
// `spread`.
double UpperQuartile(const std::vector<BoneObservation>& looks, double scale,
                     double length_m, double spread) {
  std::vector<double> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.push_back(Square(Length(look, scale) - length_m) /
                     (scale * look.variance_m2 + spread + kLeastVariance));
  }
  const auto at = static_cast<std::ptrdiff_t>(
      std::ceil(0.75 * static_cast<double>(values.size())) - 1.0);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<size_t>(at)];
}

// Of a bone that is much longer than the noise: length and spread in turn,
// which hardly depend on each other.
LengthFit FitMedianLength(const std::vector<BoneObservation>& looks,
                          double scale) {
  LengthFit fit;
  fit.known = true;
  double spread = 0.0;   // variance
  double missing = 0.0;  // share of the noise that looks do not show
  for (int round = 0; round < 3; ++round) {
    std::vector<WeightedValue> values;
    values.reserve(looks.size());
    for (const BoneObservation& look : looks) {
      values.emplace_back(Length(look, scale), 1.0 / (scale * look.variance_m2 +
                                                      spread + kLeastVariance));
    }
    fit.length_m = WeightedQuantile(std::move(values), 0.5);
    double low = 0.0;
    double high = 0.25;  // half a metre, squared
    const double without = UpperQuartile(looks, scale, fit.length_m, low);
    if (without <= kUpperQuartile) {
      spread = 0.0;
      missing = 1.0 - without / kUpperQuartile;
      continue;
    }
    missing = 0.0;
    constexpr int kHalvings = 30;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (UpperQuartile(looks, scale, fit.length_m, middle) > kUpperQuartile
           ? low
           : high) = middle;
    }
    spread = high;
  }
  double information = 0.0;
  for (const BoneObservation& look : looks) {
    const double variance = scale * look.variance_m2 + spread + kLeastVariance;
    fit.variances_m2.push_back(variance);
    fit.deviations.push_back((Length(look, scale) - fit.length_m) /
                             std::sqrt(variance));
    information += 1.0 / variance;
  }
  const double variance = static_cast<double>(looks.size()) / information;
  fit.noise_m2 = variance - spread;
  fit.spread_m2 = spread - missing * variance;
  return fit;
}

// Of a bone beside which the noise is not small. A look's |d|^2 - tr N has the
// variance 4 L^2 v + 2 tr N^2 around L^2, with v along the bone.
LengthFit FitSquaredLength(const std::vector<BoneObservation>& looks,
                           double scale) {
  constexpr double kFar = 4.0;  // sigmas
  std::vector<WeightedValue> values;
  values.reserve(looks.size());
  for (const BoneObservation& look : looks) {
    values.emplace_back(Square(look.distance_m) - scale * look.noise_m2, 1.0);
  }
  // From the median, which lies below the mean; a mean it has to be.
  double square_m2 = WeightedQuantile(values, 0.5);
  std::vector<double> variances_m4(looks.size());
  for (int round = 0; round < 5; ++round) {
    double information = 0.0;
    double sum = 0.0;
    for (size_t i = 0; i < looks.size(); ++i) {
      variances_m4[i] =
          4.0 * std::max(0.0, square_m2) * scale * looks[i].variance_m2 +
          2.0 * scale * scale * looks[i].noise_square_m4 +
          Square(kLeastVariance);
      const double far = kFar * std::sqrt(variances_m4[i]);
      const double seen =
          std::clamp(values[i].first, square_m2 - far, square_m2 + far);
      information += 1.0 / variances_m4[i];
      sum += seen / variances_m4[i];
    }
    square_m2 = sum / information;
  }
  LengthFit fit;
  fit.is_median = false;
  fit.length_m = std::sqrt(std::max(0.0, square_m2));
  if (!(fit.length_m > 0.0)) return fit;
  fit.known = true;
  double information = 0.0;
  for (size_t i = 0; i < looks.size(); ++i) {
    fit.variances_m2.push_back(variances_m4[i] / (4.0 * square_m2));
    fit.deviations.push_back((values[i].first - square_m2) /
                             std::sqrt(variances_m4[i]));
    information += 1.0 / fit.variances_m2.back();
  }
  fit.noise_m2 = static_cast<double>(looks.size()) / information;
  return fit;
}

// Whether the noise across the bone lengthens it by more than a twentieth: from
// there on the second order is not enough.
bool IsNoisy(const std::vector<BoneObservation>& looks, double scale) {
  constexpr double kMost = 0.1;  // tr N / L^2
  std::vector<WeightedValue> squares;
  std::vector<WeightedValue> noises;
  for (const BoneObservation& look : looks) {
    squares.emplace_back(Square(look.distance_m), 1.0);
    noises.emplace_back(scale * look.noise_m2, 1.0);
  }
  const double noise = WeightedQuantile(std::move(noises), 0.5);
  const double square = WeightedQuantile(std::move(squares), 0.5);
  return noise > kMost * (square - noise);
}

}  // namespace

LengthFit FitLength(const std::vector<BoneObservation>& looks) {
  const double scale = NoiseScale(looks);
  return IsNoisy(looks, scale) ? FitSquaredLength(looks, scale)
                               : FitMedianLength(looks, scale);
}

}  // namespace kinegraph
