// The information of a recording on its cameras and clocks: short stretches of
// single joints, each seen by several views.
//
// Within a fifth of a second a joint moves nearly along a parabola: a stretch
// has nine parameters, and after their elimination the pixels of all views in
// it constrain cameras and clocks. Stretches are independent of each other: the
// problem has the structure of a bundle adjustment, with velocities, which
// clocks require.
#ifndef KINEGRAPH_SOLVERS_CAMERAS_SEGMENTS_H_
#define KINEGRAPH_SOLVERS_CAMERAS_SEGMENTS_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/data/detection.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"
#include "core/tracking/replay.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/factors/loss.h"

namespace kinegraph {

inline constexpr int kSegmentSize = 9;
// Information on a stretch's position that keeps its normal equations regular
// if its views leave a direction undetermined: a sigma of one kilometre
// [1/m^2].
inline constexpr double kPositionInformation = 1e-6;
// Largest clock error that stretches can determine: half their length of a
// fifth of a second. Beyond a stretch's ends its velocity and acceleration
// follow a view's noise. Whole frames are searched for before.
inline constexpr double kFarthestClockS = 0.1;

// Position [m], velocity [m/s], acceleration [m/s^2] at the stretch's middle.
using SegmentState = Eigen::Matrix<double, kSegmentSize, 1>;

struct SegmentMeasurement {
  int view_idx = 0;
  double time_s = 0.0;  // nominal capture time less the stretch's middle
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw
  double sigma_px = 1.0;
};

struct MotionSegment {
  int person = 0;         // in the frozen matches
  int joint = 0;          // of the detections' skeleton
  double middle_s = 0.0;  // since the middle of the recording
  std::vector<SegmentMeasurement> measurements;
  SegmentState state = SegmentState::Zero();  // by the stated calibration
  // Per component of its velocity [m/s], at a noise scale of 1.
  double velocity_sigma_mps = 0.0;
};

struct SegmentOptions {
  double span_s = 0.2;      // of a stretch; at least one frame
  int max_segments = 1500;  // spread evenly over the recording
  double sigma_px = 6.0;    // at 1000 px of focal length and 4 m
  double min_sigma_px = 1.0;
  double min_confidence = 0.3;
  double velocity_sigma_mps = 5.0;
  double acceleration_sigma_mps2 = 30.0;
  // Weights measurements down towards the ends of a stretch, so that its middle
  // is the same moment in all views wherever their frames lie. Otherwise
  // detector errors that last a tenth of a second draw clocks towards whole
  // frames.
  bool tapered = false;
};

struct SceneSegments {
  std::vector<MotionSegment> segments;  // by ascending middle
  int view_count = 0;
  double span_s = 0.0;       // of the whole recording
  double frame_s = 0.0;      // median interval of frames
  double noise_scale = 1.0;  // on every sigma, from the residuals
  // For each view, over the frames in which at least two other views have
  // matches: people matched, and those that could be, of whom there are no more
  // than detections.
  std::vector<int64_t> matched;
  std::vector<int64_t> matchable;
  std::vector<JointClass> classes;  // of the detections' joints
};

// Scales all confidences so that the median over found joints is 0.6, where it
// is less: joints below SegmentOptions::min_confidence (0.3) are left out, a
// limit for detectors whose joints usually have 0.6 and more.
DetectionSequence WithUsualConfidences(DetectionSequence detections);

// The detection with that index_in_file; null without one.
const Detection* FindDetection(const ViewDetections& view, int index_in_file);

// Stretches of the people in `matches`. Views are those of the detections, with
// one camera each. A stretch is of one joint that at least two views saw and
// that can be triangulated.
SceneSegments MakeSegments(const CameraRig& cameras,
                           const DetectionSequence& detections,
                           const FrozenMatches& matches,
                           const SegmentOptions& options);

// The loss of all solves on stretches: Cauchy, scale in sigmas.
inline constexpr LossKind kSceneLoss = LossKind::kCauchy;
inline constexpr double kSceneLossScale = 2.0;

// Residual [sigmas] of a measurement; nullopt where the point has no image. The
// Jacobians by the stretch's state and by the camera's change may be null.
std::optional<Eigen::Vector2d> SegmentResidual(
    const Camera& camera, const CameraChange& change,
    const MotionSegment& segment, const SegmentState& state,
    const SegmentMeasurement& measurement, double noise_scale,
    Eigen::Matrix<double, 2, kSegmentSize>* by_state = nullptr,
    Eigen::Matrix<double, 2, kChangeSize>* by_change = nullptr);

// Linearised term of one measurement: its residual, the Jacobians by the
// stretch's state and by the view's camera, and its weight under the loss.
struct SegmentTerm {
  size_t view = 0;
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kSegmentSize> by_state;
  Eigen::Matrix<double, 2, kChangeSize> by_change;
  double weight = 0.0;
};

// The terms of all measurements that have an image at `state` and `changes`.
std::vector<SegmentTerm> TermsOf(const CameraRig& cameras,
                                 const std::vector<CameraChange>& changes,
                                 const MotionSegment& segment,
                                 const SegmentState& state, double noise_scale);

// The most likely state of the stretch for given cameras (Gauss-Newton under
// the loss, from `state`); false where there is none.
bool SolveSegment(const CameraRig& cameras,
                  const std::vector<CameraChange>& changes,
                  const MotionSegment& segment, double noise_scale,
                  const SegmentOptions& options, SegmentState* state);

// Prior information on velocity and acceleration.
SegmentState PriorInformation(const SegmentOptions& options);

// 3D position [m] of `segment` at its middle, by its state.
inline Eigen::Vector3d PositionOf(const MotionSegment& segment) {
  return segment.state.head<3>();
}

// Whether joints move fast enough to determine clocks: a tenth of the stretches
// at 0.3 m/s or more, and a tenth at five or more standard deviations of their
// velocity. For people at rest the upper decile is 2.9 to 3.5 standard
// deviations (2.5 for white errors), whatever the detector's noise; for people
// who talk, work, walk or dance it is 7 to 20, and 0.7 m/s and more.
bool MoveEnough(const SceneSegments& segments);

// Length of a bin of time [s]: a twentieth of the recording, within 0.2 .. 1 s.
// Detector errors last about a tenth of a second.
double BinLength(const SceneSegments& segments);

// Ways to halve a recording. Lasting detector errors belong to a joint: they
// are in both halves of the time, but not in other joints. Joints of one limb
// share them, those of two legs more than those of a leg and an arm, and they
// last while a person stays in one place.
enum class Halving {
  kTime,
  kJoints,
  kBody,    // hips and legs, and the rest
  kPlaces,  // along the direction in which people move most
  kPeople,  // every other one
};

// The stretches of one half (0 or 1).
SceneSegments HalfOf(const SceneSegments& segments, Halving halving, int half);

// Interquartile range [m] of the joints' positions, less each joint's mean,
// along the direction in which people move most. Only stretches of three views
// count (of two, if there are only two): a match of two views fits any camera.
double PlacesApart(const SceneSegments& scene);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_SEGMENTS_H_
