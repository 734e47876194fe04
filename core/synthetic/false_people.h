// False positives of a detector.
#ifndef KINEGRAPH_CORE_SYNTHETIC_FALSE_PEOPLE_H_
#define KINEGRAPH_CORE_SYNTHETIC_FALSE_PEOPLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/synthetic/labelled_detection.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// The false positives of one view. Each is a part of a person's pose at a
// random place and size, and lives for some frames.
class FalsePeople {
 public:
  // References must outlive the object.
  FalsePeople(const NoiseOptions& options, const Scene& scene,
              const Camera& camera, int view_idx);

  // Appends those of the next frame.
  void Step(std::vector<LabelledDetection>* detections);

 private:
  using MaybePixels = std::vector<std::optional<Eigen::Vector2d>>;

  int64_t Poisson(double mean);
  void Shake(Detection* figure);
  MaybePixels SomePose();
  std::optional<Detection> Make();
  Detection Placed(const MaybePixels& joints, const std::vector<size_t>& chosen,
                   const Eigen::Vector2d& anchor);

  const NoiseOptions& options_;
  const Scene& scene_;
  const Camera& camera_;
  Random random_;
  bool started_ = false;
  std::vector<Detection> alive_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYNTHETIC_FALSE_PEOPLE_H_
