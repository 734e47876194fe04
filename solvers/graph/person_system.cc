#include "solvers/graph/person_system.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace kinegraph {
namespace {

struct BoneTerm {
  double residual = 0.0;      // whitened
  Eigen::Vector3d direction;  // d residual / d p_a
};

BoneTerm Evaluate(const BoneConstraint& bone, const State& a, const State& b) {
  BoneTerm term;
  const Eigen::Vector3d between = a.head<3>() - b.head<3>();
  const double length = between.norm();
  constexpr double kCoincident = 1e-9;  // as bone_length_factor.cc
  term.residual = (length - bone.length_m) / bone.sigma_m;
  term.direction.setZero();
  if (length > kCoincident) term.direction = between / (length * bone.sigma_m);
  return term;
}

void AddBones(const PersonProblem& problem, const PersonStates& states,
              PersonSystem* system) {
  system->directions.resize(problem.bones.size());
  for (size_t i = 0; i < problem.bones.size(); ++i) {
    const BoneConstraint& bone = problem.bones[i];
    LinearChain& a = system->chains[bone.a];
    LinearChain& b = system->chains[bone.b];
    system->directions[i].resize(problem.times.size());
    for (size_t k = 0; k < problem.times.size(); ++k) {
      const BoneTerm term =
          Evaluate(bone, states[bone.a][k], states[bone.b][k]);
      system->directions[i][k] = term.direction;
      const Eigen::Matrix3d information =
          term.direction * term.direction.transpose();
      a.diagonal[k].topLeftCorner<3, 3>() += information;
      b.diagonal[k].topLeftCorner<3, 3>() += information;
      a.gradient[k].head<3>() += term.residual * term.direction;
      b.gradient[k].head<3>() -= term.residual * term.direction;
      system->cost += 0.5 * term.residual * term.residual;
    }
  }
}

// The prior's information: each joint's own block joins its chain, the rest
// stays as coupling.
void AddPriorInformation(const Eigen::MatrixXd& A, PersonSystem* system) {
  system->prior_coupling.noalias() = A.transpose() * A;
  for (size_t j = 0; j < system->chains.size(); ++j) {
    auto block = system->prior_coupling.block<kStateSize, kStateSize>(
        j * kStateSize, j * kStateSize);
    system->chains[j].diagonal[0] += block;
    block.setZero();
  }
}

void AddPrior(const PersonPrior& prior, const PersonStates& states,
              PersonSystem* system) {
  Eigen::VectorXd away = -prior.x0;
  for (size_t j = 0; j < states.size(); ++j) {
    away.segment<kStateSize>(j * kStateSize) += states[j][0];
  }
  const Eigen::VectorXd residual = prior.A * away + prior.b;
  const Eigen::VectorXd gradient = prior.A.transpose() * residual;
  system->cost += 0.5 * residual.squaredNorm();
  for (size_t j = 0; j < states.size(); ++j) {
    system->chains[j].gradient[0] +=
        gradient.segment<kStateSize>(j * kStateSize);
  }
  AddPriorInformation(prior.A, system);
}

}  // namespace

bool Linearise(const PersonProblem& problem, const PersonStates& states,
               const SolveStage& stage, PersonSystem* system) {
  system->cost = 0.0;
  system->chains.resize(problem.joints.size());
  const bool own_priors = problem.prior.empty();
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    if (!Linearise(problem.times, problem.joints[j], states[j], stage,
                   own_priors, &system->chains[j])) {
      return false;
    }
    system->cost += system->chains[j].cost;
  }
  AddBones(problem, states, system);
  if (!own_priors) AddPrior(problem.prior, states, system);
  return std::isfinite(system->cost);
}

