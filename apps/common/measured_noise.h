// A modelled detector with parameters measured on a real one.
#ifndef KINEGRAPH_APPS_COMMON_MEASURED_NOISE_H_
#define KINEGRAPH_APPS_COMMON_MEASURED_NOISE_H_

#include <string>

#include "core/base/options.h"
#include "core/synthetic/noise.h"

namespace kinegraph {

// Table [noise.model]: measured parameters instead of the joints' own keys,
// each kind scaled by a factor.
struct NoiseModelOptions {
  std::string file;  // relative to the configuration's folder; empty: none
  double noise = 1.0;
  double floor_px = 0.0;
  double outliers = 1.0;
  double missing = 1.0;
  double missed = 1.0;
  double swaps = 1.0;
  double false_people = 1.0;
  double fragments = 1.0;

  void Describe(OptionVisitor& visitor);
};

// Reads the model `path` and replaces the joints' own parameters in `noise`.
// `focal_px`: of the scene's cameras. Throws InputError naming the file.
void ApplyNoiseModel(const std::string& path, const NoiseModelOptions& options,
                     double focal_px, NoiseOptions* noise);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_MEASURED_NOISE_H_
