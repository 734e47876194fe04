#include "core/geometry/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// Smallest s = r^2 > 0 where d(r + k1 r^3 + k2 r^5 + k3 r^7)/dr
// = 1 + 3 k1 s + 5 k2 s^2 + 7 k3 s^3 falls to zero. Beyond it the radial model
// folds back. Scans outwards and bisects; infinite when it never folds within
// r^2 = 100 (84 degrees off the axis).
double FirstFold(double k1, double k2, double k3) {
  const auto slope = [&](double s) {
    return 1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3));
  };
  constexpr double kEnd = 100.0;
  double low = 0.0;
  for (double high = 1e-3; high < kEnd; high *= 1.02) {
    if (slope(high) <= 0.0) {
      for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (low + high);
        (slope(middle) > 0.0 ? low : high) = middle;
      }
      return low;
    }
    low = high;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

OpenCv5Lens::OpenCv5Lens(const std::array<double, 5>& coefficients)
    : k_(coefficients) {
  for (const double k : k_) {
    if (!std::isfinite(k)) {
      throw OptionError("distortion", "a coefficient is not a finite number");
    }
  }
  plain_.kind = LensKind::kOpenCv5;
  plain_.k1 = k_[0];
  plain_.k2 = k_[1];
  plain_.p1 = k_[2];
  plain_.p2 = k_[3];
  plain_.k3 = k_[4];
  // First radius where d r' / d r = 0.
  plain_.max_radius_squared = FirstFold(k_[0], k_[1], k_[4]);
}

std::vector<double> OpenCv5Lens::parameters() const {
  return {k_.begin(), k_.end()};
}

Eigen::Vector2d OpenCv5Lens::Distort(const Eigen::Vector2d& ideal,
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

std::optional<Eigen::Vector2d> OpenCv5Lens::Undistort(
    const Eigen::Vector2d& distorted) const {
  // Newton's method, damped so that no step leaves the one-to-one region.
  Eigen::Vector2d ideal = distorted;
  const double limit = 0.98 * plain_.max_radius_squared;
  if (ideal.squaredNorm() > limit) {
    ideal *= std::sqrt(limit / ideal.squaredNorm());
  }
  constexpr int kMaxIterations = 50;
  // Normalised units: 1e-13 is far below a millionth of a pixel, and above
  // rounding for points with |x| of order one.
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
  // A point that Newton could not settle to rounding but that is right to a
  // ten-thousandth of a pixel (focal length about 1000 px) is good enough.
  return error < 1e-7 ? std::optional<Eigen::Vector2d>(ideal) : std::nullopt;
}

bool OpenCv5Lens::InDomain(const Eigen::Vector2d& ideal) const {
  return kinegraph::InDomain(plain_, ideal.x(), ideal.y());
}

std::shared_ptr<const Lens> MakeLens(const std::string& model,
                                     const std::vector<double>& parameters) {
  if (model == "pinhole") return nullptr;
  if (model != "opencv5") {
    throw OptionError("model", "found '" + Printable(model) +
                                   "', known are pinhole and opencv5");
  }
  const size_t count = parameters.size();
  if (count != 0 && count != 2 && count != 4 && count != 5) {
    throw OptionError("distortion", "found " + std::to_string(count) +
                                        " coefficients, expected 0, 2, 4 or "
                                        "5 (k1 k2 p1 p2 k3)");
  }
  std::array<double, 5> coefficients{};
  std::copy(parameters.begin(), parameters.end(), coefficients.begin());
  auto lens = std::make_shared<OpenCv5Lens>(coefficients);
  const bool all_zero = std::all_of(coefficients.begin(), coefficients.end(),
                                    [](double k) { return k == 0.0; });
  if (all_zero) return nullptr;
  return lens;
}

}  // namespace kinegraph
