// The arithmetic of LaneKernels (chain_lanes.h), templated on the SIMD type
// (core/base/pack.h). Included by files that are compiled for one instruction
// set each, so it must not use Eigen.
//
// With D_k the diagonal block of frame k, B_k the block to its right, g_k the
// gradient, S_k the Schur complement that remains of D_k when all later frames
// are eliminated, and P_k = S_k^-1:
//   S_k = D_k - B_k P_k+1 B_k',   r_k = -g_k - B_k P_k+1 r_k+1,
//   x_0 = P_0 r_0,   x_k+1 = P_k+1 (r_k+1 - B_k' x_k).
// Elimination runs from the last frame to the first, so that the covariance of
// a window's oldest frame is P_0, at no further cost.
#ifndef KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_KERNEL_H_
#define KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_KERNEL_H_

#include <type_traits>

#include "core/base/pack.h"
#include "solvers/block_tridiagonal/chain_lanes.h"
#include "solvers/block_tridiagonal/lane_blocks.h"
#include "solvers/factors/factors.h"

namespace kinegraph {

// A camera as the View of a reprojection factor over packs. Project always
// returns true; `visible` receives the lanes in which there is an image.
template <typename T>
struct LaneCamera {
  const CameraModel* camera;
  Mask<T>* visible;

  KINEGRAPH_INLINE bool Project(const T* point, T* px, T (*by_point)[3]) const {
    *visible = kinegraph::Project(*camera, point, &px[0], &px[1],
                                  by_point == nullptr ? nullptr : by_point[0]);
    const auto& R = camera->R;
    const T depth = R[2][0] * point[0] + R[2][1] * point[1] +
                    R[2][2] * point[2] + camera->t[2];
    *visible = And(*visible, depth > T(kNearestDepthM));
    return true;
  }
};

template <typename T>
using LanePixel = Reprojection<T, LaneCamera<T>>;

// Motion from frame k to the next, constant during a solve: the blocks of its
// information, each number times the 3x3 identity.
template <typename T>
struct LaneMotion {
  ConstantVelocity<T> factor;
  T from[3];      // pp, pv, vv at frame k
  T to[3];        // at frame k + 1
  LaneAxis<T> m;  // between the frames
};

template <typename T>
LaneMotion<T> MotionBetween(double dt_s, const T& process_noise) {
  LaneMotion<T> motion;
  motion.factor = ConstantVelocity<T>(dt_s, process_noise);
  T at_rest[6];
  for (T& value : at_rest) value = 0.0;
  const T* const states[2] = {at_rest, at_rest};
  T residual[6];
  AxisJacobian<T> by[2];
  motion.factor.Evaluate(states, residual, by);
  const auto product = [&](int a, int b, int row, int column) {
    return by[a].axis[0][row] * by[b].axis[0][column] +
           by[a].axis[1][row] * by[b].axis[1][column];
  };
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      motion.m.a[row][column] = product(0, 1, row, column);
      if (row > column) continue;
      motion.from[row + column] = product(0, 0, row, column);
      motion.to[row + column] = product(1, 1, row, column);
    }
  }
  return motion;
}

template <typename T>
struct LaneSystem {
  LaneBlock<T>* diagonal;  // [frames]
  T (*gradient)[6];        // [frames]
  T cost;
  Mask<T> valid;  // every active measurement has an image; finite cost
};

// The chains of T::kLanes joints.
template <typename T>
class ChainGroup {
 public:
  // Work space per frame and lane, in doubles.
  static constexpr long kNumbersPerFrame =
      (3 * sizeof(LaneBlock<T>) + sizeof(LaneMotion<T>) + 6 * sizeof(T[6])) /
      sizeof(T);

  ChainGroup(const ChainLanes& chains, int lane, double* workspace)
      : chains_(chains), lane_(lane), frames_(chains.frames) {
    char* at = reinterpret_cast<char*>(workspace);
    const auto allot = [&](auto** array) {
      using Item =
          std::remove_pointer_t<std::remove_pointer_t<decltype(array)>>;
      *array = reinterpret_cast<Item*>(at);
      at += sizeof(Item) * frames_;
    };
    allot(&current_.diagonal);
    allot(&trial_.diagonal);
    allot(&inverse_);
    allot(&motion_);
    allot(&current_.gradient);
    allot(&trial_.gradient);
    allot(&gained_);
    allot(&states_);
    allot(&candidate_);
    allot(&step_);
  }

