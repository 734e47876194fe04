#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/plot.h"
#include "apps/common/table.h"
#include "apps/markers/marker_study.h"
#include "apps/report/page.h"
#include "apps/report/page_data.h"
#include "core/base/constants.h"
#include "core/evaluation/mpjpe.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {
namespace {

constexpr double kMm = 1000.0;  // mm per m, and ms per s

std::string BaseName(const std::string& path) {
  return path.substr(path.find_last_of('/') + 1);
}

// ---- JSON -------------------------------------------------------------------

Json Three(const Eigen::Vector3d& vector, double factor) {
  return {factor * vector.x(), factor * vector.y(), factor * vector.z()};
}

// NaN becomes null.
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

const char* SideOf(const FootEvent& event) {
  return event.foot == Foot::kLeft ? "left" : "right";
}
const char* KindOf(const FootEvent& event) {
  return event.is_contact ? "contact" : "off";
}

Json EventsJson(const FootEvents& events) {
  Json json = Json::array();
  for (const FootEvent& event : events.events) {
    json.push_back({{"foot", SideOf(event)},
                    {"event", KindOf(event)},
                    {"time_s", event.time_s}});
  }
  return json;
}

// Mean and mean absolute difference of the matched events [s].
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
    list.push_back({{"foot", SideOf(event.plate)},
                    {"event", KindOf(event.plate)},
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

Json AlignmentJson(const Alignment& alignment) {
  return {{"clock_s", alignment.clock.offset_s},
          {"clock_sigma_s", alignment.clock.offset_sigma_s},
          {"drift_ppm", 1e6 * alignment.clock.drift},
          {"drift_sigma_ppm", 1e6 * alignment.clock.drift_sigma},
          {"rotation_deg", alignment.world.rotation_deg()},
          {"rotation_sigma_deg", alignment.world.rotation_sigma_deg},
          {"translation_mm",
           kMm * alignment.world.truth_from_tracks.translation().norm()},
          {"translation_sigma_mm", kMm * alignment.world.translation_sigma_m},
          {"truth_from_tracks", WorldJson(alignment.world)},
          {"median_mm",
           {{"none", kMm * alignment.median_none_m},
            {"clock", kMm * alignment.median_clock_m},
            {"both", kMm * alignment.median_both_m}}}};
}

// ---- Text -------------------------------------------------------------------

std::string Mm(double metres) { return Fixed(kMm * metres, 1); }

// Whole millimetres along three axes, "+3 -12 +0" if signed; "-" for a missing
// value.
std::string AxesMm(const Eigen::Vector3d& metres, bool is_signed) {
  std::string text;
  for (const double m : metres) {
    const std::string mm = Fixed(kMm * m, 0);
    const bool has_sign = mm.front() == '-';  // also of a missing value
    text += (text.empty() ? "" : " ");
    text += (is_signed && !has_sign ? "+" : "") + mm;
  }
  return text;
}

// The row of one joint.
Cells ErrorRow(const JointAgreement& joint) {
  return {joint.joint + (joint.is_pooled ? "" : " (*)"),
          std::to_string(joint.count),
          Mm(joint.median_m),
          Mm(joint.median_interval.low) + ".." + Mm(joint.median_interval.high),
          Mm(joint.mean_m),
          Mm(joint.rms_m),
          Mm(joint.p95_m),
          AxesMm(joint.bias_m, true),
          AxesMm(joint.limits_m, false),
          Mm(joint.after_offset_median_m)};
}

std::string ErrorTable(const MarkerStudy& study) {
  Table table({"joint", "n", "median", "95 %", "mean", "RMS", "p95",
               "bias r f u", "limits", "no offset"});
  bool any_apart = false;
  for (const JointAgreement& joint : study.agreement.joints) {
    any_apart = any_apart || !joint.is_pooled;
    table.AddRow(ErrorRow(joint));
  }
  table.AddRow(ErrorRow(study.agreement.pooled));
  return fmt::format(
      "{}\nMillimetres. 95 %: interval of the median, by bootstrap over {} of "
      "{} s. bias r f u: to the right, forward and up. limits: limits of "
      "agreement about the bias (1.96 standard deviations to each side). "
      "no offset: median after removing each joint's constant offset, "
      "estimated on the other half of the recording. Mean of the medians: {} "
      "mm.\n{}",
      table.ToString(TableStyle::kMarkdown),
      study.blocks_are_strides ? "strides" : "blocks", Fixed(study.block_s, 2),
      Mm(study.agreement.mean_of_medians_m),
      any_apart ? "\n(*) not pooled: the markers do not enclose the joint's "
                  "centre.\n"
                : "");
}

std::string MotionTable(const MarkerStudy& study) {
  Table table({"joint", "velocity RMS, m/s", "acceleration RMS, m/s^2"});
  const auto add = [&](const JointAgreement& joint) {
    table.AddRow({joint.joint, Fixed(joint.velocity_rms_m_s, 3),
                  Fixed(joint.acceleration_rms_m_s2, 2)});
  };
  for (const JointAgreement& joint : study.agreement.joints) add(joint);
  add(study.agreement.pooled);
  return table.ToString(TableStyle::kMarkdown);
}

Cells CalibrationRow(const std::string& name, const Calibration& calibration) {
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
    return "The tracks contain no covariances.\n";
  }
  Table table({"ellipsoids", "n", "50 %", "80 %", "95 %", "ECE",
               "RMS by covariance, mm", "log score"});
  for (const JointAgreement& joint : agreement.joints) {
    table.AddRow(CalibrationRow(joint.joint, joint.calibration));
  }
  table.AddRow(CalibrationRow("pooled", agreement.pooled.calibration));
  for (const auto& [name, calibration] :
       {std::pair{"pooled, observed", agreement.observed},
        {"pooled, inferred", agreement.inferred},
        {"pooled, no offset", agreement.pooled.after_offset}}) {
    if (calibration.count() > 0)
      table.AddRow(CalibrationRow(name, calibration));
  }
  const JointAgreement& pooled = agreement.pooled;
  return fmt::format(
      "{}\nPercentage of the true joints within the stated ellipsoids. ECE: "
      "mean absolute difference of actual and nominal coverage.\n\nCovariances "
      "state the precision of a joint given its detections. They do not "
      "include the constant difference between the detector's joint and the "
      "anatomical one, unless the run estimated it (graph.view_bias). With the "
      "offset removed, the median changes from {} to "
      "{} mm, and the 95 % ellipsoids contain {} % of the joints instead of {} "
      "%.\n",
      table.ToString(TableStyle::kMarkdown), Mm(pooled.median_m),
      Mm(pooled.after_offset_median_m),
      Fixed(100.0 * pooled.after_offset.Covered(0.95), 1),
      Fixed(100.0 * pooled.calibration.Covered(0.95), 1));
}

std::string AngleTable(const MarkerStudy& study) {
  Table table({"angle, deg", "n", "bias", "limits", "RMS", "RMS, no offset",
               "in 95 % CI, %", "CI, no offset, %"});
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
  const auto method = [](const FootEvents& events) {
    return events.is_walk ? "positions relative to the pelvis (Zeni 2008)"
                          : "vertical speeds (no walking)";
  };
  const FootEvents& markers = study.true_events;
  const FootEvents& tracks = study.found_events;
  const std::string text =
      markers.is_walk == tracks.is_walk
          ? fmt::format(
                "Foot events from {}: {} in the markers, {} in the "
                "tracks.\n",
                method(markers), markers.events.size(), tracks.events.size())
          : fmt::format(
                "Foot events: {} in the markers, from {}; {} in the "
                "tracks, from {}.\n",
                markers.events.size(), method(markers), tracks.events.size(),
                method(tracks));
  if (study.true_on_plates.empty()) return text;
  Table table(
      {"plate event", "time, s", "markers - plate, ms", "tracks - plate, ms"});
  const auto ms = [](double seconds) { return Fixed(kMm * seconds, 1); };
  for (size_t i = 0; i < study.true_on_plates.size(); ++i) {
    const TimedEvent& event = study.true_on_plates[i];
    table.AddRow({std::string(SideOf(event.plate)) + " " + KindOf(event.plate),
                  Fixed(event.plate.time_s, 3), ms(event.found_minus_plate_s),
                  ms(study.found_on_plates[i].found_minus_plate_s)});
  }
  const auto by_markers = MeanOf(study.true_on_plates);
  const auto by_tracks = MeanOf(study.found_on_plates);
  table.AddRow({"mean", "", ms(by_markers.first), ms(by_tracks.first)});
  table.AddRow(
      {"mean absolute", "", ms(by_markers.second), ms(by_tracks.second)});
  return text + "\n" + table.ToString(TableStyle::kMarkdown);
}

std::string AlignText(const MarkerStudy& study) {
  const Align align = study.align;
  const auto& clock = study.alignment.clock;
  const WorldFit& world = study.alignment.world;
  std::string text = fmt::format(
      "Median distance over all joints: {} mm without alignment, {} mm with "
      "aligned clocks, {} mm with aligned clocks and worlds. Scored with "
      "`--align={}`",
      Mm(study.alignment.median_none_m), Mm(study.alignment.median_clock_m),
      Mm(study.alignment.median_both_m), ToString(align));
  if (align == Align::kBoth || align == Align::kClock) {
    text += fmt::format("; clock {} +- {} ms", Fixed(kMm * clock.offset_s, 2),
                        Fixed(kMm * clock.offset_sigma_s, 2));
    if (clock.drift != 0.0) {
      text += fmt::format(", drift {} +- {} ppm", Fixed(1e6 * clock.drift, 1),
                          Fixed(1e6 * clock.drift_sigma, 1));
    }
  }
  if (align == Align::kBoth || align == Align::kWorld) {
    text += fmt::format("; rotation {} +- {} degrees, translation {} +- {} mm",
                        Fixed(world.rotation_deg(), 2),
                        Fixed(world.rotation_sigma_deg, 2),
                        Mm(world.truth_from_tracks.translation().norm()),
                        Mm(world.translation_sigma_m));
  }
  return text + ".\n";
}

std::string InputText(const MarkerInput& input) {
  return BaseName(input.path) +
         (input.set.empty() ? "" : " (" + BaseName(input.set) + ")");
}

// ---- Plots and the page

// More points of a cloud or line would make no visible difference.
constexpr size_t kMostPoints = 2000;

size_t Stride(size_t count) {
  return std::max<size_t>(1, (count + kMostPoints - 1) / kMostPoints);
}

PlotSeries Level(double x_low, double x_high, double y, bool dashed) {
  PlotSeries line = {"", PlotStyle::kLine, {x_low, x_high}, {y, y}};
  line.dashed = dashed;
  line.colour = 0;
  return line;
}

// Difference against mean of each pooled joint's position on one axis of the
// body, relative to the mean of the true joints.
Plot BlandAltman(const MarkerStudy& study, int axis) {
  static const char* const kAxes[] = {"right", "forward", "up"};
  const PairedMotion& motion = study.motion;
  PlotSeries cloud = {"", PlotStyle::kPoints};
  cloud.colour = 1;
  const size_t joints = motion.is_centre.size();
  const size_t stride = Stride(motion.truth.frames.size() * joints);
  for (size_t f = 0; f < motion.truth.frames.size(); f += stride) {
    const Pose3d& truth = motion.truth.frames[f].people.front().joints;
    const Pose3d& found = motion.tracks.frames[f].people.front().joints;
    const auto body = BodyFrame(truth, motion.truth.header.skeleton, study.up);
    const auto middle = MeanPosition(truth);
    if (!body || !middle) continue;
    for (size_t j = 0; j < joints; ++j) {
      if (!motion.IsPooled(j)) continue;
      if (!truth[j].present() || !found[j].present()) continue;
      const Eigen::Vector3d a =
          body->transpose() * (truth[j].position_m - *middle);
      const Eigen::Vector3d b =
          body->transpose() * (found[j].position_m - *middle);
      cloud.Add(kMm * 0.5 * (a[axis] + b[axis]), kMm * (b[axis] - a[axis]));
    }
  }
  Plot plot;
  plot.title = kAxes[axis];
  plot.x.label = "mean of both [mm]";
  plot.y.label = "tracks minus markers [mm]";
  plot.legend = PlotLegend::kNone;
  const JointAgreement& pooled = study.agreement.pooled;
  if (!cloud.x.empty()) {
    const auto ends = std::minmax_element(cloud.x.begin(), cloud.x.end());
    const double low = *ends.first, high = *ends.second;
    const double bias = kMm * pooled.bias_m[axis];
    const double limit = kMm * pooled.limits_m[axis];
    plot.title += ": bias " + Fixed(bias, 1) + " mm, limits " +
                  Fixed(bias - limit, 0) + " to " + Fixed(bias + limit, 0) +
                  " mm";
    plot.series = {std::move(cloud), Level(low, high, bias, false),
                   Level(low, high, bias - limit, true),
                   Level(low, high, bias + limit, true)};
  }
  return plot;
}

Plot ErrorsOverTime(const MarkerStudy& study) {
  const PairedMotion& motion = study.motion;
  const size_t stride = Stride(motion.truth.frames.size());
  Plot plot;
  plot.title = "Distance between tracks and markers";
  plot.x.label = "time of the markers [s]";
  plot.y.label = "distance [mm]";
  plot.y.low = 0.0;
  for (size_t j = 0; j < motion.is_centre.size(); ++j) {
    if (!motion.IsPooled(j)) continue;
    PlotSeries line = {motion.truth.header.skeleton.joints()[j]};
    for (size_t f = 0; f < motion.truth.frames.size(); f += stride) {
      const Joint3d& a = motion.truth.frames[f].people.front().joints[j];
      const Joint3d& b = motion.tracks.frames[f].people.front().joints[j];
      line.Add(ToSeconds(motion.truth.frames[f].time),
               a.present() && b.present()
                   ? kMm * (a.position_m - b.position_m).norm()
                   : kNan);
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

Plot CalibrationCurve(const MotionAgreement& agreement) {
  constexpr int kLevels = 20;
  Plot plot;
  plot.title = "Calibration of the ellipsoids";
  plot.x.label = "nominal [%]";
  plot.y.label = "actual [%]";
  plot.x.low = plot.y.low = 0.0;
  plot.x.high = plot.y.high = 100.0;
  PlotSeries right = {"ideal", PlotStyle::kLine, {0.0, 100.0}, {0.0, 100.0}};
  right.dashed = true;
  plot.series.push_back(right);
  for (const auto& [name, calibration] :
       {std::pair{"observed", &agreement.observed},
        {"inferred", &agreement.inferred},
        {"no offset", &agreement.pooled.after_offset}}) {
    if (calibration->count() == 0) continue;
    PlotSeries line = {name + (", n " + std::to_string(calibration->count())),
                       PlotStyle::kLinePoints};
    for (int level = 1; level < kLevels; ++level) {
      const double nominal = level / static_cast<double>(kLevels);
      line.Add(100.0 * nominal, 100.0 * calibration->Covered(nominal));
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

// Writes bland_altman.svg, errors.svg and, with covariances, calibration.svg
// into `folder`, which ends with '/'; returns their names.
std::vector<std::string> WriteMarkerPlots(const MarkerStudy& study,
                                          const std::string& folder) {
  std::vector<std::string> names = {"bland_altman.svg", "errors.svg"};
  WritePlot(
      {BlandAltman(study, 0), BlandAltman(study, 1), BlandAltman(study, 2)},
      folder + names[0], {1350, 420, 3});
  WritePlot({ErrorsOverTime(study)}, folder + names[1]);
  if (study.agreement.pooled.calibration.count() > 0) {
    names.emplace_back("calibration.svg");
    WritePlot({CalibrationCurve(study.agreement)}, folder + names.back());
  }
  return names;
}

// The truth's joints followed by its markers with other names, in the scored
// frames.
TrackSequence WithMarkers(const MarkerStudy& study) {
  TrackSequence shown = study.motion.truth;
  if (study.truth.set.empty()) return shown;
  const Skeleton& skeleton = shown.header.skeleton;
  std::vector<std::string> names = skeleton.joints();
  std::set<std::string> taken(names.begin(), names.end());
  std::vector<int> markers;
  const TrackSequence& points = study.truth.points;
  for (int m = 0; m < points.header.skeleton.joint_count(); ++m) {
    const std::string& label =
        points.header.skeleton.joints()[static_cast<size_t>(m)];
    if (!taken.insert(label).second) continue;
    names.push_back(label);
    markers.push_back(m);
  }
  const JointPaths paths(points, OnlyPerson(points), markers);
  for (TrackFrame& frame : shown.frames) {
    for (size_t m = 0; m < markers.size(); ++m) {
      const auto at_m = paths.At(ToSeconds(frame.time), m);
      frame.people.front().joints.push_back(
          at_m ? Joint3d{*at_m, JointStatus::kObserved} : Joint3d{});
    }
  }
  shown.header.skeleton = Skeleton("markers", names, skeleton.bones());
  return shown;
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
    entry["pooled"] = joint.is_pooled;
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
  json.update(AlignmentJson(study.alignment));
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
  const double rate_hz = study.motion.tracks.header.frame_rate_hz;
  const double truth_hz = study.truth.joints.tracks.header.frame_rate_hz;
  const bool is_interpolated =
      truth_hz != rate_hz || study.alignment.clock.offset_s != 0.0;
  std::string text = fmt::format(
      "# {} against {}\n\n{} frames at {} Hz{}. {}", InputText(study.tracks),
      InputText(study.truth), study.motion.truth.frames.size(),
      Fixed(rate_hz, 1),
      is_interpolated
          ? fmt::format("; the ground truth, of {} Hz, is interpolated at "
                        "their times",
                        Fixed(truth_hz, 1))
          : "",
      AlignText(study));
  const Cells& lacking = study.truth.joints.lacking;
  if (!lacking.empty()) {
    text += fmt::format("\nLeft out because a marker is missing: {}.\n",
                        fmt::join(lacking, " "));
  }
  text += "\n## Joints\n\n" + ErrorTable(study);
  text += fmt::format(
      "\nPA-MPJPE {} mm; PCK at 150 mm {} %, AUC {} %{}.\n",
      Mm(agreement.pa_mpjpe_m), Fixed(agreement.pck_150.percent(), 1),
      Fixed(100.0 * agreement.auc, 1),
      agreement.root_aligned ? ", with the middle of the hips aligned"
                             : ", without root alignment");
  text += "\n## Covariances\n\n" + CalibrationTable(study);
  if (!study.angles.empty()) text += "\n## Angles\n\n" + AngleTable(study);
  text += "\n## Steps\n\n" + EventText(study);
  return text + "\n## Speeds\n\n" + MotionTable(study);
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
