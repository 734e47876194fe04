// The paper's ablation: part-aware or body-aware affinity, with or without the
// joints filter.
#ifndef KINEGRAPH_APPS_TABLES_ABLATION_H_
#define KINEGRAPH_APPS_TABLES_ABLATION_H_

#include <optional>
#include <string>
#include <vector>

#include "apps/common/plot.h"
#include "apps/tables/benchmark.h"
#include "apps/tables/dataset.h"
#include "apps/tables/pcp_tables.h"
#include "core/evaluation/identity.h"
#include "core/evaluation/pcp.h"
#include "core/io/text/json.h"

namespace kinegraph {

struct AblationCell {
  AffinityKind affinity = AffinityKind::kBody;
  bool joints_filter = false;
  PcpResult pcp;
  IdentityResult identity;  // of the scored frames
  // Of the mean of actors against the baseline (body-aware, no filter), on the
  // same frames; zero for the baseline itself.
  double difference = 0.0;
  Interval difference_interval;
};

// The four cells; the baseline (body-aware without filter) first, the whole
// paper last. "Without" means the update's filter: initialisation keeps its
// own.
std::vector<AblationCell> RunAblation(const LoadedDataset& loaded);

// The joints filter in the front end of Chen et al., by which the paper shows
// that it helps others too.
struct FilterInChen {
  std::string recording;
  PcpResult without;
  PcpResult with;
};
// nullopt when the recording is not tracked both ways.
std::optional<FilterInChen> RunFilterInChen(const BenchmarkRecording& recording,
                                            const std::string& data_folder,
                                            const std::string& extra_set);
TableOutput FilterInChenTable(const std::vector<FilterInChen>& recordings);

// The paper's bars: what each ingredient adds to the baseline, with the paired
// interval; a panel for the headline and one for the lower arms.
struct AblatedRecording {
  std::string name;
  std::vector<AblationCell> cells;  // as RunAblation gives them
};
std::vector<Plot> AblationPlots(
    const std::vector<AblatedRecording>& recordings);

std::string AblationMarkdown(const LoadedDataset& loaded,
                             const std::vector<AblationCell>& cells);
Json AblationJson(const LoadedDataset& loaded,
                  const std::vector<AblationCell>& cells);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_ABLATION_H_