void Multiply(const PersonProblem& problem, const PersonSystem& system,
              double damping, const PersonStates& x, PersonStates* product) {
  const size_t frame_count = problem.times.size();
  for (size_t j = 0; j < x.size(); ++j) {
    const LinearChain& chain = system.chains[j];
    std::vector<State>& y = (*product)[j];
    for (size_t k = 0; k < frame_count; ++k) {
      y[k].noalias() = chain.diagonal[k] * x[j][k];
      if (damping > 0.0) {
        y[k] += damping * chain.diagonal[k].diagonal().cwiseProduct(x[j][k]);
      }
      if (k > 0) y[k].noalias() += chain.upper[k - 1].transpose() * x[j][k - 1];
      if (k + 1 < frame_count) y[k].noalias() += chain.upper[k] * x[j][k + 1];
    }
  }
  for (size_t i = 0; i < problem.bones.size(); ++i) {
    const BoneConstraint& bone = problem.bones[i];
    for (size_t k = 0; k < frame_count; ++k) {
      const Eigen::Vector3d& d = system.directions[i][k];
      (*product)[bone.a][k].head<3>() -= d * d.dot(x[bone.b][k].head<3>());
      (*product)[bone.b][k].head<3>() -= d * d.dot(x[bone.a][k].head<3>());
    }
  }
  if (system.prior_coupling.size() == 0) return;
  Eigen::VectorXd first(x.size() * kStateSize);
  for (size_t j = 0; j < x.size(); ++j) {
    first.segment<kStateSize>(j * kStateSize) = x[j][0];
  }
  const Eigen::VectorXd coupled = system.prior_coupling * first;
  for (size_t j = 0; j < x.size(); ++j) {
    (*product)[j][0] += coupled.segment<kStateSize>(j * kStateSize);
  }
}

namespace {

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
        size_(static_cast<Eigen::Index>(problem.joints.size()) * kStateSize) {}

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

  Eigen::MatrixXd Diagonal(size_t k) const {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size_, size_);
    if (k == 0 && system_.prior_coupling.size() > 0) {
      block = system_.prior_coupling;
    }
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      block.block<6, 6>(j * 6, j * 6) += system_.chains[j].diagonal[k];
    }
    for (size_t i = 0; i < problem_.bones.size(); ++i) {
      const Eigen::Vector3d& d = system_.directions[i][k];
      const Eigen::Matrix3d information = d * d.transpose();
      const Eigen::Index a = 6 * problem_.bones[i].a;
      const Eigen::Index b = 6 * problem_.bones[i].b;
      block.block<3, 3>(a, b) -= information;
      block.block<3, 3>(b, a) -= information;
    }
    return block;
  }

  // The block right of frame k's diagonal, transposed: 6x6 blocks on its own
  // diagonal.
  Eigen::MatrixXd Below(size_t k) const {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(size_, size_);
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      block.block<6, 6>(j * 6, j * 6) = system_.chains[j].upper[k].transpose();
    }
    return block;
  }

  // From the pivot of frame k + 1 (Cholesky factor in its lower triangle) to
  // that of frame k; `coupling` receives L^-1 B'.
  bool Step(size_t k, const Eigen::MatrixXd& later, Eigen::MatrixXd* coupling,
            Eigen::MatrixXd* pivot) const {
    *pivot = Diagonal(k);
    if (k + 1 < frame_count_) {
      *coupling = Below(k);
      SolveLowerTriangular(later, coupling);
      AddSquare(*coupling, -1.0, pivot);
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
  PersonStates states(joint_count);
  system.chains.resize(joint_count);
  for (size_t j = 0; j < joint_count; ++j) {
    (*covariances)[j].resize(frame_end);
    states[j] = problem.joints[j].states;
    LineariseMotion(problem.times, problem.joints[j].process_noise,
                    &system.chains[j]);
    LineariseInformation(problem.times, problem.joints[j], correction,
                         problem.prior.empty(), &system.chains[j]);
  }
  AddBones(problem, states, &system);
  if (!problem.prior.empty()) {
    AddPriorInformation(problem.prior.A_stated, &system);
  }
  return FrameInversion(problem, system).Run(frame_end, covariances);
}

}  // namespace kinegraph
