// Learns the detector's bias from the residuals of a recording's solutions,
// over all people, and stores it in their measurements (bias_px).
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
#include "core/base/weighted_quantile.h"
#include "core/data/view_bias.h"
#include "core/geometry/camera.h"
#include "solvers/graph/assembler.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/bias_model.h"
#include "solvers/noise/learnt_noise.h"

namespace kinegraph {

inline constexpr int kBiasSize = 2 * kViewFeatureCount;
using BiasVector = Eigen::Matrix<double, kBiasSize, 1>;

// Normal equations of one joint's coefficients c (bias_model.h). With whitened
// residuals r = u - project(X) at the solution's positions X, and their model D
// c (D: the whitened derivative of a pixel by the coefficients),
//   A = sum D' D,  g = sum D' r.
// X is treated as known: neighbouring frames and bones contribute to it, so a
// view's error affects it far less than it would a point triangulated from its
// own frame alone. A constant offset of the joint in the body lies (nearly) in
// the span of the Jacobians J = d project / d X and is unobservable in images.
// Coefficients must therefore not displace the joint on average: with offset =
// sum D' J B (B: the body's axes) they satisfy offset' c = 0, i.e. they are
// orthogonal to the coefficients of a constant offset in the recording's metric
// D' D. A constant offset between the detector's joint and the anatomical one
// therefore remains in the estimated position.
struct BiasSums {
  Eigen::Matrix<double, kBiasSize, kBiasSize> A = decltype(A)::Zero();
  BiasVector g = BiasVector::Zero();
  Eigen::Matrix<double, kBiasSize, 3> offset = decltype(offset)::Zero();
  Eigen::Matrix<double, kViewFeatureCount, 1> feature_squares =  // weighted
      decltype(feature_squares)::Zero();
  double weight = 0.0;       // sum of (whitened pixels per metre)^2 [1/m^2]
  double square = 0.0;       // r' r
  int64_t observations = 0;  // of a joint in one view of one frame
  // Number of such joints, left and right, summed over people and frames; each
  // has two or more observations.
  int64_t looks = 0;
  // Equivalent number of independent observations, to be compared with the
  // prior's: at most `observations`, because successive errors are correlated.
  double independent = 0.0;
  // By view, up to the last view seen: the terms of a shift of this camera's
  // images, with S the whitened effect of a shift of one pixel.
  struct OfView {
    Eigen::Matrix<double, kBiasSize, 2> cross =
        decltype(cross)::Zero();                     // D' S
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();  // S' r
    double weight = 0.0;                             // S' S [1/px^2]
  };
  std::vector<OfView> views;

  BiasSums& operator+=(const BiasSums& other);
};

// One view of a joint in a frame.
struct BiasView {
  int view_idx = 0;
  ViewDirection direction;
  // Observed minus projected.
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();
  Matrix23d jacobian = Matrix23d::Zero();  // d pixel / d point
  // Root of the robust weight times the information, over sigma [1/px].
  double per_sigma = 1.0;
};

// Adds the views of a joint in a frame, at its solution's position; each
// observation counts as `independent` (at most 1) independent observations. A
// single view is ignored, because it has no residual.
void AddViews(const std::vector<BiasView>& views, double independent,
              BiasSums* sums);

// Number of independent observations that each observation counts as, in a
// series with one observation every `period_s`, from the variance of a mean of
// AR(1) errors.
double IndependentShare(const ErrorCorrelation& correlation, double period_s);

// The ridge solution that does not displace the joint. `ridge`: a number of
// independent observations of mean weight.
BiasVector SolveBias(const BiasSums& sums, double ridge);

// Sums over segments (blocks) of a recording. Even and odd segments form the
// two halves of a cross-validation. For recordings of any length: if there are
// more than kMostBlocks segments, neighbours are merged.
class BiasSeries {
 public:
  BiasSeries(const BiasJoints& joints, int view_count);

  // Adds the sums of the frame at `time`, one per name of the joints
  // (BiasJoints::names).
  void Add(TimeNs time, const std::vector<BiasSums>& sums);
  // `azimuth` [rad] of the camera around the body, -pi .. pi.
  void AddAzimuth(int view_idx, double azimuth);
  // Adds another person's sums, which must have as many joints and views.
  void Add(const BiasSeries& other);

  // Removes, for each camera, the weighted mean of the residuals over all
  // joints. A shift of a camera's images displaces all joints alike, and could
  // be confused with their bias if each camera has seen people from some sides
  // only. Nothing may be added afterwards.
  void RemoveShifts();

  // A joint is used if cameras have seen people from enough sides and, unless
  // `always`, if it was seen in at least six segments and the gain (the share
  // of the squared residuals that the coefficients of one half explain in the
  // other) exceeds one per cent and is significantly positive (97.5 %
  // confidence, over segments).
  ViewBias Fit(bool always) const;
  // Fit() for positions that were solved from the same views and have absorbed
  // part of the bias: a bias is too persistent for neighbouring frames to
  // correct, so a position absorbs 3 of the 2 n numbers that its n views
  // contribute. The residuals contain the fraction 1 - 3 / (2 n) of the bias,
  // and coefficients are scaled up accordingly.
  ViewBias FitSolved(bool always) const;

 private:
  static constexpr size_t kMostBlocks = 32;
  static constexpr int kSectors = 24;
  void JoinNeighbours();
  // For each camera that saw a joint together with another view, the number of
  // sectors of azimuth that contain more than a tenth of a sector's mean count;
  // each of weight 1.
  std::vector<WeightedValue> SectorsSeen() const;
  ViewBias::OfJoint FitJoint(size_t name_idx, bool always) const;

  std::vector<std::string> names_;
  std::vector<JointClass> classes_;  // one per name
  std::map<int64_t, std::vector<BiasSums>> blocks_;
  TimeNs block_ns_ = FromSeconds(1.0);
  std::vector<std::array<int64_t, kSectors>> azimuths_;  // by view
  bool shifts_away_ = false;
};

// Adds the residuals of a recording's solution to a series, with the solver's
// weights, and the azimuths of the views that contribute them. Measurements
// refer to `cameras`; `correlation`: of the detector's errors.
void AddBiasResiduals(const BiasJoints& joints, const CameraRig& cameras,
                      double frame_rate_hz, const ErrorCorrelation& correlation,
                      const PersonProblem& solved, BiasSeries* series);

// Writes `bias` to the measurements (bias_px) of a recording that has not been
// solved yet: the states of triangulated joints are their triangulated
// positions. `bias` may have other joints than `joints`.
void WriteBias(const BiasJoints& joints, const ViewBias& bias,
               const std::vector<FrameRecord>& records,
               PersonProblem* recording);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BIAS_LEARNER_H_
