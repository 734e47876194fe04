// What a detector adds to the joints that it shows, by where the camera stands
// around the body: the value, as it is learnt and kept in files. What it means
// is in solvers/noise/bias_model.h.
#ifndef KINEGRAPH_CORE_DATA_VIEW_BIAS_H_
#define KINEGRAPH_CORE_DATA_VIEW_BIAS_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph {

// Features of the viewing direction: 1, three harmonics of the azimuth, the
// elevation and its product with the first.
inline constexpr int kViewFeatureCount = 10;
using ViewCoefficients = std::array<double, kViewFeatureCount>;

struct ViewBias {
  // Left and right partners share a line.
  struct OfJoint {
    std::string joint;  // without "l_" and "r_"
    ViewCoefficients across_m{};
    ViewCoefficients along_m{};
    bool used = false;  // else the coefficients count as zero
    // Joints of single frames and views that told them.
    int64_t observations = 0;
    // Share of the squared residuals that coefficients of one half of the
    // recording explain in the other, and its standard error over stretches of
    // time.
    double gain = 0.0;
    double gain_error = 0.0;
  };
  std::vector<OfJoint> joints;
  // Least azimuth that most cameras have seen people from [degrees].
  double azimuth_deg = 0.0;

  bool empty() const {
    for (const OfJoint& joint : joints) {
      if (joint.used) return false;
    }
    return true;
  }
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_VIEW_BIAS_H_
