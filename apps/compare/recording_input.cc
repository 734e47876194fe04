#include "apps/compare/recording_input.h"

#include <optional>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/config.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/source.h"
#include "solvers/session/refine_recording.h"

namespace kinegraph {
std::vector<RecordingInput> RecordingsOf(const Manifest& manifest,
                                         const std::string& path,
                                         const std::string& config,
                                         const std::string& mode,
                                         const std::string& set) {
  if (manifest.recordings.size() < 2) {
    throw InputError(path, "takes",
                     "found one, expected two or more: what is chosen on some "
                     "is scored on others");
  }
  ManifestConfiguration own;
  if (!config.empty()) {
    own.config = config;
  } else if (manifest.configurations.size() == 1) {
    own = manifest.configurations.front();
  } else {
    throw InputError(path, "configurations",
                     "found " + std::to_string(manifest.configurations.size()) +
                         ", expected one, or --config");
  }
  std::vector<RecordingInput> recordings;
  for (const ManifestRecording& recording : manifest.recordings) {
    RecordingInput& input = recordings.emplace_back();
    input.name = recording.name;
    input.cameras = recording.cameras;
    input.detections = recording.detections;
    input.config = own.config;
    input.mode = mode.empty() ? own.mode : mode;
    input.set = JoinSets(JoinSets(own.set, recording.set), set);
    input.frames = recording.frames;
  }
  return recordings;
}

FrozenRecording FreezeRecording(const RecordingInput& input, int threads) {
  FrozenRecording recording;
  recording.options =
      ReadRunOptions(FindConfig(input.config), input.set, input.mode);
  RunRequest request;
  request.cameras = ReadCameras(input.cameras, recording.options.cameras);
  request.frames = ParseFrameRanges(input.frames);
  request.threads = threads;
  DetectionSequence detections =
      ReadDetections(input.detections, DetectionOptionsOf(recording.options));
  const auto record = ReadRefinementRecord(input.cameras);
  if (record.has_value() && record->has_clocks()) {
    detections =
        WithRecordedClocks(recording.options, request, *record, detections);
  }
  recording.run = FreezeTracking(recording.options, request, detections);
  if (recording.run.tracks.frames.empty()) {
    throw InputError(input.detections, "", "no frame in the frames asked for");
  }
  return recording;
}

}  // namespace kinegraph
