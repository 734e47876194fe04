// A program outside the project: projects a point and compares the result with
// a hand-computed pixel.
#include <cmath>

#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

int main() {
  kinegraph::CameraParameters parameters;
  parameters.K << 1000, 0, 500, 0, 1000, 400, 0, 0, 1;
  const kinegraph::Camera camera(parameters);
  // 1000 * 0.2 / 2 + 500 = 600 and 1000 * -0.4 / 2 + 400 = 200.
  const auto pixel = camera.Project({0.2, -0.4, 2.0});
  const bool right = pixel && std::abs(pixel->x() - 600.0) < 1e-9 &&
                     std::abs(pixel->y() - 200.0) < 1e-9;
  return right && kinegraph::Coco17().joint_count() == 17 ? 0 : 1;
}
