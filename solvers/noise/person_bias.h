// One person's part in the detector's bias: what it tells of it, and what it
// takes from its pixels.
#ifndef KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_
#define KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/bias_learner.h"
#include "solvers/noise/frame_points.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

class PersonBias {
 public:
  // A null pool: nothing is learnt and nothing changes. `scene` must outlive
  // it.
  PersonBias(const SceneModel& scene, std::shared_ptr<ViewBiasPool> pool);

  // The newest frame `k` of `problem`, whose joints in `triangulated` stand at
  // their states; its pixels have no bias yet.
  void Observe(const PersonProblem& problem, size_t k,
               const std::vector<bool>& triangulated);
  // Writes the bias of the frame that was observed last, from what earlier
  // frames told (window).
  void ApplyCausally(size_t k, PersonProblem* problem);
  // Whether Observe has anything to learn.
  bool observes() const { return pool_ != nullptr; }
  // From all there is (batch); null: nothing.
  std::shared_ptr<const ViewBias> OfTake() const;
  // Whether a solution of the take has something to tell; each round once.
  bool HasRound() const;
  // What the round's solution begins with; null: nothing.
  std::shared_ptr<const ViewBias> OfRound() const;
  // Tells the round what a solution leaves of its frames, in order. Its
  // measurements name `cameras`, which must outlive the round; errors last as
  // `correlation` says.
  class Round;
  Round BeginRound(const CameraRig& cameras,
                   const ErrorCorrelation& correlation);
  // Writes it to the observed frames begin .. end - 1, the first ones of
  // `part`; all observed ones were at `times`.
  void ApplyTake(const ViewBias& bias, const std::vector<TimeNs>& times,
                 size_t begin, size_t end, PersonProblem* part) const;

 private:
  TimeNs LookAfter() const;
  void Learn(const PersonProblem& problem, size_t k);
  bool AddJoint(const PersonProblem& problem, size_t k, int joint_idx);
  void Apply(const ViewBias& bias, const BodyStance& frame, size_t k,
             PersonProblem* problem) const;
  const BodyStance* NearestFrame(size_t k,
                                 const std::vector<TimeNs>& times) const;

  const SceneModel& scene_;
  std::shared_ptr<ViewBiasPool> pool_;
  BiasJoints joints_;
  std::shared_ptr<ViewBiasPool::Pending> pending_;
  ViewBiasPool::Pending seen_;  // of the frame that is looked at
  std::shared_ptr<const ViewBias> before_;
  FrameTriangulator triangulator_;
  NoiseScales scales_;
  std::vector<std::optional<BodyStance>> frames_;  // of the batch
  std::optional<BodyStance> last_;
  TimeNs last_time_ = 0;
  bool learnt_ = false;
  TimeNs learnt_time_ = 0;
  int round_ = 0;
};

// A solution is looked at frame by frame, and handed in as a whole.
class PersonBias::Round {
 public:
  Round(PersonBias* person, const CameraRig& cameras,
        const ErrorCorrelation& correlation);
  // Frame `k` of `solved`, with the weights that the solver gave.
  void Add(const PersonProblem& solved, size_t k);
  void HandIn();

 private:
  std::vector<BiasView> ViewsOf(const PersonProblem& solved, size_t k,
                                int joint_idx, const BodyStance& stance) const;

  PersonBias* const person_;
  const CameraRig& cameras_;
  const double independent_;  // what a look counts as
  std::unique_ptr<BiasSeries> series_;
  std::vector<BiasSums> sums_;  // of the frame that is looked at
  bool looked_ = false;
  TimeNs look_time_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_PERSON_BIAS_H_
