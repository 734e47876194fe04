// Cameras and clocks from the people themselves: 2D detections alone, whose
// person is whose unknown, clocks apart, focal lengths known or not.
#ifndef KINEGRAPH_SOLVERS_RIG_RIG_H_
#define KINEGRAPH_SOLVERS_RIG_RIG_H_

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/tracking/replay.h"
#include "solvers/cameras/bundle.h"
#include "solvers/cameras/segments.h"

namespace kinegraph {

// Whose detections are whose, for cameras that are nearly right.
using RigMatcher = std::function<FrozenMatches(
    const CameraRig& cameras, const DetectionSequence& recording)>;

struct RigInput {
  // One a view, in the order of the detections: names, image sizes, lenses and
  // a guess of the focal lengths; where they stand is not looked at.
  CameraRig intrinsics;
  // Standard deviation of the logarithm of the focal lengths about the guess;
  // 0: they are known.
  double focal_sigma = 0.0;
  // They were measured: that the recording says otherwise is said.
  bool focal_stated = false;
  // Principal points and lenses are known; else they are estimated, from the
  // image's middle and no distortion on.
  bool lenses_known = true;
  bool in_step = false;          // all views show the same moments
  DetectionSequence detections;  // with a frame rate
  RigMatcher match;
  // May be empty: what is done, and how many steps of it of how many.
  std::function<void(const std::string& stage, int done, int total)> progress;
};

// Mean residual of one view on the halves of the frames, joints or people that
// a fit was not given, each at most 30 px; 0 where they cannot be halved.
struct LeftOutPx {
  double frames = 0.0;
  double joints = 0.0;
  double people = 0.0;
};

// How sure one view is.
struct RigView {
  bool joined = false;
  double rotation_sigma_deg = 0.0;  // along the least sure axis
  double centre_sigma_m = 0.0;      // likewise
  double clock_s = 0.0;             // added to its time of capture
  double clock_sigma_s = 0.0;       // 0: the first joined view, or in step
  double drift = 0.0;               // [s/s]
  double mean_px = 0.0;             // of residuals, each at most 30 px
  LeftOutPx left_out_px;
  // How far fits on halves of the joints put it apart, in what is sure enough.
  double halves_apart = 0.0;
  double agreement = 0.0;  // with the other views (PairAgreement::score)
  std::string left_out;    // why, in words; empty where it is sure
};

enum class RigVerdict { kCalibrated, kPartly, kRefused };
const char* ToString(RigVerdict verdict);

struct RigResult {
  RigVerdict verdict = RigVerdict::kRefused;
  std::vector<std::string> reasons;  // what cannot be told, what to record
  std::vector<RigView> views;        // one a view of the detections
  // The joined views: their indices, cameras (metres by people's stature; the
  // world is the first one's) and the covariance of their parameters.
  std::vector<int> used;
  CameraRig cameras;
  std::vector<std::vector<int>> places;
  Eigen::MatrixXd covariance;
  bool clocks_told = false;  // beyond whole frames
  // How likely every joined view is within 0.3 degrees and 1 % of `size_m`.
  double likely_right = 0.0;
  double likely_by_lenses = 0.0;  // the same were the lenses as estimated
  // Focal lengths that the recording tells and that are not those stated, in
  // words.
  std::string other_focal;
  double size_m = 0.0;  // of the rig: twice the rms distance from its middle
  // The detections of the joined views with their clocks set right.
  DetectionSequence recording;
};

RigResult EstimateRig(const RigInput& input);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_H_
