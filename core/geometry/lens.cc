#include "core/geometry/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/constants.h"
#include "core/base/error.h"

namespace kinegraph {
namespace {

// Root by bisection; `slope` is positive at `low` and not at `high`.
template <typename Slope>
double WhereZero(const Slope& slope, double low, double high) {
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0.0 ? low : high) = middle;
  }
  return low;
}

// Smallest s = r^2 > 0 where d(r + k1 r^3 + k2 r^5 + k3 r^7)/dr = 1 + 3 k1 s +
// 5 k2 s^2 + 7 k3 s^3 falls to zero; beyond it the radial model folds back.
// Scans outwards, then bisects; infinite when it does not fold within r^2 = 100
// (84 degrees off the axis).
double FirstFold(double k1, double k2, double k3) {
  const auto slope = [&](double s) {
    return 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3));
  };
  constexpr double kEnd = 100.0;
  double low = 0.0;
  for (double high = 1e-3; high < kEnd; high *= 1.02) {
    if (slope(high) <= 0.0) return WhereZero(slope, low, high);
    low = high;
  }
  return std::numeric_limits<double>::infinity();
}

void CheckFinite(const double* coefficients, size_t count) {
  const bool finite = std::all_of(coefficients, coefficients + count,
                                  [](double k) { return std::isfinite(k); });
  if (!finite) {
    throw OptionError("distortion", "a coefficient is not a finite number");
  }
}

// r' and d r' / d a of a fisheye lens at the angle a [rad] off the axis.
struct FisheyeRadius {
  double radius = 0.0;
  double slope = 0.0;
};
FisheyeRadius RadiusAt(const LensModel& lens, double angle) {
  const double s = angle * angle;
  return {
      angle *
          (1.0 + s * (lens.k1 + s * (lens.k2 + s * (lens.k3 + s * lens.k4)))),
      1.0 +
          s * (3.0 * lens.k1 +
               s * (5.0 * lens.k2 + s * (7.0 * lens.k3 + s * 9.0 * lens.k4)))};
}

// The smallest angle [rad] at which the slope falls to zero, 90 degrees if it
// does not.
double FirstFisheyeFold(const LensModel& lens) {
  constexpr double kRightAngle = 0.5 * kPi;
  constexpr int kSteps = 2000;
  const auto slope = [&](double angle) { return RadiusAt(lens, angle).slope; };
  double low = 0.0;
  for (int i = 1; i <= kSteps; ++i) {
    const double high = kRightAngle * i / kSteps;
    if (slope(high) <= 0.0) return WhereZero(slope, low, high);
    low = high;
  }
  return kRightAngle;
}

}  // namespace

Eigen::Vector2d Lens::Distort(const Eigen::Vector2d& ideal,
                              Eigen::Matrix2d* jacobian) const {
  Eigen::Vector2d distorted;
  double symmetric[3];
  kinegraph::Distort(plain_, ideal.x(), ideal.y(), &distorted.x(),
                     &distorted.y(), jacobian == nullptr ? nullptr : symmetric);
  if (jacobian != nullptr) {
    *jacobian << symmetric[0], symmetric[1], symmetric[1], symmetric[2];
  }
  return distorted;
}

bool Lens::InDomain(const Eigen::Vector2d& ideal) const {
  return kinegraph::InDomain(plain_, ideal.x(), ideal.y());
}

OpenCv5Lens::OpenCv5Lens(const std::array<double, 5>& coefficients) {
  CheckFinite(coefficients.data(), coefficients.size());
  const auto& [k1, k2, p1, p2, k3] = coefficients;
  // One-to-one up to the first radius where d r' / d r = 0.
  plain_ = {LensKind::kOpenCv5, k1, k2, p1, p2, k3, 0.0, FirstFold(k1, k2, k3)};
}

std::vector<double> OpenCv5Lens::parameters() const {
  return {plain_.k1, plain_.k2, plain_.p1, plain_.p2, plain_.k3};
}

std::optional<Eigen::Vector2d> OpenCv5Lens::Undistort(
    const Eigen::Vector2d& distorted) const {
  // Newton's method, damped so that no step leaves the one-to-one region, from
  // a start inside it: at its edge the radial part is singular.
  Eigen::Vector2d ideal = distorted;
  const double limit = 0.98 * plain_.max_radius_squared;
  if (ideal.squaredNorm() > limit) {
    ideal *= std::sqrt(limit / ideal.squaredNorm());
  }
  constexpr int kMaxIterations = 50;
  // In normalised units: 1e-13 is far below a millionth of a pixel, and above
  // rounding error for |x| of order one.
  const double tolerance = 1e-13 * (1.0 + distorted.norm());
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d error = Distort(ideal, &jacobian) - distorted;
    if (error.norm() <= tolerance) return ideal;
    const double determinant = jacobian.determinant();
    if (!(std::abs(determinant) > 1e-12)) return std::nullopt;
    Eigen::Vector2d step = jacobian.inverse() * error;
    while ((ideal - step).squaredNorm() > plain_.max_radius_squared &&
           step.norm() > tolerance) {
      step *= 0.5;
    }
    ideal -= step;
  }
  const double error = (Distort(ideal, nullptr) - distorted).norm();
  // Where Newton's method did not converge to rounding, accept an error of a
  // ten-thousandth of a pixel (at a focal length of about 1000 px).
  return error < 1e-7 ? std::optional<Eigen::Vector2d>(ideal) : std::nullopt;
}

