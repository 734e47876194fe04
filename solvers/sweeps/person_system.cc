#include "solvers/sweeps/person_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "solvers/graph/factor_list.h"
#include "solvers/sweeps/linear_chain.h"

namespace kinegraph {
namespace {

// What a factor on the positions of two joints in one frame adds between them:
// the information by_a by_b'.
struct PointCoupling {
  int a = 0;
  int b = 0;
  size_t frame = 0;
  Eigen::Vector3d by_a;
  Eigen::Vector3d by_b;
};

// Information of a person: a chain for each joint (the diagonal parts of
// coupling factors included) and what couples the joints within a frame.
struct PersonSystem {
  std::vector<LinearChain> chains;
  std::vector<PointCoupling> couplings;
  // Of the person's prior; the joints' own blocks stand in the chains. Empty
  // without one.
  Eigen::MatrixXd prior_coupling;
};

// Adds weight J'J of a factor on two joints of one frame.
template <typename Factor>
void AddCoupling(const Linearised<Factor>& at, const Keys<2>& keys,
                 double weight, PersonSystem* system) {
  static_assert(Factor::kResiduals == 1, "a coupling has rank one");
  const double root = std::sqrt(weight);
  Eigen::Vector3d by_point[2];
  for (int i = 0; i < 2; ++i) {
    AddProduct(at.by_states[i], at.by_states[i], weight,
               system->chains[keys[i].joint].diagonal[keys[i].frame].data());
    by_point[i] =
        root * Eigen::Map<const Eigen::Vector3d>(at.by_states[i].by_point[0]);
  }
  system->couplings.push_back(
      {keys[0].joint, keys[1].joint, keys[0].frame, by_point[0], by_point[1]});
}

void AddCouplings(const PersonProblem& problem, PersonSystem* system) {
  const auto state_of = [&](const StateKey& key) {
    return problem.joints[key.joint].states[key.frame].data();
  };
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    Linearised<std::decay_t<decltype(factor)>> at;
    if (!LineariseFactor(factor, keys, state_of, &at)) return false;
    const LossValue loss = robustness.Evaluate(at.squared_norm());
    AddCoupling(at, keys, robustness.information * loss.first, system);
    return true;
  };
  ForEachCoupling(problem, FactorWalk(), add);
}

// The joints' own blocks of A'A.
void AddPriorInformation(const Eigen::MatrixXd& A, PersonSystem* system) {
  for (size_t j = 0; j < system->chains.size(); ++j) {
    // A is upper triangular: below the block there is nothing.
    const auto columns =
        A.block(0, j * kStateSize, (j + 1) * kStateSize, kStateSize);
    system->chains[j].diagonal[0].noalias() += columns.transpose() * columns;
  }
}

// A'A without the joints' own blocks; empty without a prior.
Eigen::MatrixXd PriorCoupling(const Eigen::MatrixXd& A) {
  Eigen::MatrixXd coupling = A.transpose() * A;
  for (Eigen::Index at = 0; at < A.cols(); at += kStateSize) {
    coupling.block<kStateSize, kStateSize>(at, at).setZero();
  }
  return coupling;
}

// L^-1 X in place for X that is zero above its diagonal, panel by panel: a
// third of the work of the whole.
void SolveLowerTriangular(const Eigen::MatrixXd& lower, Eigen::MatrixXd* x) {
  constexpr Eigen::Index kPanel = 24;
  const Eigen::Index size = lower.rows();
  for (Eigen::Index at = 0; at < size; at += kPanel) {
    const Eigen::Index rest = size - at;
    auto panel = x->block(at, at, rest, std::min(kPanel, rest));
    lower.bottomRightCorner(rest, rest)
        .triangularView<Eigen::Lower>()
        .solveInPlace(panel);
  }
}

// sum += sign * X' X for such an X, in the lower triangle.
void AddSquare(const Eigen::MatrixXd& x, double sign, Eigen::MatrixXd* sum) {
  constexpr Eigen::Index kPanel = 24;
  const Eigen::Index size = x.rows();
  for (Eigen::Index at = 0; at < size; at += kPanel) {
    const Eigen::Index rows = std::min(kPanel, size - at);
    const Eigen::Index columns = at + rows;
    sum->topLeftCorner(columns, columns)
        .selfadjointView<Eigen::Lower>()
        .rankUpdate(x.block(at, 0, rows, columns).transpose(), sign);
  }
}

// Selected inversion with whole frames as blocks.
class FrameInversion {
 public:
  FrameInversion(const PersonProblem& problem, const PersonSystem& system)
      : problem_(problem),
        system_(system),
        frame_count_(problem.times.size()),
        size_(static_cast<Eigen::Index>(problem.joints.size()) * kStateSize) {
    SortCouplings();
    AddUserFactors();
  }

