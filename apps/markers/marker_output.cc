#include "apps/markers/marker_output.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/plot.h"
#include "apps/common/table.h"
#include "apps/markers/marker_plots.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {
namespace {

constexpr double kMm = 1000.0;  // and ms, of metres and seconds

std::string BaseName(const std::string& path) {
  return path.substr(path.find_last_of('/') + 1);
}

// ---- JSON -------------------------------------------------------------------

Json Three(const Eigen::Vector3d& vector, double factor) {
  return {factor * vector.x(), factor * vector.y(), factor * vector.z()};
}

// NaN is null.
void AddCalibration(const Calibration& calibration, const std::string& before,
                    Json* json) {
  (*json)[before + "coverage_50"] = calibration.Covered(0.50);
  (*json)[before + "coverage_80"] = calibration.Covered(0.80);
  (*json)[before + "coverage_95"] = calibration.Covered(0.95);
  (*json)[before + "ece"] = calibration.ExpectedCalibrationError();
  (*json)[before + "log_score"] = calibration.LogScore();
}

Json ToJson(const JointAgreement& joint) {
  Json json = {
      {"n", joint.count},
      {"median_mm", kMm * joint.median_m},
      {"median_interval_mm",
       {kMm * joint.median_interval.low, kMm * joint.median_interval.high}},
      {"mean_mm", kMm * joint.mean_m},
      {"rms_mm", kMm * joint.rms_m},
      {"p95_mm", kMm * joint.p95_m},
      {"bias_mm", Three(joint.bias_m, kMm)},
      {"limits_mm", Three(joint.limits_m, kMm)},
      {"after_offset_median_mm", kMm * joint.after_offset_median_m},
      {"velocity_rms_m_s", joint.velocity_rms_m_s},
      {"acceleration_rms_m_s2", joint.acceleration_rms_m_s2},
      {"stated_rms_mm", kMm * joint.calibration.StatedRms()}};
  AddCalibration(joint.calibration, "", &json);
  AddCalibration(joint.after_offset, "after_offset_", &json);
  return json;
}

Json ToJson(const ValueAgreement& angle) {
  return {{"n", angle.count},
          {"bias_deg", angle.bias},
          {"limits_deg", angle.limits},
          {"rms_deg", angle.rms},
          {"after_offset_rms_deg", angle.after_offset_rms},
          {"coverage_95", angle.covered.fraction()},
          {"after_offset_coverage_95", angle.covered_after_offset.fraction()}};
}

Json EventsJson(const FootEvents& events) {
  Json json = Json::array();
  for (const FootEvent& event : events.events) {
    json.push_back({{"foot", event.foot == Foot::kLeft ? "left" : "right"},
                    {"event", event.is_contact ? "contact" : "off"},
                    {"time_s", event.time_s}});
  }
  return json;
}

// Of the events found: mean and mean size [s].
std::pair<double, double> MeanOf(const std::vector<TimedEvent>& events) {
  std::vector<double> differences, sizes;
  for (const TimedEvent& event : events) {
    if (!std::isfinite(event.found_minus_plate_s)) continue;
    differences.push_back(event.found_minus_plate_s);
    sizes.push_back(std::abs(event.found_minus_plate_s));
  }
  return {Mean(differences), Mean(sizes)};
}

Json PlatesJson(const std::vector<TimedEvent>& events) {
  Json list = Json::array();
  for (const TimedEvent& event : events) {
    list.push_back(
        {{"foot", event.plate.foot == Foot::kLeft ? "left" : "right"},
         {"event", event.plate.is_contact ? "contact" : "off"},
         {"plate_s", event.plate.time_s},
         {"found_minus_plate_ms", kMm * event.found_minus_plate_s}});
  }
  const auto [mean_s, mean_size_s] = MeanOf(events);
  return {{"mean_ms", kMm * mean_s},
          {"mean_size_ms", kMm * mean_size_s},
          {"events", list}};
}

Json CalibrationJson(const Calibration& calibration) {
  Json json = {{"n", calibration.count()},
               {"stated_rms_mm", kMm * calibration.StatedRms()}};
  AddCalibration(calibration, "", &json);
  return json;
}

Json WorldJson(const WorldFit& world) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back(Three(world.truth_from_tracks.linear().row(row), 1.0));
  }
  return {{"R", rows},
          {"t_mm", Three(world.truth_from_tracks.translation(), kMm)}};
}

