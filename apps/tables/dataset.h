// The recordings on which tables are made, by their places below the data
// folder.
#ifndef KINEGRAPH_APPS_TABLES_DATASET_H_
#define KINEGRAPH_APPS_TABLES_DATASET_H_

#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/evaluation/pcp.h"
#include "solvers/session/run.h"

namespace kinegraph {

struct Dataset {
  std::string name;  // "Shelf, filled"
  // What the detections are: printed with every table made from them.
  std::string detections_note;
  std::string cameras;  // paths below the data folder
  std::string detections;
  std::string ground_truth;
  std::string config;              // below configs/
  std::string set;                 // as --set takes it
  std::vector<FrameRange> frames;  // tracked; none: all
  PcpProtocol protocol;
};

// Shelf with the reference's filled detections (the authors' configuration,
// warmed up as they do) and with real ones (the paper's text), Campus with
// three levels of modelled noise.
Dataset ShelfFilled();
Dataset ShelfReal();
Dataset CampusModelled(const std::string& level);  // clean, typical, hard

// A dataset read into memory.
struct LoadedDataset {
  Dataset dataset;
  RunOptions options;
  RunRequest request;
  DetectionSequence detections;
  TrackSequence truth;
};

// Throws InputError naming what is missing below `data_folder`.
LoadedDataset LoadDataset(const Dataset& dataset,
                          const std::string& data_folder);

// The recording tracked.
TrackSequence TracksOf(const LoadedDataset& loaded, const RunOptions& options);
inline TrackSequence TracksOf(const LoadedDataset& loaded) {
  return TracksOf(loaded, loaded.options);
}

// Two lists of --set after one another; either may be empty.
std::string JoinSets(const std::string& first, const std::string& second);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_DATASET_H_
