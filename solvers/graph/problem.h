// One person's factor graph as plain values: the cost that every solver
// minimises.
//
// Cost of joint n over its frames k:
//   0.5 |prior(x_0)|^2 + 0.5 sum |body_centre(x_k)|^2
//   + 0.5 sum |constant_velocity(x_k, x_k+1)|^2
//   + 0.5 sum information * rho(|reprojection(x_k)|^2)
// and, over joints, 0.5 sum |bone_length(x_k,a, x_k,b)|^2, a prior on their
// first states and the factors of the library's user. The residuals are those
// of solvers/factors, listed in factor_list.h. Unless PersonProblem::coupled(),
// the joints are independent.
#ifndef KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_
#define KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/camera.h"
#include "solvers/factors/jacobian.h"
#include "solvers/factors/loss.h"
#include "solvers/graph/general_factor.h"

namespace kinegraph {

// The unknowns of one joint at one frame: position [m] and velocity [m/s] in
// the world, one parameter block.
using State = Eigen::Matrix<double, kStateSize, 1>;
using Matrix6d = Eigen::Matrix<double, kStateSize, kStateSize>;

// Identifies a state that a factor depends on.
struct StateKey {
  int joint = 0;
  size_t frame = 0;
};

// States that a factor depends on, the earliest frame first.
template <int kCount>
using Keys = std::array<StateKey, kCount>;

// The cost of a factor with squared residual s: 0.5 information rho(s).
struct Robustness {
  LossKind loss = LossKind::kNone;
  double scale = 1.0;
  double information = 1.0;
  // Index of the measurement in its chain; -1 for other factors.
  int32_t measurement = -1;

  LossValue Evaluate(double s) const { return EvaluateLoss(loss, scale, s); }
};

// A user's factor attached to states of a problem.
struct PlacedFactor {
  std::shared_ptr<const GeneralFactor> factor;
  std::vector<StateKey> keys;  // in one frame or two consecutive frames
  Robustness robustness;

  size_t first_frame() const;
  size_t last_frame() const;
};

// The factors that `source` returns for `frame`, which is frame `k` of the
// problem. Throws OptionError for joints or frames that do not exist, repeated
// states, a missing factor (null), a number of states that is 0 or does not
// match the factor, and losses with a scale <= 0.
std::vector<PlacedFactor> PlaceUserFactors(const UserFactorSource& source,
                                           const UserFrame& frame, size_t k,
                                           int joint_count);

// A placed factor at given states: whitened rows times the root of its weight.
struct GeneralRows {
  Eigen::VectorXd residual;
  std::vector<
      Eigen::Matrix<double, Eigen::Dynamic, kStateSize, Eigen::RowMajor>>
      by_states;
};

// One joint in one view of one frame. All joints of a view in a frame share
// camera and offset. Fields are ordered to avoid padding: a recording has
// millions of these.
struct PixelMeasurement {
  Eigen::Vector2d px;
  // The detector's bias: known part of the difference between the detected
  // pixel and the joint's true pixel in this view.
  Eigen::Vector2f bias_px = Eigen::Vector2f::Zero();
  double sigma_px = 1.0;
  // sigma_px by the options' noise model, before noise is learnt.
  double model_sigma_px = 1.0;
  double information = 1.0;  // factor on the loss (Robustness)
  double offset_s = 0.0;     // capture time minus the frame's
  const Camera* camera = nullptr;
  double weight = 0.0;  // rho' at the estimate, set by the solver
  // Natural logarithm of the confidence, which is clamped to
  // GraphOptions::min_confidence .. 1.
  float log_confidence = 0.0f;
  int16_t view_slot = 0;  // index among the frame's views
  // Excluded: the current estimate cannot be projected into this view.
  bool gated = false;
};
static_assert(sizeof(PixelMeasurement) == 80);

// Gaussian on one state: residual A (x - x0) + b. A is upper triangular.
struct StatePrior {
  Matrix6d A = Matrix6d::Identity();
  State x0 = State::Zero();
  State b = State::Zero();
  // A for covariances: with the information of every observation multiplied by
  // the correction of its loss (InformationCorrection).
  Matrix6d A_stated = Matrix6d::Identity();
};

// Prior of a joint before any measurement: around `centre` [m] and at rest;
// `sigma_mps` permits walking and running. A constant-velocity chain is
// rank-deficient without it; with it every problem has full rank, whatever was
// measured. Sigmas > 0.
StatePrior BirthPrior(const Eigen::Vector3d& centre, double sigma_m,
                      double sigma_mps);

using StateChain = std::vector<State>;  // of one joint, one per frame

// Gaussian on the first states of all joints, stacked: residual A (x - x0) + b.
struct PersonPrior {
  Eigen::MatrixXd A;  // upper triangular
  Eigen::VectorXd x0;
  Eigen::VectorXd b;
  Eigen::MatrixXd information;  // A'A
  // The information for covariances, as in StatePrior::A_stated.
  Eigen::MatrixXd stated;

