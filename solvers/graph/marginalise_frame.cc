#include "solvers/graph/marginalise_frame.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "solvers/graph/factor_list.h"
#include "solvers/graph/marginalise.h"

namespace kinegraph {
namespace {

// Whitened, linearised factors: rows over states below each other.
struct Rows {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residual;
};

// What is left of a frame is kept twice: for the estimate, which the loss
// weighs, and for the covariances that are stated (StatePrior::A_stated).
enum class KeptFor { kEstimate, kCovariance };

// Factors whose earliest state is in the first frame.
FactorWalk FirstFrame(KeptFor use) {
  FactorWalk walk;
  walk.end = 1;
  walk.stated = use == KeptFor::kCovariance;
  return walk;
}

// Writes a factor's rows from `row` on, times `root`. `column_of(key)` is where
// a state's columns begin.
template <typename Factor, typename ColumnOf>
void WriteRows(const Linearised<Factor>& at, const Keys<Factor::kKeys>& keys,
               double root, const ColumnOf& column_of, Eigen::Index row,
               Rows* rows) {
  for (int i = 0; i < Factor::kResiduals; ++i) {
    rows->residual(row + i) = root * at.residual[i];
    for (int key = 0; key < Factor::kKeys; ++key) {
      const Eigen::Index column = column_of(keys[key]);
      for (int c = 0; c < kStateSize; ++c) {
        rows->jacobian(row + i, column + c) = root * at.by_states[key](i, c);
      }
    }
  }
}

// Calls `take(linearised factor, keys, root of what it counts)` for a joint's
// factors of the first frame; `correction` is that of the observations.
template <typename Take>
void LineariseFirst(const std::vector<TimeNs>& times, const JointChain& chain,
                    const FactorWalk& walk, double correction,
                    const Take& take) {
  const auto state_of = [&](const StateKey& key) {
    return chain.states[key.frame].data();
  };
  ForEachFactor(
      times, chain, 0, walk,
      [&](const auto& factor, const auto& keys, const Robustness& robustness) {
        Linearised<std::decay_t<decltype(factor)>> at;
        if (!LineariseFactor(factor, keys, state_of, &at)) return true;
        double weight = robustness.information *
                        WeightAtEstimate(chain, robustness, at.squared_norm());
        if (robustness.measurement >= 0) weight *= correction;
        take(at, keys, std::sqrt(weight));
        return true;
      });
}

SquareRootPrior MarginaliseWith(const std::vector<TimeNs>& times,
                                const JointChain& chain, KeptFor use,
                                double correction) {
  // At least as many rows as columns; prior, motion and measurements have.
  Eigen::Index row_count = 0;
  const FactorWalk walk = FirstFrame(use);
  LineariseFirst(times, chain, walk, correction,
                 [&](const auto& at, const auto&, double) {
                   row_count += std::size(at.residual);
                 });
  Rows rows{Eigen::MatrixXd::Zero(row_count, 2 * kStateSize),
            Eigen::VectorXd::Zero(row_count)};
  Eigen::Index row = 0;
  LineariseFirst(
      times, chain, walk, correction,
      [&](const auto& at, const auto& keys, double root) {
        WriteRows(
            at, keys, root,
            [](const StateKey& key) { return kStateSize * key.frame; }, row,
            &rows);
        row += std::size(at.residual);
      });
  return Marginalise(rows.jacobian, rows.residual, kStateSize);
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

}  // namespace

StatePrior MarginaliseFirstState(const std::vector<TimeNs>& times,
                                 const JointChain& chain, double correction) {
  CHECK_GE(chain.states.size(), 2u);
  const SquareRootPrior kept =
      MarginaliseWith(times, chain, KeptFor::kEstimate, 1.0);
  StatePrior prior;
  prior.A = kept.A;
  prior.b = kept.b;
  prior.x0 = chain.states[1];
  prior.A_stated =
      correction == 1.0
          ? prior.A
          : Matrix6d(
                MarginaliseWith(times, chain, KeptFor::kCovariance, correction)
                    .A);
  return prior;
}

namespace {

Eigen::Index SizeOf(const PersonProblem& problem) {
  return kStateSize * static_cast<Eigen::Index>(problem.joints.size());
}

Eigen::Index ColumnOf(const StateKey& key) { return kStateSize * key.joint; }

// What a joint's first state alone is known by, as six rows.
SquareRootPrior CompressFirst(const PersonProblem& problem,
                              const JointChain& chain) {
  FactorWalk walk = FirstFrame(KeptFor::kEstimate);
  walk.priors = problem.prior.empty();
  Eigen::Index row_count = kStateSize;  // of zeros, so that there are enough
  const auto count = [&](const auto& at, const auto& keys, double) {
    if (keys.size() == 1) row_count += std::size(at.residual);
  };
  LineariseFirst(problem.times, chain, walk, 1.0, count);
  Rows rows{Eigen::MatrixXd::Zero(row_count, kStateSize),
            Eigen::VectorXd::Zero(row_count)};
  Eigen::Index row = kStateSize;
  const auto write = [&](const auto& at, const auto& keys, double root) {
    if constexpr (std::tuple_size_v<std::decay_t<decltype(keys)>> == 1) {
      WriteRows(at, keys, root, ColumnOf, row, &rows);
      row += std::size(at.residual);
    }
  };
  LineariseFirst(problem.times, chain, walk, 1.0, write);
  return Marginalise(rows.jacobian, rows.residual, 0);
}

// Calls `take(linearised factor, keys, root)` for the factors that couple
// joints in the first frame.
template <typename Take>
void LineariseCouplings(const PersonProblem& problem, const Take& take) {
  const auto state_of = [&](const StateKey& key) {
    return problem.joints[key.joint].states[key.frame].data();
  };
  ForEachCoupling(
      problem, FirstFrame(KeptFor::kEstimate),
      [&](const auto& factor, const auto& keys, const Robustness& robustness) {
        Linearised<std::decay_t<decltype(factor)>> at;
        if (!LineariseFactor(factor, keys, state_of, &at)) return true;
        take(at, keys,
             std::sqrt(robustness.information *
                       robustness.Evaluate(at.squared_norm()).first));
        return true;
      });
}

// Calls `take(placed factor, rows)` for the user's factors whose earliest state
// is in the first frame.
template <typename Take>
void LineariseUser(const PersonProblem& problem, const Take& take) {
  const auto state_of = [&](const StateKey& key) {
    return problem.joints[key.joint].states[key.frame].data();
  };
  GeneralRows rows;
  for (const PlacedFactor& placed : problem.user) {
    if (placed.first_frame() > 0) continue;
    if (LineariseGeneral(placed, state_of, &rows)) take(placed, rows);
  }
}

// Writes the rows of a user's factor from `row` on.
template <typename ColumnOf>
void WriteUserRows(const PlacedFactor& placed, const GeneralRows& from,
                   const ColumnOf& column_of, Eigen::Index row, Rows* rows) {
  rows->residual.segment(row, from.residual.size()) = from.residual;
  for (size_t i = 0; i < placed.keys.size(); ++i) {
    rows->jacobian.block(row, column_of(placed.keys[i]), from.residual.size(),
                         kStateSize) += from.by_states[i];
  }
}

// All that is known of the first states alone, as a square of rows.
SquareRootPrior CompressFirstFrame(const PersonProblem& problem) {
  const Eigen::Index size = SizeOf(problem);
  const Eigen::Index prior_rows = problem.prior.A.rows();
  Eigen::Index row_count = prior_rows + size;
  LineariseCouplings(problem, [&](const auto& at, const auto&, double) {
    row_count += std::size(at.residual);
  });
  LineariseUser(problem, [&](const PlacedFactor& placed, const auto& from) {
    if (placed.last_frame() == 0) row_count += from.residual.size();
  });
  Rows rows{Eigen::MatrixXd::Zero(row_count, size),
            Eigen::VectorXd::Zero(row_count)};
  if (prior_rows > 0) {
    rows.jacobian.topRows(prior_rows) = problem.prior.A;
    rows.residual.head(prior_rows) = problem.prior.Residual(StatesOf(problem));
  }
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    const SquareRootPrior own = CompressFirst(problem, problem.joints[j]);
    const Eigen::Index at = kStateSize * static_cast<Eigen::Index>(j);
    rows.jacobian.block<6, 6>(prior_rows + at, at) = own.A;
    rows.residual.segment<6>(prior_rows + at) = own.b;
  }
  Eigen::Index row = prior_rows + size;
  LineariseCouplings(problem,
                     [&](const auto& at, const auto& keys, double root) {
                       WriteRows(at, keys, root, ColumnOf, row, &rows);
                       row += std::size(at.residual);
                     });
  LineariseUser(problem, [&](const PlacedFactor& placed, const auto& from) {
    if (placed.last_frame() > 0) return;
    WriteUserRows(placed, from, ColumnOf, row, &rows);
    row += from.residual.size();
  });
  return Marginalise(rows.jacobian, rows.residual, 0);
}

// Calls `take(joint, linearised factor, keys, root)` for the factors on a
// joint's first and second state.
template <typename Take>
void LineariseTransitions(const PersonProblem& problem, const Take& take) {
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    LineariseFirst(
        problem.times, problem.joints[j], FirstFrame(KeptFor::kEstimate), 1.0,
        [&](const auto& at, const auto& keys, double root) {
          if constexpr (std::tuple_size_v<std::decay_t<decltype(keys)>> == 2) {
            take(static_cast<Eigen::Index>(j), at, keys, root);
          }
        });
  }
}

// Information of the first two frames' states: of the first, between both, of
// the second.
struct TwoFrames {
  Eigen::MatrixXd first;
  Eigen::MatrixXd coupling;
  Eigen::MatrixXd second;
};

// Adds a' b, times the square of `root`, at a place of `information`.
template <typename JacobianA, typename JacobianB>
void AddBlock(const JacobianA& a, const JacobianB& b, double root,
              Eigen::Index row, Eigen::Index column,
              Eigen::MatrixXd* information) {
  Matrix6d block = Matrix6d::Zero();
  AddProduct(a, b, root * root, block.data());
  information->block<6, 6>(row, column) += block;
}

void AddCouplings(const PersonProblem& problem, TwoFrames* information) {
  LineariseCouplings(
      problem, [&](const auto& at, const auto& keys, double root) {
        for (int i = 0; i < 2; ++i) {
          for (int l = 0; l < 2; ++l) {
            AddBlock(at.by_states[i], at.by_states[l], root, ColumnOf(keys[i]),
                     ColumnOf(keys[l]), &information->first);
          }
        }
      });
}

void AddJoints(const PersonProblem& problem, double correction,
               TwoFrames* information) {
  FactorWalk walk = FirstFrame(KeptFor::kCovariance);
  walk.priors = problem.prior.empty();
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    const Eigen::Index own = kStateSize * static_cast<Eigen::Index>(j);
    LineariseFirst(
        problem.times, problem.joints[j], walk, correction,
        [&](const auto& at, const auto& keys, double root) {
          AddBlock(at.by_states[0], at.by_states[0], root, own, own,
                   &information->first);
          if constexpr (std::tuple_size_v<std::decay_t<decltype(keys)>> == 2) {
            AddBlock(at.by_states[0], at.by_states[1], root, own, own,
                     &information->coupling);
            AddBlock(at.by_states[1], at.by_states[1], root, own, own,
                     &information->second);
          }
        });
  }
}

