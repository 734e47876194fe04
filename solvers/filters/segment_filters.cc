#include "solvers/filters/segment_filters.h"

#include <cstdio>
#include <string>

#include "core/base/error.h"
#include "solvers/filters/uniform_time.h"

namespace kinegraph {
namespace {

void RequireBelowNyquist(const std::string& key, double frequency_hz,
                         double rate_hz) {
  if (frequency_hz < 0.5 * rate_hz) return;
  char text[120];
  std::snprintf(text, sizeof(text),
                "found %g Hz, allowed: below half the frame rate of %g Hz",
                frequency_hz, rate_hz);
  throw OptionError(key, text);
}

}  // namespace

void FilterOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("filters");
  segments.Describe(visitor);
  visitor.Enter("centred_gaussian");
  centred_gaussian.Describe(visitor);
  visitor.Leave();
  visitor.Enter("butterworth");
  butterworth.Describe(visitor);
  visitor.Leave();
  visitor.Leave();
}

SegmentFilter RawFilter() {
  return [](const JointSegment& segment) -> SegmentEstimate {
    return {segment.positions_m, {}};
  };
}

SegmentFilter CentredGaussianFilter(const CentredGaussianOptions& options) {
  return [options](const JointSegment& segment) -> SegmentEstimate {
    return {
        CentredGaussian(options.sigma_s, segment.times_s, segment.positions_m),
        {}};
  };
}

SegmentFilter ButterworthFilter(const ButterworthOptions& options,
                                double rate_hz) {
  RequireBelowNyquist("filters.butterworth.cutoff", options.cutoff_hz, rate_hz);
  return [options, rate_hz](const JointSegment& segment) -> SegmentEstimate {
    RequireUniformTime("butterworth", segment.times_s, rate_hz);
    return {ZeroPhaseButterworth(options, rate_hz, segment.positions_m), {}};
  };
}

}  // namespace kinegraph
