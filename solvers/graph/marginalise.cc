#include "solvers/graph/marginalise.h"

#include <glog/logging.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/dense_lanes.h"
#include "core/base/lane_buffer.h"
#include "core/base/pack.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Two priors result from a dropped frame: one for the estimate, and one for the
// reported covariances, with corrected weights (StatePrior::A_stated).
enum class KeptFor { kEstimate, kCovariance };

// Factors whose earliest state is in the first frame.
FactorWalk FirstFrame(KeptFor use) {
  FactorWalk walk;
  walk.end = 1;
  walk.stated = use == KeptFor::kCovariance;
  return walk;
}

// Calls `visit(linearised factor, keys, weight)` for a joint's factors of the
// first frame; `correction` multiplies the weights of observations.
template <typename Visit>
void LineariseFirst(const PersonProblem& problem, size_t joint,
                    const FactorWalk& walk, double correction,
                    const Visit& visit) {
  const JointChain& chain = problem.joints[joint];
  ForEachFactor(
      problem, joint, walk,
      [&](const auto& factor, const auto& keys, const Robustness& robustness) {
        Linearised<std::decay_t<decltype(factor)>> at;
        if (!LineariseFactor(factor, keys, problem, &at)) return true;
        double weight = robustness.information *
                        WeightAtEstimate(chain, robustness, at.squared_norm());
        if (robustness.measurement >= 0) weight *= correction;
        visit(at, keys, weight);
        return true;
      });
}

using TwoStates = RowTriangle<2 * kStateSize>;

SquareRootPrior<kStateSize> MarginaliseWith(const PersonProblem& problem,
                                            size_t joint, KeptFor use,
                                            double correction) {
  TwoStates triangle;
  std::vector<TwoStates::Row> of_both;
  const auto add = [&](const auto& at, const auto& keys, double weight) {
    const double root = std::sqrt(weight);
    for (size_t i = 0; i < std::size(at.residual); ++i) {
      TwoStates::Row row{};
      row.back() = root * at.residual[i];
      for (size_t key = 0; key < keys.size(); ++key) {
        for (int c = 0; c < kStateSize; ++c) {
          row[kStateSize * key + c] =
              root * at.by_states[key](static_cast<int>(i), c);
        }
      }
      if (keys.size() == 1) {
        triangle.Add(row, kStateSize);
      } else {
        of_both.push_back(row);
      }
    }
  };
  LineariseFirst(problem, joint, FirstFrame(use), correction, add);
  for (const TwoStates::Row& row : of_both) triangle.Add(row);
  return triangle.Drop<kStateSize>();
}

void EraseFirst(JointChain* chain) {
  const int32_t dropped = chain->first[1];
  chain->measurements.erase(chain->measurements.begin(),
                            chain->measurements.begin() + dropped);
  chain->first.erase(chain->first.begin());
  for (int32_t& first : chain->first) first -= dropped;
  chain->states.erase(chain->states.begin());
  chain->process_noise.erase(chain->process_noise.begin());
}

void EraseFirst(std::vector<PlacedFactor>* user) {
  user->erase(std::remove_if(user->begin(), user->end(),
                             [](const PlacedFactor& placed) {
                               return placed.first_frame() == 0;
                             }),
              user->end());
  for (PlacedFactor& placed : *user) {
    for (StateKey& key : placed.keys) --key.frame;
  }
}

StatePrior MarginaliseFirstState(const PersonProblem& problem, size_t joint,
                                 double correction) {
  const auto kept = MarginaliseWith(problem, joint, KeptFor::kEstimate, 1.0);
  StatePrior prior;
  prior.A = kept.A;
  prior.b = kept.b;
  prior.x0 = problem.joints[joint].states[1];
  prior.A_stated =
      correction == 1.0
          ? prior.A
          : MarginaliseWith(problem, joint, KeptFor::kCovariance, correction).A;
  return prior;
}

Eigen::Index ColumnOf(const StateKey& key) { return kStateSize * key.joint; }

// A square matrix of `size` rows, padded as EliminateDense requires.
class PaddedSquare {
 public:
  explicit PaddedSquare(Eigen::Index size)
      : size_(size), rows_(PaddedLanes(static_cast<int>(size))) {
    numbers_.Assign(rows_ * rows_, 0.0);
  }

  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> inside() {
    return {numbers_.data(), size_, size_, Eigen::OuterStride<>(rows_)};
  }
  double* data() { return numbers_.data(); }
  int rows() const { return static_cast<int>(rows_); }
  void PadWithIdentity() {
    for (Eigen::Index i = size_; i < rows_; ++i) numbers_[i * rows_ + i] = 1.0;
  }

 private:
  const Eigen::Index size_;
  const Eigen::Index rows_;
  LaneBuffer numbers_;
};

