#include "solvers/noise/learnt_noise.h"

#include <locale>
#include <sstream>

namespace kinegraph {

std::string ToString(const LearntNoise& learnt) {
  std::ostringstream line;
  line.precision(2);
  line << "errors last " << learnt.correlation.time_s << " s (share "
       << learnt.correlation.share << "), grow with confidence^-"
       << learnt.confidence_power;
  for (int c = 0; c < kJointClassCount; ++c) {
    const LearntNoise::OfClass& of_class = learnt.classes[c];
    if (of_class.joints_seen == 0) continue;
    line << "; " << ToString(static_cast<JointClass>(c)) << " "
         << of_class.sigma_px << " px, " << of_class.process_noise << " ("
         << of_class.least_process_noise << " .. "
         << of_class.greatest_process_noise << ") m^2/s^3";
  }
  return line.str();
}

std::string ToJson(const LearntNoise& learnt) {
  std::ostringstream json;
  json.imbue(std::locale::classic());
  json.precision(6);
  json << "{\"error_time_s\": " << learnt.correlation.time_s
       << ", \"error_share\": " << learnt.correlation.share
       << ", \"confidence_power\": " << learnt.confidence_power
       << ", \"classes\": {";
  bool first = true;
  for (int c = 0; c < kJointClassCount; ++c) {
    const LearntNoise::OfClass& one = learnt.classes[c];
    if (one.joints_seen == 0) continue;
    json << (first ? "" : ", ") << "\"" << ToString(static_cast<JointClass>(c))
         << "\": {\"joints_seen\": " << one.joints_seen
         << ", \"sigma_px\": " << one.sigma_px
         << ", \"process_noise\": " << one.process_noise
         << ", \"least_process_noise\": " << one.least_process_noise
         << ", \"greatest_process_noise\": " << one.greatest_process_noise
         << "}";
    first = false;
  }
  json << "}}";
  return json.str();
}

}  // namespace kinegraph
