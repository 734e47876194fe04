// 3D poses and tracks: the output of the system.
#ifndef KINEGRAPH_CORE_DATA_POSE_H_
#define KINEGRAPH_CORE_DATA_POSE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/time.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

enum class JointStatus : uint8_t {
  // No position: never supported by two views in its track, not supported near
  // this frame, or too uncertain.
  kMissing,
  kInferred,  // a position supported by at most one view in this frame
  kObserved,  // two or more inlier views in this frame
};
const char* ToString(JointStatus status);

// `position_m` is valid unless the status is kMissing.
struct Joint3d {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // world
  JointStatus status = JointStatus::kMissing;

  bool present() const { return status != JointStatus::kMissing; }
};

using Pose3d = std::vector<Joint3d>;

// Number of joints that have a position.
int CountPresent(const Pose3d& pose);

// Mean of the finite joints that have a position [m]; nullopt if there are
// none.
std::optional<Eigen::Vector3d> MeanPosition(const Pose3d& pose);

// Mean distance of the joints that both have [m]; nullopt if there are none.
std::optional<double> MeanDistance(const Pose3d& a, const Pose3d& b);

// The contribution of one view to a person in one frame.
struct ViewMatch {
  int view_idx = 0;
  int detection_idx = 0;  // index_in_file of the matched detection
  // One per joint: its weight, 0 (rejected) to 1; nullopt when the view did not
  // measure the joint. Empty unless the weights are kept (KeptMatches).
  std::vector<std::optional<double>> weights;
};

// Derivatives of a joint's position under the model of its estimator: the
// velocity of a state, the derivatives of a spline.
struct JointDerivatives {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> acceleration_m_s2;  // nullopt: not modelled
};

// One person in one frame, as written. `matches` has one entry per matched
// view. The other vectors have one entry per joint; all but `joints` may be
// empty.
struct PersonPose {
  TrackId id;
  Pose3d joints;
  std::vector<int> inlier_views;  // number of inlier views, in this frame
  std::vector<std::optional<Eigen::Matrix3d>> covariances;  // m^2
  std::vector<ViewMatch> matches;
  double score = 0.0;  // mean confidence of the matched joints
  // Only if SceneModel::keep_derivatives; not part of a track file.
  std::vector<std::optional<JointDerivatives>> derivatives;
};

struct TrackFrame {
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<PersonPose> people;
};

// Multiplies all lengths by a factor.
void Scale(double factor, TrackFrame* frame);

struct TrackHeader {
  Skeleton skeleton;
  std::string mode;                     // "paper", "graph" or a source's name
  double frame_rate_hz = 0.0;           // 0: unknown
  std::vector<std::string> view_names;  // the views that matches refer to
  std::string config_json = "{}";       // the effective configuration
};

struct TrackSequence {
  TrackHeader header;
  std::vector<TrackFrame> frames;  // ascending
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_POSE_H_
