#include "solvers/ceres/ceres_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/stop_check.h"
#include "solvers/ceres/ceres_factor.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

using CeresMotion = CeresFactor<ConstantVelocity<double>>;
using CeresBone = CeresFactor<BoneLength<double>>;
using CeresPrior = CeresFactor<GaussianPrior<double>>;

// Adapts a user's factor, which the PersonProblem owns.
class CeresGeneral final : public ceres::CostFunction {
 public:
  explicit CeresGeneral(const GeneralFactor* factor) : factor_(factor) {
    set_num_residuals(factor->residual_count());
    mutable_parameter_block_sizes()->assign(factor->state_count(), kStateSize);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    return factor_->Evaluate(parameters, residuals, jacobians);
  }

 private:
  const GeneralFactor* factor_;
};

// Ceres' data for one frame: the joints' states as parameter blocks and the
// factors whose latest state is among them. Their addresses never change.
struct FrameBlocks {
  FrameBlocks(size_t joint_count, size_t bone_count)
      : states(joint_count),
        bundles(joint_count),
        motions(joint_count),
        bones(bone_count) {}

  std::vector<State> states;
  std::vector<ViewBundle> bundles;
  std::vector<CeresMotion> motions;  // from the previous frame
  std::vector<CeresBone> bones;
  std::vector<ceres::ResidualBlockId> residuals;  // in order of addition
};

// Records the last accepted step of all states. Ends a solve when an undamped
// step moves every position by less than the tolerance along each axis, or when
// a stop is requested.
class StepWatch final : public ceres::IterationCallback {
 public:
  using Frames = std::vector<std::unique_ptr<FrameBlocks>>;

  // Watches the first `count` frames. `frames` must outlive the watch.
  void Begin(const Frames* frames, size_t count, double tolerance_m) {
    frames_ = frames;
    tolerance_m_ = tolerance_m;
    stop_ = nullptr;
    before_.clear();
    for (size_t k = 0; k < count; ++k) {
      const std::vector<State>& states = (*frames)[k]->states;
      before_.insert(before_.end(), states.begin(), states.end());
    }
    step_.assign(before_.size(), State::Zero());
  }

  // Ordered by frame, then by joint.
  const std::vector<State>& step() const { return step_; }
  // Rethrows the exception that ended the solve (stop_check.h); exceptions must
  // not pass through Ceres.
  void RethrowStop() const {
    if (stop_ != nullptr) std::rethrow_exception(stop_);
  }

  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary& summary) override {
    try {
      CheckStop();
    } catch (...) {
      stop_ = std::current_exception();
      return ceres::SOLVER_ABORT;
    }
    if (summary.iteration == 0 || !summary.step_is_successful) {
      return ceres::SOLVER_CONTINUE;
    }
    double farthest_m = 0.0;
    size_t i = 0;
    for (auto frame = frames_->begin(); i < before_.size(); ++frame) {
      for (const State& now : (*frame)->states) {
        step_[i] = now - before_[i];
        before_[i] = now;
        farthest_m =
            std::max(farthest_m, step_[i].head<3>().cwiseAbs().maxCoeff());
        ++i;
      }
    }
    // A short step is no sign of convergence if the trust region limits it.
    // Ceres adds diag(J'J) / radius to J'J, negligible above this radius.
    constexpr double kFree = 1e3;
    return farthest_m < tolerance_m_ && summary.trust_region_radius >= kFree
               ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
               : ceres::SOLVER_CONTINUE;
  }

 private:
  const Frames* frames_ = nullptr;
  double tolerance_m_ = 0.0;
  std::vector<State> before_;
  std::vector<State> step_;
  std::exception_ptr stop_;
};

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  // CeresSolver creates all blocks itself, and they are distinct.
  options.disable_all_safety_checks = true;
  options.enable_fast_removal = true;
  return options;
}

// Largest gradient entry at which Ceres accepts a point as the minimum [1/m,
// s/m]. At gradient g a state of standard deviation s is about g s^2 from the
// minimum. At this limit that is the step tolerance for s = 1 cm, typical of
// two views, and 3 % of s for s = 10 cm at the default tolerance.
double GradientTolerance(double step_tolerance_m) {
  constexpr double kTypicalSigmaM = 0.01;
  return step_tolerance_m / (kTypicalSigmaM * kTypicalSigmaM);
}

ceres::Solver::Options SolverOptions(ceres::IterationCallback* callback) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // CHOLMOD's supernodal factorisation starts OpenMP threads, whatever
  // num_threads is, and is no faster: 18 iterations of 332 frames with bones
  // took 5.8 s with one thread and Debian's ATLAS, 4.7 s with Eigen.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.jacobi_scaling = false;
  options.initial_trust_region_radius = 1e12;  // nearly Gauss-Newton
  options.max_trust_region_radius = 1e16;
  options.update_state_every_iteration = true;  // for StepWatch
  options.callbacks.push_back(callback);
  return options;
}

}  // namespace

class CeresSolver::Graph {
 public:
  Graph() : options_(SolverOptions(&watch_)) {}

