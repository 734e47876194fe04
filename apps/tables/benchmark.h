// What each table is made of: recordings, ways to track them, results of
// others.
#ifndef KINEGRAPH_APPS_TABLES_BENCHMARK_H_
#define KINEGRAPH_APPS_TABLES_BENCHMARK_H_

#include <optional>
#include <string>
#include <vector>

#include "apps/tables/dataset.h"
#include "apps/tables/published.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {

// Names of methods that tables look for.
inline constexpr const char* kChen = "†Chen et al.";
inline constexpr const char* kChenWithFilter = "†Chen et al. + joints filter";

// A way from detections to tracks.
struct Method {
  std::string name;    // "paper mode, text"
  std::string config;  // below configs/
  std::string set;     // as --set takes it
};

// A recording tracked in every way; the first is what the others are compared
// with. Configuration and set of `dataset` are those of its first method.
struct BenchmarkRecording {
  Dataset dataset;
  std::vector<Method> methods;
};

// What somebody else's program made.
struct ResultFile {
  std::string method;
  std::string path;  // below the data folder
  std::string detections_note;
  std::string remark;  // what to know of its figures
  std::optional<std::string>
      same_recording;  // name of the recording it was made from
};

enum class BenchmarkSet { kShelf, kCampus };

// A result under the rules of its own program, which are not the benchmark's.
struct OwnRules {
  ResultFile result;
  std::string ground_truth;  // below the data folder
  PcpProtocol protocol;
  std::string rules;  // what they are
};

// One benchmark: all that is scored against one ground truth.
struct Benchmark {
  BenchmarkSet set = BenchmarkSet::kShelf;
  std::string ground_truth;  // below the data folder
  std::vector<BenchmarkRecording> recordings;
  std::vector<ResultFile> results;        // of everybody in the recording
  std::vector<ResultFile> single_person;  // of actor 0 alone
  std::vector<OwnRules> own_rules;
};

struct BenchmarkData {
  std::string folder;  // everything above is below it
  std::string note;    // what was found there
  std::vector<Benchmark> benchmarks;
};

// What is in `data_folder`: either the developers' layout (shelf/, campus/ with
// their READMEs) or official downloads (docs/official_data.md). Throws
// InputError saying what was looked for when it is neither.
BenchmarkData FindBenchmarks(const std::string& data_folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_BENCHMARK_H_
