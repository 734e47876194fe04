// Lens models: how a ray's ideal image point is displaced.
#ifndef KINEGRAPH_CORE_GEOMETRY_LENS_H_
#define KINEGRAPH_CORE_GEOMETRY_LENS_H_

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/projection.h"

namespace kinegraph {

// Works on normalised coordinates x/z, y/z of the camera frame (dimensionless).
// Another model joins by deriving from this class and naming itself in
// MakeLens, with its formula in projection.h.
class Lens {
 public:
  virtual ~Lens() = default;
  virtual std::string model() const = 0;
  virtual std::vector<double> parameters() const = 0;
  // The same as plain numbers.
  virtual const LensModel& plain() const = 0;

  // Distorted point of an ideal one. `jacobian`, if not null, receives
  // d distorted / d ideal (2x2).
  virtual Eigen::Vector2d Distort(const Eigen::Vector2d& ideal,
                                  Eigen::Matrix2d* jacobian) const = 0;
  // Ideal point of a distorted one; nullopt where the model cannot be
  // inverted (outside the region in which it is one-to-one).
  virtual std::optional<Eigen::Vector2d> Undistort(
      const Eigen::Vector2d& distorted) const = 0;
  // Whether the model is one-to-one at this ideal point. Points outside do not
  // reach the image although the polynomial gives them a place.
  virtual bool InDomain(const Eigen::Vector2d& ideal) const = 0;
};

// OpenCV's five coefficients k1 k2 p1 p2 k3 (radial and tangential, Brown);
// the formula stands at Distort in projection.h.
class OpenCv5Lens final : public Lens {
 public:
  // Throws OptionError for a coefficient that is not finite.
  explicit OpenCv5Lens(const std::array<double, 5>& coefficients);

  std::string model() const override { return "opencv5"; }
  std::vector<double> parameters() const override;
  const LensModel& plain() const override { return plain_; }
  Eigen::Vector2d Distort(const Eigen::Vector2d& ideal,
                          Eigen::Matrix2d* jacobian) const override;
  std::optional<Eigen::Vector2d> Undistort(
      const Eigen::Vector2d& distorted) const override;
  bool InDomain(const Eigen::Vector2d& ideal) const override;

 private:
  std::array<double, 5> k_;
  LensModel plain_;
};

// nullptr (an ideal pinhole) for "pinhole" or all-zero coefficients. Throws
// OptionError for an unknown model or a wrong number of parameters; "opencv5"
// takes 0, 2, 4 or 5.
std::shared_ptr<const Lens> MakeLens(const std::string& model,
                                     const std::vector<double>& parameters);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_LENS_H_
