// One descriptor a smoother: all that the factory and `compare` know of it.
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
  std::string name;  // key of a file of parameters
  std::string unit;
  std::vector<double> grid;  // ascending
  bool log = false;          // drawn on a log axis
  std::function<void(double, EstimatorOptions*)> set;
  // What it is if nobody tells: as the configuration says.
  std::function<double(const EstimatorOptions&)> get;
};

// One way to run a smoother that `compare` sets against others.
struct SmootherVariant {
  std::string name;   // "kalman_cv"
  std::string title;  // "Kalman, constant velocity"
  // Fixes what makes it this one; may be empty.
  std::function<void(double rate_hz, EstimatorOptions*)> fix;
  // None to two.
  std::vector<SmootherParameter> parameters;
  // Takes the values of this one, which has the same parameters and minimises
  // the same cost, instead of being tuned itself.
  std::string tuned_as;
  // Frames that a window keeps; -1: no window.
  int lag_frames = -1;
  // Whether `compare` also runs it on points that outliers were kept out of.
  bool also_on_robust_points = false;
};

struct Smoother {
  OutputKind kind = OutputKind::kWindow;
  std::string name;  // as output.estimator takes it
  // Whether a pose depends on nothing that came after its frame.
  std::function<bool(const EstimatorOptions&)> causal;
  // What its people learn from the recording goes into `notes`; null: nobody
  // learns from it.
  std::function<EstimatorFactory(const EstimatorOptions&,
                                 std::shared_ptr<RecordingNotes> notes)>
      make;
  std::vector<SmootherVariant> variants;  // in the order of the report
};

// All of them, in the order of OutputKind, which is that of the report, too.
const std::vector<Smoother>& Smoothers();
const Smoother& SmootherOf(OutputKind kind);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SMOOTHERS_H_
