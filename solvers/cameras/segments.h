// What a recording says of its cameras and clocks: short stretches of single
// joints, each seen by several views.
//
// Over a fifth of a second a joint moves nearly as a parabola. So a stretch is
// nine numbers, and the pixels of all views in it speak of cameras and clocks
// once these nine are eliminated. No stretch touches another: the problem has
// the structure of a bundle adjustment, with velocities in it, which clocks
// need.
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
// where its views leave a direction open: that of a kilometre [1/m^2].
inline constexpr double kPositionInformation = 1e-6;
// A stretch is a fifth of a second long. Of a clock that is off by more than
// half of it it tells nothing: beyond its ends its speed and acceleration
// follow a view's noise. Whole frames are looked for before.
inline constexpr double kFarthestClockS = 0.1;

// Position [m], velocity [m/s], acceleration [m/s^2] at the stretch's middle.
using SegmentState = Eigen::Matrix<double, kSegmentSize, 1>;

struct SegmentMeasurement {
  int view_idx = 0;
  double time_s = 0.0;  // told time of capture less the stretch's middle
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw
  double sigma_px = 1.0;
};

struct MotionSegment {
  int person = 0;         // index in the frozen matches
  int joint = 0;          // of the detections' skeleton
  double middle_s = 0.0;  // since the middle of the recording
  std::vector<SegmentMeasurement> measurements;
  SegmentState state = SegmentState::Zero();  // at the calibration as stated
  // Of each component of its velocity [m/s], at a noise scale of 1.
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
  // Measurements count less towards the ends of their stretch, so that its
  // middle is the same moment in all views wherever their frames lie. Else the
  // part of a detector's errors that lasts a tenth of a second draws clocks
  // towards whole frames.
  bool tapered = false;
};

struct SceneSegments {
  std::vector<MotionSegment> segments;  // by ascending middle
  int view_count = 0;
  double span_s = 0.0;       // of the whole recording
  double frame_s = 0.0;      // the frames' usual distance
  double noise_scale = 1.0;  // on every sigma, from the residuals
  // A view's detections that were matched to a person, and all of them, over
  // frames in which two other views matched somebody.
  std::vector<int64_t> matched;
  std::vector<int64_t> detections;
  std::vector<JointClass> classes;  // of the detections' joints
};

// Joints below a confidence of 0.3 (SegmentOptions::min_confidence) are left
// out, which is meant for detectors whose joints have 0.6 and more as a rule.
// All confidences by the factor that brings the median of the joints found to
// 0.6, where it is less.
DetectionSequence WithUsualConfidences(DetectionSequence detections);

// The detection with that index_in_file; null without one.
const Detection* FindDetection(const ViewDetections& view, int index_in_file);

// Stretches of the people that `matches` names. Views are those of the
// detections and have a camera each. A stretch has a joint that two views or
// more saw and that can be triangulated.
SceneSegments MakeSegments(const CameraRig& cameras,
                           const DetectionSequence& detections,
                           const FrozenMatches& matches,
                           const SegmentOptions& options);

// The loss of every solve here: Cauchy, in sigmas.
inline constexpr LossKind kSceneLoss = LossKind::kCauchy;
inline constexpr double kSceneLossScale = 2.0;

// Residual [sigmas] of a measurement, or nullopt where the point has no image.
// Jacobians may be null: by the stretch's state and by the camera's change.
std::optional<Eigen::Vector2d> SegmentResidual(
    const Camera& camera, const CameraChange& change,
    const MotionSegment& segment, const SegmentState& state,
    const SegmentMeasurement& measurement, double noise_scale,
    Eigen::Matrix<double, 2, kSegmentSize>* by_state = nullptr,
    Eigen::Matrix<double, 2, kChangeSize>* by_change = nullptr);

// What one measurement says of a stretch's state and of its view's camera: the
// residual, its Jacobians, and its weight under the loss.
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

// The stretch's most likely state for given cameras (Gauss-Newton under the
// loss, from `state`); false when it has none.
bool SolveSegment(const CameraRig& cameras,
                  const std::vector<CameraChange>& changes,
                  const MotionSegment& segment, double noise_scale,
                  const SegmentOptions& options, SegmentState* state);

// The information of velocity and acceleration before anything is measured.
SegmentState PriorInformation(const SegmentOptions& options);

// 3D position of the middle of `segment`, at its own state.
inline Eigen::Vector3d PositionOf(const MotionSegment& segment) {
  return segment.state.head<3>();
}

// Whether joints move fast enough to tell of clocks: a tenth of the stretches
// at 0.3 m/s or more, and at five standard deviations of their velocity or
// more. Of people at rest a tenth comes out at 2.9 to 3.5 standard deviations
// (2.5 were their errors white), whatever the detector's noise; of people who
// talk, work, walk or dance at 7 to 20, and at 0.7 m/s and more.
bool MoveEnough(const SceneSegments& segments);

// Length of a bin of time [s]: a twentieth of the recording, between 0.2 and 1
// s. Errors of a detector last a tenth of a second or so.
double BinLength(const SceneSegments& segments);

// Ways to halve a recording. What lasts in a detector's errors stays with its
// joint: a second half of the time has it too, other joints have not. Joints of
// one limb share it, and those of legs more than those of legs and arms; and it
// stays the same while somebody stays in one place.
enum class Halving {
  kTime,
  kJoints,
  kBody,    // hips and legs, and the rest
  kPlaces,  // along the direction in which people move most
  kPeople,  // every other one
};

// The stretches of one half (0 or 1).
SceneSegments HalfOf(const SceneSegments& segments, Halving halving, int half);

// How far the two halves of the places lie apart [m]: of each joint's
// positions, less its mean one, where three views see it: what two views pair
// fits any camera, such as a figure that nobody else sees.
double PlacesApart(const SceneSegments& scene);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_SEGMENTS_H_
