// The data for the tables: recordings and results of other programs, by their
// paths below the data folder; methods to track the recordings, by their
// configurations below configs/; and the printed tables of Chu et al. (2021).
#ifndef KINEGRAPH_APPS_TABLES_DATASET_H_
#define KINEGRAPH_APPS_TABLES_DATASET_H_

#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/evaluation/pcp.h"
#include "solvers/session/run.h"

namespace kinegraph {

struct Dataset {
  std::string name;  // "Shelf, filled"
  // The source of the detections, printed with every table based on them.
  std::string detections_note;
  std::string cameras;  // paths below the data folder
  std::string detections;
  std::string ground_truth;
  std::string config;              // below configs/
  std::string set;                 // as in --set
  std::vector<FrameRange> frames;  // tracked; empty: all
  PcpProtocol protocol;
};

// Shelf with detections in which missing joints are filled in, tracked with the
// configuration of the authors' code; Shelf with the detector's own output,
// tracked with the parameters of the paper's text; Campus with three levels of
// modelled noise.
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

// Throws InputError naming the first file below `data_folder` that is missing
// or cannot be read.
LoadedDataset LoadDataset(const Dataset& dataset,
                          const std::string& data_folder);

// Tracks the recording.
TrackSequence TracksOf(const LoadedDataset& loaded, const RunOptions& options);
inline TrackSequence TracksOf(const LoadedDataset& loaded) {
  return TracksOf(loaded, loaded.options);
}

// Names of methods that tables look up.
inline constexpr const char* kChen = "†Chen et al.";
inline constexpr const char* kChenWithFilter = "†Chen et al. + joints filter";

// A tracking method.
struct Method {
  std::string name;    // "paper mode, text"
  std::string config;  // below configs/
  std::string set;     // as in --set
};

// A recording tracked by several methods, at least one; the first is the
// baseline. Their configurations and sets replace those of `dataset`.
struct BenchmarkRecording {
  Dataset dataset;
  std::vector<Method> methods;
};

// The result of another program.
struct ResultFile {
  std::string method;
  std::string path;  // below the data folder
  std::string detections_note;
  std::string remark;  // remark on its scores
  // Name of the recording with whose first method it is compared; may be empty.
  std::string same_recording;
};

enum class BenchmarkSet { kShelf, kCampus };

// A result under its own program's rules, which differ from the benchmark's.
struct OwnRules {
  ResultFile result;
  std::string ground_truth;  // below the data folder
  PcpProtocol protocol;
  std::string rules;  // description
};

// One benchmark: everything scored against one ground truth.
struct Benchmark {
  BenchmarkSet set = BenchmarkSet::kShelf;
  std::string ground_truth;  // below the data folder
  std::vector<BenchmarkRecording> recordings;
  std::vector<ResultFile> results;        // of all people in the recording
  std::vector<ResultFile> single_person;  // of actor 0 only
  std::vector<OwnRules> own_rules;

  bool is_shelf() const { return set == BenchmarkSet::kShelf; }
};

struct BenchmarkData {
  std::string folder;  // the data folder
  std::string set;  // applied to each run after the method's own, as in --set
  std::vector<Benchmark> benchmarks;
};

// Finds the benchmarks in `folder`, each in the developers' layout (below
// shelf/ or campus/) or as an official download (docs/official_data.md). Throws
// InputError listing the expected files if there is none, or if a download with
// actorsGT.mat lacks a calibration or detections.
BenchmarkData FindBenchmarks(const std::string& folder, const std::string& set);

// Reads the recording with the configuration of a method.
LoadedDataset LoadDataset(const BenchmarkData& data,
                          const BenchmarkRecording& recording,
                          const Method& method);

// A line of a printed table. Cells are texts, so that "98" stays "98"; "-" is a
// cell left empty in the paper.
struct PublishedRow {
  std::string method;
  std::vector<std::string> cells;
};

struct PublishedTable {
  std::string caption;  // place in the paper, and remarks
  std::vector<std::string> columns;
  std::vector<PublishedRow> rows;
};

// PCP [%] of the paper's Actor1..3 (0..2 here) and their average.
PublishedTable PublishedCampus();
PublishedTable PublishedCampusExtended();
PublishedTable PublishedShelf();
// PCP [%] of upper and lower arms and legs.
PublishedTable PublishedCampusParts();
PublishedTable PublishedShelfParts();
// Milliseconds per frame by stage on Shelf, and frames per second.
PublishedTable PublishedRuntime();
// The ablation, quoted from the text, because the values of the figure are not
// available.
PublishedTable PublishedAblation();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_DATASET_H_