void AddUser(const PersonProblem& problem, TwoFrames* information) {
  LineariseUser(problem, [&](const PlacedFactor& placed, const auto& from) {
    for (size_t a = 0; a < placed.keys.size(); ++a) {
      for (size_t b = 0; b < placed.keys.size(); ++b) {
        const StateKey& of_a = placed.keys[a];
        const StateKey& of_b = placed.keys[b];
        if (of_a.frame > of_b.frame) continue;
        Eigen::MatrixXd& block = of_b.frame == 0   ? information->first
                                 : of_a.frame == 0 ? information->coupling
                                                   : information->second;
        block.block<6, 6>(ColumnOf(of_a), ColumnOf(of_b)) +=
            from.by_states[a].transpose() * from.by_states[b];
      }
    }
  });
}

// Square root of the information that the dropped frame leaves for the
// covariances that are stated, by Schur complement: less exact than the QR of
// the estimate's own prior, in a fraction of its time. nullopt when it is not
// definite.
std::optional<Eigen::MatrixXd> StatedInformation(const PersonProblem& problem,
                                                 double correction) {
  const Eigen::Index size = SizeOf(problem);
  TwoFrames information{Eigen::MatrixXd::Zero(size, size),
                        Eigen::MatrixXd::Zero(size, size),
                        Eigen::MatrixXd::Zero(size, size)};
  auto& [first, coupling, second] = information;
  if (!problem.prior.empty()) {
    first.noalias() =
        problem.prior.A_stated.transpose() * problem.prior.A_stated;
  }
  AddCouplings(problem, &information);
  AddJoints(problem, correction, &information);
  AddUser(problem, &information);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> eliminated(first);
  if (eliminated.info() != Eigen::Success) return std::nullopt;
  eliminated.matrixL().solveInPlace(coupling);
  second.selfadjointView<Eigen::Lower>().rankUpdate(coupling.transpose(), -1.0);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> kept(second);
  if (kept.info() != Eigen::Success) return std::nullopt;
  return Eigen::MatrixXd(kept.matrixU());
}

}  // namespace

