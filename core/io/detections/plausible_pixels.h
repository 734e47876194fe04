// Whether positions can be pixels. For core/io/detections alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_PLAUSIBLE_PIXELS_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_PLAUSIBLE_PIXELS_H_

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "core/data/detection.h"

namespace kinegraph {

// Finds views whose positions are shares of the image, 0 .. 1 (MediaPipe,
// OpenPose with --keypoint_scale 3) or -1 .. 1 (4). Frames are handed in as
// they are read; one position that can only be pixels settles its view.
class PlausiblePixels {
 public:
  explicit PlausiblePixels(std::vector<std::string> view_names);

  // Throws InputError without a file, naming the view, once enough people show
  // that its positions are no pixels.
  void See(const DetectionFrame& frame);
  // The same for a recording that is too short for that.
  void SeeEnd() const;

 private:
  struct View {
    std::string name;
    bool has_pixels = false;
    int64_t shares = 0;       // people who can be shares of the image
    int64_t far = 0;          // people beyond any image
    Eigen::AlignedBox2d box;  // of all positions
  };

  static void Check(const View& view, int64_t enough_people);

  std::vector<View> views_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_PLAUSIBLE_PIXELS_H_
