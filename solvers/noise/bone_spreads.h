// How long a person's bones are, how sure that is, and how much each length
// varies: joint centres of real people, and of detectors, are no points of
// rigid bones.
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
#include "solvers/noise/pixel_noise.h"

namespace kinegraph {

// What the looks say of a bone.
struct BoneEstimate {
  double length_m = 0.0;
  double length_sigma_m = 0.0;  // how sure the length is
  double spread_m = 0.0;        // how much it varies, without detector's noise
  double spread_bound_m = 0.0;  // the same with one standard error more
  double averaged_frames = 1.0;
  int64_t looks = 0;
  // The length varies so much that it says nothing: it is left out.
  bool gives_way = false;
};

// Collects looks and tells each bone's length and spread.
//
// Model of look k: l_k = L + s_k + e_k, with s of the spread and e of the noise
// of triangulation, v_k. The noise's scale comes from the residuals of the same
// looks (a low quantile of square / chi-square, which outliers do not reach).
// L is the weighted median; the spread is what makes the upper quartile of
// (l - L)^2 / (v + spread^2) that of chi-square with one degree of freedom
// (Paule and Mandel 1982, with a quantile for the mean). Standard errors count
// looks that follow each other as less than one each, by their correlation.
// An error that stays shows in no deviation: SetLasting tells of it.
// Where the noise is not small beside the bone, distances are no lengths any
// more (the longest ones most of all): their squares are, less the noise's
// variance, E |d + e|^2 = L^2 + tr N. Such a bone's spread cannot be seen.
// A bone's spread is drawn to that of the person's other bones as far as they
// are alike: what little varies is hard to tell from one bone's looks.
// Left and right inform each other as if they differed by 1 cm, and the
// population's length as if people differed by 15 %.
//
// Memory does not grow: of many looks every second, fourth, ... is kept.
class BoneSpreads {
 public:
  explicit BoneSpreads(const Skeleton& skeleton);

  // RigidPairs(skeleton); the bones of the functions below.
  const std::vector<Bone>& bones() const { return bones_; }

  // How long the detector's errors last, and the time between frames. What does
  // not average out over the looks leaves the length unsure.
  void SetLasting(const ErrorCorrelation& lasting, double frame_s) {
    lasting_ = lasting;
    frame_s_ = frame_s;
  }

  void Add(int bone_idx, const BoneObservation& look);
  // Looks at all bones whose ends were located, by joint.
  void AddFrame(const std::vector<std::optional<BoneEnd>>& ends);

  // nullopt while neither enough was seen nor the population's is known. The
  // answer is worked out anew when a tenth more has been seen, so that asking
  // in every frame costs little.
  std::optional<BoneEstimate> Estimate(int bone_idx) const;

 private:
  static constexpr size_t kMaxLooks = 1024;

  // Of one bone.
  struct Seen {
    std::vector<BoneObservation> looks;
    int64_t stride = 1;  // every so manieth look is kept
    int64_t count = 0;   // of all looks
  };
  // Of one bone's own looks.
  struct Summary {
    int64_t at_count = 0;  // of looks, when it was made
    bool known = false;
    double length_m = 0.0;
    double length_variance_m2 = 0.0;  // by how the looks deviate
    double noise_m2 = 0.0;            // variance of a look's length
    // Below zero where looks vary less than their noise says.
    double spread_variance_m2 = 0.0;
    double spread_error_m2 = 0.0;  // standard error of the line above
    double rigid_error_m2 = 0.0;   // the same, were the bone rigid
    double averaged_frames = 1.0;
  };

  // What the spreads (variances) of all bones are like: bones of one person,
  // seen by one detector (DerSimonian and Laird 1986). The errors are those of
  // rigid bones: own errors grow with the spread and would hide what differs.
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
  std::vector<int> mirror_;  // of each bone; -1: none
  std::vector<std::optional<double>> population_m_;
  std::vector<Seen> seen_;
  mutable std::vector<Summary> summaries_;
  ErrorCorrelation lasting_;
  double frame_s_ = 0.0;
};

// What a bone's factor is for.
enum class BoneUse {
  kEstimate,
  // Less sure, for what is stated: the length's own variance counts as often
  // as frames are averaged, since its error is the same in all of them. In the
  // estimate that would cost more than it gives.
  kCovariance
};

// The factor for a bone of which that is known. Its variance in one frame is
//   n spread^2 + sqrt(n) hidden^2 + length_sigma^2
// with n the frames that the solver averages a joint over:
// - A joint centre that sways does so for longer than a frame, so these n
//   frames share one error and may together say no more than the spread allows.
// - hidden^2 is what the spread may be beyond that without the looks showing it
//   (spread_bound_m). Counted n times it would cost more than it saves.
// - An error of the length is one number for the whole recording, which moves
//   each end by half of it; it counts once (BoneUse::kCovariance: n times).
BoneConstraint ConstraintOf(const Bone& bone, const BoneEstimate& estimate,
                            BoneUse use = BoneUse::kEstimate);

// Collects the distances of bones' ends where both were observed, and tells
// each bone's length: the median, shared by left and right, drawn towards the
// population's while little has been seen, of a human. Memory does not grow:
// distances are counted in bins of 2 mm.
class BoneLengths {
 public:
  explicit BoneLengths(const Skeleton& skeleton);

  // A distance of the ends of bone `bone_idx` of RigidPairs(skeleton) [m], seen
  // for `duration_s`.
  void Add(int bone_idx, double distance_m, double duration_s);

  // Those of a pose whose ends were both observed.
  void AddPose(const Pose3d& pose, double duration_s);

  // nullopt while neither enough was seen nor the population's is known.
  std::optional<double> Length(int bone_idx) const;
  // All bones whose length is known.
  std::vector<KnownBone> Known() const;

 private:
  static constexpr double kBin = 0.002;  // m
  static constexpr int kBinCount = 750;  // up to 1.5 m

  // Seen of a bone and its mirror, together.
  struct Seen {
    std::vector<float> seconds;  // by bin; empty: nothing yet
    double total_s = 0.0;
  };

  std::vector<Bone> bones_;  // RigidPairs
  // Of each bone, itself or its mirror: whose place in `seen_` they share.
  std::vector<size_t> counted_as_;
  std::vector<std::optional<double>> population_m_;
  std::vector<Seen> seen_;
};

// The bones of one person, as the options say: of length and freedom as the
// recording shows them, or of median lengths with one freedom for all. They are
// learnt from estimates without bones, or they would confirm themselves.
class PersonBones {
 public:
  // `options` must outlive it.
  PersonBones(const SceneModel& scene, const GraphOptions& options);

  // How long the detector's errors last, if that is learnt.
  void SetLasting(const ErrorCorrelation& lasting);
  // Frame `k` of the problem, solved.
  void AddFrame(const PersonProblem& problem, size_t k);
  // Factors of all bones that are known, do not give way and have both ends
  // `placed` (by joint).
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
