// The information of a recording about its cameras and clocks: short motion
// segments of single joints, each seen by several views.
//
// Within a fifth of a second a joint moves nearly along a parabola, so a
// segment has nine parameters; after their elimination, its pixels in all views
// constrain cameras and clocks. Segments are independent of each other, so the
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
// Information [1/m^2] about a segment's position that keeps its normal
// equations regular if its views leave a direction undetermined: a sigma of one
// kilometre.
inline constexpr double kPositionInformation = 1e-6;
// Largest clock error that segments can determine: half of their length of a
// fifth of a second. Beyond a segment's ends its velocity and acceleration
// follow the noise of a view. Lags of whole frames are searched for beforehand.
inline constexpr double kFarthestClockS = 0.1;

// Position [m], velocity [m/s], acceleration [m/s^2] at the segment's middle.
using SegmentState = Eigen::Matrix<double, kSegmentSize, 1>;

struct SegmentMeasurement {
  int view_idx = 0;
  double time_s = 0.0;  // nominal capture time minus the segment's middle
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  // raw
  double sigma_px = 1.0;
};

struct MotionSegment {
  int person = 0;         // index in the frozen matches
  int joint = 0;          // of the detections' skeleton
  double middle_s = 0.0;  // since the middle of the recording
  std::vector<SegmentMeasurement> measurements;
  SegmentState state = SegmentState::Zero();  // for the given cameras
  // Standard deviation per component of its velocity [m/s], at a noise scale of
  // 1.
  double velocity_sigma_mps = 0.0;
};

struct SegmentOptions {
  double span_s = 0.2;      // longest segment; at least one frame
  int max_segments = 1500;  // spread evenly over the recording
  double sigma_px = 6.0;    // at focal length 1000 px, 4 m, confidence 1
  double min_sigma_px = 1.0;
  double min_confidence = 0.3;
  double velocity_sigma_mps = 5.0;
  double acceleration_sigma_mps2 = 30.0;
  // Reduces the weights of measurements towards the ends of a segment, so that
  // its middle is the same instant in all views regardless of when their frames
  // were captured. Otherwise detector errors with a correlation time of a tenth
  // of a second bias clocks towards whole frames.
  bool tapered = false;
};

struct SceneSegments {
  std::vector<MotionSegment> segments;  // by ascending first frame
  int view_count = 0;
  double span_s = 0.0;       // of the whole recording
  double frame_s = 0.0;      // median interval of frames
  double noise_scale = 1.0;  // factor of all sigmas, from the residuals
  // By view, over the frames in which at least two other views have matches:
  // the number of people matched, and of people that could be matched, which is
  // at most the number of detections.
  std::vector<int64_t> matched;
  std::vector<int64_t> matchable;
  std::vector<JointClass> classes;  // of the detections' joints
};

// If the median confidence of found joints is below 0.6, scales all confidences
// so that it is 0.6. Joints below SegmentOptions::min_confidence (0.3) are left
// out, a limit that suits detectors whose confidences typically exceed 0.6.
DetectionSequence WithUsualConfidences(DetectionSequence detections);

// The detection with this index_in_file; null if there is none.
const Detection* FindDetection(const ViewDetections& view, int index_in_file);

// Median interval between frames; 1 s for fewer than two frames.
TimeNs FrameIntervalOf(const DetectionSequence& detections);

// Segments of the people in `matches`. `cameras`: one per view of the
// detections. A segment is of one joint that at least two views saw and that
// can be triangulated.
SceneSegments MakeSegments(const CameraRig& cameras,
                           const DetectionSequence& detections,
                           const FrozenMatches& matches,
                           const SegmentOptions& options);

// The loss of all solves on segments: Cauchy, scale in sigmas.
inline constexpr LossKind kSceneLoss = LossKind::kCauchy;
inline constexpr double kSceneLossScale = 2.0;

// Residual [sigmas] of a measurement; nullopt if the point cannot be projected.
// The Jacobians with respect to the segment's state and the camera's change may
// be null.
std::optional<Eigen::Vector2d> SegmentResidual(
    const Camera& camera, const CameraChange& change,
    const MotionSegment& segment, const SegmentState& state,
    const SegmentMeasurement& measurement, double noise_scale,
    Eigen::Matrix<double, 2, kSegmentSize>* by_state = nullptr,
    Eigen::Matrix<double, 2, kChangeSize>* by_change = nullptr);

// Linearised term of one measurement: its residual, the Jacobians with respect
// to the segment's state and the change of the view's camera, and its weight
// under the loss.
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

// Estimates the most likely state of the segment for given cameras
// (Gauss-Newton with the loss, from `state`); false if it fails.
bool SolveSegment(const CameraRig& cameras,
                  const std::vector<CameraChange>& changes,
                  const MotionSegment& segment, double noise_scale,
                  const SegmentOptions& options, SegmentState* state);

// Diagonal of the prior information about velocity [s^2/m^2] and acceleration
// [s^4/m^2]; zero for the position.
SegmentState PriorInformation(const SegmentOptions& options);

// 3D position [m] of `segment` at its middle.
inline Eigen::Vector3d PositionOf(const MotionSegment& segment) {
  return segment.state.head<3>();
}

// Whether joints move fast enough to determine clocks: a tenth of the segments
// at 0.3 m/s or more, and a tenth at five or more standard deviations of their
// velocity. For people at rest the 90th percentile is 2.9 to 3.5 standard
// deviations (2.5 for white errors), regardless of the detector's noise; for
// people who talk, work, walk or dance it is 7 to 20 standard deviations and at
// least 0.7 m/s.
bool MoveEnough(const SceneSegments& segments);

// Length of a time bin [s]: a twentieth of the recording, within 0.2 .. 1 s,
// which exceeds the correlation time of detector errors of about a tenth of a
// second.
double BinLength(const SceneSegments& segments);

// Index of the time bin that contains the middle of `segment`.
int64_t BinOf(const SceneSegments& segments, const MotionSegment& segment);

// Ways to halve a recording. Persistent detector errors are specific to a
// joint: they are present in both halves of the time, but not in other joints.
// They are correlated between joints of one limb, more between two legs than
// between a leg and an arm, and persist while a person stays in one place.
enum class Halving {
  kTime,
  kJoints,  // alternating pairs of joints, each left and right
  kBody,    // hips and legs / the other joints
  kPlaces,  // along the direction in which people move most
  kPeople,  // alternating people
};

// The segments of one half (0 or 1).
SceneSegments HalfOf(const SceneSegments& segments, Halving halving, int half);

// Interquartile range [m] of the joints' positions relative to each joint's
// mean, along the direction in which people move most. Only segments seen by at
// least three views count (by two, if there are only two), because a match of
// two views fits any camera.
double PlacesApart(const SceneSegments& scene);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_CAMERAS_SEGMENTS_H_