  void Solve(const LaneStage* stages, int stage_count,
             const LaneReports& reports) {
    LoadStates();
    LoadMotion();
    LoadPrior(chains_.prior_A);
    Gate(Gated::kAnew);
    for (int k = 0; k < frames_; ++k) {
      for (T& value : step_[k]) value = 0.0;
    }
    iterations_ = 0.0;
    finite_ = InAllLanes<T>();
    converged_ = finite_;
    for (int i = 0; i < stage_count && Any(finite_); ++i) RunStage(stages[i]);
    StoreWeights(stages[stage_count - 1]);
    for (int k = 0; k < frames_; ++k) {
      for (int i = 0; i < 6; ++i) {
        StoreRow(states_[k][i], chains_.states, 6 * k + i);
        StoreRow(step_[k][i], reports.steps, 6 * k + i);
      }
    }
    const T yes = 1.0;
    const T no = 0.0;
    StoreRow(Select(finite_, yes, no), reports.finite, 0);
    StoreRow(Select(And(finite_, converged_), yes, no), reports.converged, 0);
    StoreRow(iterations_, reports.iterations, 0);
  }

  void Covariances(double correction, int frame_end, double* covariances,
                   double* known) {
    LoadStates();
    LoadMotion();
    LoadPrior(chains_.prior_A_stated);
    Mask<T> visible;
    const Factors factors = {*this, &visible};
    for (int k = 0; k < frames_; ++k) {
      LaneBlock<T>& diagonal = current_.diagonal[k];
      BeginFrame(k, &diagonal);
      ForEachFactorOfFrame(factors, k,
                           Informer{*this, correction, &diagonal, k});
    }
    const Mask<T> definite = Eliminate(current_.diagonal, T(0.0));
    LaneBlock<T> covariance = inverse_[0];
    for (int k = 0; k < frame_end; ++k) {
      if (k > 0) {
        LaneBlock<T> next = inverse_[k];
        AddGained(inverse_[k], motion_[k - 1].m, covariance, &next);
        covariance = next;
      }
      int at = 21 * k;
      for (int row = 0; row < 6; ++row) {
        for (int column = row; column < 6; ++column) {
          StoreRow(Entry(covariance, row, column), covariances, at++);
        }
      }
    }
    StoreRow(Select(definite, T(1.0), T(0.0)), known, 0);
  }

  void LineariseAll(const LaneStage& stage, bool own_priors,
                    const LaneSystemRows& system) {
    LoadStates();
    LoadMotion();
    if (own_priors) {
      LoadPrior(chains_.prior_A);
    } else {
      LeavePriorOut();
    }
    Linearise(states_, stage, &current_);
    for (int k = 0; k < frames_; ++k) {
      ForEachEntry(
          [&](int i, const T& entry) {
            StoreRow(entry, system.diagonal, kLaneBlockSize * k + i);
          },
          current_.diagonal[k]);
      for (int i = 0; i < 6; ++i) {
        StoreRow(current_.gradient[k][i], system.gradient, 6 * k + i);
      }
    }
    StoreRow(current_.cost, system.cost, 0);
    StoreRow(Select(current_.valid, T(1.0), T(0.0)), system.valid, 0);
  }
  void Weigh(const LaneStage& stage) {
    LoadStates();
    StoreWeights(stage);
  }

 private:
  T Row(const double* rows, int row) const {
    return T::Load(rows + static_cast<long>(row) * chains_.lanes + lane_);
  }
  void StoreRow(const T& value, double* rows, int row) const {
    value.Store(rows + static_cast<long>(row) * chains_.lanes + lane_);
  }
  LanePixel<T> FactorOf(int view, Mask<T>* visible) const {
    return {{chains_.views[view].camera, visible},
            chains_.views[view].offset_s,
            {Row(chains_.x_px, view), Row(chains_.y_px, view)},
            Row(chains_.per_sigma, view)};
  }
  // The group's chains in the form that factors.h iterates over.
  struct Factors {
    const ChainGroup& group;
    Mask<T>* visible;  // lanes in which the last evaluated pixel has an image