void AddAlignment(const Alignment& alignment, Json* out) {
  Json& json = *out;
  json["clock_s"] = alignment.clock.offset_s;
  json["clock_sigma_s"] = alignment.clock.offset_sigma_s;
  json["drift_ppm"] = 1e6 * alignment.clock.drift;
  json["drift_sigma_ppm"] = 1e6 * alignment.clock.drift_sigma;
  json["rotation_deg"] = alignment.world.rotation_deg();
  json["rotation_sigma_deg"] = alignment.world.rotation_sigma_deg;
  json["translation_mm"] =
      kMm * alignment.world.truth_from_tracks.translation().norm();
  json["translation_sigma_mm"] = kMm * alignment.world.translation_sigma_m;
  json["truth_from_tracks"] = WorldJson(alignment.world);
  json["median_mm"] = {{"none", kMm * alignment.median_none_m},
                       {"clock", kMm * alignment.median_clock_m},
                       {"both", kMm * alignment.median_both_m}};
}

// ---- Text -------------------------------------------------------------------

std::string ThreeCells(const Eigen::Vector3d& vector, const char* sign) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    char number[32];
    std::snprintf(number, sizeof(number), sign, kMm * vector[axis]);
    text += (axis > 0 ? " " : "") + std::string(number);
  }
  return text;
}

std::string Mm(double metres) { return Fixed(kMm * metres, 1); }

// A dozen figures of one joint, as a row.
std::vector<std::string> ErrorRow(const JointAgreement& joint, bool is_apart) {
  return {joint.joint + (is_apart ? " (*)" : ""),
          std::to_string(joint.count),
          Mm(joint.median_m),
          Fixed(kMm * joint.median_interval.low, 1) + ".." +
              Fixed(kMm * joint.median_interval.high, 1),
          Mm(joint.mean_m),
          Mm(joint.rms_m),
          Mm(joint.p95_m),
          ThreeCells(joint.bias_m, "%+.0f"),
          ThreeCells(joint.limits_m, "%.0f"),
          Mm(joint.after_offset_median_m)};
}

bool IsPooled(const MarkerStudy& study, const std::string& joint) {
  const int at = study.motion.truth.header.skeleton.IndexOf(joint);
  const std::vector<bool>& centres = study.motion.is_centre;
  return centres[static_cast<size_t>(at)] ||
         std::count(centres.begin(), centres.end(), true) == 0;
}

std::string ErrorTable(const MarkerStudy& study) {
  Table table({"joint", "n", "median", "95 %", "mean", "RMS", "p95",
               "bias r f u", "limits", "offset off"});
  bool any_apart = false;
  for (const JointAgreement& joint : study.agreement.joints) {
    const bool is_apart = !IsPooled(study, joint.joint);
    any_apart = any_apart || is_apart;
    table.AddRow(ErrorRow(joint, is_apart));
  }
  table.AddRow(ErrorRow(study.agreement.pooled, false));
  std::string text =
      table.ToString(TableStyle::kMarkdown) +
      "\nMillimetres; 95 %: interval of the median by bootstrap over " +
      (study.blocks_are_strides ? "strides of " : "pieces of ") +
      Fixed(study.block_s, 2) +
      " s; bias right, forward, up and its limits of agreement (1.96 standard "
      "deviations to each side); offset off: median after each joint's "
      "constant offset, learnt on the other half. Mean of the medians: " +
      Mm(study.agreement.mean_of_medians_m) + " mm.\n";
  if (any_apart) {
    text +=
        "\n(*) not pooled: its markers do not enclose the joint's centre.\n";
  }
  return text;
}

std::string MotionTable(const MarkerStudy& study) {
  Table table({"joint", "velocity RMS, m/s", "acceleration RMS, m/s^2"});
  std::vector<JointAgreement> rows = study.agreement.joints;
  rows.push_back(study.agreement.pooled);
  for (const JointAgreement& joint : rows) {
    table.AddRow({joint.joint, Fixed(joint.velocity_rms_m_s, 3),
                  Fixed(joint.acceleration_rms_m_s2, 2)});
  }
  return table.ToString(TableStyle::kMarkdown);
}

std::vector<std::string> CalibrationRow(const std::string& name,
                                        const Calibration& calibration) {
  const auto percent = [&](double level) {
    return Fixed(100.0 * calibration.Covered(level), 1);
  };
  return {name,
          std::to_string(calibration.count()),
          percent(0.50),
          percent(0.80),
          percent(0.95),
          Fixed(calibration.ExpectedCalibrationError(), 3),
          Mm(calibration.StatedRms()),
          Fixed(calibration.LogScore(), 2)};
}

