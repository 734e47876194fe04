// The paper's tables of PCP beside new measurements. All tracks of a benchmark
// are made or read once and scored with both rules for the ends of a part; the
// table by actor also scores tracks of several people with every head
// conversion.
#ifndef KINEGRAPH_APPS_TABLES_PCP_TABLES_H_
#define KINEGRAPH_APPS_TABLES_PCP_TABLES_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/common/progress.h"
#include "apps/tables/dataset.h"
#include "core/data/pose.h"
#include "core/evaluation/pcp.h"
#include "core/io/text/json.h"

namespace kinegraph {

// A part of the report, as Markdown and JSON.
struct TableOutput {
  std::string markdown;
  std::string details;  // Markdown for a separate page; may be empty
  Json json;
};

// Tracks and their origin.
struct TrackedRow {
  std::string method;
  std::string recording;  // name of the detections
  std::string detections_note;
  std::string made_by;  // configuration and --set, or the file
  std::string remark;
  bool ours = false;
  bool baseline = false;  // first method of its recording
  TrackSequence tracks;
};

struct TrackedBenchmark {
  Benchmark benchmark;
  TrackSequence truth;
  // Tracks made here, by recording, then the results of other programs.
  std::vector<TrackedRow> rows;
  std::vector<TrackedRow> single_person;  // results of actor 0 only
  std::vector<PcpResult> own_rules;       // of benchmark.own_rules
};

// Runs every method and reads every result; `progress` advances by RowCount.
TrackedBenchmark TrackBenchmark(const BenchmarkData& data,
                                const Benchmark& benchmark, Progress* progress);
int64_t RowCount(const Benchmark& benchmark);

// Difference between two means over actors [% PCP], paired on the same frames.
struct PcpDifference {
  double value = 0.0;
  Interval interval;

  bool is_significant() const {
    return interval.low > 0.0 || interval.high < 0.0;
  }
};
PcpDifference DifferenceOf(const PcpResult& pcp, const PcpResult& baseline,
                           PcpGroup group = PcpGroup::kTotal);

// Numbers of correct parts and of all parts, and the percentage.
Json PartsJson(const Share& share);

// PCP by actor: the printed rows with every measured row under the paper's head
// conversion and mean rule, then the means under every conversion and rule and,
// if there are any, TrackedBenchmark::own_rules and single_person. The details
// hold all counts and, under the paper's conversion and mean rule, the
// incorrect parts of each actor with their frames.
TableOutput ActorTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol);

// PCP by body part, pooled over the actors of the headline score and as the
// mean over these actors.
TableOutput PartsTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol);

// The printed table alone, as Markdown and JSON.
TableOutput PrintedTable(const PublishedTable& published);

// "300-302, 410" for ascending numbers: consecutive numbers form a run; after
// `max_runs` runs the remaining numbers are only counted.
std::string FrameRuns(const std::vector<int64_t>& frames, size_t max_runs);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_PCP_TABLES_H_
