// The paper's tables of PCP beside what was measured.
#ifndef KINEGRAPH_APPS_TABLES_PCP_TABLES_H_
#define KINEGRAPH_APPS_TABLES_PCP_TABLES_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/tables/published.h"
#include "apps/tables/rows.h"
#include "core/io/text/json.h"

namespace kinegraph {

// A piece of the report: the same twice.
struct TableOutput {
  std::string markdown;
  std::string details;  // Markdown too, for a page of its own; may be empty
  Json json;
};

// PCP by actor: the printed rows with every measured row under the paper's head
// conversion and mean rule, then the means under every conversion and rule. The
// details hold all counts, and what each actor lost and where.
TableOutput ActorTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol);

// PCP by body part, pooled over the headline's actors and as their mean.
TableOutput PartsTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol);

// The printed table alone, as Markdown and JSON.
TableOutput PrintedTable(const PublishedTable& published);

// "300-302, 410": ascending numbers, runs put together; after `max_runs` the
// rest is counted.
std::string FrameRuns(const std::vector<int64_t>& frames, size_t max_runs);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_PCP_TABLES_H_
