// Merges the results of all tasks of a batch into tables.
#ifndef KINEGRAPH_APPS_BATCH_MERGE_H_
#define KINEGRAPH_APPS_BATCH_MERGE_H_

#include <optional>
#include <string>
#include <vector>

#include "apps/batch/tasks.h"
#include "core/evaluation/statistics.h"
#include "core/io/text/json.h"

namespace kinegraph {

// A value in the results of one task.
struct BatchValue {
  double value = 0.0;
  double standard_error = 0.0;  // over frames; 0 if unknown
};

// By recording; nullopt if a recording has no value.
using BatchColumn = std::vector<std::optional<BatchValue>>;

// Mean over the recordings that have a value, and its interval: recordings are
// drawn with replacement, and each drawn recording's value from a normal
// distribution with the standard error of its own block bootstrap over frames.
// With a single recording the interval does not include the variation between
// recordings.
struct BatchSummary {
  int recordings = 0;
  double mean = 0.0;
  Interval interval;
};
BatchSummary Summarise(const BatchColumn& column);
// "1.5 [1.2, 1.8]"; "-" without recordings.
std::string SummaryCell(const BatchSummary& summary, int decimals);
// Null without recordings.
Json SummaryJson(const BatchSummary& summary);

// Summarises the differences of two configurations, formed for each recording.
BatchSummary SummariseDifference(const BatchColumn& a, const BatchColumn& b);

// Reads the results below `out` and writes batch.json, batch.csv, batch.md and
// index.html there. Returns the number of unfinished tasks, which the tables
// name.
int MergeBatch(const std::vector<Task>& tasks, const std::string& out);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_BATCH_MERGE_H_