// Information and gradients of the states of the first two frames. `below` is
// the block between the frames, with the second frame's states as rows.
struct TwoFrames {
  explicit TwoFrames(Eigen::Index size)
      : first(size),
        below(size),
        second(size),
        first_gradient(Eigen::VectorXd::Zero(size)),
        second_gradient(Eigen::VectorXd::Zero(size)) {}

  PaddedSquare first;
  PaddedSquare below;
  PaddedSquare second;
  Eigen::VectorXd first_gradient;
  Eigen::VectorXd second_gradient;
  bool joints_apart = true;  // `below` has one block per joint
};

// Adds `weight` a' b to a block of `information`.
template <typename JacobianA, typename JacobianB>
void AddBlock(const JacobianA& a, const JacobianB& b, double weight,
              Eigen::Index row, Eigen::Index column,
              PaddedSquare* information) {
  Matrix6d block = Matrix6d::Zero();
  AddProduct(a, b, weight, block.data());
  information->inside().block<6, 6>(row, column) += block;
}

void AddPrior(const PersonProblem& problem, KeptFor use, TwoFrames* frames) {
  const PersonPrior& prior = problem.prior;
  if (prior.empty()) return;
  frames->first.inside() +=
      use == KeptFor::kEstimate ? prior.information : prior.stated;
  Eigen::VectorXd away = -prior.x0;
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    away.segment<kStateSize>(kStateSize * j) += problem.joints[j].states[0];
  }
  const Eigen::VectorXd residual = prior.A * away + prior.b;
  frames->first_gradient += prior.A.transpose() * residual;
}

// The factors that couple joints in the first frame.
void AddCouplings(const PersonProblem& problem, TwoFrames* frames) {
  ForEachCoupling(
      problem, FirstFrame(KeptFor::kEstimate),
      [&](const auto& factor, const auto& keys, const Robustness& robustness) {
        Linearised<std::decay_t<decltype(factor)>> at;
        if (!LineariseFactor(factor, keys, problem, &at)) return true;
        const double weight = robustness.information *
                              robustness.Evaluate(at.squared_norm()).first;
        for (int i = 0; i < 2; ++i) {
          AddGradient(at.by_states[i], at.residual, weight,
                      &frames->first_gradient[ColumnOf(keys[i])]);
          for (int l = 0; l < 2; ++l) {
            AddBlock(at.by_states[i], at.by_states[l], weight,
                     ColumnOf(keys[i]), ColumnOf(keys[l]), &frames->first);
          }
        }
        return true;
      });
}

// Each joint's own factors whose earliest state is in the first frame.
void AddJoints(const PersonProblem& problem, KeptFor use, double correction,
               TwoFrames* frames) {
  FactorWalk walk = FirstFrame(use);
  walk.priors = problem.prior.empty();
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    const Eigen::Index own = kStateSize * static_cast<Eigen::Index>(j);
    LineariseFirst(
        problem, j, walk, correction,
        [&](const auto& at, const auto& keys, double weight) {
          AddGradient(at.by_states[0], at.residual, weight,
                      &frames->first_gradient[own]);
          AddBlock(at.by_states[0], at.by_states[0], weight, own, own,
                   &frames->first);
          if constexpr (std::tuple_size_v<std::decay_t<decltype(keys)>> == 2) {
            AddGradient(at.by_states[1], at.residual, weight,
                        &frames->second_gradient[own]);
            AddBlock(at.by_states[1], at.by_states[0], weight, own, own,
                     &frames->below);
            AddBlock(at.by_states[1], at.by_states[1], weight, own, own,
                     &frames->second);
          }
        });
  }
}

// The user's factors whose earliest state is in the first frame.
void AddUser(const PersonProblem& problem, TwoFrames* frames) {
  GeneralRows rows;
  for (const PlacedFactor& placed : problem.user) {
    if (placed.first_frame() > 0) continue;
    if (!LineariseGeneral(placed, problem, &rows)) continue;
    if (placed.last_frame() > 0) frames->joints_apart = false;
    for (size_t a = 0; a < placed.keys.size(); ++a) {
      const StateKey& of_a = placed.keys[a];
      Eigen::VectorXd& gradient =
          of_a.frame == 0 ? frames->first_gradient : frames->second_gradient;
      gradient.segment<kStateSize>(ColumnOf(of_a)) +=
          rows.by_states[a].transpose() * rows.residual;
      for (size_t b = 0; b < placed.keys.size(); ++b) {
        const StateKey& of_b = placed.keys[b];
        if (of_a.frame < of_b.frame) continue;
        PaddedSquare& square = of_a.frame == 0   ? frames->first
                               : of_b.frame == 0 ? frames->below
                                                 : frames->second;
        square.inside().block<6, 6>(ColumnOf(of_a), ColumnOf(of_b)) +=
            rows.by_states[a].transpose() * rows.by_states[b];
      }
    }
  }
}

