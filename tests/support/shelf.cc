#include "tests/support/shelf.h"

#include "apps/common/config_folder.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph::testing {

ShelfRecording LoadRawShelf(const std::string& data_folder) {
  const std::string shelf = data_folder + "/shelf/";
  // What the files are does not depend on how they are tracked.
  const RunOptions options =
      ReadRunOptions(ProjectConfig("paper/shelf.toml"), "", "");
  ShelfRecording recording;
  recording.detections = ReadDetections(shelf + "detections/openpose",
                                        DetectionOptionsOf(options));
  const std::vector<std::string>& views =
      recording.detections.header.view_names;
  recording.cameras = CamerasOfViews(
      views, ReadCameras(shelf + "calibration.json", options.cameras), {});
  recording.truth = ReadTracks(shelf + "tum/actorsGT.mat");
  recording.set = ReadHeldOutSet(shelf + "reference/held_out_set.json", views);
  recording.reference =
      ReadTracks(shelf + "reference/paper_code_shelf_warm3.json");
  return recording;
}

TrackSequence Track(const ShelfRecording& recording,
                    const RunOptions& options) {
  RunRequest request;
  request.cameras = recording.cameras;
  return TrackSequenceOf(options, request, recording.detections);
}

HeldOutScores ScoreHeldOutCameras(const ShelfRecording& recording,
                                  const RunOptions& options) {
  HeldOutScores scores;
  for (size_t view = 0; view < recording.cameras.size(); ++view) {
    RunRequest request;
    request.cameras = recording.cameras;
    request.without_cameras = {recording.detections.header.view_names[view]};
    ScoreHeldOutCamera(
        recording.set, recording.detections, static_cast<int>(view),
        recording.cameras[view], recording.reference,
        TrackSequenceOf(options, request, recording.detections), &scores);
  }
  return scores;
}

}  // namespace kinegraph::testing
