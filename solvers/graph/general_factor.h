// Factors of any size, added by a user of the library.
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
// wraps a ceres::CostFunction as one.
class GeneralFactor {
 public:
  virtual ~GeneralFactor() = default;
  virtual int residual_count() const = 0;
  virtual int state_count() const = 0;
  // As ceres::CostFunction::Evaluate: jacobians[i], if not null, receives
  // residual_count x 6 numbers row by row; `jacobians` may be null. Returns
  // false where the factor is undefined. Called from several threads at a time.
  virtual bool Evaluate(double const* const* states, double* residuals,
                        double** jacobians) const = 0;
};

// A state on which a user's factor depends.
struct UserState {
  int joint = 0;        // of the tracks' skeleton
  int frames_back = 0;  // 0: the current frame, 1: the previous one
};

struct UserFactor {
  std::shared_ptr<const GeneralFactor> factor;
  std::vector<UserState> states;  // one per state of the factor, all different
  LossKind loss = LossKind::kNone;
  double loss_scale = 1.0;  // in sigmas, > 0
};

// A frame of a person, for which factors may be created.
struct UserFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  bool has_previous = false;  // frames_back = 1 is allowed
  const Skeleton* skeleton = nullptr;
  const Pose3d* initial = nullptr;  // DLT's pose; null if there is none
};

// Called for each frame of each person in every pass, from several threads at a
// time; returns the factors whose newest state is of this frame. Window and
// batch include them in estimates, marginalisation and covariances.
using UserFactorSource =
    std::function<std::vector<UserFactor>(const UserFrame& frame)>;

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_GENERAL_FACTOR_H_