    int frame_count() const { return group.frames_; }
    bool HasPrior() const { return true; }  // zero if there is none
    GaussianPrior<T> Prior() const {
      return {group.prior_root_, group.prior_x0_, group.prior_b_};
    }
    bool HasCentre(int k) const { return group.chains_.centres[k][3] > 0.0; }
    BodyCentre<T> Centre(int k) const {
      return {group.chains_.centres[k], group.chains_.centres[k][3]};
    }
    const ConstantVelocity<T>& Motion(int k) const {
      return group.motion_[k].factor;
    }
    int PixelsBegin(int k) const { return group.chains_.first_view[k]; }
    int PixelsEnd(int k) const { return group.chains_.first_view[k + 1]; }
    bool IsLeftOut(int) const { return false; }  // handled per lane by `counts`
    LanePixel<T> Pixel(int view) const { return group.FactorOf(view, visible); }
    int Always() const { return -1; }  // no view
    int CountingOf(int view) const { return view; }
  };

  // Adds cost and gradient of the factors of frame k, and the information of
  // pixels. The information of the other factors was added by BeginFrame.
  struct Lineariser {
    const ChainGroup& group;
    const LaneStage& stage;
    const T (*states)[6];
    T (*gradient)[6];
    LaneBlock<T> diagonal = {};
    T cost = 0.0;
    Mask<T> valid = InAllLanes<T>();
    int k = 0;

    KINEGRAPH_INLINE bool operator()(const GaussianPrior<T>& prior,
                                     int /*view*/) {
      const T* const first[1] = {states[k]};
      T away[6];
      prior.Evaluate(first, away, nullptr);
      for (int i = 0; i < 6; ++i) {
        cost += 0.5 * (away[i] * away[i]);
        for (int row = 0; row <= i; ++row) {
          gradient[k][i] += prior.A[6 * i + row] * away[row];
        }
      }
      return true;
    }

    KINEGRAPH_INLINE bool operator()(const BodyCentre<T>& centre,
                                     int /*view*/) {
      const T* const state[1] = {states[k]};
      T residual[3];
      centre.Evaluate(state, residual, nullptr);
      for (int i = 0; i < 3; ++i) {
        cost += 0.5 * (residual[i] * residual[i]);
        gradient[k][i] += centre.per_sigma * residual[i];
      }
      return true;
    }

    KINEGRAPH_INLINE bool operator()(const ConstantVelocity<T>& motion,
                                     int /*view*/) {
      const T* const ends[2] = {states[k], states[k + 1]};
      T residual[6];
      AxisJacobian<T> by[2];
      motion.Evaluate(ends, residual, by);
      AddGradient(by[0], residual, T(1.0), gradient[k]);
      AddGradient(by[1], residual, T(1.0), gradient[k + 1]);
      T square = residual[0] * residual[0];
      for (int i = 1; i < 6; ++i) square += residual[i] * residual[i];
      cost += 0.5 * square;
      return true;
    }

    KINEGRAPH_INLINE bool operator()(const LanePixel<T>& pixel, int view) {
      const T* const state[1] = {states[k]};
      T residual[2];
      PointJacobian<2, T> jacobian;
      pixel.Evaluate(state, residual, &jacobian);
      const T counts = group.Row(group.chains_.counts, view);
      valid = And(valid, Or(*pixel.view.visible, counts == T(0.0)));
      const LossTerms<T> loss =
          LossAt(stage.loss, stage.scale,
                 residual[0] * residual[0] + residual[1] * residual[1]);
      const T information = counts * group.Row(group.chains_.information, view);
      cost += 0.5 * (information * loss.rho);
      const T weight = information * loss.first;
      group.AddObservation(jacobian, weight, &diagonal);
      AddGradient(jacobian, residual, weight, gradient[k]);
      return true;
    }
  };

  // Adds the information of frame k's pixels at the stored weights.
  struct Informer {
    const ChainGroup& group;
    double correction;  // of observations
    LaneBlock<T>* diagonal;
    int k;

    bool operator()(const GaussianPrior<T>&, int) { return true; }
    bool operator()(const BodyCentre<T>&, int) { return true; }
    bool operator()(const ConstantVelocity<T>&, int) { return true; }

