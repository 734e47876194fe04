// Learns the detector's bias from a take, over all people: from what single
// frames' views disagree about once the best point is taken away, and, where
// the take is solved as a whole, from what its solutions leave.
#ifndef KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_
#define KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/data/view_bias.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

inline constexpr int kBiasSize = 2 * kViewFeatureCount;

// Normal equations of one joint's coefficients, the positions of the joint
// eliminated (Golub and Pereyra 1973): with residuals r = u - project(X),
// directions D and Jacobians J, whitened,
//   A = sum D' M D,  g = sum D' M r,  M = I - J (J' J)^-1 J'.
// A constant offset of the joint in the body lies (nearly) in J's span: no
// image can tell it. So coefficients must not move the joint on the whole: with
// offset = sum D' J B (B: the body's axes) they keep offset' c = 0, which is
// orthogonal to the coefficients of a constant offset in the take's own metric
// D' D. What is written is the position of the detector's own joint.
//
// Where a solution of the take says where the joint is, nothing is eliminated
// (M = I): neighbouring frames and bones have placed it with far less of each
// view's error than its own frame can.
struct BiasSums {
  Eigen::Matrix<double, kBiasSize, kBiasSize> A;
  Eigen::Matrix<double, kBiasSize, 1> g;
  Eigen::Matrix<double, kBiasSize, 3> offset;
  Eigen::Matrix<double, kViewFeatureCount, 1> feature_squares;  // weighted
  double weight = 0.0;  // sum of the squared whitening [1/m^2]
  double square = 0.0;  // r' M r
  int64_t observations = 0;
  // What the observations count as beside a prior: errors that last are seen
  // again and again.
  double independent = 0.0;
  // By view, as many as were seen: what a shift of that camera's pictures by a
  // pixel does, S (whitened). Of solved positions alone.
  struct OfView {
    Eigen::Matrix<double, kBiasSize, 2> cross =
        Eigen::Matrix<double, kBiasSize, 2>::Zero();  // D' S
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();   // S' r
    double weight = 0.0;                              // S' S [1/px^2]
  };
  std::vector<OfView> views;

  BiasSums() { Clear(); }
  void Clear();
  BiasSums& operator+=(const BiasSums& other);
};

// One view of a joint in a frame.
struct BiasView {
  int view_idx = 0;
  ViewDirection direction;
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  // seen less projected
  Matrix23d jacobian = Matrix23d::Zero();                 // d pixel / d point
  double per_sigma = 1.0;  // root of the robust weight over sigma [1/px]
};

// False, and nothing is added, where the views leave a direction open.
bool AddViews(const std::vector<BiasView>& views, BiasSums* sums);

// The same where the joint's position is known otherwise; an observation counts
// as `independent` ones (at most 1).
void AddSolvedViews(const std::vector<BiasView>& views, double independent,
                    BiasSums* sums);

// The share of an independent observation that each of a row counts as, which
// come every `period_s`: the variance of a mean of AR(1) errors.
double IndependentShare(const ErrorCorrelation& correlation, double period_s);

// The ridge solution that moves no joint. `ridge` counts independent
// observations of mean weight.
Eigen::Matrix<double, kBiasSize, 1> SolveBias(const BiasSums& sums,
                                              double ridge);

// Sums of a take in stretches of time, of which every other one belongs to the
// same half. Of any length: when there are too many, neighbours are joined.
class BiasSeries {
 public:
  BiasSeries(std::vector<JointClass> classes, int view_count);

  int name_count() const { return static_cast<int>(classes_.size()); }
  // Of the same joints and views.
  BiasSeries Empty() const {
    return {classes_, static_cast<int>(azimuths_.size())};
  }
  void Add(TimeNs time, const std::vector<BiasSums>& sums);
  void AddAzimuth(int view_idx, double azimuth);
  // What another person's say, of as many joints and views.
  void Add(const BiasSeries& other);

