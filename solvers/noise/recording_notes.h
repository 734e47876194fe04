// Data that the estimators of a run learn from the recording, shared between
// its people and available afterwards.
#ifndef KINEGRAPH_SOLVERS_NOISE_RECORDING_NOTES_H_
#define KINEGRAPH_SOLVERS_NOISE_RECORDING_NOTES_H_

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/data/view_bias.h"
#include "solvers/graph/options.h"
#include "solvers/graph/outcome.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/person_noise.h"

namespace kinegraph {

// A person as solved by one pass over a recording, kept for the next pass.
struct SolvedPerson {
  struct Joint {
    JointOutcome outcome;        // for all frames
    std::vector<int32_t> first;  // as in JointChain
  };
  std::vector<FrameRecord> records;  // by frame
  std::vector<Joint> joints;
  AppliedNoise noise;
  std::vector<BoneConstraint> bones;         // used for the estimate
  std::vector<BoneConstraint> stated_bones;  // used for its covariances
};

// People register in order of birth from one thread; the other functions may be
// called from any thread.
class RecordingNotes {
 public:
  explicit RecordingNotes(const GraphOptions& options);

  // Announces another pass after this one. This pass then keeps people's
  // solutions, whose residuals determine the detector's bias if the options
  // request one and do not give it.
  void ExpectAnotherPass();
  bool expects_another_pass() const { return expects_another_pass_; }
  // Starts another pass over the same recording: fits the detector's bias from
  // the stored residuals, if any, and discards the noise of Noise(). The stored
  // solutions remain, unless there is a new bias. No other thread may write
  // meanwhile.
  void BeginPass();

  // The bias to subtract; null if none.
  std::shared_ptr<const ViewBias> view_bias() const { return view_bias_; }
  // Where a new person stores the residuals of its solution; null if they are
  // not needed.
  std::shared_ptr<BiasSeries> NewSeries(const BiasJoints& joints,
                                        int view_count);
  // Keep() stores a person solved in this pass. SolvedPeople() returns, and
  // Forget() removes, those of the previous pass whose solutions are still
  // valid.
  void Keep(std::shared_ptr<const SolvedPerson> person);
  std::vector<std::shared_ptr<const SolvedPerson>> SolvedPeople() const;
  void Forget(const SolvedPerson* person);
  // Where a new person stores the noise learnt for it.
  std::shared_ptr<LearntNoise> NewPerson();

  // The noise of all people with results: means weighted by the joints seen,
  // geometric for sigmas and process noise, and the least and greatest process
  // noise of any person. No other thread may write meanwhile.
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
