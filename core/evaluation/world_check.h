// Checks that a ground truth is in the world of the tracks: where few people
// are found, searches for other axes or another unit of length that would find
// them.
#ifndef KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_
#define KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/evaluation/correspondence.h"
#include "core/evaluation/frame_pairing.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// The rotation or reflection, and the scale, from the truth to the tracks.
struct OtherWorld {
  // From the truth's to the tracks' world: a signed permutation of axes.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  double scale = 1.0;  // a power of ten
  Share found;         // true people near a track in that world

  bool is_mirrored() const;
  // "x,-z,y": the axes of the tracks' world that correspond to X, Y and Z of
  // the truth.
  std::string AxesText() const;
};

struct WorldCheck {
  Share found;  // true people near a track with the files as they are
  // Median extent of the true people's compared joints [m]; 0: unknown.
  double extent_m = 0.0;
  // Set where few people are found with the files as they are, and most in
  // another world.
  std::optional<OtherWorld> other;

  // Reports that few people are found, with the remedy or possible causes;
  // empty if some are found and `other` is not set.
  std::string Text() const;
  // Reports that kPersonGateM does not suit subjects of this extent; empty if
  // it does.
  std::string GateText() const;
};

// True people are found in the sense of EvaluateCoverage, in up to 200 of the
// frames in which both recordings have people.
WorldCheck CheckWorld(const FramePairing& frames, const JointPairs& joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_
