#include "apps/tables/dataset.h"

#include "apps/common/config_folder.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

Dataset Shelf(const std::string& name, const std::string& note,
              const std::string& detections, const std::string& config,
              const std::string& set) {
  Dataset dataset;
  dataset.name = "Shelf, " + name;
  dataset.detections_note = note;
  dataset.cameras = "shelf/calibration.json";
  dataset.detections = detections;
  dataset.ground_truth = "shelf/tum/actorsGT.mat";
  dataset.config = config;
  dataset.set = set;
  dataset.protocol = ShelfProtocol();
  return dataset;
}

}  // namespace

Dataset ShelfFilled() {
  return Shelf(
      "filled",
      "OpenPose with missing joints filled in (confidence 0), as fed to "
      "the authors' code; warmed up with three frames",
      "shelf/reference/filled_coco17", "paper/shelf_authors_code.toml",
      "input.repeat_first_frame=3");
}

Dataset ShelfReal() {
  return Shelf("real", "OpenPose as it is, frames 300..600 only",
               "shelf/detections/openpose", "paper/shelf.toml", "");
}

Dataset CampusModelled(const std::string& level) {
  Dataset dataset;
  dataset.name = "Campus, modelled " + level;
  dataset.detections_note =
      "modelled noise (" + level + ") on the annotation, no detector's output";
  dataset.cameras = "campus/calibration.json";
  dataset.detections = "campus/detections_modelled/" + level;
  dataset.ground_truth = "campus/annotation_3d.json";
  dataset.config = "paper/campus.toml";
  dataset.protocol = CampusProtocol();
  return dataset;
}

LoadedDataset LoadDataset(const Dataset& dataset,
                          const std::string& data_folder) {
  LoadedDataset loaded;
  loaded.dataset = dataset;
  loaded.options =
      ReadRunOptions(ProjectConfig(dataset.config), dataset.set, "");
  const std::string root = data_folder + "/";
  loaded.request.frames = dataset.frames;
  loaded.request.cameras =
      ReadCameras(root + dataset.cameras, loaded.options.cameras);
  loaded.detections = ReadDetections(root + dataset.detections,
                                     DetectionOptionsOf(loaded.options));
  TrackReadOptions truth;
  truth.frame_rate_hz = loaded.options.input.frame_rate_hz;
  loaded.truth = ReadTracks(root + dataset.ground_truth, truth);
  return loaded;
}

TrackSequence TracksOf(const LoadedDataset& loaded, const RunOptions& options) {
  return TrackSequenceOf(options, loaded.request, loaded.detections);
}

std::string JoinSets(const std::string& first, const std::string& second) {
  return first.empty() || second.empty() ? first + second
                                         : first + ";" + second;
}

}  // namespace kinegraph