  // A shift of a camera's pictures moves all joints alike. Where each camera
  // has seen people from some sides only it would pass for their bias; so what
  // the joints of a camera leave on average (weighted) is taken away. Of solved
  // positions; afterwards nothing may be added.
  void TakeShiftsAway();

  // `names` as the classes of the constructor. A joint is used where cameras
  // have seen people from enough sides and, unless `always`, where the
  // gain of one half's coefficients on the other is surely positive: the lower
  // 97.5 % limit over stretches of time.
  ViewBias Fit(const std::vector<std::string>& names, bool always) const;
  int64_t observations() const { return observations_; }

 private:
  static constexpr size_t kMostBlocks = 32;
  static constexpr int kSectors = 24;
  void JoinNeighbours();
  double AzimuthDegrees() const;
  double LeastAzimuthDegrees() const;
  ViewBias::OfJoint FitJoint(size_t name_idx, bool always) const;

  std::vector<JointClass> classes_;
  std::map<int64_t, std::vector<BiasSums>> blocks_;
  TimeNs block_ns_ = FromSeconds(1.0);
  std::vector<std::array<int64_t, kSectors>> azimuths_;  // by view
  int64_t observations_ = 0;
  bool shifts_away_ = false;
};

// What the people of a run share of it. Each registers; what it saw in a frame
// counts for everybody from the next frame on, whatever the order in which
// threads get there, so results do not depend on it.
//
// Where everybody is solved at the end, rounds follow: all are solved with the
// bias that the round before told (none in the first), and what their solutions
// leave tells it anew. Taking a bias away moves the joints it has pulled, and
// more of it shows.
class ViewBiasPool {
 public:
  static constexpr int kRounds = 3;

  // Of one person.
  struct Pending {
    TimeNs time = 0;
    std::vector<BiasSums> sums;
    std::vector<std::pair<int, double>> azimuths;  // view, azimuth
    bool full = false;
    std::unique_ptr<BiasSeries> solved;  // of this round
  };

  // `always` as BiasSeries::Fit; `given`, if not null, is the answer whatever
  // is seen.
  ViewBiasPool(bool always, std::shared_ptr<const ViewBias> given)
      : always_(always), given_(std::move(given)) {}

  bool learns() const { return given_ == nullptr; }
  // From one thread at a time, as people are born.
  std::shared_ptr<Pending> Register(const BiasJoints& joints, int view_count);
  // The bias as told by frames other than the one at `time`; to be asked for
  // before anything of that frame is put into a Pending.
  std::shared_ptr<const ViewBias> Before(TimeNs time);
  // Moves what one person saw in a frame, after Before of that frame; leaves it
  // cleared.
  void Hand(Pending* seen, Pending* pending);
  // As told by everything, by the last round where there are any; nobody may
  // add meanwhile.
  std::shared_ptr<const ViewBias> Now();

  // What `round` (0 .. kRounds - 1) begins with; null: nothing. Everybody has
  // handed in the solution of the round before.
  std::shared_ptr<const ViewBias> BeforeRound(int round);
  void HandSolved(std::unique_ptr<BiasSeries> solved, Pending* pending);
  std::unique_ptr<BiasSeries> EmptySeries() const;

 private:
  void Collect();
  void Refit();
  void FitRound();

  const bool always_;
  std::shared_ptr<const ViewBias> given_;  // as names_ after Register
  std::mutex mutex_;
  std::vector<std::string> names_;
  std::unique_ptr<BiasSeries> series_;
  std::vector<std::shared_ptr<Pending>> people_;  // in order of birth
  std::shared_ptr<const ViewBias> fitted_;
  int64_t fitted_at_ = 0;  // observations
  int rounds_told_ = 0;    // that fitted_ has heard of
  bool solved_ = false;    // somebody has handed in a solution
  bool any_time_ = false;
  TimeNs time_ = 0;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_
