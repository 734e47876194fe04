#include "solvers/noise/information.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/constants.h"
#include "core/base/median.h"

namespace kinegraph {
namespace {

struct Spectrum {
  Spectrum(const ErrorCorrelation& correlation, double frame_s)
      : share(correlation.share),
        time_s(correlation.time_s),
        phi(std::exp(-frame_s / correlation.time_s)),
        h(frame_s) {}

  double operator()(double w) const { return 1.0 - share + share * Lasting(w); }
  // Normalised spectrum of the correlated part.
  double Lasting(double w) const {
    const double angle = std::min(kPi, w * h);
    return (1.0 - phi * phi) / (1.0 + phi * phi - 2.0 * phi * std::cos(angle));
  }

  double share;
  double time_s;
  double phi;
  double h;
};

// (1 / (1 + u^4))^2: fraction of the errors' power that the smoother passes at
// u times its crossover.
double Passed(double u) {
  const double gain = 1.0 / (1.0 + u * u * u * u);
  return gain * gain;
}

// Upper end of the integrals over u.
constexpr double kEnd = 4.0;

// Knots of CovarianceFactorTable: from 1e-7 to 1e14 in process noise / variance
// [1/s^3].
constexpr double kFirstKnot = -16.0;
constexpr double kKnotsPerUnit = 8.0;
constexpr int kKnots = 388;

// Integral of `power` over u = w / w_c by the midpoint rule.
template <typename Power>
double Integral(const Power& power) {
  constexpr int kSteps = 48;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    sum += power((i + 0.5) * kEnd / kSteps) * kEnd / kSteps;
  }
  return sum;
}

// Integrals over u = w / w_c in units of R h S(w_c).
struct WhitePowers {
  double passed = Integral(Passed);  // of the errors
  // Power of the motion that is removed: (1 - H)^2 / u^4.
  double lag = Integral([](double u) { return u * u * u * u * Passed(u); });
};

// Integral over u of the passed power of the correlated errors. The power peaks
// below 1 / time_s, which may be far below the crossover, so it is integrated
// over t, with w time_s = tan t, by the midpoint rule; accurate to 1e-6 for
// crossovers below 3 / time_s, to about 1 % at 50 / time_s.
double LastingPower(const Spectrum& spectrum, double crossover) {
  constexpr int kSteps = 16;
  const double end = std::atan(kEnd * crossover * spectrum.time_s);
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double tangent = std::tan((i + 0.5) * end / kSteps);
    const double w = tangent / spectrum.time_s;
    sum +=
        Passed(w / crossover) * spectrum.Lasting(w) * (1.0 + tangent * tangent);
  }
  return sum * end / kSteps / (crossover * spectrum.time_s);
}

struct Crossover {
  double frequency = 0.0;  // rad/s
  double divisor = 1.0;
};

Crossover FindCrossover(const Spectrum& spectrum, double process_noise,
                        double variance_m2, double near = 0.0) {
  constexpr int kMostRounds = 8;
  constexpr double kSettled = 1e-5;
  Crossover at;
  if (near > 0.0) at.divisor = near;
  // Converges fast: the crossover's relative change is a quarter of the
  // divisor's.
  for (int i = 0; i < kMostRounds; ++i) {
    const double before = at.divisor;
    at.frequency = std::sqrt(
        std::sqrt(process_noise / (variance_m2 * spectrum.h * at.divisor)));
    at.divisor = std::max(1.0, spectrum(at.frequency));
    if (std::abs(at.divisor - before) < kSettled * before) break;
  }
  return at;
}

}  // namespace

double InformationDivisor(const ErrorCorrelation& correlation, double frame_s,
                          double process_noise, double variance_m2,
                          double near) {
  if (!(correlation.share > 0.0)) return 1.0;
  return FindCrossover(Spectrum(correlation, frame_s), process_noise,
                       variance_m2, near)
      .divisor;
}

double CovarianceFactor(const ErrorCorrelation& correlation, double frame_s,
                        double process_noise, double variance_m2) {
  if (!(correlation.share > 0.0)) return 1.0;
  const Spectrum spectrum(correlation, frame_s);
  const Crossover at = FindCrossover(spectrum, process_noise, variance_m2);
  static const WhitePowers white;
  const double errors_power =
      (1.0 - spectrum.share) * white.passed +
      spectrum.share * LastingPower(spectrum, at.frequency);
  return (errors_power / at.divisor + white.lag) / (white.passed + white.lag);
}

