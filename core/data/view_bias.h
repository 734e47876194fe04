// The detector's bias of each joint as a function of the camera's direction
// around the body: the coefficients that are learned and stored in files. For
// their meaning see solvers/noise/bias_model.h.
#ifndef KINEGRAPH_CORE_DATA_VIEW_BIAS_H_
#define KINEGRAPH_CORE_DATA_VIEW_BIAS_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph {

// Features of the viewing direction: 1, sine and cosine of three harmonics of
// the azimuth, the elevation, and its products with the first harmonic.
inline constexpr int kViewFeatureCount = 10;
using ViewCoefficients = std::array<double, kViewFeatureCount>;

struct ViewBias {
  // Left and right partners share an entry.
  struct OfJoint {
    std::string joint;  // without "l_" and "r_"
    // Coefficients of the bias across and along the image of the trunk or, for
    // joints of the head, of the head [m], at the joint's depth.
    ViewCoefficients across_m{};
    ViewCoefficients along_m{};
    bool used = false;  // false: the bias is taken as zero
    // Number of residuals used to learn it, one per frame, view and joint.
    int64_t observations = 0;
    // Cross-validated share of the squared residuals explained: those of each
    // half of the recording by coefficients learned from the other half. Its
    // standard error is over segments of time.
    double gain = 0.0;
    double gain_error = 0.0;
  };
  std::vector<OfJoint> joints;
  // Range of azimuths [degrees] from which a camera has seen people: the median
  // over the cameras.
  double azimuth_deg = 0.0;

  bool empty() const {
    return std::none_of(joints.begin(), joints.end(),
                        [](const OfJoint& joint) { return joint.used; });
  }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_VIEW_BIAS_H_
