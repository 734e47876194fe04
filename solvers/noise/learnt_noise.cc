#include "solvers/noise/learnt_noise.h"

#include <fmt/format.h>

namespace kinegraph {

std::string ToString(const LearntNoise& learnt) {
  std::string line = fmt::format(
      "errors are correlated over {:.2g} s (share {:.2g}), grow with "
      "confidence^-{:.2g}",
      learnt.correlation.time_s, learnt.correlation.share,
      learnt.confidence_power);
  for (int c = 0; c < kJointClassCount; ++c) {
    const LearntNoise::OfClass& one = learnt.classes[c];
    if (one.joints_seen == 0) continue;
    line += fmt::format("; {} {:.2g} px, {:.2g} ({:.2g} .. {:.2g}) m^2/s^3",
                        ToString(static_cast<JointClass>(c)), one.sigma_px,
                        one.process_noise, one.least_process_noise,
                        one.greatest_process_noise);
  }
  return line;
}

std::string ToJson(const LearntNoise& learnt) {
  std::string classes;
  for (int c = 0; c < kJointClassCount; ++c) {
    const LearntNoise::OfClass& one = learnt.classes[c];
    if (one.joints_seen == 0) continue;
    classes += fmt::format(
        R"({}"{}": {{"joints_seen": {}, "sigma_px": {:.6g}, )"
        R"("process_noise": {:.6g}, "least_process_noise": {:.6g}, )"
        R"("greatest_process_noise": {:.6g}}})",
        classes.empty() ? "" : ", ", ToString(static_cast<JointClass>(c)),
        one.joints_seen, one.sigma_px, one.process_noise,
        one.least_process_noise, one.greatest_process_noise);
  }
  return fmt::format(R"({{"error_time_s": {:.6g}, "error_share": {:.6g}, )"
                     R"("confidence_power": {:.6g}, "classes": {{{}}}}})",
                     learnt.correlation.time_s, learnt.correlation.share,
                     learnt.confidence_power, classes);
}

}  // namespace kinegraph
