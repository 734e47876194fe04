// Everybody's tracks of a benchmark, made or read once and scored in every way.
#ifndef KINEGRAPH_APPS_TABLES_ROWS_H_
#define KINEGRAPH_APPS_TABLES_ROWS_H_

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "apps/tables/benchmark.h"
#include "core/data/pose.h"
#include "core/evaluation/pcp.h"

namespace kinegraph {

// The head conversions of a set, the paper's first.
std::vector<HeadConversion> HeadConversionsOf(BenchmarkSet set);
inline constexpr std::array<EndpointRule, 2> kEndpointRules = {
    EndpointRule::kMean, EndpointRule::kEach};

// Tracks with their maker.
struct TrackedRow {
  std::string method;
  std::string recording;  // name of the detections
  std::string detections_note;
  std::string made_by;  // configuration and set, or the file
  std::string remark;
  bool ours = false;
  bool baseline = false;  // first method of its take
  TrackSequence tracks;
};

struct TrackedBenchmark {
  Benchmark benchmark;
  TrackSequence truth;
  std::vector<TrackedRow> rows;  // ours, recording by recording, then results
  std::vector<TrackedRow> single_person;  // results of actor 0 alone
  std::vector<PcpResult> own_rules;       // of benchmark.own_rules
};

// Runs every method and reads every result. `extra_set` is set in each run, as
// --set takes it; `progress` is told after each row.
TrackedBenchmark TrackBenchmark(const Benchmark& benchmark,
                                const std::string& data_folder,
                                const std::string& extra_set,
                                const std::function<void()>& progress);
// Rows that TrackBenchmark makes.
int64_t RowCount(const Benchmark& benchmark);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_ROWS_H_
