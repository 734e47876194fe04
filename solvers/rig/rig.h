// Estimates cameras and clocks from 2D detections of moving people alone.
// Matches between views and clocks are unknown; focal lengths may be unknown.
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
  // Whether the focal lengths were measured; if the recording contradicts them,
  // this is reported and the rig is estimated without them.
  bool focal_stated = false;
  // Whether principal points and lenses are known. Otherwise they are
  // estimated, starting at those of `intrinsics`.
  bool lenses_known = true;
  bool in_step = false;          // whether all views are synchronised
  DetectionSequence detections;  // with a known frame rate
  RigMatcher match;
  // May be empty. Called with the stage, the number of its finished steps and
  // their total.
  std::function<void(const std::string& stage, int done, int total)> progress;
};

// Mean residual of one view [px] on the half of the frames, joints or people
// that was held out of a fit, each residual capped at 30 px; 0 if there are too
// few for two halves.
struct LeftOutPx {
  double frames = 0.0;
  double joints = 0.0;
  double people = 0.0;
};

// Accuracy and clock of one view.
struct RigView {
  bool joined = false;              // to the rig: its camera was estimated
  double rotation_sigma_deg = 0.0;  // along the least certain axis
  double centre_sigma_m = 0.0;      // likewise
  double clock_s = 0.0;  // to be added to its capture times; 0 for the first
                         // joined view
  double clock_sigma_s = 0.0;  // 0 for the first joined view or if in step
  double drift = 0.0;          // [s/s]
  double mean_px = 0.0;        // of residuals, each capped at 30 px
  LeftOutPx left_out_px;
  // Difference between the fits to the two halves of the joints (of the frames,
  // for skeletons with too few joints), in units of the limits for a calibrated
  // view; 0 if a half does not suffice for a fit.
  double halves_apart = 0.0;
  double agreement = 0.0;  // with the other views (PairAgreement::score)
  std::string left_out;    // why it is left out; empty if accurate enough
};

// kCalibrated: all views of the detections are accurate, likely_right is at
// least 0.8, and the recording does not contradict stated focal lengths.
// kPartly: at least two views are accurate; if the recording contradicts stated
// focal lengths, in the fit without them. kRefused: fewer are.
enum class RigVerdict { kCalibrated, kPartly, kRefused };
const char* ToString(RigVerdict verdict);

struct RigResult {
  RigVerdict verdict = RigVerdict::kRefused;
  std::vector<std::string> reasons;  // what is undetermined, and remedies
  std::vector<RigView> views;        // one per view of the detections
  // The joined views: their indices, cameras (the scale assumes a stature or,
  // for subjects other than people, a `size_m` of 3 m; the axes and origin of
  // the world are arbitrary), the parameters estimated for each camera (indices
  // of CameraChange, without k1 and k2) and the covariance matrix of these
  // parameters of all cameras.
  std::vector<int> used;
  CameraRig cameras;
  std::vector<std::vector<int>> places;
  Eigen::MatrixXd covariance;
  bool clocks_told = false;  // whether clocks are known to fractions of a frame
  // Probability that every joined view is within 0.3 degrees and 1 % of
  // `size_m` of its true pose; halved if, for some view, another explanation
  // fits nearly as well.
  double likely_right = 0.0;
  double likely_by_lenses = 0.0;  // the same given exact lenses
  // Describes focal lengths whose estimates differ from the stated values;
  // empty if there are none.
  std::string other_focal;
  double size_m = 0.0;  // twice the RMS distance of cameras from the centroid
  // Detections of the joined views with their clocks corrected, their frames
  // numbered consecutively.
  DetectionSequence recording;
};

// Throws InputError if more than a million frames are missing.
RigResult EstimateRig(const RigInput& input);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_RIG_RIG_H_
