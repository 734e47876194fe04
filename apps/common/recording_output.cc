#include "apps/common/recording_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/common/app.h"
#include "apps/common/table.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/detections/view_pairing.h"

namespace kinegraph {
namespace {

constexpr size_t kMaxPeopleShown = 12;
constexpr size_t kColumns = 98;

std::string CameraLines(const RecordingReport& report) {
  constexpr size_t kMostLetters = 40;
  size_t width = 4;
  for (const CameraReport& camera : report.cameras) {
    width = std::max(width, Printable(camera.view, kMostLetters).size());
  }
  std::string text =
      fmt::format("{:<{}}  matched  error, px: median    p90\n", "view", width);
  for (const CameraReport& camera : report.cameras) {
    const std::string view = Printable(camera.view, kMostLetters);
    if (camera.detections == 0) {
      text += fmt::format("{:<{}}  no person seen\n", view, width);
      continue;
    }
    text += fmt::format("{:<{}}  {:>5.0f} %            {:>6.1f} {:>6.1f}\n",
                        view, width, 100.0 * camera.matched_share(),
                        camera.median_px, camera.p90_px);
  }
  return text;
}

std::string PeopleLines(const RecordingReport& report) {
  std::string text = fmt::format(
      "{} {}, up to {} in one view (in 5 % of the frames or more)\n",
      report.people.size(),
      report.people.size() == 1 ? "identity" : "identities",
      report.most_people_in_a_view);
  std::vector<PersonReport> people = report.people;
  std::stable_sort(people.begin(), people.end(),
                   [](const PersonReport& a, const PersonReport& b) {
                     return a.frames > b.frames;
                   });
  for (size_t i = 0; i < std::min(people.size(), kMaxPeopleShown); ++i) {
    const PersonReport& person = people[i];
    std::string height = report.is_human ? "height unknown" : "";
    if (person.height_m > 0.0) {
      height = person.height_m > 0.5 ? fmt::format("{:.2f} m", person.height_m)
                                     : fmt::format("{:.2g} m", person.height_m);
    }
    text += fmt::format("  {} {:<4} {:<14}  {:>6} frames, {}..{}\n",
                        report.is_human ? "person" : "track", person.id.value(),
                        height, person.frames, person.first_frame,
                        person.last_frame);
  }
  if (people.size() > kMaxPeopleShown) {
    text += fmt::format("  and {} more\n", people.size() - kMaxPeopleShown);
  }
  return text;
}

// The pairing of views with cameras, unless it is configured or follows from
// equal names or numbers.
std::string PairingText(const RecordingReport& report) {
  if (report.paired_by < PairedBy::kWithin ||
      report.paired_by == PairedBy::kNumber) {
    return "";
  }
  std::string text = fmt::format(
      "views are paired with cameras {} "
      "(override with cameras.map): ",
      ToString(report.paired_by));
  for (const CameraReport& camera : report.cameras) {
    text += (&camera == &report.cameras.front() ? "" : ", ") +
            Printable(camera.view) + " = " + Printable(camera.camera);
  }
  return Wrapped(text, kColumns, "  ");
}

std::string TextOf(const Finding& finding) {
  return finding.camera.empty()
             ? finding.evidence
             : "view of " + finding.camera + ": " + finding.evidence;
}

// Whether a fix consists of flags or a command, not prose.
bool IsCommand(const std::string& fix) {
  return fix.rfind("--", 0) == 0 || fix.rfind("'--", 0) == 0 ||
         fix.rfind("kinegraph ", 0) == 0;
}

std::string PresenceText(const RecordingReport& report) {
  if (report.least_confidence == 0.0) return "";
  return fmt::format(
      "joints below a confidence of {:g} are unreliable and count as missing\n",
      report.least_confidence);
}

// A note for recordings with two cameras and no warning.
std::string PairText(const RecordingReport& report) {
  if (report.cameras.size() != 2 || !report.warnings.empty()) return "";
  return "note: with two cameras many calibration errors remain undetected; "
         "`kinegraph doctor` checks more.\n";
}

Json Vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json ChangeJson(const CameraChange& change) {
  return {{"rotation_deg", Vector(kDegPerRad * change.segment<3>(kRotationAt))},
          {"centre_mm", Vector(1e3 * change.segment<3>(kCentreAt))},
          {"shift_px", {change[kShiftAt], change[kShiftAt + 1]}},
          {"focal_percent", 100.0 * std::expm1(change[kFocalAt])},
          {"clock_ms", 1e3 * change[kOffsetAt]},
          {"clock_ppm", 1e6 * change[kDriftAt]}};
}

// The refinement that a later run applies without estimating it again.
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
    if (!step.left_out.has_value()) continue;
    steps.back()["left_out"] = {
        {"before_px", step.left_out->before_px},
        {"after_px", step.left_out->after_px},
        {"gain_interval_px", {step.left_out->low_px, step.left_out->high_px}}};
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
    return "floor: too few resting feet to determine it; the world "
           "remains that of the calibration\n";
  }
  if (!recording.ground.has_value()) return "";
  return fmt::format(
      "floor: the world was tilted by {:.1f} degrees; the distances of {} "
      "positions of resting feet from the floor have an RMS of {:.0f} mm\n",
      recording.ground->tilt_deg, recording.ground->foot_count,
      1e3 * recording.ground->spread_m);
}

}  // namespace

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