    KINEGRAPH_INLINE bool operator()(const LanePixel<T>& pixel, int view) {
      const T* const state[1] = {group.states_[k]};
      T residual[2];
      PointJacobian<2, T> jacobian;
      pixel.Evaluate(state, residual, &jacobian);
      const ChainLanes& chains = group.chains_;
      const T weight = correction * group.Row(chains.counts, view) *
                       group.Row(chains.information, view) *
                       group.Row(chains.weights, view);
      group.AddObservation(
          jacobian, Select(*pixel.view.visible, weight, T(0.0)), diagonal);
      return true;
    }
  };

  void LoadMotion() {
    for (int k = 0; k + 1 < frames_; ++k) {
      motion_[k] =
          MotionBetween<T>(chains_.dt_s[k], Row(chains_.process_noise, k));
    }
  }

  void LoadStates() {
    for (int k = 0; k < frames_; ++k) {
      for (int i = 0; i < 6; ++i)
        states_[k][i] = Row(chains_.states, 6 * k + i);
    }
  }

  void LoadPrior(const double* root) {
    for (int i = 0; i < 36; ++i) prior_root_[i] = Row(root, i);
    for (int i = 0; i < 6; ++i) {
      prior_x0_[i] = Row(chains_.prior_x0, i);
      prior_b_[i] = Row(chains_.prior_b, i);
    }
    prior_information_ = {};
    AddSquareOf(prior_root_, &prior_information_);
  }

  void LeavePriorOut() {
    for (T& value : prior_root_) value = 0.0;
    for (T& value : prior_x0_) value = 0.0;
    for (T& value : prior_b_) value = 0.0;
    prior_information_ = {};
  }

  // Gates the measurements into whose views the states cannot be projected, and
  // either activates all others (kAnew) or leaves them unchanged (kAsWell).
  enum class Gated { kAnew, kAsWell };
  void Gate(Gated gated) {
    for (int k = 0; k < frames_; ++k) {
      for (int v = chains_.first_view[k]; v < chains_.first_view[k + 1]; ++v) {
        Mask<T> visible;
        const auto factor = FactorOf(v, &visible);
        const T* const states[1] = {states_[k]};
        T residual[2];
        factor.Evaluate(states, residual, nullptr);
        const Mask<T> counted = gated == Gated::kAnew
                                    ? factor.per_sigma > T(0.0)
                                    : Row(chains_.counts, v) > T(0.0);
        StoreRow(Select(And(visible, counted), T(1.0), T(0.0)), chains_.counts,
                 v);
      }
    }
  }