std::string CalibrationTable(const MarkerStudy& study) {
  const MotionAgreement& agreement = study.agreement;
  if (agreement.pooled.calibration.count() == 0) {
    return "The tracks state no covariances: nothing to calibrate.\n";
  }
  Table table({"ellipsoids", "n", "50 %", "80 %", "95 %", "ECE", "stated, mm",
               "log score"});
  for (const JointAgreement& joint : agreement.joints) {
    table.AddRow(CalibrationRow(joint.joint, joint.calibration));
  }
  table.AddRow(CalibrationRow("pooled", agreement.pooled.calibration));
  for (const auto& [name, calibration] :
       {std::pair{"pooled, observed", agreement.observed},
        {"pooled, inferred", agreement.inferred},
        {"pooled, offset off", agreement.pooled.after_offset}}) {
    if (calibration.count() > 0)
      table.AddRow(CalibrationRow(name, calibration));
  }
  std::string text = table.ToString(TableStyle::kMarkdown) +
                     "\nShare of the true joints within the stated ellipsoids; "
                     "ECE: mean difference of covered and promised share.\n";
  const JointAgreement& pooled = agreement.pooled;
  return text +
         "\nCovariances say how precise the detections make a joint, not where "
         "a detector sees it: each joint's constant offset is no part of what "
         "they promise, unless the tracks have learnt it. Freed of it the "
         "median goes from " +
         Mm(pooled.median_m) + " to " + Mm(pooled.after_offset_median_m) +
         " mm, and the 95 % ellipsoids hold " +
         Fixed(100.0 * pooled.after_offset.Covered(0.95), 1) +
         " % of the joints instead of " +
         Fixed(100.0 * pooled.calibration.Covered(0.95), 1) + " %.\n";
}

std::string AngleTable(const MarkerStudy& study) {
  Table table({"angle, deg", "n", "bias", "limits", "RMS", "RMS, offset off",
               "covered, %", "offset off, %"});
  for (const auto& [name, angle] : study.angles) {
    table.AddRow({name, std::to_string(angle.count), Fixed(angle.bias, 1),
                  Fixed(angle.limits, 1), Fixed(angle.rms, 1),
                  Fixed(angle.after_offset_rms, 1),
                  Fixed(angle.covered.percent(), 1),
                  Fixed(angle.covered_after_offset.percent(), 1)});
  }
  return table.ToString(TableStyle::kMarkdown);
}

std::string EventText(const MarkerStudy& study) {
  std::string text = std::string("Feet, by ") +
                     (study.true_events.is_walk
                          ? "their way relative to the pelvis (Zeni 2008)"
                          : "their vertical speed (nobody walks)") +
                     ": " + std::to_string(study.true_events.events.size()) +
                     " events of the markers, " +
                     std::to_string(study.found_events.events.size()) +
                     " of the tracks.\n";
  if (study.true_on_plates.empty()) return text;
  Table table({"plate", "at, s", "markers, ms", "tracks, ms"});
  const auto ms = [](double seconds) { return Fixed(kMm * seconds, 1); };
  for (size_t i = 0; i < study.true_on_plates.size(); ++i) {
    const TimedEvent& event = study.true_on_plates[i];
    table.AddRow(
        {std::string(event.plate.foot == Foot::kLeft ? "left " : "right ") +
             (event.plate.is_contact ? "contact" : "off"),
         Fixed(event.plate.time_s, 3), ms(event.found_minus_plate_s),
         ms(study.found_on_plates[i].found_minus_plate_s)});
  }
  const auto by_markers = MeanOf(study.true_on_plates);
  const auto by_tracks = MeanOf(study.found_on_plates);
  table.AddRow({"mean", "", ms(by_markers.first), ms(by_tracks.first)});
  table.AddRow({"mean size", "", ms(by_markers.second), ms(by_tracks.second)});
  return text + "\n" + table.ToString(TableStyle::kMarkdown);
}

std::string AlignText(const MarkerStudy& study, Align align) {
  const Alignment& alignment = study.alignment;
  std::string text =
      "Median distance of all joints: " + Mm(alignment.median_none_m) +
      " mm as they stand, " + Mm(alignment.median_clock_m) +
      " mm on one clock, " + Mm(alignment.median_both_m) +
      " mm in one world, too. Scored with `--align=" + ToString(align) + "`";
  if (align == Align::kBoth || align == Align::kClock) {
    text += "; clock " + Fixed(kMm * alignment.clock.offset_s, 2) + " +- " +
            Fixed(kMm * alignment.clock.offset_sigma_s, 2) + " ms";
    if (alignment.clock.drift != 0.0) {
      text += ", drift " + Fixed(1e6 * alignment.clock.drift, 1) + " +- " +
              Fixed(1e6 * alignment.clock.drift_sigma, 1) + " ppm";
    }
  }
  if (align == Align::kBoth || align == Align::kWorld) {
    text += "; turned by " + Fixed(alignment.world.rotation_deg(), 2) + " +- " +
            Fixed(alignment.world.rotation_sigma_deg, 2) +
            " degrees, moved by " +
            Mm(alignment.world.truth_from_tracks.translation().norm()) +
            " +- " + Mm(alignment.world.translation_sigma_m) + " mm";
  }
  return text + ".\n";
}

