// kinegraph-doctor: finds errors of the calibration and the clocks of a
// recording.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/recording_output.h"
#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "solvers/session/diagnose.h"

DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(config, "",
              "configuration (TOML); without it configs/default.toml");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(frames, "", "frames to use: A:B includes A and excludes B");
DEFINE_string(without_cameras, "", "names of cameras to leave out: a,b");
DEFINE_string(out, "", "folder to write: doctor.json, cameras.json, doctor.md");

namespace kinegraph {
namespace {

std::string JsonReport(const Diagnosis& diagnosis) {
  Json findings = Json::array();
  for (const Finding& finding : diagnosis.findings) {
    findings.push_back(
        {{"kind", finding.kind},
         {"camera", finding.camera.empty() ? Json() : Json(finding.camera)},
         {"confidence", finding.confidence},
         {"before_px", finding.before_px},
         {"after_px", finding.after_px},
         {"fix", finding.fix},
         {"evidence", finding.evidence}});
  }
  const Json report = {{"verdict", ToString(diagnosis.verdict)},
                       {"findings", findings},
                       {"notes", diagnosis.notes}};
  return DumpJson(report, 1) + "\n";
}

std::string Sentence(const Finding& finding) {
  std::string text = finding.kind;
  if (!finding.camera.empty()) text += " of " + finding.camera;
  text += fmt::format(" (confidence {:.2f}): {}", finding.confidence,
                      finding.evidence);
  if (finding.before_px != finding.after_px) {
    text += fmt::format("; residual {:.2f} px, with the fix {:.2f} px",
                        finding.before_px, finding.after_px);
  }
  return text + ". Fix: " + finding.fix;
}

std::string MarkdownReport(const Diagnosis& diagnosis) {
  std::string text = fmt::format("# Calibration and clocks: {}\n\n",
                                 ToString(diagnosis.verdict));
  for (const Finding& finding : diagnosis.findings) {
    text += "- " + Sentence(finding) + "\n";
  }
  if (!diagnosis.findings.empty()) text += "\n";
  text += "Observations:\n\n";
  for (const std::string& note : diagnosis.notes) text += "- " + note + "\n";
  return text +
         "\n`cameras.json` beside this file is the calibration with the "
         "estimated corrections of the cameras; clocks are not corrected.\n";
}

// Reads the recording. If its frame rate is unknown, assumes 25 Hz, or throws
// for a pipe.
DetectionSequence ReadRecording(RunOptions* options, std::string* note) {
  DetectionSequence recording =
      ReadDetections(FLAGS_detections, DetectionOptionsOf(*options));
  if (recording.header.frame_rate_hz > 0.0) return recording;
  if (IsPipe(FLAGS_detections)) {
    throw OptionError("input.frame_rate",
                      "not given, and the detections do not specify it [Hz]; "
                      "a pipe cannot be read again with an assumed rate");
  }
  options->input.frame_rate_hz = 25.0;
  *note =
      "no frame rate is given (input.frame_rate): 25 Hz is assumed; multiply "
      "clock errors in ms by 25 Hz / true frame rate";
  return ReadDetections(FLAGS_detections, DetectionOptionsOf(*options));
}

void RequireFrames(const RunRequest& request,
                   const DetectionSequence& recording) {
  if (std::any_of(recording.frames.begin(), recording.frames.end(),
                  [&](const DetectionFrame& one) {
                    return ContainsFrame(request.frames, one.frame);
                  })) {
    return;
  }
  std::string asked;
  if (!FLAGS_frames.empty()) asked = " in --frames=" + FLAGS_frames;
  if (!recording.frames.empty()) {
    asked += fmt::format(", the recording has {} .. {}",
                         recording.frames.front().frame,
                         recording.frames.back().frame);
  }
  throw InputError(FLAGS_detections, "", "no frame to examine" + asked);
}

bool AreAlike(const Camera& a, const Camera& b) {
  return a.K() == b.K() && a.R() == b.R() && a.t() == b.t() &&
         a.lens() == b.lens();
}

// The calibration's refinement record for the corrected cameras: the clocks
// and, if no camera changed, the covariance. Empty without a record.
std::string RecordFor(const CameraRig& corrected, const CameraRig& stated,
                      std::optional<RefinementRecord> record) {
  if (!record.has_value()) return "";
  const bool stay = std::all_of(
      corrected.begin(), corrected.end(), [&](const Camera& camera) {
        return std::any_of(stated.begin(), stated.end(), [&](const auto& one) {
          return one.name() == camera.name() && AreAlike(one, camera);
        });
      });
  if (!stay) {
    record->covariance.resize(0, 0);
    for (RefinementRecord::Camera& camera : record->cameras) {
      camera.places.clear();
    }
  }
  return RefinementJson(*record);
}

// Adds to the corrected cameras those of the calibration that belong to no
// view. If a finding changes the whole calibration, these would have to change
// too, and a note names them instead.
void AddOtherCameras(const RunRequest& request, Diagnosis* diagnosis) {
  const auto has = [](const auto& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const std::vector<std::string> of_all = {"unit", "convention", "intrinsics",
                                           "image", "lens"};
  const bool all_change =
      std::any_of(diagnosis->findings.begin(), diagnosis->findings.end(),
                  [&](const Finding& one) {
                    return one.camera.empty() && has(of_all, one.kind);
                  });
  std::vector<std::string> examined;
  for (const Camera& camera : diagnosis->cameras) {
    examined.push_back(camera.name());
  }
  for (const Camera& camera : request.cameras) {
    const std::string& name = camera.name();
    if (has(examined, name) || has(request.without_cameras, name)) continue;
    if (!all_change) {
      diagnosis->cameras.push_back(camera);
      continue;
    }
    diagnosis->notes.push_back("cameras.json lacks '" + Printable(name) +
                               "', which was not examined");
  }
}

void RunDoctor() {
  UseAdapterFlag();
  RequireFlag("cameras", FLAGS_cameras);
  RequireFlag("detections", FLAGS_detections);
  RequireFlag("out", FLAGS_out);
  RunOptions options = OptionsOfFlags(FLAGS_config, FLAGS_set, "");
  RunRequest request;
  request.frames = ParseFrameRanges(FLAGS_frames);
  request.without_cameras = ParseList(FLAGS_without_cameras, "without_cameras");
  request.cameras = ReadCameras(FLAGS_cameras, options.cameras);
  const CalibrationUnit unit =
      UnitOfCalibration(FLAGS_cameras, options.cameras);
  std::string note;
  const DetectionSequence recording = ReadRecording(&options, &note);
  RequireFrames(request, recording);
  const auto record = ReadRefinementRecord(FLAGS_cameras);
  AtomicFolder folder(WithFolders(FLAGS_out));
  Diagnosis diagnosis =
      DiagnoseRecording(options, request, recording, unit, record);
  AddOtherCameras(request, &diagnosis);
  NameInputs(
      Flag("cameras", FLAGS_cameras) + Flag("detections", FLAGS_detections),
      Flag("config", FLAGS_config) + Flag("set", FLAGS_set) +
          Flag("without_cameras", FLAGS_without_cameras),
      FLAGS_out + "/cameras.json", &diagnosis.findings);
  if (!note.empty()) diagnosis.notes.push_back(note);
  WriteTextFile(folder.PathOf("doctor.json"), JsonReport(diagnosis));
  WriteTextFile(folder.PathOf("doctor.md"), MarkdownReport(diagnosis));
  WriteCameras(folder.PathOf("cameras.json"), diagnosis.cameras,
               RecordFor(diagnosis.cameras, request.cameras, record));
  folder.Commit();
  std::printf("%s\n", ToString(diagnosis.verdict));
  for (const Finding& finding : diagnosis.findings) {
    std::printf("  %s\n", Sentence(finding).c_str());
  }
  for (const std::string& one : diagnosis.notes) {
    std::printf("  - %s\n", one.c_str());
  }
  std::printf("-> %s\n", FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"doctor",
       "finds what is wrong with a calibration or with clocks",
       "--cameras=F --detections=PATH [--config=F.toml] --out=DIR",
       {"--cameras=calibration.json --detections=openpose/ --out=out/doctor",
        "--cameras=calibration.json --detections=openpose/ --config=my.toml "
        "--out=out/doctor"}},
      kinegraph::RunDoctor);
}