  // Sets the diagonal block of frame k to the information of prior, centre and
  // motion.
  KINEGRAPH_INLINE void BeginFrame(int k, LaneBlock<T>* diagonal) const {
    T axis[3];
    for (int i = 0; i < 3; ++i) {
      axis[i] = k + 1 < frames_ ? motion_[k].from[i] : T(0.0);
      if (k > 0) axis[i] += motion_[k - 1].to[i];
    }
    const double per_sigma = chains_.centres[k][3];
    axis[0] += T(per_sigma * per_sigma);
    const T zero = 0.0;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        diagonal->pp[kSymmetric[r][c]] = r == c ? axis[0] : zero;
        diagonal->pv[3 * r + c] = r == c ? axis[1] : zero;
        diagonal->vv[kSymmetric[r][c]] = r == c ? axis[2] : zero;
      }
    }
    if (k > 0) return;
    ForEachEntry([](int, T& sum, const T& of_prior) { sum += of_prior; },
                 *diagonal, prior_information_);
  }

  // Adds weight J'J.
  KINEGRAPH_INLINE void AddObservation(const PointJacobian<2, T>& jacobian,
                                       const T& weight,
                                       LaneBlock<T>* diagonal) const {
    const auto& by = jacobian.by_point;
    for (int r = 0; r < 3; ++r) {
      const T x = weight * by[0][r];
      const T y = weight * by[1][r];
      for (int c = r; c < 3; ++c) {
        const T sum = x * by[0][c] + y * by[1][c];
        diagonal->pp[kSymmetric[r][c]] += sum;
        if (jacobian.offset_s == 0.0) continue;
        const T cross = jacobian.offset_s * sum;
        diagonal->pv[3 * r + c] += cross;
        if (r != c) diagonal->pv[3 * c + r] += cross;
        diagonal->vv[kSymmetric[r][c]] += jacobian.offset_s * cross;
      }
    }
  }

  void Linearise(const T (*states)[6], const LaneStage& stage,
                 LaneSystem<T>* system) const {
    for (int k = 0; k < frames_; ++k) {
      for (T& value : system->gradient[k]) value = 0.0;
    }
    Mask<T> visible;
    const Factors factors = {*this, &visible};
    Lineariser add = {*this, stage, states, system->gradient};
    for (add.k = 0; add.k < frames_; ++add.k) {
      BeginFrame(add.k, &add.diagonal);
      ForEachFactorOfFrame(factors, add.k, add);
      system->diagonal[add.k] = add.diagonal;
    }
    system->cost = add.cost;
    system->valid = And(add.valid, add.cost < T(1e300));
  }

  void StoreWeights(const LaneStage& stage) const {
    for (int k = 0; k < frames_; ++k) {
      for (int v = chains_.first_view[k]; v < chains_.first_view[k + 1]; ++v) {
        Mask<T> visible;
        const auto factor = FactorOf(v, &visible);
        const T* const state[1] = {states_[k]};
        T residual[2];
        factor.Evaluate(state, residual, nullptr);
        const LossTerms<T> loss =
            LossAt(stage.loss, stage.scale,
                   residual[0] * residual[0] + residual[1] * residual[1]);
        StoreRow(Row(chains_.counts, v) * loss.first, chains_.weights, v);
      }
    }
  }

  // Fills P_k after adding `damping` times the diagonal. The mask is true where
  // every block is positive definite.
  Mask<T> Eliminate(const LaneBlock<T>* diagonal, const T& damping) {
    const T grown = 1.0 + damping;
    Mask<T> definite = InAllLanes<T>();
    for (int k = frames_; k-- > 0;) {
      LaneBlock<T> pivot = diagonal[k];
      ScaleDiagonal(grown, &pivot);
      if (k + 1 < frames_) {
        SubtractCongruence(motion_[k].m, inverse_[k + 1], &pivot);
      }
      definite = And(definite, Invert(pivot, &inverse_[k]));
    }
    return definite;
  }

  // Computes steps and candidates. Lanes that are not `usable` keep their
  // states and their last step. Returns the largest change of a coordinate of a
  // position [m].
  T FindStep(const Mask<T>& usable) {
    for (int k = frames_; k-- > 0;) {
      T r[6];
      for (int i = 0; i < 6; ++i) r[i] = -current_.gradient[k][i];
      if (k + 1 < frames_) {
        SubtractProduct(motion_[k].m, gained_[k + 1], r);
      }
      Multiply(inverse_[k], r, gained_[k]);
    }
    T largest = 0.0;
    T step[6];
    for (int k = 0; k < frames_; ++k) {
      if (k == 0) {
        for (int i = 0; i < 6; ++i) step[i] = gained_[0][i];
      } else {
        T pull[6];
        MultiplyTransposed(motion_[k - 1].m, step, pull);
        T back[6];
        Multiply(inverse_[k], pull, back);
        for (int i = 0; i < 6; ++i) step[i] = gained_[k][i] - back[i];
      }
      for (int i = 0; i < 6; ++i) {
        const T used = Select(usable, step[i], T(0.0));
        candidate_[k][i] = states_[k][i] + used;
        step_[k][i] = Select(usable, step[i], step_[k][i]);
        if (i < 3) largest = Max(largest, Abs(used));
      }
    }
    return largest;
  }

  // Accepts the candidate, except in the `kept` lanes.
  void Keep(const Mask<T>& kept) {
    if (Any(kept)) {
      for (int k = 0; k < frames_; ++k) {
        for (int i = 0; i < 6; ++i) {
          trial_.gradient[k][i] =
              Select(kept, current_.gradient[k][i], trial_.gradient[k][i]);
          candidate_[k][i] = Select(kept, states_[k][i], candidate_[k][i]);
        }
        ForEachEntry([&](int, T& entry,
                         const T& old) { entry = Select(kept, old, entry); },
                     trial_.diagonal[k], current_.diagonal[k]);
      }
      trial_.cost = Select(kept, current_.cost, trial_.cost);
    }
    const LaneSystem<T> old = current_;
    current_ = trial_;
    trial_ = old;
    auto* const states = states_;
    states_ = candidate_;
    candidate_ = states;
  }

  void RunStage(const LaneStage& stage) {
    Linearise(states_, stage, &current_);
    if (Any(And(finite_, Not(current_.valid)))) {
      // The last step of the previous stage was not checked and may have moved
      // a joint behind a camera.
      Gate(Gated::kAsWell);
      Linearise(states_, stage, &current_);
    }
    finite_ = And(finite_, current_.valid);
    Mask<T> active = finite_;
    converged_ = And(converged_, Not(active));
    T damping = 0.0;
    for (int i = 0; i < stage.max_iterations && Any(active); ++i) {
      iterations_ += Select(active, T(1.0), T(0.0));
      const Mask<T> usable = And(active, Eliminate(current_.diagonal, damping));
      const T move = FindStep(usable);
      // A step below the tolerance is taken without checking its cost.
      const Mask<T> done = And(usable, move < T(stage.step_tolerance_m));
      Mask<T> accepted = done;
      if (Any(And(active, Not(done)))) {
        // Lanes without a step are linearised at unchanged states, with
        // identical results.
        Linearise(candidate_, stage, &trial_);
        // Near a minimum rounding may raise the cost by a part in 1e12.
        const Mask<T> lower =
            trial_.cost <= current_.cost + 1e-12 * (1.0 + current_.cost);
        accepted = Or(done, And(usable, And(trial_.valid, lower)));
      }
      const Mask<T> rejected = And(active, Not(accepted));
      const T lowered = Select(damping > T(1e-6), 0.1 * damping, T(0.0));
      const T raised = Select(damping > T(0.0), 10.0 * damping, T(1e-4));
      damping = Select(rejected, raised, lowered);
      Keep(rejected);
      converged_ = Or(converged_, done);
      active = And(active, Not(done));
      // Gives up where no step lowers the cost.
      active = And(active, Not(And(rejected, raised >= T(1e10))));
    }
  }

  const ChainLanes& chains_;
  const int lane_;
  const int frames_;
  LaneSystem<T> current_;
  LaneSystem<T> trial_;
  LaneBlock<T>* inverse_;  // P_k
  LaneMotion<T>* motion_;
  T (*gained_)[6];  // P_k r_k
  T (*states_)[6];
  T (*candidate_)[6];
  T (*step_)[6];
  T prior_root_[36];
  T prior_x0_[6];
  T prior_b_[6];
  LaneBlock<T> prior_information_;
  Mask<T> finite_;
  Mask<T> converged_;
  T iterations_;
};

