// kinegraph-calibrate: estimates cameras and clocks from the people in view.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/progress.h"
#include "apps/common/recording_output.h"
#include "apps/common/track_files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "solvers/session/calibrate_recording.h"

DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(
    cameras, "",
    "calibration whose focal lengths and lenses are used; its poses are "
    "ignored");
DEFINE_string(image_size, "",
              "image size W,H [px]; required without --cameras");
DEFINE_string(focal, "",
              "focal length [px] of all views, or one per view: PX[,PX...]; "
              "without it fields of view of 35 to 93 degrees are tried");
DEFINE_double(focal_error, 1.0,
              "standard deviation of the given focal lengths [%]; 0: they are "
              "exact, the default with --cameras");
DEFINE_bool(in_step, false,
            "the cameras share a trigger, so their clocks agree");
DEFINE_double(scale, 0.0, "height of the people [m]");
DEFINE_string(distance, "",
              "distance between two joints [m]: JOINT,JOINT,METRES");
DEFINE_string(cameras_apart, "",
              "distance between two cameras [m]: VIEW,VIEW,METRES");
DEFINE_double(frame_rate, 0.0,
              "frame rate [Hz] if the files do not specify it; never guessed");
DEFINE_string(skeleton, "",
              "skeleton of the detections if the file does not specify it");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(to, "kinegraph",
              "format of the calibration (`convert --formats` lists them)");
DEFINE_string(out, "",
              "calibration to write; the report NAME.calibrate.json is written "
              "beside it");