  SolveReport Solve(const SolveSchedule& schedule, PersonProblem* person) {
    SolveReport report;
    Arrange(*person);
    report.ceres_problems = 1;
    for (size_t i = 0; i < schedule.stages.size(); ++i) {
      Run(schedule.stages[i], schedule.StepToleranceM(i), person);
      Count(&report);
      if (!report.finite) break;
      Unload(person);
    }
    RemoveUser();
    if (!report.finite) return report;
    for (JointChain& chain : person->joints) {
      StoreWeights(schedule.stages.back(), &chain);
    }
    if (!report.converged && schedule.doubt_unsettled) Doubt(person, &report);
    return report;
  }

 private:
  // Adds or removes blocks to match the pattern of `person`.
  void Arrange(const PersonProblem& person) {
    RemoveUser();  // a stopped solve leaves them behind
    if (!HasPatternOf(person)) Reset(person);
    while (count_ > person.times.size()) RemoveFrame();
    while (count_ < person.times.size()) AddFrame(person);
    AddUser(person);
  }

  bool HasPatternOf(const PersonProblem& person) const {
    return problem_ != nullptr && joint_count_ == person.joints.size() &&
           (person_prior_ != nullptr) != person.prior.empty() &&
           std::equal(
               bones_.begin(), bones_.end(), person.bones.begin(),
               person.bones.end(),
               [](const std::pair<int, int>& ends, const BoneConstraint& bone) {
                 return ends == std::make_pair(bone.a, bone.b);
               });
  }

  void Reset(const PersonProblem& person) {
    problem_.reset();  // before the data it points to
    frames_.clear();
    count_ = 0;
    problem_ = std::make_unique<ceres::Problem>(ProblemOptions());
    joint_count_ = person.joints.size();
    bones_.clear();
    for (const BoneConstraint& bone : person.bones) {
      bones_.emplace_back(bone.a, bone.b);
    }
    person_prior_ = person.prior.empty()
                        ? nullptr
                        : std::make_unique<CeresPersonPrior>(joint_count_);
    priors_ = std::vector<CeresPrior>(person.prior.empty() ? joint_count_ : 0);
  }

  void AddFrame(const PersonProblem& person) {
    if (count_ == frames_.size()) {
      frames_.push_back(
          std::make_unique<FrameBlocks>(joint_count_, bones_.size()));
    }
    FrameBlocks& frame = *frames_[count_];
    const auto add = [&](ceres::CostFunction* cost, auto... states) {
      frame.residuals.push_back(
          problem_->AddResidualBlock(cost, nullptr, states...));
    };
    for (State& state : frame.states) {
      problem_->AddParameterBlock(state.data(), kStateSize);
    }
    for (size_t j = 0; j < joint_count_; ++j) {
      double* const state = frame.states[j].data();
      if (count_ == 0 && !priors_.empty()) add(&priors_[j], state);
      if (count_ > 0) {
        add(&frame.motions[j], frames_[count_ - 1]->states[j].data(), state);
      }
      frame.bundles[j].Set(person.joints[j], count_, person.centres[count_],
                           &stage_);
      add(&frame.bundles[j], state);
    }
    for (size_t i = 0; i < bones_.size(); ++i) {
      add(&frame.bones[i], frame.states[bones_[i].first].data(),
          frame.states[bones_[i].second].data());
    }
    if (count_ == 0 && person_prior_ != nullptr) {
      blocks_.clear();
      for (State& state : frame.states) blocks_.push_back(state.data());
      frame.residuals.push_back(
          problem_->AddResidualBlock(person_prior_.get(), nullptr, blocks_));
    }
    ++count_;
  }

  // Removes blocks in reverse order of addition: with fast removal Ceres moves
  // the last block to the place of the removed one.
  void RemoveFrame() {
    FrameBlocks& frame = *frames_[--count_];
    while (!frame.residuals.empty()) {
      problem_->RemoveResidualBlock(frame.residuals.back());
      frame.residuals.pop_back();
    }
    for (auto state = frame.states.rbegin(); state != frame.states.rend();
         ++state) {
      problem_->RemoveParameterBlock(state->data());
    }
  }

  // The user's factors differ from problem to problem and are not reused.
  void AddUser(const PersonProblem& person) {
    for (const PlacedFactor& placed : person.user) {
      user_.push_back(std::make_unique<CeresGeneral>(placed.factor.get()));
      losses_.emplace_back(
          MakeCeresLoss(placed.robustness.loss, placed.robustness.scale));
      blocks_.clear();
      for (const StateKey& key : placed.keys) {
        blocks_.push_back(frames_[key.frame]->states[key.joint].data());
      }
      user_residuals_.push_back(problem_->AddResidualBlock(
          user_.back().get(), losses_.back().get(), blocks_));
    }
  }

  void RemoveUser() {
    while (!user_residuals_.empty()) {
      problem_->RemoveResidualBlock(user_residuals_.back());
      user_residuals_.pop_back();
    }
    user_.clear();
    losses_.clear();
  }

