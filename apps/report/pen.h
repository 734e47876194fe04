// Lines, discs and numbers in a picture, with soft edges.
#ifndef KINEGRAPH_APPS_REPORT_PEN_H_
#define KINEGRAPH_APPS_REPORT_PEN_H_

#include <Eigen/Core>
#include <cstdint>

#include "apps/report/picture.h"

namespace kinegraph {

struct Stroke {
  Colour colour;
  double width_px = 1.0;
  double opacity = 1.0;
};

// What lies outside of the picture is left out.
class Pen {
 public:
  explicit Pen(Picture* picture) : picture_(*picture) {}

  // With round ends. Coordinates are pixels, (0, 0) the middle of the first.
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
            const Stroke& stroke);
  void Disc(const Eigen::Vector2d& middle, double radius_px, Colour colour);
  // The digits of `number`, `height_px` high, its lower left corner at `at`, on
  // a ground of its own.
  void Number(int64_t number, const Eigen::Vector2d& at, double height_px,
              Colour colour, Colour ground);

 private:
  void Blend(int x, int y, Colour colour, double share);
  void Box(double left, double top, double right, double bottom, Colour colour);

  Picture& picture_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_PEN_H_