namespace kinegraph {
namespace {

double NumberOf(const std::string& text, const std::string& flag) {
  const auto number = ParseNumber<double>(WithoutPlus(Trimmed(text)));
  if (number && *number > 0.0 && std::isfinite(*number)) return *number;
  throw InputError("--" + flag + ": '" + Printable(text) +
                   "', expected a number above 0");
}

// Accepts lengths from 0.1 mm to `most`, so that most lengths given in
// millimetres are rejected.
double MetresOf(double metres, const std::string& flag, double most) {
  constexpr double kLeastM = 1e-4;
  if (!(metres >= kLeastM && metres <= most)) {
    throw InputError(fmt::format("--{}: {} m, expected {} .. {} m", flag,
                                 metres, kLeastM, most));
  }
  return metres;
}

KnownLength LengthOfFlags() {
  constexpr double kTallestM = 20.0;
  constexpr double kLongestM = 100.0;
  constexpr double kFarthestM = 1000.0;
  const int given = (FLAGS_scale != 0.0 ? 1 : 0) +
                    (FLAGS_distance.empty() ? 0 : 1) +
                    (FLAGS_cameras_apart.empty() ? 0 : 1);
  if (given > 1) {
    throw InputError(
        "--scale, --distance, --cameras_apart: expected at most one of them");
  }
  if (FLAGS_scale != 0.0) {
    return {KnownLength::Kind::kStature,
            MetresOf(FLAGS_scale, "scale", kTallestM), "", ""};
  }
  for (const auto& [text, flag, kind, most] :
       {std::tuple(FLAGS_distance, "distance", KnownLength::Kind::kDistance,
                   kLongestM),
        {FLAGS_cameras_apart, "cameras_apart", KnownLength::Kind::kCameras,
         kFarthestM}}) {
    if (text.empty()) continue;
    const std::vector<std::string> parts = ParseList(text, flag);
    const std::string found = fmt::format("--{}: '{}'", flag, Printable(text));
    if (parts.size() != 3) {
      throw InputError(found + ", expected two names and metres: A,B,METRES");
    }
    if (parts[0] == parts[1]) {
      throw InputError(
          found + " has the same name twice, expected two different names");
    }
    return {kind, MetresOf(NumberOf(parts[2], flag), flag, most), parts[0],
            parts[1]};
  }
  return {};
}

int SideOf(const std::string& text) {
  constexpr double kMostPx = 100000.0;
  const double side = NumberOf(text, "image_size");
  if (side != std::floor(side) || side > kMostPx) {
    throw InputError("--image_size: '" + Printable(text) +
                     "', expected whole pixels, at most 100000");
  }
  return static_cast<int>(side);
}

// Throws if too many joints are far outside the image, which means that the
// image size is wrong: detectors place few joints outside, and these near the
// edge.
void CheckInside(const DetectionSequence& detections, int width, int height) {
  constexpr double kBeyond = 0.05;      // of the image's sides
  constexpr double kMostBeyond = 0.05;  // of the joints
  const Eigen::AlignedBox2d image(
      Eigen::Vector2d(-kBeyond * width, -kBeyond * height),
      Eigen::Vector2d((1.0 + kBeyond) * width, (1.0 + kBeyond) * height));
  for (size_t v = 0; v < detections.header.view_names.size(); ++v) {
    double found = 0.0;
    double beyond = 0.0;
    for (const DetectionFrame& frame : detections.frames) {
      for (const Detection& detection : frame.views[v].detections) {
        for (const Keypoint& joint : detection.joints) {
          if (!joint.found) continue;
          found += 1.0;
          beyond += image.contains(joint.px) ? 0.0 : 1.0;
        }
      }
    }
    if (beyond <= kMostBeyond * found) continue;
    throw InputError(fmt::format(
        "--image_size: {:.0f} % of the joints of view '{}' lie outside {} x {} "
        "px; expected the size of the images on which the detector ran",
        100.0 * beyond / found, Printable(detections.header.view_names[v]),
        width, height));
  }
}

// Pinhole cameras with the principal point at the image centre, as initial
// values of the estimation.
CameraRig RigOfFlags(const DetectionSequence& detections) {
  const std::vector<std::string>& views = detections.header.view_names;
  const std::vector<std::string> size =
      ParseList(FLAGS_image_size, "image_size");
  if (size.size() != 2) {
    throw InputError(
        "--image_size: expected W,H [px]; or give --cameras with a calibration "
        "that has the right focal lengths");
  }
  const int width = SideOf(size[0]);
  const int height = SideOf(size[1]);
  CheckInside(detections, width, height);
  std::vector<double> focal;
  for (const std::string& one : ParseList(FLAGS_focal, "focal")) {
    focal.push_back(NumberOf(one, "focal"));
  }
  if (focal.size() > 1 && focal.size() != views.size()) {
    throw InputError(fmt::format(
        "--focal: {} lengths for {} views, expected one, or one per view",
        focal.size(), views.size()));
  }
  CameraRig cameras;
  // Default: a field of view of 60 degrees along the longer side.
  if (focal.empty()) focal.push_back(0.866 * std::max(width, height));
  for (size_t v = 0; v < views.size(); ++v) {
    const double px = focal[focal.size() > 1 ? v : 0];
    CameraParameters camera;
    camera.name = views[v];
    camera.width_px = width;
    camera.height_px = height;
    camera.K << px, 0.0, 0.5 * width, 0.0, px, 0.5 * height, 0.0, 0.0, 1.0;
    cameras.emplace_back(camera);
  }
  return cameras;
}

CalibrationInput InputOfFlags(const RunOptions& options,
                              const DetectionSequence& detections) {
  CalibrationInput input;
  input.length = LengthOfFlags();
  if (!(FLAGS_focal_error >= 0.0 && FLAGS_focal_error <= 50.0)) {
    throw InputError("--focal_error: expected 0 .. 50 %");
  }
  // True also if the flag is given with its default value.
  const bool has_focal_error =
      !gflags::GetCommandLineFlagInfoOrDie("focal_error").is_default;
  input.in_step = FLAGS_in_step;
  if (!FLAGS_cameras.empty()) {
    if (!FLAGS_focal.empty() || !FLAGS_image_size.empty()) {
      throw InputError(
          "--focal, --image_size: cannot be combined with --cameras, which "
          "specifies both");
    }
    input.cameras = ReadCameras(FLAGS_cameras, options.cameras);
    // Measured focal lengths are exact unless --focal_error is given.
    if (has_focal_error) input.focal_sigma = 0.01 * FLAGS_focal_error;
    return input;
  }
  if (FLAGS_focal.empty() && has_focal_error) {
    throw InputError(
        "--focal_error: needs --focal or --cameras, whose focal lengths have "
        "this error");
  }
  input.cameras = RigOfFlags(detections);
  input.lenses_known = false;
  input.focal_stated = !FLAGS_focal.empty();
  input.focal_sigma = 0.01 * FLAGS_focal_error;
  // Relative to 60 degrees, 40 and 90 degrees are 1.5 and 1.8 sigmas away.
  if (FLAGS_focal.empty()) input.focal_sigma = 0.3;
  return input;
}

// Indexed by KnownLength::Kind.
constexpr std::array kMetreFrom = {"population", "scale", "distance",
                                   "cameras_apart"};

// null for 0, which stands for an unknown value.
Json NumberOrNull(double value) { return value > 0.0 ? Json(value) : Json(); }

std::string JsonReport(const RecordingCalibration& recording,
                       const KnownLength& length,
                       const std::vector<std::string>& views,
                       const std::string& fingerprint) {
  Json of_views = Json::object();
  Json clocks = Json::object();
  Json left_out = Json::array();
  for (size_t v = 0; v < views.size(); ++v) {
    const RigView& view = recording.rig.views[v];
    if (!view.left_out.empty()) left_out.push_back(views[v]);
    Json one = {{"calibrated", view.joined && view.left_out.empty()},
                {"reason", view.left_out}};
    if (view.joined) {
      one["rotation_sigma_deg"] = view.rotation_sigma_deg;
      one["centre_sigma_m"] = view.centre_sigma_m;
      one["residual_px"] = view.mean_px;
      one["left_out_px"] = {{"frames", NumberOrNull(view.left_out_px.frames)},
                            {"joints", NumberOrNull(view.left_out_px.joints)},
                            {"people", NumberOrNull(view.left_out_px.people)}};
      clocks[views[v]] = {{"offset_s", view.clock_s},
                          {"sigma_s", view.clock_sigma_s},
                          {"drift", view.drift}};
    }
    of_views[views[v]] = one;
  }
  Json scale = {{"from", kMetreFrom[static_cast<size_t>(length.kind)]}};
  if (recording.rig.verdict != RigVerdict::kRefused) {
    scale["sigma"] = recording.scale_sigma;
    scale["stature_m"] = NumberOrNull(recording.stature_m);
  }
  const Json report = {
      {"cameras_fingerprint", fingerprint.empty() ? Json() : Json(fingerprint)},
      {"verdict", ToString(recording.rig.verdict)},
      {"reasons", recording.rig.reasons},
      {"views", of_views},
      {"left_out", left_out},
      {"scale", scale},
      {"likely_right", recording.rig.likely_right},
      {"likely_right_by_lenses", recording.rig.likely_by_lenses},
      {"floor", recording.ground.has_value()},
      {"clocks_told", recording.rig.clocks_told},
      {"clocks", clocks},
      {"covariance", RowsJson(recording.record.covariance)}};
  return DumpJson(report, 1) + "\n";
}

// Mean residuals on held-out parts, over the joined views.
std::string LeftOutText(const RigResult& rig) {
  const std::pair<const char*, double LeftOutPx::*> kinds[] = {
      {"frames", &LeftOutPx::frames},
      {"joints", &LeftOutPx::joints},
      {"people", &LeftOutPx::people}};
  std::vector<std::string> parts;
  for (const auto& [name, px] : kinds) {
    double sum = 0.0;
    for (const int v : rig.used) {
      sum += rig.views[static_cast<size_t>(v)].left_out_px.*px;
    }
    if (sum == 0.0) continue;
    parts.push_back(fmt::format("{:.1f} px on other {}",
                                sum / static_cast<double>(rig.used.size()),
                                name));
  }
  return parts.empty() ? ""
                       : fmt::format("held out   {}\n", fmt::join(parts, ", "));
}

std::string MetreText(const RecordingCalibration& recording,
                      const KnownLength& length) {
  const double percent = 100.0 * recording.scale_sigma;
  if (recording.stature_m <= 0.0) {
    return fmt::format("all lengths +- {:.2g} %\n", percent);
  }
  return fmt::format("people {} {:.2f} m tall, all lengths +- {:.2g} %\n",
                     length.kind == KnownLength::Kind::kPopulation
                         ? "are assumed to be"
                         : "are",
                     recording.stature_m, percent);
}

std::string FindingsText(const RecordingCalibration& recording,
                         const KnownLength& length,
                         const std::vector<std::string>& views) {
  std::string text = fmt::format("{}\n", ToString(recording.rig.verdict));
  for (const std::string& reason : recording.rig.reasons) {
    text += "  - " + reason + "\n";
  }
  if (recording.rig.verdict == RigVerdict::kRefused) return text;
  text += fmt::format("{:<10} {:>8} {:>8} {:>8} {:>8}\n", "view", "+- deg",
                      "+- mm", "px", "clock ms");
  for (size_t v = 0; v < views.size(); ++v) {
    const RigView& view = recording.rig.views[v];
    const std::string name = Printable(views[v]);
    if (!view.left_out.empty()) {
      text += fmt::format("{:<10} left out: {}\n", name, view.left_out);
    }
    if (!view.joined) continue;
    text += fmt::format("{:<10} {:8.2f} {:8.0f} {:8.1f} {:8}\n", name,
                        view.rotation_sigma_deg, 1e3 * view.centre_sigma_m,
                        view.mean_px, std::lround(1e3 * view.clock_s));
  }
  return text + LeftOutText(recording.rig) + MetreText(recording, length) +
         "floor      " +
         (recording.ground.has_value()
              ? "from the feet, z up"
              : "unknown: no resting feet were found") +
         "\n";
}

std::string ReportPath(const std::string& out) {
  return WithoutExtension(out) + ".calibrate.json";
}

// Throws before minutes of work if the format cannot express the cameras.
void CheckLenses(const CalibrationInput& input,
                 const CalibrationFormat& format) {
  if (format.name != "tum") return;
  if (!input.lenses_known) {
    throw InputError(
        "--to=tum: its matrices cannot express the lenses that are estimated; "
        "write cameras.json, then use `kinegraph convert --to=tum "
        "--set=cameras.ignore_distortion=true`");
  }
  for (const Camera& camera : input.cameras) {
    if (camera.lens() == nullptr) continue;
    throw InputError(FLAGS_cameras, "camera '" + Printable(camera.name()) + "'",
                     "has a lens, which --to=tum cannot express "
                     "(--set=cameras.ignore_distortion=true omits it)");
  }
}

// Throws for an unusable --out before minutes of work. To be called after
// reading: only then is an --out that is itself an input refused, and no folder
// is made for input that cannot be read.
void CheckOutput() {
  const std::string path = WithFolders(FLAGS_out);
  AtomicFiles files;
  // Some formats are folders.
  if (FLAGS_to != "kinegraph" && IsFolder(path)) {
    files.FolderAside(path);
  } else {
    files.Aside(path);
  }
  if (!IsStream(path)) files.Aside(ReportPath(path));
}

void WriteCalibration(const RecordingCalibration& recording,
                      const CalibrationFormat& format,
                      const std::string& path) {
  if (format.name == "kinegraph") {
    WriteCameras(path, recording.cameras, RefinementJson(recording.record));
    return;
  }
  LostFields lost_fields;
  format.write(path, recording.cameras, &lost_fields);
  lost_fields.push_back("clocks and covariance are written to " +
                        ReportPath(FLAGS_out) + " only");
  SayNotes(lost_fields);
}

// The calibration and its report appear together. A refusal removes an older
// calibration of the same name, unless it is a folder.
void WriteAll(const RecordingCalibration& recording, const KnownLength& length,
              const std::vector<std::string>& views,
              const CalibrationFormat& format) {
  const bool refused = recording.rig.verdict == RigVerdict::kRefused;
  AtomicFiles files;
  const bool is_folder = IsFolder(FLAGS_out);
  const std::string aside =
      is_folder ? files.FolderAside(FLAGS_out) : files.Aside(FLAGS_out);
  if (!refused) WriteCalibration(recording, format, aside);
  if (!IsStream(FLAGS_out)) {
    WriteTextFile(files.Aside(ReportPath(FLAGS_out)),
                  JsonReport(recording, length, views,
                             refused ? "" : FingerprintOfTracks(aside)));
    if (refused && !is_folder) files.RemoveOld(FLAGS_out);
  }
  files.Commit();
}

// The flag with which `track` uses only the views that the calibration
// contains, if it lacks some.
std::string UseFlag(const RecordingCalibration& recording) {
  if (recording.cameras.size() == recording.view_names.size()) return "";
  std::string list;
  for (const Camera& camera : recording.cameras) {
    list += (list.empty() ? "\"" : ",\"") + Printable(camera.name()) + "\"";
  }
  return "; to use it add '--set=cameras.use=[" + list + "]'";
}

void RunCalibrate() {
  UseAdapterFlag();
  RequireFlag("detections", FLAGS_detections);
  RequireFlag("out", FLAGS_out);
  const CalibrationFormat* format = FindCalibrationFormat(FLAGS_to);
  if (format == nullptr || format->write == nullptr) {
    throw InputError("--to: '" + Printable(FLAGS_to) +
                     "' is not a calibration format that can be written; "
                     "`convert --formats` lists them");
  }
  const RunOptions options =
      DefaultOptions(FLAGS_frame_rate, FLAGS_skeleton, FLAGS_set);
  const DetectionSequence detections =
      ReadDetections(FLAGS_detections, DetectionOptionsOf(options));
  if (detections.header.view_names.size() < 2) {
    throw InputError("--detections: found one view, expected two or more");
  }
  if (!(detections.header.frame_rate_hz > 0.0)) {
    throw InputError(
        "--frame_rate: not given, and the detections do not specify it [Hz]");
  }
  CalibrationInput input = InputOfFlags(options, detections);
  CheckLenses(input, *format);
  CheckOutput();
  std::unique_ptr<Progress> progress;
  std::string stage;
  input.progress = [&](const std::string& now, int done, int total) {
    if (now != stage || progress == nullptr) {
      progress.reset();
      progress = std::make_unique<Progress>(now, total);
      stage = now;
    }
    progress->Set(done);
  };
  const RecordingCalibration recording =
      CalibrateRecording(options, input, detections);
  progress.reset();
  WriteAll(recording, input.length, recording.view_names, *format);
  const bool refused = recording.rig.verdict == RigVerdict::kRefused;
  const std::string text =
      FindingsText(recording, input.length, recording.view_names) +
      (refused ? "" : "-> " + FLAGS_out + UseFlag(recording) + "\n");
  std::fputs(text.c_str(), SummaryStream(FLAGS_out));
  if (refused) {
    throw std::runtime_error("refused: no calibration is written" +
                             (IsStream(FLAGS_out) ? ""
                                                  : "; for the reasons see " +
                                                        ReportPath(FLAGS_out)));
  }
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"calibrate",
       "finds cameras and clocks from the people, without a calibration",
       "--detections=PATH [--image_size=W,H] [--focal=PX,..|--cameras=F] "
       "[--frame_rate=HZ] [--in_step]\n"
       "    [--scale=M|--distance=JOINT,JOINT,M|--cameras_apart=A,B,M] "
       "--out=cameras.json",
       {"--detections=openpose/ --image_size=1920,1080 --frame_rate=25 "
        "--scale=1.75 --out=cameras.json",
        "--detections=openpose/ --cameras=lenses.json "
        "--cameras_apart=cam1,cam2,3.2 --out=cameras.json"}},
      kinegraph::RunCalibrate);
}
