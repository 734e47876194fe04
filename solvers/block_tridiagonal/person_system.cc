#include "solvers/block_tridiagonal/person_system.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "core/base/dense_lanes.h"
#include "solvers/block_tridiagonal/chain_solver.h"
#include "solvers/graph/factor_list.h"

namespace kinegraph {
namespace {

// Information of a joint's chain: diagonal blocks and the blocks to their
// right.
struct LinearChain {
  std::vector<Matrix6d> diagonal;
  std::vector<Matrix6d> upper;
};

// Blocks of the information at the chain's states and stored weights. The
// information of observations is multiplied by `correction`
// (InformationCorrection of their loss). Includes the chain's own prior unless
// the person's prior replaces it.
LinearChain LineariseInformation(const PersonProblem& problem, size_t joint,
                                 double correction) {
  const JointChain& chain = problem.joints[joint];
  const size_t frames = problem.times.size();
  LinearChain linear = {std::vector<Matrix6d>(frames, Matrix6d::Zero()),
                        std::vector<Matrix6d>(frames - 1, Matrix6d::Zero())};
  FactorWalk walk;
  walk.priors = problem.prior.empty();
  walk.stated = true;
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, problem, &at)) return true;
    double weight = WeightAtEstimate(chain, robustness, at.squared_norm());
    if (robustness.measurement >= 0) {
      weight *= correction * robustness.information;
    }
    if (!(weight > 0.0)) return true;
    for (int i = 0; i < Factor::kKeys; ++i) {
      AddProduct(at.by_states[i], at.by_states[i], weight,
                 linear.diagonal[keys[i].frame].data());
    }
    if constexpr (Factor::kKeys == 2) {
      AddProduct(at.by_states[0], at.by_states[1], weight,
                 linear.upper[keys[0].frame].data());
    }
    return true;
  };
  ForEachFactor(problem, joint, walk, add);
  return linear;
}

// The off-diagonal information of a factor on the positions of two joints in
// one frame: by_a by_b'.
struct PointCoupling {
  int a = 0;
  int b = 0;
  Eigen::Vector3d by_a;
  Eigen::Vector3d by_b;
};

// Information of a person: a chain for each joint (with the diagonal parts of
// the coupling factors) and the couplings within a frame.
struct PersonSystem {
  std::vector<LinearChain> chains;
  std::vector<std::vector<PointCoupling>> couplings;  // by frame
  // Blocks of the person's prior between joints; its diagonal blocks are in the
  // chains. Empty without a prior.
  Eigen::MatrixXd prior_coupling;
};

void AddCouplings(const PersonProblem& problem, PersonSystem* system) {
  system->couplings.resize(problem.times.size());
  const auto add = [&](const auto& factor, const auto& keys,
                       const Robustness& robustness) {
    using Factor = std::decay_t<decltype(factor)>;
    static_assert(Factor::kResiduals == 1, "a coupling has rank one");
    Linearised<Factor> at;
    if (!LineariseFactor(factor, keys, problem, &at)) return false;
    const double weight =
        robustness.information * robustness.Evaluate(at.squared_norm()).first;
    const double root = std::sqrt(weight);
    Eigen::Vector3d by_point[2];
    for (int i = 0; i < 2; ++i) {
      AddProduct(at.by_states[i], at.by_states[i], weight,
                 system->chains[keys[i].joint].diagonal[keys[i].frame].data());
      by_point[i] =
          root * Eigen::Map<const Eigen::Vector3d>(at.by_states[i].by_point[0]);
    }
    system->couplings[keys[0].frame].push_back(
        {keys[0].joint, keys[1].joint, by_point[0], by_point[1]});
    return true;
  };
  ForEachCoupling(problem, FactorWalk(), add);
}

// Adds the prior's diagonal blocks to the chains and its blocks between joints
// to prior_coupling.
void AddPrior(const PersonPrior& prior, PersonSystem* system) {
  system->prior_coupling = prior.stated;
  for (size_t j = 0; j < system->chains.size(); ++j) {
    auto own = system->prior_coupling.block<kStateSize, kStateSize>(
        j * kStateSize, j * kStateSize);
    system->chains[j].diagonal[0] += own;
    own.setZero();
  }
}

// Covariances by message passing from both sides: a frame's pivot is its own
// information plus the messages of the later and earlier frames; a message is
// the Schur complement that the elimination of a neighbour leaves. Blocks are
// whole frames. For a window's oldest frame the backward sweep suffices.
class FrameInversion {
 public:
  FrameInversion(const PersonProblem& problem, const PersonSystem& system)
      : problem_(problem),
        system_(system),
        frame_count_(problem.times.size()),
        size_(kStateSize * problem.joints.size()),
        rows_(PaddedLanes(static_cast<int>(size_))) {
    AddUserFactors();
    for (LaneBuffer* square :
         {&pivot_, &coupling_, &earlier_, &later_[0], &later_[1]}) {
      square->Assign(rows_ * rows_, 0.0);
    }
  }