std::string ReportText(const RecordingReport& report) {
  if (report.poses == 0) return PairingText(report) + WarningsText(report);
  return PairingText(report) + PresenceText(report) + CameraLines(report) +
         PeopleLines(report) + WarningsText(report) + PairText(report);
}

std::string WarningsText(const RecordingReport& report) {
  std::string text;
  const std::vector<Finding>& warnings = report.warnings;
  for (size_t w = 0; w < warnings.size(); ++w) {
    const Finding& warning = warnings[w];
    text += Wrapped("warning: " + TextOf(warning) + ".", kColumns, "  ");
    // A fix shared by successive warnings is printed once.
    if (w + 1 < warnings.size() && warnings[w + 1].fix == warning.fix) continue;
    text += IsCommand(warning.fix)
                ? "try: " + warning.fix + "\n"
                : Wrapped("try: " + warning.fix + ".", kColumns, "  ");
  }
  return text;
}

std::string Flag(const std::string& name, const std::string& value) {
  if (value.empty()) return "";
  constexpr char kPlain[] =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
      "/._-+,:=@%";
  const bool is_plain = value.find_first_not_of(kPlain) == std::string::npos;
  return " --" + name + "=" + (is_plain ? value : ShellQuoted(value));
}

void NameInputs(const std::string& recording, const std::string& configuration,
                const std::string& corrected, std::vector<Finding>* findings) {
  for (Finding& finding : *findings) {
    for (const auto& [mark, flags] :
         {std::pair{std::string(kUseCorrected),
                    corrected.empty() ? corrected
                                      : Flag("cameras", corrected).substr(1)},
          {std::string(" INPUTS"), recording + configuration},
          {std::string(" RECORDING"), recording}}) {
      const size_t at = finding.fix.find(mark);
      if (at != std::string::npos) finding.fix.replace(at, mark.size(), flags);
    }
  }
}

namespace {

// Counts over all solves, successful or not, for people whose tracks have
// ended.
Json SolverJson(const RunSummary& run) {
  const SolveCounts& counts = run.solves;
  return {{"name", run.solver},
          {"solves", counts.solves},
          {"not_converged", counts.not_converged},
          {"failed", counts.not_finite},
          {"bones_dropped", counts.bones_dropped},
          {"positions_in_doubt", counts.positions_in_doubt},
          {"without_covariance", counts.no_covariance},
          {"sweep_iterations", counts.sweep_iterations},
          {"ceres_problems", counts.ceres_problems},
          {"ceres_iterations", counts.ceres_iterations}};
}

bool LearntAnything(const LearntNoise& learnt) {
  return std::any_of(learnt.classes.begin(), learnt.classes.end(),
                     [](const auto& of) { return of.joints_seen > 0; });
}

}  // namespace

