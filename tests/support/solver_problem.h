// A short recording as a problem, for tests of solvers.
#ifndef KINEGRAPH_TESTS_SUPPORT_SOLVER_PROBLEM_H_
#define KINEGRAPH_TESTS_SUPPORT_SOLVER_PROBLEM_H_

#include <gtest/gtest.h>

#include <vector>

#include "solvers/block_tridiagonal/person_system.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/factor_list.h"
#include "solvers/graph/marginalise.h"
#include "tests/support/simulated_person.h"

namespace kinegraph::testing {

// Calls `visit` for all of a person's factors except PersonProblem::user and
// PersonProblem::prior; if the latter is not empty, the priors of the joints,
// which it replaces, are left out, too. False if a call returned false.
template <typename Visit>
bool ForEachFactor(const PersonProblem& problem, const FactorWalk& walk,
                   const Visit& visit) {
  FactorWalk own = walk;
  own.priors = problem.prior.empty();
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    if (!kinegraph::ForEachFactor(problem, j, own, visit)) return false;
  }
  return ForEachCoupling(problem, walk, visit);
}

// Marginalising out the first frames must not change the covariances of the
// other frames; the information of observations is multiplied by `correction`.
inline void ExpectMarginalisationKeepsCovariances(double correction,
                                                  PersonProblem problem) {
  const size_t frames = problem.times.size();
  std::vector<std::vector<Matrix6d>> before;
  ASSERT_TRUE(PersonCovariances(problem, correction, frames, &before));
  for (size_t dropped = 1; dropped <= 3; ++dropped) {
    DropFirstFrame(correction, &problem);
    std::vector<std::vector<Matrix6d>> after;
    ASSERT_TRUE(
        PersonCovariances(problem, correction, frames - dropped, &after));
    for (size_t j = 0; j < after.size(); ++j) {
      for (size_t k = 0; k < after[j].size(); ++k) {
        const Matrix6d& expected = before[j][k + dropped];
        // A bound, not derived: normal equations lose half of the sixteen
        // digits, and some more because the information of positions is up to
        // 1e3 times that of velocities.
        EXPECT_LT((after[j][k] - expected).norm(), 1e-6 * expected.norm())
            << dropped << " " << j << " " << k;
      }
    }
  }
}

inline void ExpectSameStates(const PersonProblem& a, const PersonProblem& b,
                             double tolerance_m) {
  for (size_t j = 0; j < a.joints.size(); ++j) {
    for (size_t k = 0; k < a.times.size(); ++k) {
      EXPECT_LT(
          (a.joints[j].states[k] - b.joints[j].states[k]).head<3>().norm(),
          tolerance_m)
          << "joint " << j << " frame " << k;
    }
  }
}

class SolverProblemTest : public ::testing::Test {
 protected:
  struct Rig {
    int cameras = 5;
    int frames = 30;
    uint64_t seed = 17;
    bool distorted = false;
    // Delay of each camera's capture times relative to the previous camera
    // [ns].
    int64_t later_each_ns = 0;
  };

  // The arm of a walking person, with poor initial values.
  void Make(const Rig& rig, const SimulatedNoise& noise) {
    scene_ = SmallScene(RingOfCameras(rig.cameras, 5.0, 1000.0, rig.distorted),
                        25.0);
    recording_ = Simulate(scene_, options_, WalkingMotion(scene_, rig.frames),
                          noise, rig.seed);
    for (EstimatorFrame& frame : recording_.frames) {
      for (FreshView& view : frame.views) {
        view.capture_time += view.view_idx * rig.later_each_ns;
      }
    }
    problem_ = Assemble(scene_, options_, recording_.frames);
    for (JointChain& chain : problem_.joints) GateMeasurements(&chain);
  }

  // More iterations than needed, so that every solver reaches the minimum.
  static SolveSchedule Exact(LossKind loss, double scale = 3.0) {
    SolveSchedule schedule;
    schedule.step_tolerance_m = 1e-11;
    schedule.stages.push_back({LossKind::kHuber, 1.5, 300});
    schedule.stages.push_back({loss, scale, 300});
    return schedule;
  }

  SceneModel scene_;
  GraphOptions options_ = FixedNoise();
  SimulatedRecording recording_;
  PersonProblem problem_;
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_SOLVER_PROBLEM_H_
