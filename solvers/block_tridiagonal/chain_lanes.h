// Chains of joints, one joint per SIMD lane: inputs and outputs of the kernels
// as plain arrays.
//
// An array consists of rows of `lanes` numbers, one per joint; `lanes` is a
// multiple of kLaneMultiple, and lanes without a joint are filled as for a
// joint without measurements. A view is one camera's detection in one frame:
// its joints share camera and clock.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_H_

#include "core/geometry/projection.h"
#include "solvers/factors/robust_loss.h"

namespace kinegraph {

struct LaneFrameView {
  const CameraModel* camera = nullptr;
  double offset_s = 0.0;  // capture time minus the frame's
};

struct ChainLanes {
  int frames = 0;
  int joints = 0;  // results of further lanes are meaningless
  int lanes = 0;
  const double* dt_s = nullptr;           // [frames - 1], not per lane
  const double* process_noise = nullptr;  // [frames - 1][lanes] m^2/s^3
  // BodyCentre, the same in all lanes: x, y, z [m] and 1 / sigma [1/m] (0: no
  // such factor).
  const double (*centres)[4] = nullptr;  // [frames], not per lane

  // Views of frame k have the indices first_view[k] .. first_view[k + 1] - 1.
  const int* first_view = nullptr;
  const LaneFrameView* views = nullptr;
  const double* x_px = nullptr;         // [views][lanes]
  const double* y_px = nullptr;         // [views][lanes]
  const double* per_sigma = nullptr;    // [views][lanes] 1/px; 0: not measured
  const double* information = nullptr;  // [views][lanes] factor after the loss
  double* counts = nullptr;  // [views][lanes] 1: measured and not gated, else 0
  double* weights = nullptr;  // [views][lanes] rho' at the states

  // Prior on the first states, as StatePrior: A by columns.
  const double* prior_A = nullptr;         // [36][lanes]
  const double* prior_A_stated = nullptr;  // [36][lanes], for covariances
  const double* prior_x0 = nullptr;        // [6][lanes]
  const double* prior_b = nullptr;         // [6][lanes]

  double* states = nullptr;  // [frames][6][lanes] m, m/s: start and result
};

struct LaneStage {
  LossKind loss = LossKind::kNone;
  double scale = 1.0;  // in sigmas
  int max_iterations = 10;
  double step_tolerance_m = 1e-5;
};

// The result of a solve, [lanes], and the last step of every state.
struct LaneReports {
  double* finite = nullptr;     // 1, or 0: no result
  double* converged = nullptr;  // 1 or 0, in the last stage
  double* iterations = nullptr;
  double* steps = nullptr;  // [frames][6][lanes]
};

// Gauss-Newton system of all chains: a row of lanes for each number.
struct LaneSystemRows {
  double* diagonal = nullptr;  // [frames][21][lanes], as LaneBlock
  double* gradient = nullptr;  // [frames][6][lanes]
  double* cost = nullptr;      // [lanes]
  double* valid = nullptr;     // [lanes] 1: all measurements that count have
                               // an image and the cost is finite, else 0
};

// The off-diagonal information of a factor on the positions of two joints in
// one frame: rows are the axes of joint a, columns those of joint b.
struct LaneCoupling {
  int frame = 0;
  int a = 0;  // lanes
  int b = 0;
  double block[3][3];
};

// The couplings between the chains of a person.
struct LaneCouplings {
  const LaneCoupling* list = nullptr;
  int count = 0;
  // Between the joints' first states, [6 joint + i][6][lanes]; the diagonal
  // blocks are zero. Null without a person's prior.
  const double* first = nullptr;
};

// Size of the work space in doubles; the caller aligns it to 64 bytes.
long LaneWorkspaceSize(int frames);

long CoupledWorkspaceSize(int frames, int lanes);

// The arithmetic, compiled for one instruction set.
struct LaneKernels {
  // Gates the measurements at the start (`counts`) and runs the stages: damped
  // Gauss-Newton by block-tridiagonal sweeps, each lane with its own damping
  // and termination. Writes states, counts, weights and reports.
  void (*solve)(const ChainLanes& chains, const LaneStage* stages,
                int stage_count, double* workspace, const LaneReports& reports);
  // Covariances of frames 0 .. frame_end - 1 at the stored states and weights,
  // with the information of every observation times `correction`:
  // [frame_end][21][lanes], the upper triangle row by row. `known` [lanes]: 0
  // where the information is not positive definite.
  void (*covariance)(const ChainLanes& chains, double correction, int frame_end,
                     double* workspace, double* covariances, double* known);
  // The chains' system at their states. `own_priors`: include the priors of
  // ChainLanes; otherwise lanes without a joint may be singular.
  void (*linearise)(const ChainLanes& chains, const LaneStage& stage,
                    bool own_priors, double* workspace,
                    const LaneSystemRows& system);
  // Writes the measurements' weights at the chains' states.
  void (*weigh)(const ChainLanes& chains, const LaneStage& stage,
                double* workspace);
  // Solves H step = -gradient, step [frames][6][lanes], for the chains, their
  // couplings and `damping` times the chains' diagonal: conjugate gradients,
  // preconditioned with the damped chains M. Ends when the norm sqrt(r' M^-1 r)
  // of the residual r is at most `accuracy` times that of the gradient; after
  // 100 iterations; or at a direction along which H has no positive curvature.
  // False if that is the first direction, the gradient is not finite, or the
  // chains are not positive definite.
  bool (*solve_coupled)(const ChainLanes& chains, const LaneSystemRows& system,
                        const LaneCouplings& couplings, double damping,
                        double accuracy, double* workspace, double* step);
};
extern const LaneKernels kLaneKernelsAvx2;
extern const LaneKernels kLaneKernelsAvx512;

// The kernels of the widest instruction set that may be used
// (core/base/instruction_set.h).
const LaneKernels& CurrentLaneKernels();

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_LANES_H_