  bool empty() const { return A.size() == 0; }
};

struct JointChain {
  // Power of the white noise on acceleration [m^2/s^3] from frame k to frame k
  // + 1; one element fewer than states.
  std::vector<double> process_noise;
  StatePrior prior;   // on states.front()
  StateChain states;  // one per frame; start and result of a solve
  // Measurements of frame k have the indices first[k] .. first[k + 1] - 1.
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

// Approximate position of the person in a frame, a weak prior on all joints.
struct PersonCentre {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  double per_sigma = 0.0;  // 1/m; 0: no prior
};

struct PersonProblem {
  std::vector<TimeNs> times;          // ascending, at least one frame
  std::vector<PersonCentre> centres;  // one per frame
  std::vector<JointChain> joints;
  std::vector<BoneConstraint> bones;
  // Replaces the joints' own priors unless it is empty.
  PersonPrior prior;
  std::vector<PlacedFactor> user;  // from the library's user

  // Whether the joints depend on each other.
  bool coupled() const {
    return !bones.empty() || !prior.empty() || !user.empty();
  }
  // The state [6] of a key.
  const double* At(const StateKey& key) const {
    return joints[key.joint].states[key.frame].data();
  }
};

// Linearises a placed factor at the problem's states; false where the factor is
// undefined.
bool LineariseGeneral(const PlacedFactor& placed, const PersonProblem& problem,
                      GeneralRows* rows);

struct SolveStage {
  LossKind loss = LossKind::kNone;
  double scale = 1.0;  // in sigmas
  int max_iterations = 10;
};

// Stages of a solve and its convergence criterion.
struct SolveSchedule {
  // Earlier stages only provide a start, so their tolerance is wider.
  double StepToleranceM(size_t stage) const {
    return stage + 1 == stages.size() ? step_tolerance_m
                                      : 30.0 * step_tolerance_m;
  }

  std::vector<SolveStage> stages;
  double step_tolerance_m = 1e-5;  // of the last stage
  // Whether states that still move far at the end lose their measurements
  // (SolveReport::unsettled). False for solves that only provide a start.
  bool doubt_unsettled = true;
};

struct SolveReport {
  // False: the start was kept, and the other fields are meaningless.
  bool finite = true;
  bool converged = true;  // in the last stage
  int iterations = 0;     // of the block-tridiagonal solver
  int ceres_iterations = 0;
  int ceres_problems = 0;
  double cost_decrease = 0.0;  // in Ceres' last stage
  // Number of states (of one joint in one frame) that were still far from
  // convergence: their measurements got zero weight, so that status and
  // covariance reflect it.
  int unsettled = 0;
};

// Gates exactly those measurements in whose views the chain's states have no
// image.
void GateMeasurements(JointChain* chain);

// Stores the weights of the measurements at the chain's states, under a stage's
// loss.
void StoreWeights(const SolveStage& stage, JointChain* chain);

// For a solve that ended before it converged, with `step` as its last step.
// Frames whose position moved by 5 cm or more along any axis in that step have
// no usable estimate: the weights of their measurements become 0. Returns the
// number of these frames.
int DoubtUnsettled(const StateChain& step, JointChain* chain);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_PROBLEM_H_
