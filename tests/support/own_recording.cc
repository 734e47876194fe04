#include "tests/support/own_recording.h"

#include <array>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "core/evaluation/mpjpe.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/program.h"

namespace kinegraph::testing {
namespace {

struct Detector {
  const char* format;
  const char* skeleton;
  int people;
};

// MediaPipe finds one person.
constexpr std::array<Detector, 5> kDetectors = {
    {{"openpose", "body25", 2},
     {"openpose", "body25b", 2},
     {"mmpose", "halpe26", 2},
     {"coco", "coco17", 2},
     {"mediapipe", "mediapipe33", 1}}};
constexpr std::array<double, 3> kRatesHz = {25.0, 60.0, 120.0};
constexpr std::array<double, 2> kUnitsPerM = {1.0, 1000.0};
constexpr std::array<double, 4> kFocalsPx = {500.0, 1000.0, 1700.0, 3000.0};

OwnRecording RecordingOf(size_t detector, size_t rate, size_t unit,
                         size_t focal) {
  const Detector& one = kDetectors[detector];
  return {one.format,
          one.skeleton,
          kRatesHz[rate],
          kFocalsPx[focal],
          kUnitsPerM[unit],
          one.people,
          2.5};
}

std::string Text(double value) { return std::to_string(value); }

std::string SceneKeys(const OwnRecording& recording) {
  const int width = static_cast<int>(1.6 * recording.focal_px);
  return "scene.skeleton=" + recording.skeleton +
         ";scene.frame_rate=" + Text(recording.frame_rate_hz) +
         ";scene.duration=" + Text(recording.duration_s) +
         ";scene.people=" + std::to_string(recording.people) +
         ";scene.motion.visitors=0;scene.motion.area_radius=1.5"
         ";scene.cameras.count=4;scene.cameras.focal=" +
         Text(recording.focal_px) +
         ";scene.cameras.radius=" + Text(recording.radius_m()) +
         ";scene.cameras.image_width=" + std::to_string(width) +
         ";scene.cameras.image_height=" + std::to_string(width * 9 / 16);
}

// Noise that is the same share of a person's size in every image: 4 px at
// 800 px and 6.5 m.
std::string SceneToml(const OwnRecording& recording) {
  return "[scene]\nseed = 8\n[noise]\nseed = 7\nsigma = " +
         Text(4.0 * recording.focal_px / 800.0) +
         "\nreference_depth = 6.5\ncorrelation_time = 0.1\nwhite_share = 0.5\n"
         "missing_rate = 0.03\nconfidence = 0.8\n";
}

// Appends to `failed` what did not end well.
std::string Run(const std::string& command, const std::string& arguments,
                std::string* failed) {
  const ProgramOutcome outcome = RunProgram(command, arguments);
  if (outcome.exit_code != 0) *failed += command + ": " + outcome.errors;
  return outcome.output;
}

double ErrorOf(const std::string& tracks, const std::string& truth) {
  return EvaluateMpjpe(ReadTracks(truth), ReadTracks(tracks)).raw_m;
}

}  // namespace

double OwnRecording::radius_m() const { return 4.0 + focal_px / 750.0; }

std::string OwnRecording::unit() const {
  return unit_per_m == 1000.0 ? "mm" : "the calibration's own";
}

std::string OwnRecording::name() const {
  const auto whole = [](double value) {
    return std::to_string(std::lround(value));
  };
  return skeleton + "_" + whole(frame_rate_hz) + "hz_" + whole(focal_px) +
         "px_" + (unit_per_m == 1000.0 ? "mm" : "m");
}

// Twenty pairs of detector and focal length; rate and unit go round so that
// each meets every detector and every focal length, and the other.
std::vector<OwnRecording> CoveringRecordings() {
  std::vector<OwnRecording> recordings;
  for (size_t d = 0; d < kDetectors.size(); ++d) {
    for (size_t f = 0; f < kFocalsPx.size(); ++f) {
      recordings.push_back(RecordingOf(d, (d + f) % 3, (d + f / 2) % 2, f));
    }
  }
  return recordings;
}

std::vector<OwnRecording> AllRecordings() {
  std::vector<OwnRecording> recordings;
  for (size_t d = 0; d < kDetectors.size(); ++d) {
    for (size_t r = 0; r < kRatesHz.size(); ++r) {
      for (size_t u = 0; u < kUnitsPerM.size(); ++u) {
        for (size_t f = 0; f < kFocalsPx.size(); ++f) {
          recordings.push_back(RecordingOf(d, r, u, f));
        }
      }
    }
  }
  return recordings;
}

void MakeOwnRecording(const OwnRecording& recording,
                      const std::string& folder) {
  const std::string scene = folder + "/scene.toml";
  std::ofstream(scene) << SceneToml(recording);
  std::string failed;
  Run("synthesize",
      "--config='" + scene + "' --set='" + SceneKeys(recording) +
          "' --format=" + recording.format + " --out='" + folder + "'",
      &failed);
  if (!failed.empty()) throw std::runtime_error(failed);
  CameraRig cameras;
  for (const Camera& camera : ReadCameras(folder + "/cameras.json")) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= recording.unit_per_m;
    cameras.emplace_back(parameters);
  }
  LostFields lost_fields;
  WriteCalibration(folder + "/calibration.json", "krt", cameras, &lost_fields);
}

std::string InputsOf(const OwnRecording& recording, const std::string& folder) {
  return "--cameras='" + folder + "/calibration.json' --detections='" + folder +
         "/detections_" + recording.format + "' ";
}

std::string HandMadeKeys(const OwnRecording& recording) {
  const double scale = recording.focal_px / recording.radius_m() / 310.0;
  return "gates.units=pixels;association.alpha_2d=" + Text(70 * scale) +
         ";reconstruction.alpha_epi=" + Text(60 * scale) +
         ";initialisation.alpha_group=" + Text(60 * scale) +
         ";initialisation.alpha_filter=" + Text(60 * scale);
}

OwnRecordingOutcome WalkFiveSteps(const OwnRecording& recording,
                                  const std::string& folder) {
  OwnRecordingOutcome outcome;
  MakeOwnRecording(recording, folder);
  const std::string inputs = InputsOf(recording, folder);
  const std::string config = " --config='" + folder + "/new/my.toml' ";
  outcome.init = Run("init",
                     inputs + "--frame_rate=" + Text(recording.frame_rate_hz) +
                         " --out='" + folder + "/new/my.toml'",
                     &outcome.failed);
  outcome.track =
      Run("track", inputs + config + "--out='" + folder + "/take.jsonl'",
          &outcome.failed);
  Run("report",
      "--tracks='" + folder + "/take.jsonl' " + inputs + config + "--out='" +
          folder + "/page/take.html'",
      &outcome.failed);
  Run("track",
      inputs + config + "--set='" + HandMadeKeys(recording) + "' --out='" +
          folder + "/by_hand.jsonl'",
      &outcome.failed);
  if (!outcome.failed.empty()) return outcome;
  const std::string truth = folder + "/truth.jsonl";
  outcome.error_m = ErrorOf(folder + "/take.jsonl", truth);
  outcome.by_hand_error_m = ErrorOf(folder + "/by_hand.jsonl", truth);
  outcome.identity =
      EvaluateIdentity(ReadTracks(truth), ReadTracks(folder + "/take.jsonl"));
  return outcome;
}

}  // namespace kinegraph::testing