std::string ReportJson(const RecordingReport& report, const RunSummary& run,
                       const LearntNoise& learnt) {
  Json json;
  json["kinegraph_summary"] = 1;
  json["frames"] = report.frames;
  json["poses"] = report.poses;
  json["frame_rate_hz"] = report.frame_rate_hz;
  json["detections_skeleton"] = report.skeleton;
  json["working_distance_m"] = report.working_distance_m;
  json["reprojection_error_px"] = {{"median", report.median_px},
                                   {"p90", report.p90_px}};
  json["most_people_in_a_view"] = report.most_people_in_a_view;
  json["height_m"] = report.height_m > 0.0 ? Json(report.height_m) : Json();
  json["paired"] = ToString(report.paired_by);
  if (report.least_confidence > 0.0) {
    json["least_confidence"] = report.least_confidence;
  }
  if (!run.subject_scale.is_one()) {
    json["subject"] = {{"size_m", run.subject_scale.size_m()},
                       {"scale", run.subject_scale.metres()}};
  }
  json["cameras"] = Json::array();
  for (const CameraReport& camera : report.cameras) {
    json["cameras"].push_back({{"view", camera.view},
                               {"camera", camera.camera},
                               {"detections", camera.detections},
                               {"matched", camera.matched},
                               {"matched_share", camera.matched_share()},
                               {"joints", camera.joints},
                               {"median_px", camera.median_px},
                               {"p90_px", camera.p90_px},
                               {"person_px", camera.person_px}});
  }
  json["people"] = Json::array();
  for (const PersonReport& person : report.people) {
    json["people"].push_back(
        {{"id", person.id.value()},
         {"frames", person.frames},
         {"first_frame", person.first_frame},
         {"last_frame", person.last_frame},
         {"height_m", person.height_m > 0.0 ? Json(person.height_m) : Json()},
         {"bone_spread", person.bone_spread},
         {"side_difference", person.side_difference}});
  }
  // Paper mode has no solves.
  if (run.solves.solves > 0) json["solver"] = SolverJson(run);
  if (LearntAnything(learnt)) {
    json["noise"] = Json::parse(ToJson(learnt));
    json["learnt"] = {ToString(learnt)};  // as a sentence
  }
  json["warnings"] = Json::array();
  for (const Finding& warning : report.warnings) {
    json["warnings"].push_back({{"kind", warning.kind},
                                {"text", TextOf(warning)},
                                {"try", warning.fix}});
  }
  // View names need not be UTF-8.
  return DumpJson(json, 1) + "\n";
}

std::string RefinementJson(const ReadyRecording& recording) {
  Json json = RecordJson(recording.record.value_or(RefinementRecord()));
  if (recording.refinement.has_value())
    AddRefinement(*recording.refinement, &json);
  if (const auto& motion = recording.world_motion) {
    json["world"] = {{"moved_mm", 1e3 * motion->moved_m},
                     {"turned_deg", motion->turned_deg},
                     {"scale", motion->scale}};
  }
  if (recording.ground.has_value())
    json["ground"] = GroundJson(*recording.ground);
  return DumpJson(json);
}

std::string RefinementJson(const RefinementRecord& record) {
  return DumpJson(RecordJson(record));
}

std::string RefinementText(const ReadyRecording& recording) {
  const Refinement refinement = recording.refinement.value_or(Refinement());
  std::vector<std::string> lags;
  for (size_t v = 0;
       recording.record.has_value() && v < refinement.lag_numbers.size(); ++v) {
    if (refinement.lag_numbers[v] == 0) continue;
    lags.push_back(fmt::format("{} {:+}",
                               Printable(recording.record->cameras[v].name),
                               refinement.lag_numbers[v]));
  }
  std::string text;
  if (!lags.empty()) {
    text += fmt::format(
        "clock offsets in frame numbers (VIEW +n: frame k of the first view "
        "corresponds to frame k + n of VIEW): {}\n",
        fmt::join(lags, ", "));
  }
  for (const RefineStep& step : refinement.steps) {
    if (step.gain.before_px == 0.0 && !step.taken) {
      text += step.what + ": rejected (" + step.reason + ")\n";
      continue;
    }
    text += fmt::format(
        "{}: {}, held-out residual {:.2f} px instead of {:.2f} px{}\n",
        step.what, step.taken ? "accepted" : "rejected", step.gain.after_px,
        step.gain.before_px,
        step.reason.empty() ? "" : " (" + step.reason + ")");
  }
  if (const auto& motion = recording.world_motion) {
    text += fmt::format(
        "the refined cameras define another world frame: mean displacement "
        "{:.1f} mm in the observed volume, rotation {:.2f} degrees, scale "
        "{:+.2f} %\n",
        1e3 * motion->moved_m, motion->turned_deg,
        100.0 * (motion->scale - 1.0));
  }
  return text + GroundText(recording);
}

}  // namespace kinegraph
