// Do two pieces of tracks have the same body: bone lengths with their
// uncertainty, which the recording itself tells.
#ifndef KINEGRAPH_CORE_IDENTITY_BONES_H_
#define KINEGRAPH_CORE_IDENTITY_BONES_H_

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/identity/tracklet.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A body's bone lengths, left and right each for itself (the model's constants
// were chosen so). Errors of neighbouring frames go together, so lengths are
// medians of pieces of a second.
struct BoneSamples {
  struct Piece {
    double log_length = 0.0;
    double seconds = 0.0;          // observed
    double stated_variance = 0.0;  // of the log length; 0: not stated
  };
  std::vector<std::vector<Piece>> of_bone;

  // The samples of both, as of one body.
  void Append(const BoneSamples& other);
};

class BoneModel {
 public:
  // Limbs, shoulders, hips, and the side from shoulder to hip: bones that keep
  // their length.
  explicit BoneModel(const Skeleton& skeleton);

  // From the clean frames, joints observed by two views alone.
  BoneSamples Measure(const Tracklet& tracklet) const;
  // Logarithms of all lengths of the same frames, [bone][].
  std::vector<std::vector<double>> LogLengths(const Tracklet& tracklet) const;
  // Learns from all tracklets how much the pieces of one body differ.
  void Learn(const std::vector<BoneSamples>& tracklets);
  // Learns from pairs that are two people for sure (seen at once) how often two
  // people of this recording are built alike: what agrees then says so much
  // less. They count as `pairs` at most: the same two may be many tracks.
  void LearnAlike(
      const std::vector<std::pair<BoneSamples, BoneSamples>>& strangers,
      double pairs);
  double alike_share() const { return alike_share_; }

  // Log likelihood ratio [nats] of the two sets of lengths under one body and
  // under two bodies drawn from the population. 0 without a common bone.
  double LogRatio(const BoneSamples& a, const BoneSamples& b) const;
  // The same with people about who are built alike; `most` is the ratio for the
  // one of all strangers to the first whom the second looks like most.
  double AmongAlike(double log_ratio, double most) const;
  // Mean absolute difference of the bones that both have [m]; 0 without any.
  double MeanDifference(const BoneSamples& a, const BoneSamples& b) const;

 private:
  struct Length {
    bool known = false;
    double log_length = 0.0;
    double variance = 0.0;
  };
  Length LengthOf(const BoneSamples& samples, size_t bone) const;
  double VarianceOf(const BoneSamples::Piece& piece, size_t bone) const;

  struct KeptBone {
    Bone bone;
    double floor_m = 0.0;  // of the errors that last
  };
  std::vector<KeptBone> bones_;
  std::vector<double> piece_sigma_;  // of the log length in 1 s, by bone
  double alike_share_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_BONES_H_