  bool Run(size_t frame_end, std::vector<std::vector<Matrix6d>>* covariances) {
    frame_end_ = frame_end;
    covariances_ = covariances;
    // Blocks are eliminated from the last frame to the first, so that a window
    // is done when its oldest frame is reached.
    if (!Sweep()) return false;
    return true;
  }

 private:
  static constexpr size_t kStretch = 32;  // frames

  void SortCouplings() {
    for (const PointCoupling& coupling : system_.couplings) {
      by_frame_.push_back(&coupling);
    }
    std::stable_sort(by_frame_.begin(), by_frame_.end(),
                     [](const PointCoupling* x, const PointCoupling* y) {
                       return x->frame < y->frame;
                     });
    first_coupling_.assign(frame_count_ + 1, 0);
    for (const PointCoupling* coupling : by_frame_) {
      ++first_coupling_[coupling->frame + 1];
    }
    for (size_t k = 0; k < frame_count_; ++k) {
      first_coupling_[k + 1] += first_coupling_[k];
    }
  }

  // What the user's factors say: frame by frame a dense block, and where they
  // link two frames of any joints a dense one below.
  void AddUserFactors() {
    const auto state_of = [&](const StateKey& key) {
      return problem_.joints[key.joint].states[key.frame].data();
    };
    GeneralRows rows;
    for (const PlacedFactor& placed : problem_.user) {
      if (!LineariseGeneral(placed, state_of, &rows)) continue;
      for (size_t a = 0; a < placed.keys.size(); ++a) {
        for (size_t b = 0; b < placed.keys.size(); ++b) {
          const StateKey& of_a = placed.keys[a];
          const StateKey& of_b = placed.keys[b];
          if (of_a.frame < of_b.frame) continue;
          auto& blocks =
              of_a.frame == of_b.frame ? user_diagonal_ : user_below_;
          Eigen::MatrixXd& block = blocks[of_b.frame];
          if (block.size() == 0) block = Eigen::MatrixXd::Zero(size_, size_);
          block.block<6, 6>(6 * of_a.joint, 6 * of_b.joint) +=
              rows.by_states[a].transpose() * rows.by_states[b];
        }
      }
    }
  }

