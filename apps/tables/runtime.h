// The paper's table of runtimes by stage.
#ifndef KINEGRAPH_APPS_TABLES_RUNTIME_H_
#define KINEGRAPH_APPS_TABLES_RUNTIME_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/tables/benchmark.h"
#include "apps/tables/pcp_tables.h"

namespace kinegraph {

struct RuntimeOptions {
  int repetitions = 11;      // of each method; the median counts
  double max_seconds = 5.0;  // a method, after its second repetition
};

// Every method of each benchmark's first two recordings, with and without the
// joints filter in paper mode; detections in memory, one thread, processor
// time.
TableOutput RuntimeTable(const std::vector<Benchmark>& benchmarks,
                         const std::string& data_folder,
                         const std::string& extra_set,
                         const RuntimeOptions& options,
                         const std::function<void()>& progress);
int64_t RuntimeRowCount(const std::vector<Benchmark>& benchmarks);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_RUNTIME_H_
