// Factors that a user of the library adds, of any size.
#ifndef KINEGRAPH_SOLVERS_GRAPH_GENERAL_FACTOR_H_
#define KINEGRAPH_SOLVERS_GRAPH_GENERAL_FACTOR_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"
#include "solvers/factors/loss_kind.h"

namespace kinegraph {

// Whitened residuals over states [p; v] [m, m/s]. solvers/ceres/user_factor.h
// makes one of a ceres::CostFunction.
class GeneralFactor {
 public:
  virtual ~GeneralFactor() = default;
  virtual int residual_count() const = 0;
  virtual int state_count() const = 0;
  // As ceres::CostFunction::Evaluate: jacobians[i], if not null, receives
  // residual_count x 6 numbers row by row; `jacobians` may be null. False where
  // the factor has no value. Called from several threads at a time.
  virtual bool Evaluate(double const* const* states, double* residuals,
                        double** jacobians) const = 0;
};

// A state that a user's factor sees.
struct UserState {
  int joint = 0;        // of the tracks' skeleton
  int frames_back = 0;  // 0: the frame it is made for, 1: the one before
};

struct UserFactor {
  std::shared_ptr<const GeneralFactor> factor;
  std::vector<UserState> states;  // one a state of the factor
  LossKind loss = LossKind::kNone;
  double loss_scale = 1.0;  // sigmas
};

// A person's frame that factors may be made for.
struct UserFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  bool has_previous = false;  // frames_back 1 exists
  const Skeleton* skeleton = nullptr;
  const Pose3d* initial = nullptr;  // DLT's pose; null where there is none
};

// Called once for each frame of each person, from several threads at a time;
// returns the factors whose newest state is of this frame. Window and batch
// honour them in estimates, marginalisation and covariances.
using UserFactorSource =
    std::function<std::vector<UserFactor>(const UserFrame& frame)>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_GENERAL_FACTOR_H_
