// What the estimators of a run learn from the recording: shared between its
// people, and kept for whoever asks afterwards.
#ifndef KINEGRAPH_SOLVERS_NOISE_RECORDING_NOTES_H_
#define KINEGRAPH_SOLVERS_NOISE_RECORDING_NOTES_H_

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/data/view_bias.h"
#include "solvers/graph/options.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/person_noise.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// A person as one pass over a recording solved it, kept for the next pass.
struct SolvedPerson {
  struct Joint {
    JointOutcome outcome;        // of all frames
    std::vector<int32_t> first;  // as JointChain::first
  };
  std::vector<FrameRecord> records;  // by frame
  std::vector<Joint> joints;
  AppliedNoise noise;
  std::vector<BoneConstraint> bones;         // of the estimate
  std::vector<BoneConstraint> stated_bones;  // of its covariances
};

// People register as they are born, one after the other; the rest may come from
// any thread.
class RecordingNotes {
 public:
  explicit RecordingNotes(const GraphOptions& options);

  // Another pass follows this one, which keeps what people's solutions are;
  // what they leave tells the detector's bias, where the options ask for it.
  void ExpectAnotherPass();
  bool expects_another_pass() const { return expects_another_pass_; }
  // The run begins anew with the same recording, without the bias that was
  // told: forgets what was learnt else. Nobody may write meanwhile.
  void BeginPass();

  // The bias to take away; null: none.
  std::shared_ptr<const ViewBias> view_bias() const { return view_bias_; }
  // Where a person leaves what its solution tells of it; null: nowhere.
  std::shared_ptr<BiasSeries> NewSeries(const BiasJoints& joints,
                                        int view_count);
  // People of the pass before this one whose solutions still hold.
  void Keep(std::shared_ptr<const SolvedPerson> person);
  std::vector<std::shared_ptr<const SolvedPerson>> SolvedPeople() const;
  void Forget(const SolvedPerson* person);
  // Where a person leaves what was learnt of its noise.
  std::shared_ptr<LearntNoise> NewPerson();

  // Of all people that left something: geometric means, weighed by the joints
  // seen; least and greatest process noise of any. Nobody may write meanwhile.
  LearntNoise Noise() const;

 private:
  const GraphOptions options_;
  bool expects_another_pass_ = false;
  bool learns_view_bias_ = false;
  std::shared_ptr<const ViewBias> view_bias_;
  std::vector<std::shared_ptr<BiasSeries>> series_;  // in order of birth
  mutable std::mutex mutex_;
  std::vector<std::shared_ptr<LearntNoise>> people_;
  std::vector<std::shared_ptr<const SolvedPerson>> solved_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_RECORDING_NOTES_H_
