// Estimates the lengths of a person's bones, their uncertainty, and how much
// each length varies: the joint centres of real people, and of detectors, are
// not points on rigid bones.
#ifndef KINEGRAPH_SOLVERS_NOISE_BONE_SPREADS_H_
#define KINEGRAPH_SOLVERS_NOISE_BONE_SPREADS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/skeleton/skeleton.h"
#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/outcome.h"
#include "solvers/graph/problem.h"
#include "solvers/noise/bone_looks.h"
#include "solvers/noise/learnt_noise.h"

namespace kinegraph {

// A bone's length as estimated from its observations.
struct BoneEstimate {
  double length_m = 0.0;
  double length_sigma_m = 0.0;  // standard error of the length
  // Standard deviation of the length over time, without the detector's noise.
  double spread_m = 0.0;
  double spread_bound_m = 0.0;  // upper bound: plus one standard error
  // Number of frames over which the solver averages a joint (ConstraintOf).
  double averaged_frames = 1.0;
  // The length varies too much to be useful; the bone is left out.
  bool gives_way = false;
};

// Collects observations of bones and estimates each bone's length and spread.
//
// Model of observation k: l_k = L + s_k + e_k, with s due to the spread and e
// the noise of triangulation, of variance v_k. The scale of the noise follows
// from the residuals of the same observations (a low quantile of square /
// chi-square, unaffected by outliers). L is the weighted median; the spread is
// the value for which the upper quartile of (l - L)^2 / (v + spread^2) is that
// of chi-square with one degree of freedom (Paule and Mandel 1982, with a
// quantile instead of the mean). Standard errors use the effective number of
// observations, which are correlated. A constant error does not appear in the
// deviations; SetLasting accounts for it. If the noise is not small compared
// with the bone, the observed distances are biased; then their squares minus
// the noise's variance are used, because E |d + e|^2 = L^2 + tr N with d the
// vector between the ends and N the covariance of its noise e, and the spread
// is unobservable. A bone's spread is shrunk towards the mean of the
// person's bones, more strongly the less these differ: small variations are
// hard to estimate from one bone. The length combines the bone's observations,
// those of the same bone on the other side (standard deviation of the
// difference 1 cm) and the population's length (15 %).
//
// Memory is bounded: of many observations every second, fourth, ... is kept.
class BoneSpreads {
 public:
  explicit BoneSpreads(const Skeleton& skeleton);

  // RigidPairs(skeleton), to which the bone indices below refer.
  const std::vector<Bone>& bones() const { return bones_; }

  // Sets the correlation of the detector's errors, and the time between frames.
  // Errors that last so long that they do not average out over the observations
  // increase the uncertainty of the length.
  void SetLasting(const ErrorCorrelation& lasting, double frame_s) {
    lasting_ = lasting;
    frame_s_ = frame_s;
  }

  void Add(int bone_idx, const BoneObservation& look);
  // Adds an observation of every bone whose ends were located. `ends`: by
  // joint.
  void AddFrame(const std::vector<std::optional<BoneEnd>>& ends);

  // Without a population length, nullopt while there are too few observations
  // or if these do not exceed their noise. Recomputed when the observations
  // have grown by a tenth, so that calls in every frame are cheap.
  std::optional<BoneEstimate> Estimate(int bone_idx) const;

 private:
  static constexpr size_t kMaxLooks = 1024;

  // The observations of one bone.
  struct Seen {
    std::vector<BoneObservation> looks;
    int64_t stride = 1;  // one observation in `stride` is kept
    int64_t count = 0;   // number of all observations
  };
  // The result of one bone's own observations.
  struct Summary {
    int64_t at_count = 0;  // number of observations when computed
    bool known = false;
    double length_m = 0.0;
    double length_variance_m2 = 0.0;  // from the deviations
    double noise_m2 = 0.0;            // variance of an observed length
    // Negative if observations vary less than their noise predicts.
    double spread_variance_m2 = 0.0;
    double spread_error_m2 = 0.0;  // standard error of spread_variance_m2
    double rigid_error_m2 = 0.0;   // the same for a rigid bone
    double averaged_frames = 1.0;
  };