PersonPrior MarginaliseFirstFrame(const PersonProblem& problem,
                                  double correction) {
  const Eigen::Index size = SizeOf(problem);
  // First the factors on the first states alone, then those on both: smaller
  // factorisations than one of everything.
  const SquareRootPrior reduced = CompressFirstFrame(problem);
  Eigen::Index row_count = size;
  LineariseTransitions(problem,
                       [&](Eigen::Index, const auto& at, const auto&, double) {
                         row_count += std::size(at.residual);
                       });
  LineariseUser(problem, [&](const PlacedFactor& placed, const auto& from) {
    if (placed.last_frame() > 0) row_count += from.residual.size();
  });
  Rows both{Eigen::MatrixXd::Zero(row_count, 2 * size),
            Eigen::VectorXd::Zero(row_count)};
  both.jacobian.topLeftCorner(size, size) = reduced.A;
  both.residual.head(size) = reduced.b;
  Eigen::Index row = size;
  LineariseTransitions(problem, [&](Eigen::Index j, const auto& at,
                                    const auto& keys, double root) {
    WriteRows(
        at, keys, root,
        [&](const StateKey& key) {
          return (key.frame == 0 ? 0 : size) + kStateSize * j;
        },
        row, &both);
    row += std::size(at.residual);
  });
  LineariseUser(problem, [&](const PlacedFactor& placed, const auto& from) {
    if (placed.last_frame() == 0) return;
    const auto column_of = [&](const StateKey& key) {
      return (key.frame == 0 ? 0 : size) + ColumnOf(key);
    };
    WriteUserRows(placed, from, column_of, row, &both);
    row += from.residual.size();
  });
  const SquareRootPrior kept =
      Marginalise(both.jacobian, both.residual, static_cast<int>(size));
  PersonPrior prior;
  prior.x0.resize(size);
  for (size_t j = 0; j < problem.joints.size(); ++j) {
    prior.x0.segment<6>(kStateSize * j) = problem.joints[j].states[1];
  }
  prior.A = kept.A;
  prior.b = kept.b;
  prior.A_stated = prior.A;
  if (correction != 1.0) {
    const std::optional<Eigen::MatrixXd> stated =
        StatedInformation(problem, correction);
    if (stated.has_value()) prior.A_stated = *stated;
  }
  return prior;
}

void DropFirstFrame(double correction, PersonProblem* problem) {
  if (problem->coupled()) {
    problem->prior = MarginaliseFirstFrame(*problem, correction);
  }
  for (JointChain& chain : problem->joints) {
    chain.prior = MarginaliseFirstState(problem->times, chain, correction);
    EraseFirst(&chain);
  }
  problem->times.erase(problem->times.begin());
  EraseFirst(&problem->user);
}

}  // namespace kinegraph
