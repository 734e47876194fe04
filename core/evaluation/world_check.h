// Whether a ground truth is in the world of the tracks: where hardly anybody is
// found, whether other axes or another unit of length would find them.
#ifndef KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_
#define KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/evaluation/correspondence.h"
#include "core/evaluation/frame_pairing.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {

// What turns and scales the truth onto the tracks.
struct OtherWorld {
  // Tracks' world from the truth's: a permutation of axes with signs.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  double scale = 1.0;  // a power of ten
  Share found;         // true people near a track, then

  bool is_mirrored() const;
  // "x,-z,y": which axes of the tracks' world X, Y and Z of the truth are.
  std::string AxesText() const;
};

struct WorldCheck {
  Share found;  // true people near a track, as the files stand
  // Where few are found as it stands and most otherwise.
  std::optional<OtherWorld> other;

  // That few are found, and what would find them or may be wrong; empty where
  // somebody is found and nothing else would find more.
  std::string Text() const;
};

// True people are found as EvaluateCoverage has it, in up to 200 of the frames
// in which both have people.
WorldCheck CheckWorld(const FramePairing& frames, const JointPairs& joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_WORLD_CHECK_H_