  // Distribution of the spreads (variances) over all bones of one person, seen
  // by one detector (DerSimonian and Laird 1986). The standard errors are those
  // of rigid bones, because a bone's own error grows with its spread and would
  // hide differences.
  struct Pool {
    int bones = 0;
    double mean_m2 = 0.0;
    double mean_variance = 0.0;  // m^4
    double between = 0.0;        // variance from bone to bone, m^4
  };

  const Summary& SummaryOf(int bone_idx) const;
  Pool PooledSpread() const;
  double LengthVariance(const Summary& summary) const;
  void SetSpread(const Summary& seen, BoneEstimate* estimate) const;

  std::vector<Bone> bones_;
  std::vector<int> mirror_;  // by bone: the bone of the other side, or -1
  std::vector<std::optional<double>> population_m_;
  std::vector<Seen> seen_;
  mutable std::vector<Summary> summaries_;
  ErrorCorrelation lasting_;
  double frame_s_ = 0.0;
};

// The purpose of a bone's factor.
enum class BoneUse {
  kEstimate,
  // Less certain, for reported covariances: the variance of the length counts
  // as often as frames are averaged, because its error is the same in all of
  // them. In the estimate this would do more harm than good.
  kCovariance
};

// The factor for a bone with this estimate. Its variance in one frame is
//   n spread^2 + sqrt(n) hidden^2 + length_sigma^2
// with n the number of frames over which the solver averages a joint:
// - A joint centre is displaced for longer than a frame, so these n frames
//   share one error and together must not be more certain than the spread
//   permits.
// - hidden^2 is the additional spread that the observations cannot exclude
//   (spread_bound_m). Counted n times it would do more harm than good.
// - An error of the length is one number for the whole recording, which
//   displaces each end by half of it; it counts once (BoneUse::kCovariance: n
//   times).
BoneConstraint ConstraintOf(const Bone& bone, const BoneEstimate& estimate,
                            BoneUse use = BoneUse::kEstimate);

// Collects the distances between the ends of bones if both were observed, and
// estimates each bone's length: the median, common to left and right and, for a
// human, shrunk towards the population's length while observations are few.
// Memory is bounded, because distances are counted in bins of 2 mm.
class BoneLengths {
 public:
  explicit BoneLengths(const Skeleton& skeleton);

  // Adds a distance between the ends of bone `bone_idx` of RigidPairs(skeleton)
  // [m], observed for `duration_s`.
  void Add(int bone_idx, double distance_m, double duration_s);

  // Adds the bones of a pose whose ends were both observed.
  void AddPose(const Pose3d& pose, double duration_s);

  // nullopt while there are too few observations and no population length.
  std::optional<double> Length(int bone_idx) const;
  // All bones whose length is known.
  std::vector<KnownBone> Known() const;

 private:
  static constexpr double kBin = 0.002;  // m
  // Up to 4 m: subjects other than people are scaled to 1.7 m, which is the
  // length of the only bone of a subject of two joints.
  static constexpr int kBinCount = 2000;

  // Distances of a bone and the same bone on the other side.
  struct Seen {
    std::vector<float> seconds;  // by bin; empty without observations
    double total_s = 0.0;
  };

  std::vector<Bone> bones_;  // RigidPairs
  // By bone: the index in `seen_`, which left and right share.
  std::vector<size_t> counted_as_;
  std::vector<std::optional<double>> population_m_;
  std::vector<Seen> seen_;
};

// The bones of one person according to the options: with length and variability
// as observed in the recording, or with median lengths and one common
// variability. Learnt from estimates without bone constraints, because
// constraints would reproduce the assumed lengths.
class PersonBones {
 public:
  // `options` must outlive this object.
  PersonBones(const SceneModel& scene, const GraphOptions& options);

  // Sets the correlation of the detector's errors, if it is learnt.
  void SetLasting(const ErrorCorrelation& lasting);
  // Adds frame `k` of the solved problem.
  void AddFrame(const PersonProblem& problem, size_t k);
  // Constraints for all bones whose length is known and does not vary too much
  // (BoneEstimate::gives_way) and whose ends are both `placed`: by joint,
  // whether views determine its position.
  std::vector<BoneConstraint> Constraints(
      const std::vector<bool>& placed, BoneUse use = BoneUse::kEstimate) const;

 private:
  const GraphOptions& options_;
  const double frame_s_;
  BoneSpreads spreads_;  // NoiseFrom::kRecording
  BoneLengths lengths_;  // NoiseFrom::kFixed
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_NOISE_BONE_SPREADS_H_
