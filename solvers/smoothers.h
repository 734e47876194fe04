// One descriptor per smoother, used by the factory and `compare`.
#ifndef KINEGRAPH_SOLVERS_SMOOTHERS_H_
#define KINEGRAPH_SOLVERS_SMOOTHERS_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/factory.h"

namespace kinegraph {

// A number that `compare` chooses by held-out error.
struct SmootherParameter {
  std::string name;  // key in a file of parameters
  std::string unit;
  std::vector<double> grid;  // ascending
  bool log = false;          // drawn on a log axis
  std::function<void(double, EstimatorOptions*)> set;
  // The default: the value in the configuration.
  std::function<double(const EstimatorOptions&)> get;
};

// One variant of a smoother that `compare` evaluates.
struct SmootherVariant {
  std::string name;   // "kalman_cv"
  std::string title;  // "Kalman, constant velocity"
  // Sets the options that define this variant; may be empty.
  std::function<void(double rate_hz, EstimatorOptions*)> fix;
  // At most two.
  std::vector<SmootherParameter> parameters;
  // Name of a variant with the same parameters and cost, whose tuned values are
  // copied; empty: this variant is tuned itself.
  std::string tuned_as;
  // Lag of the window in frames; -1: no window.
  int lag_frames = -1;
  // Whether `compare` also runs it on the points of the robust triangulation
  // (PointKind::kRobust).
  bool also_on_robust_points = false;
};

struct Smoother {
  OutputKind kind = OutputKind::kWindow;
  std::string name;  // value of the key output.estimator
  // Whether a pose depends only on frames up to its own (IsCausal). False for
  // all estimators of the graph, even for the window with a lag of 0.
  std::function<bool(const EstimatorOptions&)> causal;
  // Data learnt from the recording is kept in `notes`; null: separately for
  // each estimator.
  std::function<EstimatorFactory(const EstimatorOptions&,
                                 std::shared_ptr<RecordingNotes> notes)>
      make;
  std::vector<SmootherVariant> variants;  // in the order of compare's tables
};

// All smoothers in the order of OutputKind, which is also that of compare's
// tables.
const std::vector<Smoother>& Smoothers();
const Smoother& SmootherOf(OutputKind kind);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SMOOTHERS_H_
