// Learns the detector's bias from what the solutions of a recording leave, over
// all people, and takes it from their pixels.
#ifndef KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_
#define KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

inline constexpr int kBiasSize = 2 * kViewFeatureCount;

// Normal equations of one joint's coefficients: with residuals
// r = u - project(X) at the solution's positions X and directions D, whitened,
//   A = sum D' D,  g = sum D' r.
// X counts as known: neighbouring frames and bones have placed it with far less
// of each view's error than its own frame can. A constant offset of the joint
// in the body lies (nearly) in the span of the Jacobians J = d project / d X:
// no image can tell it. So coefficients must not move the joint on the whole:
// with offset = sum D' J B (B: the body's axes) they keep offset' c = 0, which
// is orthogonal to the coefficients of a constant offset in the recording's own
// metric D' D. What is written is the position of the detector's own joint.
struct BiasSums {
  Eigen::Matrix<double, kBiasSize, kBiasSize> A = decltype(A)::Zero();
  Eigen::Matrix<double, kBiasSize, 1> g = decltype(g)::Zero();
  Eigen::Matrix<double, kBiasSize, 3> offset = decltype(offset)::Zero();
  Eigen::Matrix<double, kViewFeatureCount, 1> feature_squares =  // weighted
      decltype(feature_squares)::Zero();
  double weight = 0.0;  // sum of the squared whitening [1/m^2]
  double square = 0.0;  // r' r
  int64_t observations = 0;
  int64_t looks = 0;  // joints in frames, of which the observations are views
  // What the observations count as beside a prior: errors that last are seen
  // again and again.
  double independent = 0.0;
  // By view, as many as were seen: what a shift of that camera's pictures by a
  // pixel does, S (whitened).
  struct OfView {
    Eigen::Matrix<double, kBiasSize, 2> cross =
        Eigen::Matrix<double, kBiasSize, 2>::Zero();  // D' S
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();   // S' r
    double weight = 0.0;                              // S' S [1/px^2]
  };
  std::vector<OfView> views;

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

// Views of a joint in a frame, at its solution's position; an observation
// counts as `independent` ones (at most 1). One view alone contradicts nobody.
void AddViews(const std::vector<BiasView>& views, double independent,
              BiasSums* sums);

// The share of an independent observation that each of a row counts as, which
// come every `period_s`: the variance of a mean of AR(1) errors.
double IndependentShare(const ErrorCorrelation& correlation, double period_s);

// The ridge solution that moves no joint. `ridge` counts independent
// observations of mean weight.
Eigen::Matrix<double, kBiasSize, 1> SolveBias(const BiasSums& sums,
                                              double ridge);

// Sums of a recording in stretches of time, of which every other one belongs to
// the same half. Of any length: when there are too many, neighbours are joined.
class BiasSeries {
 public:
  BiasSeries(const BiasJoints& joints, int view_count);

  void Add(TimeNs time, const std::vector<BiasSums>& sums);
  void AddAzimuth(int view_idx, double azimuth);
  // What another person's say, of as many joints and views.
  void Add(const BiasSeries& other);

  // A shift of a camera's pictures moves all joints alike. Where each camera
  // has seen people from some sides only it would pass for their bias; so what
  // the joints of a camera leave on average (weighted) is taken away.
  // Afterwards nothing may be added.
  void RemoveShifts();

  // A joint is used where cameras have seen people from enough sides and,
  // unless `always`, where the gain of one half's coefficients on the other is
  // one per cent or more and surely positive: the lower 97.5 % limit over
  // stretches of time.
  ViewBias Fit(bool always) const;
  // The same where the positions were solved from the very views, and have been
  // pulled by the bias: a bias lasts longer than neighbouring frames could
  // correct, so a position takes 3 of the 2 n numbers that its n views add to
  // it. The residuals have kept the share 1 - 3 / (2 n), and coefficients are
  // as many times larger as that says.
  ViewBias FitSolved(bool always) const;

 private:
  static constexpr size_t kMostBlocks = 32;
  static constexpr int kSectors = 24;
  void JoinNeighbours();
  double AzimuthDegrees() const;
  ViewBias::OfJoint FitJoint(size_t name_idx, bool always) const;

  std::vector<std::string> names_;
  std::vector<JointClass> classes_;  // of each name
  std::map<int64_t, std::vector<BiasSums>> blocks_;
  TimeNs block_ns_ = FromSeconds(1.0);
  std::vector<std::array<int64_t, kSectors>> azimuths_;  // by view
  bool shifts_away_ = false;
};

// Tells a series what the solution of a recording leaves, with the weights that
// the solver gave. Measurements name `cameras`; errors last as `correlation`
// says.
void TellBias(const BiasJoints& joints, const CameraRig& cameras,
              double frame_rate_hz, const ErrorCorrelation& correlation,
              const PersonProblem& solved, BiasSeries* series);

// Writes a bias to the pixels of a recording whose triangulated joints stand at
// their states; `bias` may have other joints than `joints`.
void WriteBias(const BiasJoints& joints, const ViewBias& bias,
               const std::vector<FrameRecord>& records,
               PersonProblem* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_
