// Selection of the estimators for association and for the output.
#ifndef KINEGRAPH_SOLVERS_FACTORY_H_
#define KINEGRAPH_SOLVERS_FACTORY_H_

#include <memory>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/tracking/estimator.h"
#include "solvers/filters/options.h"
#include "solvers/graph/options.h"

namespace kinegraph {

class RecordingNotes;  // solvers/noise/recording_notes.h

enum class Mode {
  kPaper,  // the paper's causal Gaussian, for association and for the output
  kGraph,  // the two kinds that `feedback` and `output` select
};
const char* ToString(Mode mode);

// Estimators that can serve association: Last() and Predict() follow the newest
// frames.
enum class FeedbackKind { kGaussian, kWindow };
// Estimators whose poses can be written; solvers/smoothers.h has a descriptor
// of each.
enum class OutputKind {
  kRawDlt,
  kRobustTriangulation,
  kGaussian,
  kCentredGaussian,
  kHampelMedian,
  kOneEuro,
  kLoess,
  kButterworth,
  kCriticallyDamped,
  kSavitzkyGolay,
  kSmoothingSpline,
  kQuinticSpline,
  kWhittaker,
  kTrend,
  kKalman,
  kRts,
  kStudentTRts,
  kWindow,
  kBatch,
};
// The values of the key output.estimator, in the order of the enum.
const std::vector<std::string>& OutputNames();

struct EstimatorOptions {
  Mode mode = Mode::kGraph;
  // Graph mode only; paper mode always uses the Gaussian for both.
  FeedbackKind feedback = FeedbackKind::kGaussian;
  OutputKind output = OutputKind::kWindow;
  CausalGaussianOptions gaussian;
  GraphOptions graph;
  FilterOptions filters;

  // Keys mode, tracking.feedback, output.estimator; tables [gaussian], [graph],
  // [filters].
  void Describe(OptionVisitor& visitor);
};

// Whether a pose depends only on frames up to its own. Exception: a filter
// writes a joint inside a gap only if the gap is short enough to be bridged,
// which is known only when it ends.
bool IsCausal(OutputKind kind, const EstimatorOptions& options);

// A factory of one kind, whatever options.mode is. Data learnt from the
// recording is kept in `notes`; null: in separate notes of the factory. Throws
// OptionError if options.filters are invalid.
EstimatorFactory MakeOutput(OutputKind kind, const EstimatorOptions& options,
                            std::shared_ptr<RecordingNotes> notes = nullptr);

// Factories of the two estimators of a person. An empty `output` means that the
// feedback estimator's own poses are written.
struct EstimatorPair {
  EstimatorFactory feedback;
  EstimatorFactory output;
  // Data that the output estimators learn from the recording; may be null.
  std::shared_ptr<RecordingNotes> notes = nullptr;
};

EstimatorPair MakeEstimators(const EstimatorOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORY_H_
