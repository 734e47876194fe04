// The annotation audit as tables, lists and a page.
#ifndef KINEGRAPH_APPS_TABLES_AUDIT_H_
#define KINEGRAPH_APPS_TABLES_AUDIT_H_

#include <functional>
#include <string>
#include <vector>

#include "apps/tables/benchmark.h"
#include "apps/tables/pcp_tables.h"
#include "apps/tables/rows.h"
#include "core/evaluation/annotation_audit.h"

namespace kinegraph {

// One estimate held against the views.
struct AuditedEstimate {
  std::string method;
  std::string made_by;
  PcpResult pcp;
  AuditResult audit;
};

struct AuditedBenchmark {
  std::string title;  // "Shelf"
  std::string detections_note;
  std::string caution;
  std::vector<std::string> view_names;
  CameraRig cameras;  // in the order of the views
  DetectionSequence detections;
  std::vector<AuditedEstimate> estimates;
  // Thresholds tried on the first estimate.
  struct Variation {
    std::string changed;
    AuditResult audit;
  };
  std::vector<Variation> variations;
};

AuditedBenchmark RunAudit(const std::string& title, const Benchmark& benchmark,
                          const std::string& data_folder,
                          const std::string& extra_set,
                          const std::function<void()>& progress);
int64_t AuditStepCount(const Benchmark& benchmark);

// `rows` (may be empty) are scored without the annotations that the views
// themselves refute. `page` is the file name of the page that shows the cases.
TableOutput AuditTable(const AuditedBenchmark& audited,
                       const std::vector<TrackedRow>& rows,
                       const TrackSequence& truth, const std::string& page);

// Every case: frame, actor, part, and the evidence of each view.
std::string AuditCasesMarkdown(const AuditedBenchmark& audited);
Json AuditCasesJson(const AuditedBenchmark& audited);

// A page that needs no other file and no network: each case drawn in each view.
std::string AuditPage(const AuditedBenchmark& audited);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_TABLES_AUDIT_H_
