#include "tests/support/shelf.h"

#include "apps/common/config_folder.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/detections/source.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph::testing {

ShelfTake LoadRawShelf(const std::string& data_folder) {
  const std::string shelf = data_folder + "/shelf/";
  // What the files are does not depend on how they are tracked.
  const RunOptions options =
      ReadRunOptions(ProjectConfig("paper/shelf.toml"), "", "");
  ShelfTake take;
  take.detections = ReadDetections(shelf + "detections/openpose",
                                   DetectionOptionsOf(options));
  const std::vector<std::string>& views = take.detections.header.view_names;
  take.cameras = CamerasOfViews(
      views, ReadCameras(shelf + "calibration.json", options.cameras), {});
  take.truth = ReadTracks(shelf + "tum/actorsGT.mat");
  take.set = ReadHeldOutSet(shelf + "reference/held_out_set.json", views);
  take.reference = ReadTracks(shelf + "reference/paper_code_shelf_warm3.json");
  return take;
}

TrackSequence Track(const ShelfTake& take, const RunOptions& options) {
  RunRequest request;
  request.cameras = take.cameras;
  return TrackSequenceOf(options, request, take.detections);
}

HeldOutScores ScoreHeldOutCameras(const ShelfTake& take,
                                  const RunOptions& options) {
  HeldOutScores scores;
  for (size_t view = 0; view < take.cameras.size(); ++view) {
    RunRequest request;
    request.cameras = take.cameras;
    request.without_cameras = {take.detections.header.view_names[view]};
    ScoreHeldOutCamera(take.set, take.detections, static_cast<int>(view),
                       take.cameras[view], take.reference,
                       TrackSequenceOf(options, request, take.detections),
                       &scores);
  }
  return scores;
}

}  // namespace kinegraph::testing