FisheyeLens::FisheyeLens(const std::array<double, 4>& coefficients) {
  CheckFinite(coefficients.data(), coefficients.size());
  const auto& [k1, k2, k3, k4] = coefficients;
  plain_ = {LensKind::kFisheye, k1, k2, 0.0, 0.0, k3, k4, 0.0};
  max_angle_ = FirstFisheyeFold(plain_);
  const double radius = std::tan(max_angle_);
  plain_.max_radius_squared = radius * radius;
}

std::vector<double> FisheyeLens::parameters() const {
  return {plain_.k1, plain_.k2, plain_.k3, plain_.k4};
}

std::optional<Eigen::Vector2d> FisheyeLens::Undistort(
    const Eigen::Vector2d& distorted) const {
  const double radius = distorted.norm();
  if (!(radius < RadiusAt(plain_, max_angle_).radius)) return std::nullopt;
  // The radius grows with the angle up to max_angle_: Newton's method, with
  // bisection where a step would leave the bracket.
  double low = 0.0;
  double high = max_angle_;
  double angle = std::min(radius, 0.5 * max_angle_);
  constexpr int kMaxIterations = 100;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const FisheyeRadius at = RadiusAt(plain_, angle);
    const double error = at.radius - radius;
    (error > 0.0 ? high : low) = angle;
    double next = angle - error / at.slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    // The resolution of doubles of order one.
    const bool settled = std::abs(next - angle) <= 4e-16 || error == 0.0;
    angle = error == 0.0 ? angle : next;
    if (settled) break;
  }
  if (!(radius > 0.0)) return distorted;
  return distorted * (std::tan(angle) / radius);
}

double FirstRadialFactor(const Lens* lens, const Eigen::Vector2d& ideal,
                         Eigen::Matrix2d* jacobian) {
  const double r2 = ideal.squaredNorm();
  double factor = r2;
  double slope = 2.0;  // d factor / d r, over r
  // At smaller radii both models agree to rounding.
  if (lens != nullptr && lens->plain().kind == LensKind::kFisheye &&
      r2 > 1e-16) {
    const double r = std::sqrt(r2);
    const double angle = std::atan(r);
    const double square = angle * angle;
    factor = angle * square / r;
    slope = (3.0 * square / (1.0 + r2) - factor) / r2;
  }
  if (jacobian != nullptr) {
    *jacobian = factor * Eigen::Matrix2d::Identity() +
                slope * ideal * ideal.transpose();
  }
  return factor;
}

std::shared_ptr<const Lens> WithRadial(const std::shared_ptr<const Lens>& lens,
                                       double added) {
  std::vector<double> terms(5, 0.0);
  if (lens != nullptr) terms = lens->parameters();
  terms[0] += added;
  return MakeLens(lens == nullptr ? "opencv5" : lens->model(), terms);
}

std::shared_ptr<const Lens> Turned(const std::shared_ptr<const Lens>& lens,
                                   ImageTurn turn) {
  if (lens == nullptr || lens->plain().kind != LensKind::kOpenCv5) return lens;
  std::vector<double> terms = lens->parameters();
  const double p1 = terms[2];
  const double p2 = terms[3];
  if (turn == ImageTurn::kHalf) {
    terms[2] = -p1;
    terms[3] = -p2;
  } else {
    const bool clockwise = turn == ImageTurn::kClockwise;
    terms[2] = clockwise ? p2 : -p2;
    terms[3] = clockwise ? -p1 : p1;
  }
  return MakeLens(lens->model(), terms);
}

std::shared_ptr<const Lens> MakeLens(const std::string& model,
                                     const std::vector<double>& parameters) {
  const bool all_zero = std::all_of(parameters.begin(), parameters.end(),
                                    [](double k) { return k == 0.0; });
  if (model == "pinhole") {
    if (all_zero) return nullptr;
    throw OptionError("distortion",
                      "found coefficients of a pinhole, expected none, or the "
                      "model opencv5 or opencv_fisheye");
  }
  const size_t count = parameters.size();
  if (model == kFisheyeModel) {
    std::array<double, 4> coefficients{};
    if (count > coefficients.size()) {
      throw OptionError("distortion",
                        "found " + std::to_string(count) +
                            " coefficients of a fisheye lens, expected at "
                            "most 4 (k1 k2 k3 k4)");
    }
    std::copy(parameters.begin(), parameters.end(), coefficients.begin());
    return std::make_shared<FisheyeLens>(coefficients);
  }
  if (model != "opencv5") {
    throw OptionError("model",
                      "found '" + Printable(model) +
                          "', expected pinhole, opencv5 or opencv_fisheye");
  }
  if (count != 0 && count != 2 && count != 4 && count != 5) {
    throw OptionError("distortion", "found " + std::to_string(count) +
                                        " coefficients, expected 0, 2, 4 or "
                                        "5 (k1 k2 p1 p2 k3)");
  }
  std::array<double, 5> coefficients{};
  std::copy(parameters.begin(), parameters.end(), coefficients.begin());
  auto lens = std::make_shared<OpenCv5Lens>(coefficients);
  if (all_zero) return nullptr;
  return lens;
}

}  // namespace kinegraph