  bool Run(size_t frame_end, size_t segment_bytes,
           std::vector<std::vector<Matrix6d>>* covariances) {
    covariances_ = covariances;
    const size_t segment = std::min(SegmentLength(segment_bytes), frame_end);
    messages_.resize(segment);
    if (!SweepBack(frame_end)) return false;
    for (size_t begin = 0; begin < frame_end; begin += segment) {
      const size_t end = std::min(begin + segment, frame_end);
      if (begin > 0 && !Recall(begin, end)) return false;
      for (size_t k = begin; k < end; ++k) {
        Restore(messages_[k - begin], &later_[0]);
        if (!Take(k, later_[0])) return false;
        if (k + 1 < frame_end && !PassOn(k)) return false;
      }
    }
    return true;
  }

 private:
  using Square = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  // Lower triangle of a square, by columns.
  using Triangle = std::vector<double>;

  // Number of frames whose messages are kept at a time, at least eight. For a
  // later segment only the message to its last frame is kept, from which the
  // others are recomputed.
  size_t SegmentLength(size_t bytes) const {
    return std::max<size_t>(8,
                            bytes / (size_ * (size_ + 1) / 2 * sizeof(double)));
  }

  void Store(const LaneBuffer& square, Triangle* triangle) const {
    triangle->resize(size_ * (size_ + 1) / 2);
    auto to = triangle->begin();
    for (size_t column = 0; column < size_; ++column) {
      const double* const from = square.data() + column * rows_;
      to = std::copy(from + column, from + size_, to);
    }
  }

  void Restore(const Triangle& triangle, LaneBuffer* square) const {
    auto from = triangle.begin();
    for (size_t column = 0; column < size_; ++column) {
      const auto end = from + static_cast<std::ptrdiff_t>(size_ - column);
      std::copy(from, end, square->data() + column * rows_ + column);
      from = end;
    }
  }

  // Information of the user's factors: a dense block per frame and, where they
  // link two frames, a dense block below the diagonal.
  void AddUserFactors() {
    GeneralRows rows;
    for (const PlacedFactor& placed : problem_.user) {
      if (!LineariseGeneral(placed, problem_, &rows)) continue;
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

  // A square without its padding.
  Square Inside(LaneBuffer* square) const {
    return Square(square->data(), size_, size_, Eigen::OuterStride<>(rows_));
  }

  // Adds frame k's own information.
  void AddDiagonal(size_t k, LaneBuffer* square) const {
    Square sum = Inside(square);
    if (k == 0 && system_.prior_coupling.size() > 0) {
      sum += system_.prior_coupling;
    }
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      sum.block<6, 6>(j * 6, j * 6) += system_.chains[j].diagonal[k];
    }
    for (const PointCoupling& coupling : system_.couplings[k]) {
      // Below the diagonal.
      if (coupling.a > coupling.b) {
        sum.block<3, 3>(6 * coupling.a, 6 * coupling.b) +=
            coupling.by_a * coupling.by_b.transpose();
      } else {
        sum.block<3, 3>(6 * coupling.b, 6 * coupling.a) +=
            coupling.by_b * coupling.by_a.transpose();
      }
    }
    const auto user = user_diagonal_.find(k);
    if (user != user_diagonal_.end()) sum += user->second;
    for (size_t row = size_; row < rows_; ++row) {
      (*square)[row * rows_ + row] = 1.0;
    }
  }

  // Loads the coupling of frames k and k + 1, with the states of `rows` as
  // rows. Returns the size of its diagonal blocks, 0 if it is not
  // block-diagonal.
  enum class RowsOf { kEarlier, kLater };
  int LoadCoupling(size_t k, RowsOf rows) {
    const bool later_rows = rows == RowsOf::kLater;
    std::fill_n(coupling_.data(), rows_ * rows_, 0.0);
    Square coupling = Inside(&coupling_);
    const auto user = user_below_.find(k);
    const bool dense = user != user_below_.end();
    if (dense && later_rows) coupling = user->second;
    if (dense && !later_rows) coupling = user->second.transpose();
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      auto block = coupling.block<6, 6>(j * 6, j * 6);
      const Matrix6d& upper = system_.chains[j].upper[k];
      if (later_rows) {
        block += upper.transpose();
      } else {
        block += upper;
      }
    }
    return dense ? 0 : kStateSize;
  }

  bool Eliminate(int block, LaneBuffer* next) {
    return EliminateDense({static_cast<int>(rows_), block, pivot_.data(),
                           coupling_.data(),
                           next == nullptr ? nullptr : next->data()});
  }

  // Computes the message to frame k - 1 from the message of later frames to
  // frame k.
  bool PassBack(size_t k, const LaneBuffer& message, LaneBuffer* next) {
    std::copy_n(message.data(), rows_ * rows_, pivot_.data());
    AddDiagonal(k, &pivot_);
    std::fill_n(next->data(), rows_ * rows_, 0.0);
    const int block = LoadCoupling(k - 1, RowsOf::kEarlier);
    return Eliminate(block, next);
  }

