// Bone lengths as evidence that two pieces of tracks show one person. Their
// uncertainty is learnt from the recording.
#ifndef KINEGRAPH_CORE_IDENTITY_BONES_H_
#define KINEGRAPH_CORE_IDENTITY_BONES_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/identity/tracklet.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// The bone lengths of a person, left and right separately, as medians over
// intervals of a second, because errors of neighbouring frames are correlated.
struct BoneSamples {
  struct Piece {  // one interval
    double log_length = 0.0;
    double seconds = 0.0;          // observed
    double stated_variance = 0.0;  // of the log length, from the covariances
                                   // of the joints; 0: unknown
  };
  std::vector<std::vector<Piece>> of_bone;  // in the order of the BoneModel

  // Merges the samples of both, assumed to be one person.
  void Append(const BoneSamples& other);
};

class BoneModel {
 public:
  // Uses the bones that keep their length: limbs, shoulders, hips, and from
  // shoulder to hip; all bones if the skeleton has at most three joints.
  explicit BoneModel(const Skeleton& skeleton);

  // From the frames outside of contacts (Tracklet::clean_begin; all frames if
  // none is outside), using only joints observed by two or more views.
  BoneSamples Measure(const Tracklet& tracklet) const;
  // Learns from all tracklets how much the samples of one person differ.
  void Learn(const std::vector<BoneSamples>& tracklets);

  // Log likelihood ratio [nats] of the two sets of lengths, for one person
  // against two people drawn from the population. 0 without a common bone.
  double LogRatio(const BoneSamples& a, const BoneSamples& b) const;
  // Mean absolute difference of the bones that both have [m]; 0 if there are
  // none.
  double MeanDifference(const BoneSamples& a, const BoneSamples& b) const;

 private:
  struct Length {
    double log_length = 0.0;
    double variance = 0.0;
  };
  // nullopt without a sample of the bone.
  std::optional<Length> LengthOf(const BoneSamples& samples, size_t bone) const;
  double VarianceOf(const BoneSamples::Piece& piece, size_t bone) const;

  struct KeptBone {
    Bone bone;
    double floor_m = 0.0;  // least error of a length, which does not average
                           // out over time
  };
  std::vector<KeptBone> bones_;
  // Standard deviation of the log length of an interval of a second, by bone.
  std::vector<double> piece_sigma_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_BONES_H_