std::string InputText(const MarkerInput& input) {
  return BaseName(input.path) +
         (input.set.empty() ? "" : " (" + BaseName(input.set) + ")");
}

void WriteMarkerPage(const MarkerStudy& study, const std::string& path) {
  PageInput page;
  page.title = InputText(study.tracks) + " against " + InputText(study.truth);
  page.results.push_back(
      {BaseName(study.tracks.path), ResultRole::kTracks, study.motion.tracks});
  page.results.push_back({BaseName(study.truth.path), ResultRole::kGroundTruth,
                          WithMarkers(study)});
  PageOptions options;
  options.up = study.up;
  options.with_covariance = true;
  WritePage(page.title, MakePageData(page, options).json, path);
}

}  // namespace

Json MarkerJson(const MarkerStudy& study) {
  const MotionAgreement& agreement = study.agreement;
  Json json;
  json["frames"] = study.motion.truth.frames.size();
  json["person"] = study.alignment.person.value();
  json["joints"] = Json::object();
  for (const JointAgreement& joint : agreement.joints) {
    Json& entry = json["joints"][joint.joint] = ToJson(joint);
    entry["pooled"] = IsPooled(study, joint.joint);
  }
  json["pooled"] = ToJson(agreement.pooled);
  json["pooled"]["mean_of_medians_mm"] = kMm * agreement.mean_of_medians_m;
  json["observed"] = CalibrationJson(agreement.observed);
  json["inferred"] = CalibrationJson(agreement.inferred);
  json["pa_mpjpe_mm"] = kMm * agreement.pa_mpjpe_m;
  json["pck_150"] = agreement.pck_150.fraction();
  json["auc_150"] = agreement.auc;
  json["pck_root_aligned"] = agreement.root_aligned;
  json["angles"] = Json::object();
  for (const auto& [name, angle] : study.angles) {
    json["angles"][name] = ToJson(angle);
  }
  AddAlignment(study.alignment, &json);
  json["events"] = {{"walk", study.true_events.is_walk},
                    {"ground_truth", EventsJson(study.true_events)},
                    {"tracks", EventsJson(study.found_events)}};
  if (!study.true_on_plates.empty()) {
    json["plates"] = {{"ground_truth", PlatesJson(study.true_on_plates)},
                      {"tracks", PlatesJson(study.found_on_plates)}};
  }
  return json;
}

std::string MarkerMarkdown(const MarkerStudy& study) {
  const MotionAgreement& agreement = study.agreement;
  std::string text =
      "# " + InputText(study.tracks) + " against " + InputText(study.truth) +
      "\n\n" + std::to_string(study.motion.truth.frames.size()) +
      " frames at " + Fixed(study.motion.tracks.header.frame_rate_hz, 1) +
      " Hz. " + AlignText(study, study.align);
  if (!study.truth.joints.lacking.empty()) {
    text += "\nLeft out, for want of a marker:";
    for (const std::string& joint : study.truth.joints.lacking) {
      text += " " + joint;
    }
    text += ".\n";
  }
  text += "\n## Joints\n\n" + ErrorTable(study);
  text += "\nPA-MPJPE " + Mm(agreement.pa_mpjpe_m) + " mm; PCK at 150 mm " +
          Fixed(agreement.pck_150.percent(), 1) + " %, AUC " +
          Fixed(100.0 * agreement.auc, 1) + " %" +
          (agreement.root_aligned ? ", the middle of the hips in one place"
                                  : ", without alignment of a root") +
          ".\n";
  text += "\n## Intervals\n\n" + CalibrationTable(study);
  if (!study.angles.empty()) text += "\n## Angles\n\n" + AngleTable(study);
  text += "\n## Steps\n\n" + EventText(study);
  text += "\n## Speeds\n\n" + MotionTable(study);
  return text;
}

void WriteMarkerFolder(const MarkerStudy& study, const Json& json,
                       const std::string& folder) {
  RequirePlotTool();
  AtomicFolder out(WithFolders(folder));
  WriteTextFile(out.PathOf("markers.json"), DumpJson(json, 1) + "\n");
  std::string markdown = MarkerMarkdown(study);
  for (const std::string& name : WriteMarkerPlots(study, out.PathOf(""))) {
    markdown += "\n![" + name + "](" + name + ")\n";
  }
  WriteTextFile(out.PathOf("markers.md"), markdown);
  WriteMarkerPage(study, out.PathOf("page.html"));
  out.Commit();
}

}  // namespace kinegraph
