// One person's factor graph as plain values: what every solver minimises.
//
// Cost of joint n over its frames k:
//   0.5 |prior(x_0)|^2 + 0.5 sum |constant_velocity(x_k, x_k+1)|^2
//   + 0.5 sum information * rho(|reprojection(x_k)|^2)
// and, over joints, 0.5 sum |bone_length(x_k,a, x_k,b)|^2. The residuals are
// those of solvers/factors. Without bones the joints are independent.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_
#define KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/base/span.h"
#include "core/base/time.h"
#include "core/geometry/camera.h"
#include "solvers/factors/loss.h"
#include "solvers/factors/state.h"

namespace kinegraph {

// One joint in one view of one frame.
struct PixelMeasurement {
  Eigen::Vector2d px;
  double sigma_px = 1.0;
  double information = 1.0;  // factor after the loss
  double offset_s = 0.0;     // capture time less the frame's
  const Camera* camera = nullptr;
  int32_t view_slot = 0;  // which of the frame's views
  // Left out: the current estimate has no image in this view.
  bool gated = false;
  double weight = 0.0;  // rho' at the estimate, set by the solver
};

// Gaussian on one state: residual A (x - x0) + b. A is upper triangular.
struct StatePrior {
  Matrix6d A = Matrix6d::Identity();
  State x0 = State::Zero();
  State b = State::Zero();
  // Square root of the information that covariances state: as A, but with
  // every observation times the correction of its loss
  // (InformationCorrection).
  Matrix6d A_stated = Matrix6d::Identity();
};

// Gaussian on the first states of all joints below each other.
struct PersonPrior {
  Eigen::MatrixXd A;
  Eigen::VectorXd x0;
  Eigen::VectorXd b;
  Eigen::MatrixXd A_stated;

  bool empty() const { return A.size() == 0; }
};

struct JointChain {
  // Power of the white noise on acceleration [m^2/s^3], or on jerk [m^2/s^5].
  double process_noise = 1.0;
  StatePrior prior;           // on states.front()
  std::vector<State> states;  // one a frame; start and result of a solve
  // White noise on jerk: one a frame [m/s^2], and the spread of the first.
  // Empty with white noise on acceleration.
  std::vector<Eigen::Vector3d> accelerations;
  double birth_acceleration_sigma_mps2 = 10.0;
  // Measurements of frame k are measurements[first[k]] .. [first[k + 1]].
  std::vector<int32_t> first = {0};
  std::vector<PixelMeasurement> measurements;
};

// The length of the bone between two joints, the same in every frame.
struct BoneConstraint {
  int a = 0;
  int b = 0;
  double length_m = 0.0;
  double sigma_m = 0.02;
};

struct PersonProblem {
  std::vector<TimeNs> times;  // ascending, one a frame
  std::vector<JointChain> joints;
  std::vector<BoneConstraint> bones;
  // Replaces the joints' own priors where it is not empty.
  PersonPrior prior;
};

struct SolveStage {
  LossKind loss = LossKind::kNone;
  double scale = 1.0;  // sigmas
  int max_iterations = 10;
};

// Stages of a solve and when it has converged.
struct SolveSchedule {
  std::vector<SolveStage> stages;
  double step_tolerance_m = 1e-5;
  // Whether states that still move far at the end lose their measurements
  // (SolveReport::unsettled). Not for solves that only hand over a start.
  bool doubt_unsettled = true;
};

struct SolveReport {
  bool finite = true;     // false: the start was kept
  bool converged = true;  // in the last stage
  int iterations = 0;
  // States of one joint in one frame that were still far from settled: their
  // measurements got no weight, so that status and covariance say so.
  int unsettled = 0;
};

// Marks the measurements that the current states cannot be projected to.
void GateMeasurements(JointChain* chain);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_
