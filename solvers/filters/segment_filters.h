// The filters that offline_filter.h can apply to a joint, each with its
// options.
#ifndef KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_
#define KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_

#include "core/base/options.h"
#include "solvers/filters/butterworth.h"
#include "solvers/filters/centred_gaussian.h"
#include "solvers/filters/joint_segment.h"
#include "solvers/filters/offline_filter.h"

namespace kinegraph {

struct FilterOptions {
  OfflineFilterOptions segments;
  CentredGaussianOptions centred_gaussian;
  ButterworthOptions butterworth;

  // Table [filters], a table below it for each filter.
  void Describe(OptionVisitor& visitor);
};

// Each checks its options against the frame rate [Hz] (OptionError). Filters
// that need uniform time throw InputError for a segment without.
SegmentFilter RawFilter();  // the points as they are
SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options);
SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FILTERS_SEGMENT_FILTERS_H_
