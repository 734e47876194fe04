// Cameras and clocks estimated from 2D detections of moving people alone:
// matches between views and clocks are unknown, focal lengths may be.
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

// Matches detections to people, given approximate cameras.
using RigMatcher = std::function<FrozenMatches(
    const CameraRig& cameras, const DetectionSequence& recording)>;

struct RigInput {
  // One camera per view, in the order of the detections: name, image size, lens
  // and an estimate of the focal length. Extrinsics are ignored.
  CameraRig intrinsics;
  // Standard deviation of the logarithm of the focal lengths; 0: exact.
  double focal_sigma = 0.0;
  // The focal lengths were measured: report when the recording contradicts
  // them.
  bool focal_stated = false;
  // Principal points and lenses are known. Otherwise they are estimated,
  // starting at the image's centre without distortion.
  bool lenses_known = true;
  bool in_step = false;          // all views are synchronised
  DetectionSequence detections;  // require a frame rate
  RigMatcher match;
  // May be empty. Called with the stage, its steps done and their total.
  std::function<void(const std::string& stage, int done, int total)> progress;
};

// Mean residual of one view [px] on the halves of the frames, joints or people
// that were held out of a fit, each residual at most 30 px; 0 where there are
// too few for halves.
struct LeftOutPx {
  double frames = 0.0;
  double joints = 0.0;
  double people = 0.0;
};

// Accuracy of one view.
struct RigView {
  bool joined = false;
  double rotation_sigma_deg = 0.0;  // along the least certain axis
  double centre_sigma_m = 0.0;      // likewise
  double clock_s = 0.0;             // added to its capture times; first joined
                                    // view: 0
  double clock_sigma_s = 0.0;       // 0: the first joined view, or all in step
  double drift = 0.0;               // [s/s]
  double mean_px = 0.0;             // of residuals, each at most 30 px
  LeftOutPx left_out_px;
  // Distance between the fits on either half of the joints (of the frames, for
  // skeletons with too few joints), in units of the limits of a calibrated
  // view.
  double halves_apart = 0.0;
  double agreement = 0.0;  // with the other views (PairAgreement::score)
  std::string left_out;    // why it is left out; empty: it is accurate enough
};

enum class RigVerdict { kCalibrated, kPartly, kRefused };
const char* ToString(RigVerdict verdict);

struct RigResult {
  RigVerdict verdict = RigVerdict::kRefused;
  std::vector<std::string> reasons;  // what is undetermined, what to record
  std::vector<RigView> views;        // one per view of the detections
  // The joined views: their indices, cameras (scale: the assumed stature;
  // world: the first of them), the parameters estimated for each (indices of
  // CameraChange) and the joint covariance of these.
  std::vector<int> used;
  CameraRig cameras;
  std::vector<std::vector<int>> places;
  Eigen::MatrixXd covariance;
  bool clocks_told = false;  // to better than a whole frame
  // Probability that every joined view is within 0.3 degrees and 1 % of
  // `size_m`.
  double likely_right = 0.0;
  double likely_by_lenses = 0.0;  // the same, taking the estimated lenses as
                                  // exact
  // Description of the focal lengths that the recording determines and that
  // differ from those stated; empty: none.
  std::string other_focal;
  double size_m = 0.0;  // of the rig: twice the rms distance from its centroid
  // Detections of the joined views with their clocks corrected.
  DetectionSequence recording;
};

RigResult EstimateRig(const RigInput& input);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_H_