// Eliminates the first frame's states, which leaves information and gradient of
// the second frame's states in `second` and `second_gradient`. False where the
// first frame's states are not determined.
bool EliminateFirst(TwoFrames* frames) {
  // Adds the bound of the Schur complement's rounding error (n products are
  // subtracted from each entry). Otherwise the information of a joint that has
  // been out of view for a very long time could become negative.
  auto second = frames->second.inside();
  const double size = static_cast<double>(second.rows());
  second.diagonal() *= 1.0 + size * std::numeric_limits<double>::epsilon();
  frames->first.PadWithIdentity();
  if (!EliminateDense({frames->first.rows(),
                       frames->joints_apart ? kStateSize : 0,
                       frames->first.data(), frames->below.data(),
                       frames->second.data()})) {
    return false;
  }
  const Eigen::VectorXd gained =
      frames->first.inside().triangularView<Eigen::Lower>().solve(
          frames->first_gradient);
  frames->second_gradient -= frames->below.inside() * gained;
  second.triangularView<Eigen::StrictlyUpper>() =
      second.transpose().triangularView<Eigen::StrictlyUpper>();
  return true;
}

std::optional<TwoFrames> LeaveFirst(const PersonProblem& problem, KeptFor use,
                                    double correction) {
  std::optional<TwoFrames> frames(
      kStateSize * static_cast<Eigen::Index>(problem.joints.size()));
  AddPrior(problem, use, &*frames);
  AddCouplings(problem, &*frames);
  AddJoints(problem, use, correction, &*frames);
  AddUser(problem, &*frames);
  if (!EliminateFirst(&*frames)) return std::nullopt;
  return frames;
}

// Where the joints are coupled, replaces the first frame by one prior on the
// second states of all joints, by Schur complement. With x1 the states of the
// first frame, x2 the states of the second, and the factors that touch x1
// linearised at the estimate, the cost is, up to a constant,
//   1/2 [d1 d2] [L11 L21'] [d1] + [g1' g2'] [d1]
//               [L21 L22 ] [d2]             [d2]
// in the steps d1, d2. For any d2 the minimum over d1 is at d1 = -L11^-1 (g1 +
// L21' d2); substituting it leaves a prior on d2 alone,
//   information L22 - L21 L11^-1 L21',   gradient g2 - L21 L11^-1 g1.
// Together with the later factors, which do not touch x1, this prior gives the
// remaining frames the same minimum and covariances as the whole problem. L11 =
// C C' is factored once; the columns of C^-1 L21' give the product that is
// subtracted. Unless a user's factor links both frames, L21 consists of one
// block per joint, which EliminateDense exploits. Returns nullopt where the
// information is not positive definite, which only a user's factor can cause.
std::optional<PersonPrior> MarginaliseFirstFrame(const PersonProblem& problem,
                                                 double correction) {
  std::optional<TwoFrames> kept = LeaveFirst(problem, KeptFor::kEstimate, 1.0);
  if (!kept.has_value()) return std::nullopt;
  PersonPrior prior;
  prior.information = kept->second.inside();
  prior.stated = prior.information;
  if (correction != 1.0) {
    std::optional<TwoFrames> stated =
        LeaveFirst(problem, KeptFor::kCovariance, correction);
    if (stated.has_value()) prior.stated = stated->second.inside();
  }
  kept->second.PadWithIdentity();
  if (!EliminateDense(
          {kept->second.rows(), 0, kept->second.data(), nullptr, nullptr})) {
    return std::nullopt;
  }
  const auto root = kept->second.inside().triangularView<Eigen::Lower>();
  prior.A = root.transpose();
  prior.b = root.solve(kept->second_gradient);
  prior.x0.resize(prior.b.size());
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    prior.x0.segment<6>(kStateSize * j) = problem.joints[j].states[1];
  }
  return prior;
}

}  // namespace

void DropFirstFrame(double correction, PersonProblem* problem) {
  CHECK_GE(problem->times.size(), 2u);
  if (problem->coupled()) {
    std::optional<PersonPrior> prior =
        MarginaliseFirstFrame(*problem, correction);
    LOG_IF(WARNING, !prior.has_value())
        << "the coupled prior of earlier frames is dropped: its information is "
           "not positive definite";
    problem->prior = prior.has_value() ? *std::move(prior) : PersonPrior();
  }
  for (size_t j = 0; j < problem->joints.size(); ++j) {
    JointChain& chain = problem->joints[j];
    chain.prior = MarginaliseFirstState(*problem, j, correction);
    EraseFirst(&chain);
  }
  problem->times.erase(problem->times.begin());
  problem->centres.erase(problem->centres.begin());
  EraseFirst(&problem->user);
}

}  // namespace kinegraph