  Eigen::MatrixXd Diagonal(size_t k) const {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size_, size_);
    if (k == 0 && system_.prior_coupling.size() > 0) {
      block = system_.prior_coupling;
    }
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      block.block<6, 6>(j * 6, j * 6) += system_.chains[j].diagonal[k];
    }
    for (size_t i = first_coupling_[k]; i < first_coupling_[k + 1]; ++i) {
      const PointCoupling& coupling = *by_frame_[i];
      const Eigen::Matrix3d information =
          coupling.by_a * coupling.by_b.transpose();
      const Eigen::Index a = 6 * coupling.a;
      const Eigen::Index b = 6 * coupling.b;
      block.block<3, 3>(a, b) += information;
      block.block<3, 3>(b, a) += information.transpose();
    }
    const auto user = user_diagonal_.find(k);
    if (user != user_diagonal_.end()) block += user->second;
    return block;
  }

  // The block right of frame k's diagonal, transposed: 6x6 blocks on its own
  // diagonal.
  Eigen::MatrixXd Below(size_t k) const {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size_, size_);
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      block.block<6, 6>(j * 6, j * 6) = system_.chains[j].upper[k].transpose();
    }
    const auto user = user_below_.find(k);
    if (user != user_below_.end()) block += user->second;
    return block;
  }

  // From the pivot of frame k + 1 (Cholesky factor in its lower triangle) to
  // that of frame k; `coupling` receives L^-1 B'.
  bool Step(size_t k, const Eigen::MatrixXd& later, Eigen::MatrixXd* coupling,
            Eigen::MatrixXd* pivot) const {
    *pivot = Diagonal(k);
    if (k + 1 < frame_count_) {
      *coupling = Below(k);
      if (user_below_.count(k) > 0) {
        later.triangularView<Eigen::Lower>().solveInPlace(*coupling);
        pivot->selfadjointView<Eigen::Lower>().rankUpdate(coupling->transpose(),
                                                          -1.0);
      } else {
        SolveLowerTriangular(later, coupling);
        AddSquare(*coupling, -1.0, pivot);
      }
    }
    Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(*pivot);
    return cholesky.info() == Eigen::Success;
  }

  bool Sweep() {
    // First pass, last frame to first: keep a pivot at the end of a stretch.
    std::vector<Eigen::MatrixXd> kept((frame_count_ + kStretch - 1) / kStretch);
    Eigen::MatrixXd later;
    Eigen::MatrixXd coupling;
    Eigen::MatrixXd pivot;
    for (size_t k = frame_count_; k-- > 0;) {
      if (!Step(k, later, &coupling, &pivot)) return false;
      if (!pivot.diagonal().allFinite()) return false;
      if (k % kStretch == 0) kept[k / kStretch] = pivot;
      std::swap(later, pivot);
    }
    // Second pass, first frame to last:
    //   C_k+1 = S_k+1^-1 + G C_k G',  G = L^-T L^-1 B' of frame k + 1.
    Eigen::MatrixXd covariance = Inverse(later);
    Take(0, covariance);
    std::vector<Eigen::MatrixXd> pivots(kStretch);
    std::vector<Eigen::MatrixXd> couplings(kStretch);
    for (size_t begin = 0; begin + 1 < frame_end_; begin += kStretch) {
      // Factors of frames begin + 1 .. end again, from the kept pivot at end.
      size_t end = std::min(begin + kStretch, frame_count_ - 1);
      pivots.resize(end - begin + 1);
      couplings.resize(end - begin + 1);
      if (end % kStretch == 0) {
        pivots[end - begin] = kept[end / kStretch];
      } else {
        Eigen::MatrixXd unused;
        if (!Step(end, unused, &unused, &pivots[end - begin])) return false;
      }
      for (size_t k = end; k-- > begin;) {
        if (!Step(k, pivots[k + 1 - begin], &couplings[k - begin],
                  &pivots[k - begin])) {
          return false;
        }
      }
      for (size_t k = begin; k < end && k + 1 < frame_end_; ++k) {
        Eigen::MatrixXd& gain = couplings[k - begin];
        const Eigen::MatrixXd& lower = pivots[k + 1 - begin];
        lower.triangularView<Eigen::Lower>().transpose().solveInPlace(gain);
        const Eigen::MatrixXd product = gain * covariance;
        covariance = Inverse(lower);
        // Symmetric: half of the product is enough.
        covariance.triangularView<Eigen::Lower>() += product * gain.transpose();
        covariance.triangularView<Eigen::StrictlyUpper>() =
            covariance.transpose();
        Take(k + 1, covariance);
      }
    }
    return true;
  }

  Eigen::MatrixXd Inverse(const Eigen::MatrixXd& lower) const {
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(size_, size_);
    SolveLowerTriangular(lower, &inverse);
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(size_, size_);
    AddSquare(inverse, 1.0, &product);
    return product.selfadjointView<Eigen::Lower>();
  }

  void Take(size_t k, const Eigen::MatrixXd& covariance) {
    if (k >= frame_end_) return;
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      (*covariances_)[j][k] = covariance.block<6, 6>(j * 6, j * 6);
    }
  }

  const PersonProblem& problem_;
  const PersonSystem& system_;
  const size_t frame_count_;
  const Eigen::Index size_;
  std::vector<const PointCoupling*> by_frame_;
  std::vector<size_t> first_coupling_;  // of each frame, in by_frame_
  std::map<size_t, Eigen::MatrixXd> user_diagonal_;  // by frame
  std::map<size_t, Eigen::MatrixXd> user_below_;     // by the earlier frame
  size_t frame_end_ = 0;
  std::vector<std::vector<Matrix6d>>* covariances_ = nullptr;
};

}  // namespace

bool PersonCovariances(const PersonProblem& problem, double correction,
                       size_t frame_end,
                       std::vector<std::vector<Matrix6d>>* covariances) {
  const size_t joint_count = problem.joints.size();
  covariances->resize(joint_count);
  PersonSystem system;
  system.chains.resize(joint_count);
  for (size_t j = 0; j < joint_count; ++j) {
    (*covariances)[j].resize(frame_end);
    LineariseInformation(problem.times, problem.joints[j], correction,
                         problem.prior.empty(), &system.chains[j]);
  }
  AddCouplings(problem, &system);
  if (!problem.prior.empty()) {
    system.prior_coupling = PriorCoupling(problem.prior.A_stated);
    AddPriorInformation(problem.prior.A_stated, &system);
  }
  return FrameInversion(problem, system).Run(frame_end, covariances);
}

}  // namespace kinegraph
