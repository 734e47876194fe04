// Lens models.
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
// To add a model, derive from this class, name it in MakeLens and add its
// formula to projection.h.
class Lens {
 public:
  virtual ~Lens() = default;

  virtual std::string model() const = 0;
  virtual std::vector<double> parameters() const = 0;
  // The lens as plain numbers.
  const LensModel& plain() const { return plain_; }

  // The distorted point of an ideal point. `jacobian`, if not null, receives d
  // distorted / d ideal (2x2).
  Eigen::Vector2d Distort(const Eigen::Vector2d& ideal,
                          Eigen::Matrix2d* jacobian) const;
  // The ideal point of a distorted point; nullopt where the model cannot be
  // inverted (outside the region in which it is one-to-one).
  virtual std::optional<Eigen::Vector2d> Undistort(
      const Eigen::Vector2d& distorted) const = 0;
  // Whether the model is one-to-one at this ideal point. Points outside do not
  // reach the image although the polynomial has a value there.
  bool InDomain(const Eigen::Vector2d& ideal) const;

 protected:
  LensModel plain_;
};

// OpenCV's five coefficients k1 k2 p1 p2 k3 (radial and tangential, Brown); for
// the formula see DistortOpenCv5 in projection.h.
class OpenCv5Lens final : public Lens {
 public:
  // Throws OptionError for a coefficient that is not finite.
  explicit OpenCv5Lens(const std::array<double, 5>& coefficients);

  std::string model() const override { return "opencv5"; }
  std::vector<double> parameters() const override;
  std::optional<Eigen::Vector2d> Undistort(
      const Eigen::Vector2d& distorted) const override;
};

inline constexpr const char* kFisheyeModel = "opencv_fisheye";

// OpenCV's fisheye model with k1 k2 k3 k4 (Kannala and Brandt); for the formula
// see DistortFisheye in projection.h. Like every lens here it works on x/z, y/z
// and so is limited to rays less than 90 degrees off the axis: pixels further
// out have no ideal point, and points beside or behind the camera have no
// image. It is one-to-one up to 90 degrees, or to the angle at which its
// polynomial folds back if that is smaller.
class FisheyeLens final : public Lens {
 public:
  // Throws OptionError for a coefficient that is not finite.
  explicit FisheyeLens(const std::array<double, 4>& coefficients);

  std::string model() const override { return kFisheyeModel; }
  std::vector<double> parameters() const override;
  std::optional<Eigen::Vector2d> Undistort(
      const Eigen::Vector2d& distorted) const override;

 private:
  double max_angle_ = 0.0;  // [rad] off the axis
};

// nullptr (an ideal pinhole) for "pinhole" and "opencv5" with only zeros; a
// fisheye lens of zeros is no pinhole. Throws OptionError for an unknown model
// or wrong parameters: "pinhole" takes only zeros, "opencv5" 0, 2, 4 or 5
// finite numbers, "opencv_fisheye" up to 4.
std::shared_ptr<const Lens> MakeLens(const std::string& model,
                                     const std::vector<double>& parameters);

// The factor f of the term k1 f (x, y) in the distorted point of the ideal
// point (x, y): r^2, or a^3 / r with a = atan(r) for a fisheye lens. Null is a
// pinhole, whose k1 is the first of OpenCV's five coefficients. `jacobian`, if
// not null, receives the derivative of f (x, y) by (x, y).
double FirstRadialFactor(const Lens* lens, const Eigen::Vector2d& ideal,
                         Eigen::Matrix2d* jacobian);
// The lens (null: a pinhole) with `added` added to its k1.
std::shared_ptr<const Lens> WithRadial(const std::shared_ptr<const Lens>& lens,
                                       double added);
// The lens of an image rotated by 180 degrees, or by 90 degrees clockwise or
// counterclockwise: the tangential coefficients rotate with it.
enum class ImageTurn { kHalf, kClockwise, kCounterClockwise };
std::shared_ptr<const Lens> Turned(const std::shared_ptr<const Lens>& lens,
                                   ImageTurn turn);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_GEOMETRY_LENS_H_