template <typename T>
void SolveChainLanesWith(const ChainLanes& chains, const LaneStage* stages,
                         int stage_count, double* workspace,
                         const LaneReports& reports) {
  for (int lane = 0; lane < chains.joints; lane += T::kLanes) {
    ChainGroup<T>(chains, lane, workspace).Solve(stages, stage_count, reports);
  }
}

template <typename T>
void CovarianceChainLanesWith(const ChainLanes& chains, double correction,
                              int frame_end, double* workspace,
                              double* covariances, double* known) {
  for (int lane = 0; lane < chains.joints; lane += T::kLanes) {
    ChainGroup<T>(chains, lane, workspace)
        .Covariances(correction, frame_end, covariances, known);
  }
}

template <typename T>
void LineariseChainLanesWith(const ChainLanes& chains, const LaneStage& stage,
                             bool own_priors, double* workspace,
                             const LaneSystemRows& system) {
  for (int lane = 0; lane < chains.lanes; lane += T::kLanes) {
    ChainGroup<T>(chains, lane, workspace)
        .LineariseAll(stage, own_priors, system);
  }
}

template <typename T>
void WeighChainLanesWith(const ChainLanes& chains, const LaneStage& stage,
                         double* workspace) {
  for (int lane = 0; lane < chains.joints; lane += T::kLanes) {
    ChainGroup<T>(chains, lane, workspace).Weigh(stage);
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_BLOCK_TRIDIAGONAL_CHAIN_KERNEL_H_
