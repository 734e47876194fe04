// What the estimators of a run learn from the take: shared between its people,
// and kept for whoever asks afterwards.
#ifndef KINEGRAPH_SOLVERS_NOISE_TAKE_NOTES_H_
#define KINEGRAPH_SOLVERS_NOISE_TAKE_NOTES_H_

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/data/view_bias.h"
#include "solvers/graph/options.h"
#include "solvers/noise/person_noise.h"

namespace kinegraph {

class ViewBiasPool;

// People register as they are born,
// one after the other; the rest may come from any thread.
class TakeNotes {
 public:
  explicit TakeNotes(const GraphOptions& options);

  // The run begins anew with the same take: forgets what was learnt. People of
  // the pass before keep what they have.
  void BeginPass();

  // Null where the options ask for no bias.
  std::shared_ptr<ViewBiasPool> view_bias() const { return view_bias_; }
  // Where a person leaves what was learnt of its noise.
  std::shared_ptr<LearntNoise> NewPerson();

  // Of all people that left something: geometric means, weighed by the joints
  // seen; least and greatest process noise of any. Nobody may write meanwhile.
  LearntNoise Noise() const;
  // As told by everything so far; empty where none is asked for.
  ViewBias Bias() const;

 private:
  const GraphOptions options_;
  std::shared_ptr<ViewBiasPool> view_bias_;
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<LearntNoise>> people_;
};

// {"error_time_s", "error_share", "confidence_power", "classes": {"wrist":
// {"joints_seen", "sigma_px", "process_noise", "least_process_noise",
// "greatest_process_noise"}, ...}}: classes of which something was seen, units
// as in LearntNoise.
std::string ToJson(const LearntNoise& learnt);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_TAKE_NOTES_H_