  // Writes the numbers of `person` into the blocks.
  void Load(const PersonProblem& person, const SolveStage& stage) {
    stage_ = stage;
    FactorWalk walk;
    for (size_t j = 0; j < joint_count_; ++j) {
      const JointChain& chain = person.joints[j];
      const JointFactors factors(person, j, walk);
      if (!priors_.empty()) priors_[j].Set(factors.Prior());
      for (size_t k = 0; k < count_; ++k) {
        FrameBlocks& frame = *frames_[k];
        frame.states[j] = chain.states[k];
        frame.bundles[j].Set(chain, k, person.centres[k], &stage_);
        if (k > 0) frame.motions[j].Set(factors.Motion(k - 1));
      }
    }
    for (size_t i = 0; i < bones_.size(); ++i) {
      const BoneConstraint& bone = person.bones[i];
      for (size_t k = 0; k < count_; ++k) {
        frames_[k]->bones[i].Set({bone.length_m, 1.0 / bone.sigma_m});
      }
    }
    if (person_prior_ != nullptr) person_prior_->Set(&person.prior);
  }

  bool AllFinite() const {
    return std::all_of(
        frames_.begin(), frames_.begin() + count_, [](const auto& frame) {
          return std::all_of(
              frame->states.begin(), frame->states.end(),
              [](const State& state) { return state.allFinite(); });
        });
  }

  void Unload(PersonProblem* person) const {
    for (size_t j = 0; j < joint_count_; ++j) {
      StateChain& states = person->joints[j].states;
      for (size_t k = 0; k < count_; ++k) states[k] = frames_[k]->states[j];
    }
  }

  void Run(const SolveStage& stage, double step_tolerance_m,
           PersonProblem* person) {
    Load(*person, stage);
    watch_.Begin(&frames_, count_, step_tolerance_m);
    options_.max_num_iterations = stage.max_iterations;
    options_.gradient_tolerance = GradientTolerance(step_tolerance_m);
    // States held by bones and motion alone lie in a curved valley, along which
    // steps continue almost indefinitely without a significant change: a step
    // of n standard deviations lowers the cost by n^2 / 2. For ten seconds of a
    // person this share of the cost is 2e-3, i.e. 0.06 standard deviations.
    options_.function_tolerance = 100.0 * step_tolerance_m * step_tolerance_m;
    options_.parameter_tolerance = 1e-4 * step_tolerance_m;  // rounding
    ceres::Solve(options_, problem_.get(), &summary_);
    if (summary_.iterations.empty()) {
      // No iteration: the cost is undefined at the start, because the last step
      // of the preceding solve moved a joint behind a camera.
      for (JointChain& chain : person->joints) GateMeasurements(&chain);
      Load(*person, stage);
      ceres::Solve(options_, problem_.get(), &summary_);
    }
    watch_.RethrowStop();
    VLOG(2) << summary_.FullReport();
  }

  // Adds the stage's result to the report.
  void Count(SolveReport* report) const {
    report->finite = summary_.IsSolutionUsable() && AllFinite();
    report->converged = summary_.termination_type == ceres::CONVERGENCE ||
                        summary_.termination_type == ceres::USER_SUCCESS;
    report->ceres_iterations +=
        std::max(0, static_cast<int>(summary_.iterations.size()) - 1);
    report->cost_decrease = summary_.initial_cost - summary_.final_cost;
  }

  void Doubt(PersonProblem* person, SolveReport* report) const {
    StateChain step(count_);
    for (size_t j = 0; j < joint_count_; ++j) {
      for (size_t k = 0; k < count_; ++k) {
        step[k] = watch_.step()[joint_count_ * k + j];
      }
      report->unsettled += DoubtUnsettled(step, &person->joints[j]);
    }
  }

  size_t joint_count_ = 0;
  size_t count_ = 0;  // number of frames_ in the problem
  std::vector<std::pair<int, int>> bones_;
  SolveStage stage_;
  std::vector<std::unique_ptr<FrameBlocks>> frames_;
  std::vector<CeresPrior> priors_;  // by joint; empty if the person has a prior
  std::unique_ptr<CeresPersonPrior> person_prior_;
  std::vector<std::unique_ptr<CeresGeneral>> user_;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;
  std::vector<ceres::ResidualBlockId> user_residuals_;
  std::vector<double*> blocks_;  // work space
  StepWatch watch_;
  ceres::Solver::Options options_;
  ceres::Solver::Summary summary_;
  std::unique_ptr<ceres::Problem> problem_;
};

CeresSolver::CeresSolver() = default;
CeresSolver::~CeresSolver() = default;
CeresSolver::CeresSolver(CeresSolver&&) noexcept = default;
CeresSolver& CeresSolver::operator=(CeresSolver&&) noexcept = default;

SolveReport CeresSolver::Solve(const SolveSchedule& schedule,
                               PersonProblem* problem) {
  if (graph_ == nullptr) graph_ = std::make_unique<Graph>();
  return graph_->Solve(schedule, problem);
}

}  // namespace kinegraph