Leftover LeftOver(const ErrorCorrelation& correlation, double frame_s,
                  double process_noise, double variance_m2) {
  // The lag of white jerk has the spectrum u^2 / (1 + u^4)^2, with the same
  // integral over u as the prior's u^4 / (1 + u^4)^2; H^2 passes u^2 / (1 +
  // u^4)^4 of it.
  constexpr double kLag = 45.0 / 1536.0 * 1.4142135623730951 * kPi;
  const Spectrum spectrum(correlation, frame_s);
  const Crossover at = FindCrossover(spectrum, process_noise, variance_m2);
  const double noise = Integral([&](double u) {
    const double power = u * u * u * u;
    return Passed(u) * Passed(u) * power * power * spectrum(u * at.frequency);
  });
  // The first pass's noise is integrated over the whole band, because most of
  // it lies above the crossover.
  constexpr int kBandSteps = 96;
  double first = 0.0;
  for (int i = 0; i < kBandSteps; ++i) {
    const double w = (i + 0.5) * kPi / frame_s / kBandSteps;
    const double power = std::pow(w / at.frequency, 4.0);
    first +=
        Passed(w / at.frequency) * power * power * spectrum(w) / kBandSteps;
  }
  static const WhitePowers white;
  // Independent values per axis and frame: twice the crossover [Hz] per second.
  const double values = frame_s * at.frequency / kPi;
  return {at.divisor,
          3.0 * std::min(1.0, values),
          variance_m2 * values * noise,
          variance_m2 * values * at.divisor * kLag,
          variance_m2 * first,
          variance_m2 * values * at.divisor * white.lag};
}

CovarianceFactorTable::CovarianceFactorTable(
    const ErrorCorrelation& correlation, double frame_s)
    : correlation_(correlation), frame_s_(frame_s), knots_(kKnots) {}

const CovarianceFactorTable::Knot& CovarianceFactorTable::KnotAt(size_t i) {
  Knot& knot = knots_[i];
  if (knot.known) return knot;
  const double ratio =
      std::exp(kFirstKnot + static_cast<double>(i) / kKnotsPerUnit);
  knot.known = true;
  knot.leftover = LeftOver(correlation_, frame_s_, ratio, 1.0);
  knot.divided = knot.leftover.divisor > 1.0;
  knot.factor = CovarianceFactor(correlation_, frame_s_, ratio, 1.0);
  return knot;
}

Leftover CovarianceFactorTable::LeftoverAt(double process_noise,
                                           double variance_m2) {
  const double at =
      (std::log(process_noise / variance_m2) - kFirstKnot) * kKnotsPerUnit;
  Leftover leftover =
      KnotAt(static_cast<size_t>(std::clamp(std::round(at), 0.0, kKnots - 1.0)))
          .leftover;
  leftover.noise_m2 *= variance_m2;
  leftover.lag_m2 *= variance_m2;
  leftover.first_noise_m2 *= variance_m2;
  leftover.first_lag_m2 *= variance_m2;
  return leftover;
}

