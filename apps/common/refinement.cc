#include "apps/common/refinement.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

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

Json RowsJson(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
      row.push_back(matrix(i, k));
    }
    rows.push_back(row);
  }
  return rows;
}

// What a later run needs to repeat the decision.
Json RecordJson(const RefinementRecord& record) {
  Json cameras = Json::array();
  for (const RefinementRecord::Camera& camera : record.cameras) {
    Json parameters = Json::array();
    for (const int place : camera.places) {
      parameters.push_back(kCameraParameterNames[static_cast<size_t>(place)]);
    }
    cameras.push_back(
        {{"name", camera.name},
         {"clock", {{"offset_s", camera.offset_s}, {"drift", camera.drift}}},
         {"parameters", parameters}});
  }
  return {{"clock_zero_s", record.clock_zero_s},
          {"cameras", cameras},
          {"covariance", RowsJson(record.covariance)}};
}

void AddRefinement(const Refinement& refinement, Json* json) {
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
  (*json)["steps"] = steps;
  (*json)["stretches"] = refinement.segments;
  (*json)["largest_correlation"] = refinement.largest_correlation;
  for (size_t v = 0; v < refinement.changes.size(); ++v) {
    Json& camera = (*json)["cameras"][v];
    camera["change"] = ChangeJson(refinement.changes[v]);
    camera["sigma"] = ChangeJson(refinement.sigmas[v]);
  }
}

Json GroundJson(const Ground& ground) {
  return {
      {"new_from_old", {{"R", RowsJson(ground.R)}, {"t", Vector(ground.t)}}},
      {"tilt_deg", ground.tilt_deg},
      {"feet", ground.foot_count},
      {"feet_rms_m", ground.spread_m}};
}

std::string GroundText(const ReadyRecording& recording) {
  if (recording.misses_ground) {
    return "floor: too few feet rest to tell it; the world stays as the "
           "calibration has it\n";
  }
  if (!recording.ground.has_value()) return "";
  char line[200];
  std::snprintf(line, sizeof(line),
                "floor: the world was tilted by %.1f degrees; %lld resting "
                "feet lie within %.0f mm of it\n",
                recording.ground->tilt_deg,
                static_cast<long long>(recording.ground->foot_count),
                1e3 * recording.ground->spread_m);
  return line;
}

}  // namespace

std::string RefinementJson(const ReadyRecording& recording) {
  Json json = RecordJson(recording.record.value_or(RefinementRecord()));
  if (recording.refinement.has_value())
    AddRefinement(*recording.refinement, &json);
  if (recording.ground.has_value())
    json["ground"] = GroundJson(*recording.ground);
  return DumpJson(json);
}

std::string RefinementText(const ReadyRecording& recording) {
  std::string text;
  const std::vector<RefineStep> steps = recording.refinement.has_value()
                                            ? recording.refinement->steps
                                            : std::vector<RefineStep>();
  std::string lags;
  if (recording.refinement.has_value() && recording.record.has_value()) {
    for (size_t v = 0; v < recording.refinement->lag_frames.size(); ++v) {
      const int lag = recording.refinement->lag_frames[v];
      if (lag == 0) continue;
      lags += (lags.empty() ? "" : ", ") +
              Printable(recording.record->cameras[v].name) +
              (lag > 0 ? " +" : " ") + std::to_string(lag);
    }
  }
  if (!lags.empty()) {
    text +=
        "clock, whole frames (of the first view's frame k the frame k + n): " +
        lags + "\n";
  }
  for (const RefineStep& step : steps) {
    if (step.gain.before_px == 0.0 && !step.taken) {
      text += step.what + ": left (" + step.reason + ")\n";
      continue;
    }
    char line[200];
    std::snprintf(line, sizeof(line),
                  "%s: %s, %.2f px instead of %.2f on the other half of the "
                  "recording",
                  step.what.c_str(), step.taken ? "taken" : "left",
                  step.gain.after_px, step.gain.before_px);
    text += line;
    if (!step.reason.empty()) text += " (" + step.reason + ")";
    text += "\n";
  }
  return text + GroundText(recording);
}

}  // namespace kinegraph
