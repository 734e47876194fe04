#include "apps/common/refinement.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace kinegraph {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 57.29577951308232;  // a radian

Json Vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ChangeJson(const CameraChange& change) {
  return {{"rotation_deg", Vector(kDegrees * change.segment<3>(kRotationAt))},
          {"centre_mm", Vector(1e3 * change.segment<3>(kCentreAt))},
          {"shift_px", {change[kShiftAt], change[kShiftAt + 1]}},
          {"focal_percent", 100.0 * std::expm1(change[kFocalAt])},
          {"clock_ms", 1e3 * change[kOffsetAt]},
          {"clock_ppm", 1e6 * change[kDriftAt]}};
}

}  // namespace

std::string RefinementJson(const RefinedTake& take) {
  const Refinement& refinement = take.refinement;
  Json steps = Json::array();
  for (const RefineStep& step : refinement.steps) {
    steps.push_back(
        {{"what", step.what},
         {"taken", step.taken},
         {"reason", step.reason},
         {"before_px", step.gain.before_px},
         {"after_px", step.gain.after_px},
         {"gain_interval_px", {step.gain.low_px, step.gain.high_px}}});
  }
  Json cameras = Json::array();
  for (size_t v = 0; v < take.stated.size(); ++v) {
    cameras.push_back({{"name", take.stated[v].name()},
                       {"change", ChangeJson(refinement.changes[v])},
                       {"sigma", ChangeJson(refinement.sigmas[v])},
                       {"clock",
                        {{"offset_s", take.record.cameras[v].offset_s},
                         {"drift", take.record.cameras[v].drift}}}});
  }
  const Json json = {{"steps", steps},
                     {"stretches", refinement.stretches},
                     {"largest_correlation", refinement.largest_correlation},
                     {"clock_zero_s", take.record.clock_zero_s},
                     {"cameras", cameras}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string RefinementText(const RefinedTake& take) {
  std::string text;
  for (const RefineStep& step : take.refinement.steps) {
    char line[200];
    std::snprintf(line, sizeof(line),
                  "%s: %s, %.2f px instead of %.2f on the other half of the "
                  "take",
                  step.what.c_str(), step.taken ? "taken" : "left",
                  step.gain.after_px, step.gain.before_px);
    text += line;
    if (!step.reason.empty()) text += " (" + step.reason + ")";
    text += "\n";
  }
  return text;
}

}  // namespace kinegraph