double CovarianceFactorTable::At(double process_noise, double variance_m2) {
  if (!(correlation_.share > 0.0)) return 1.0;
  const double at =
      (std::log(process_noise / variance_m2) - kFirstKnot) * kKnotsPerUnit;
  if (at >= 1.0 && at < kKnots - 2) {
    const auto i = static_cast<size_t>(at);
    const double t = at - static_cast<double>(i);
    const Knot& before = KnotAt(i - 1);
    const Knot& from = KnotAt(i);
    const Knot& to = KnotAt(i + 1);
    const Knot& after = KnotAt(i + 2);
    if (before.divided == after.divided) {  // Lagrange polynomial
      return before.factor * (-t * (t - 1.0) * (t - 2.0) / 6.0) +
             from.factor * ((t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0) +
             to.factor * (-(t + 1.0) * t * (t - 2.0) / 2.0) +
             after.factor * ((t + 1.0) * t * (t - 1.0) / 6.0);
    }
  }
  return CovarianceFactor(correlation_, frame_s_, process_noise, variance_m2);
}

double ProcessNoiseOfCrossover(const ErrorCorrelation& correlation,
                               double frame_s, double variance_m2,
                               double frequency_hz) {
  const double w = 2.0 * kPi * frequency_hz;
  const double divisor =
      correlation.share > 0.0 ? Spectrum(correlation, frame_s)(w) : 1.0;
  return w * w * w * w * variance_m2 * frame_s * std::max(1.0, divisor);
}

namespace {

using Eigen::Matrix2d;
using Eigen::Vector3d;

// Kalman filter and Rauch-Tung-Striebel smoother for positions driven by white
// noise on acceleration. The variances are the same for all axes.
class MotionSmoother {
 public:
  explicit MotionSmoother(const std::vector<LagSample>& samples)
      : steps_(samples.size()) {
    constexpr double kUnknown = 1e4;  // m^2 and (m/s)^2
    Matrix2d covariance = kUnknown * Matrix2d::Identity();
    for (size_t k = 0; k < steps_.size(); ++k) {
      const LagSample& sample = samples[k];
      Step& step = steps_[k];
      if (k > 0) {
        const double dt = sample.time_s - samples[k - 1].time_s;
        Matrix2d drive;
        drive << dt * dt / 3.0, dt / 2.0, dt / 2.0, 1.0;
        step.transition(0, 1) = dt;
        const Matrix2d filtered = covariance;
        covariance = step.transition * filtered * step.transition.transpose() +
                     sample.process_noise * dt * drive;
        steps_[k - 1].back =
            filtered * step.transition.transpose() * covariance.inverse();
      }
      if (!sample.point_m.allFinite()) continue;
      const double variance_m2 = sample.variance_m2 * sample.expected.divisor;
      step.gain = covariance.col(0) / (covariance(0, 0) + variance_m2);
      covariance -= step.gain * covariance.row(0).eval();
    }
  }

  // Smooths in place; missing values are NaN on entry.
  void Smooth(std::vector<Vector3d>* values) const {
    using Motion = Eigen::Matrix<double, 2, 3>;  // position, velocity
    std::vector<Motion> predicted, filtered;
    Motion motion = Motion::Zero();
    for (size_t k = 0; k < steps_.size(); ++k) {
      motion = steps_[k].transition * motion;
      predicted.push_back(motion);
      const Vector3d& value = (*values)[k];
      if (value.allFinite()) {
        motion += steps_[k].gain * (value.transpose() - motion.row(0)).eval();
      }
      filtered.push_back(motion);
    }
    for (size_t k = steps_.size(); k-- > 0;) {
      if (k + 1 < steps_.size()) {
        motion =
            filtered[k] + steps_[k].back * (motion - predicted[k + 1]).eval();
      }
      (*values)[k] = motion.row(0).transpose();
    }
  }

 private:
  struct Step {
    Matrix2d transition = Matrix2d::Identity();  // from the previous step
    Eigen::Vector2d gain = Eigen::Vector2d::Zero();
    Matrix2d back = Matrix2d::Zero();
  };
  std::vector<Step> steps_;
};

}  // namespace

void LagLearner::Add(const std::vector<LagSample>& samples) {
  const MotionSmoother smoother(samples);
  std::vector<Vector3d> left;
  for (const LagSample& sample : samples) left.push_back(sample.point_m);
  smoother.Smooth(&left);
  for (size_t k = 0; k < left.size(); ++k) {
    left[k] = samples[k].point_m - left[k];
  }
  const std::vector<Vector3d> first = left;
  smoother.Smooth(&left);
  // The expected values are valid only away from the ends.
  constexpr double kEndsS = 0.2;
  for (size_t k = 0; k < left.size(); ++k) {
    const LagSample& sample = samples[k];
    if (!sample.point_m.allFinite() ||
        sample.time_s < samples.front().time_s + kEndsS ||
        sample.time_s > samples.back().time_s - kEndsS) {
      continue;
    }
    const Leftover& expected = sample.expected;
    const double weight = expected.independent;
    count_ += weight;
    first_.push_back(
        static_cast<float>(first[k].squaredNorm() / expected.first_noise_m2));
    first_lag_ += weight * expected.first_lag_m2 / expected.first_noise_m2;
    left_ += weight * left[k].squaredNorm() / 3.0 / expected.lag_m2;
    left_noise_ += weight * expected.noise_m2 / expected.lag_m2;
  }
}

LagLearner::Ratios LagLearner::Fit() const {
  // Prior: this many values with the expected variances.
  constexpr double kPrior = 30.0;
  // A noise ratio above one is due to outliers or to a different correlation of
  // the errors, and carries no information about frequencies below the
  // crossover. The lag's ratio may exceed one.
  constexpr double kLeastNoise = 0.5;
  constexpr double kMostNoise = 1.0;
  constexpr double kMostLag = 4.0;
  // Median of the squared norm of three normal values. The median is used
  // because it is insensitive to outliers.
  constexpr double kMedian = 2.366;
  if (first_.empty()) return {};
  const double first =
      count_ * Median({first_.begin(), first_.end()}) / kMedian + kPrior;
  const double left = left_ + kPrior;
  // first = noise count + lag first_lag_, left = noise left_noise_ + lag count,
  // each with the prior's values on both sides.
  const double count = count_ + kPrior;
  const double noise =
      std::clamp((first * count - left * first_lag_) /
                     (count * count - first_lag_ * left_noise_),
                 kLeastNoise, kMostNoise);
  return {noise,
          std::clamp((left - noise * left_noise_) / count, 0.0, kMostLag)};
}

}  // namespace kinegraph