  // Computes the messages from the last frame to the first. Keeps the messages
  // to all frames of the first segment, and to the last frame of every other
  // segment.
  bool SweepBack(size_t frame_end) {
    const size_t segment = messages_.size();
    kept_.resize((frame_end + segment - 1) / segment);
    std::fill_n(later_[(frame_count_ - 1) % 2].data(), rows_ * rows_, 0.0);
    for (size_t k = frame_count_; k-- > 0;) {
      const LaneBuffer& message = later_[k % 2];
      const bool last = k % segment == segment - 1 || k + 1 == frame_end;
      if (k < segment) {
        Store(message, &messages_[k]);
      } else if (last && k < frame_end) {
        Store(message, &kept_[k / segment]);
      }
      if (k > 0 && !PassBack(k, message, &later_[(k - 1) % 2])) return false;
    }
    return true;
  }

  // Recomputes the messages to the frames of a segment.
  bool Recall(size_t begin, size_t end) {
    messages_[end - 1 - begin] = std::move(kept_[begin / messages_.size()]);
    Restore(messages_[end - 1 - begin], &later_[(end - 1) % 2]);
    for (size_t k = end; k-- > begin + 1;) {
      LaneBuffer& next = later_[(k - 1) % 2];
      if (!PassBack(k, later_[k % 2], &next)) return false;
      Store(next, &messages_[k - 1 - begin]);
    }
    return true;
  }

  // Computes the message to frame k + 1 from the message of earlier frames to
  // frame k.
  bool PassOn(size_t k) {
    std::swap(pivot_, earlier_);
    AddDiagonal(k, &pivot_);
    std::fill_n(earlier_.data(), rows_ * rows_, 0.0);
    const int block = LoadCoupling(k, RowsOf::kLater);
    return Eliminate(block, &earlier_);
  }

  // Covariances of frame k, given the message of later frames.
  bool Take(size_t k, const LaneBuffer& later) {
    for (size_t i = 0; i < rows_ * rows_; ++i) {
      pivot_[i] = earlier_[i] + later[i];
    }
    AddDiagonal(k, &pivot_);
    std::fill_n(coupling_.data(), rows_ * rows_, 0.0);
    for (size_t row = 0; row < size_; ++row) {
      coupling_[row * rows_ + row] = 1.0;
    }
    if (!Eliminate(kStateSize, nullptr)) return false;
    for (size_t j = 0; j < problem_.joints.size(); ++j) {
      (*covariances_)[j][k] = SquareOfRows(kStateSize * j);
    }
    return true;
  }

  // Y Y' of rows row .. row + 5 of the matrix Y in coupling_; column `row` is
  // the first in which they are not zero.
  Matrix6d SquareOfRows(size_t row) const {
    Matrix6d square = Matrix6d::Zero();
    for (size_t column = row; column < rows_; ++column) {
      const double* const y = coupling_.data() + column * rows_ + row;
      for (int i = 0; i < 6; ++i) {
        for (int j = 0; j <= i; ++j) square(i, j) += y[i] * y[j];
      }
    }
    return square.selfadjointView<Eigen::Lower>();
  }

  const PersonProblem& problem_;
  const PersonSystem& system_;
  const size_t frame_count_;
  const size_t size_;  // numbers per frame
  const size_t rows_;  // rows of a square, with padding
  std::map<size_t, Eigen::MatrixXd> user_diagonal_;  // by frame
  std::map<size_t, Eigen::MatrixXd> user_below_;     // by the earlier frame
  // Squares of rows_ x rows_. Except in coupling_, only the lower triangle is
  // used.
  LaneBuffer pivot_, coupling_;
  LaneBuffer earlier_;              // message of earlier frames
  LaneBuffer later_[2];             // messages of later frames, alternating
  std::vector<Triangle> messages_;  // of later frames, in the current segment
  std::vector<Triangle> kept_;      // to the last frame of later segments
  std::vector<std::vector<Matrix6d>>* covariances_ = nullptr;
};

}  // namespace

bool PersonCovariances(const PersonProblem& problem, double correction,
                       size_t frame_end,
                       std::vector<std::vector<Matrix6d>>* covariances,
                       size_t segment_bytes) {
  const size_t joint_count = problem.joints.size();
  covariances->resize(joint_count);
  PersonSystem system;
  for (size_t j = 0; j < joint_count; ++j) {
    (*covariances)[j].resize(frame_end);
    system.chains.push_back(LineariseInformation(problem, j, correction));
  }
  AddCouplings(problem, &system);
  if (!problem.prior.empty()) AddPrior(problem.prior, &system);
  return FrameInversion(problem, system)
      .Run(frame_end, segment_bytes, covariances);
}

}  // namespace kinegraph
