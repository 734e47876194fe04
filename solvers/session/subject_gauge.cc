#include "solvers/session/subject_gauge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/data/box.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/triangulation.h"
#include "core/skeleton/anthropometry.h"
#include "core/skeleton/body_joints.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

// Limbs of a body and their share of the stature.
struct Limb {
  const char* a;
  const char* b;
  double share;
};
constexpr std::array<Limb, Limbs::kSided / 2> kLimbs = {
    {{"hip", "knee", kThighShare},
     {"knee", "ankle", kShankShare},
     {"shoulder", "elbow", kUpperArmShare},
     {"elbow", "wrist", kForearmShare}}};

std::optional<Eigen::Vector3d> MiddleOf(const Pose3d& pose, int a, int b) {
  if (!ObservedDistance(pose, a, b)) return std::nullopt;
  return 0.5 * (pose[a].position_m + pose[b].position_m);
}

bool IsPerson(double size_m) {
  return size_m >= kMinHeight && size_m <= kMaxHeight;
}

// The observed joints that belong to the body. Others, such as a misplaced
// joint, are far from its centre; the tip of a tail is only two or three times
// as far as most joints.
std::vector<Eigen::Vector3d> JointsOfTheBody(const Pose3d& pose) {
  constexpr double kFar = 4.0;
  std::vector<Eigen::Vector3d> joints_m;
  std::array<std::vector<double>, 3> coordinates_m;
  for (const Joint3d& joint : pose) {
    if (joint.status != JointStatus::kObserved) continue;
    joints_m.push_back(joint.position_m);
    for (Eigen::Index k = 0; k < 3; ++k) {
      coordinates_m[k].push_back(joint.position_m[k]);
    }
  }
  if (joints_m.empty()) return joints_m;
  Eigen::Vector3d middle;
  for (Eigen::Index k = 0; k < 3; ++k) middle[k] = Median(coordinates_m[k]);
  std::vector<double> distances_m;
  for (const Eigen::Vector3d& at : joints_m) {
    distances_m.push_back((at - middle).norm());
  }
  const double most_m = kFar * Median(distances_m);
  joints_m.erase(std::remove_if(joints_m.begin(), joints_m.end(),
                                [&](const Eigen::Vector3d& at) {
                                  return (at - middle).norm() > most_m;
                                }),
                 joints_m.end());
  return joints_m;
}

// Size of a subject [m]: the stature of a human; for others the extent, the 90
// % quantile of the distances between joints. For a human's joints that is 1.3
// m of 1.7 m stature; for a few points, such as the ends of a box, all of it.
std::optional<double> SizeOf(const Pose3d& pose, const Limbs& limbs,
                             bool is_human) {
  if (is_human) {
    const auto height_m = limbs.HeightOf(pose);
    return height_m > 0.0 && std::isfinite(*height_m) ? height_m : std::nullopt;
  }
  constexpr double kSizeOfExtent = kPersonSize_m / 1.3;
  constexpr size_t kFewPoints = 4;
  std::vector<double> distances_m;
  const std::vector<Eigen::Vector3d> joints_m = JointsOfTheBody(pose);
  for (size_t i = 0; i < joints_m.size(); ++i) {
    for (size_t k = i + 1; k < joints_m.size(); ++k) {
      distances_m.push_back((joints_m[i] - joints_m[k]).norm());
    }
  }
  if (distances_m.empty()) return std::nullopt;
  const double extent_m = Quantile(std::move(distances_m), 0.9);
  if (!(extent_m > 0.0 && std::isfinite(extent_m))) return std::nullopt;
  return pose.size() <= kFewPoints ? extent_m : kSizeOfExtent * extent_m;
}

// The scale of human joints is 1 unless nearly all observations have a size
// that no human has.
SubjectScale ScaleOfSizes(const std::vector<double>& sizes_m, bool is_human) {
  if (sizes_m.empty()) return SubjectScale();
  if (is_human) {
    constexpr size_t kEnough = 10;
    constexpr double kNearlyAll = 0.9;
    const auto share = [&](auto outside) {
      return static_cast<double>(
                 std::count_if(sizes_m.begin(), sizes_m.end(), outside)) /
             static_cast<double>(sizes_m.size());
    };
    const double small = share([](double m) { return m < kMinHeight; });
    const double large = share([](double m) { return m > kMaxHeight; });
    if (sizes_m.size() < kEnough || std::max(small, large) < kNearlyAll) {
      return SubjectScale();
    }
  }
  return SubjectScale::OfSize(Median(sizes_m));
}

// Whether a detection can be measured. Some detectors place all joints that
// were not found at one point; their distances are only noise.
bool HasExtent(const Detection& detection) {
  constexpr double kNoise_px = 10.0;  // upper bound of the detector's noise
  return CountFound(detection) > 1 &&
         DiagonalPx(BoxAround(detection.joints)) > kNoise_px;
}

// Two detections as one subject: its joints, and their median reprojection
// error as a share of the subject's size in the images.
struct Sighting {
  Pose3d pose;
  double off = std::numeric_limits<double>::infinity();
};

Sighting Together(const Camera& camera_a, const Detection& a,
                  const Camera& camera_b, const Detection& b) {
  constexpr double kAstray = 0.1;  // another subject, or a false detection
  TriangulationOptions options;
  options.min_angle_rad = 0.1;  // else depth is uncertain
  const double per_a = 0.5 / std::max(1.0, DiagonalPx(BoxAround(a.joints)));
  const double per_b = 0.5 / std::max(1.0, DiagonalPx(BoxAround(b.joints)));
  Sighting sighting;
  sighting.pose.resize(a.joints.size());
  std::vector<double> offs;
  for (size_t j = 0; j < a.joints.size(); ++j) {
    if (!a.joints[j].found || !b.joints[j].found) continue;
    const auto ideal_a = camera_a.Undistort(a.joints[j].px);
    const auto ideal_b = camera_b.Undistort(b.joints[j].px);
    if (!ideal_a.has_value() || !ideal_b.has_value()) continue;
    const PointMeasurement measurements[] = {{&camera_a, *ideal_a, 1.0},
                                             {&camera_b, *ideal_b, 1.0}};
    const TriangulationResult point =
        TriangulateDlt({measurements, 2}, options);
    if (!point.ok()) continue;
    const auto px_a = camera_a.Project(point.point_m);
    const auto px_b = camera_b.Project(point.point_m);
    if (!px_a.has_value() || !px_b.has_value()) continue;
    offs.push_back(per_a * (*px_a - a.joints[j].px).norm() +
                   per_b * (*px_b - b.joints[j].px).norm());
    if (offs.back() > kAstray) continue;
    sighting.pose[j] = {point.point_m, JointStatus::kObserved};
  }
  if (offs.size() > 1) sighting.off = Median(std::move(offs));
  return sighting;
}

// Extent of the cameras about their mean position [m]; 1 if they coincide.
double SpreadOf(const CameraRig& cameras) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) middle += camera.centre();
  middle /= static_cast<double>(std::max<size_t>(1, cameras.size()));
  double spread = 0.0;
  for (const Camera& camera : cameras) {
    spread = std::max(spread, (camera.centre() - middle).norm());
  }
  return spread > 0.0 ? spread : 1.0;
}

}  // namespace

std::optional<double> ObservedDistance(const Pose3d& pose, int a, int b) {
  if (a < 0 || b < 0) return std::nullopt;
  const Joint3d& from = pose[a];
  const Joint3d& to = pose[b];
  if (from.status != JointStatus::kObserved ||
      to.status != JointStatus::kObserved) {
    return std::nullopt;
  }
  return (from.position_m - to.position_m).norm();
}

double Limbs::ShareOf(size_t limb) {
  return limb < kSided ? kLimbs[limb / 2].share : kTrunkShare;
}

Limbs::Limbs(const Skeleton& skeleton) {
  if (!IsHuman(skeleton)) return;
  const auto joint = [&](bool left, const char* part) {
    return skeleton.IndexOf((left ? "l_" : "r_") + std::string(part));
  };
  hips_ = {joint(true, "hip"), joint(false, "hip")};
  shoulders_ = {joint(true, "shoulder"), joint(false, "shoulder")};
  for (size_t i = 0; i < kSided; ++i) {
    const bool left = i % 2 == 0;
    ends_[i] = {joint(left, kLimbs[i / 2].a), joint(left, kLimbs[i / 2].b)};
  }
}

std::array<std::optional<double>, Limbs::kCount> Limbs::LengthsOf(
    const Pose3d& pose) const {
  std::array<std::optional<double>, kCount> lengths_m;
  for (size_t i = 0; i < kSided; ++i) {
    lengths_m[i] = ObservedDistance(pose, ends_[i].a, ends_[i].b);
  }
  const auto hips = MiddleOfHips(pose);
  const auto shoulders = MiddleOf(pose, shoulders_.a, shoulders_.b);
  if (hips && shoulders) lengths_m[kSided] = (*hips - *shoulders).norm();
  return lengths_m;
}

std::optional<double> Limbs::HeightOf(const Pose3d& pose) const {
  double length_m = 0.0;
  double share = 0.0;
  const auto lengths_m = LengthsOf(pose);
  for (size_t i = 0; i < kCount; ++i) {
    if (!lengths_m[i]) continue;
    length_m += *lengths_m[i];
    share += ShareOf(i);
  }
  return share > kLeastShare ? std::optional<double>(length_m / share)
                             : std::nullopt;
}

std::optional<Eigen::Vector3d> Limbs::MiddleOfHips(const Pose3d& pose) const {
  return MiddleOf(pose, hips_.a, hips_.b);
}

SubjectGauge::SubjectGauge(CameraRig cameras, const Skeleton& detections,
                           double stated_m)
    : cameras_m_(SpreadOf(cameras)),
      cameras_(std::move(cameras)),
      stated_m_(stated_m),
      limbs_(detections),
      is_human_(IsHuman(detections)),
      // A point has no size, and one view cannot measure any.
      settled_(stated_m > 0.0 || detections.joint_count() < 2 ||
               cameras_.size() < 2) {
  // Triangulation depends slightly on the unit of the world.
  cameras_ = Rescaled(cameras_, 1.0 / cameras_m_);
}

void SubjectGauge::See(const DetectionFrame& frame) {
  if (settled_) return;
  const auto seeing = std::count_if(
      frame.views.begin(), frame.views.end(), [](const ViewDetections& view) {
        return std::any_of(view.detections.begin(), view.detections.end(),
                           HasExtent);
      });
  if (seeing < 2) return;
  const size_t before = sizes_m_.size();
  for (size_t a = 0; a < cameras_.size(); ++a) {
    for (size_t b = a + 1; b < cameras_.size(); ++b) SeePair(a, b, frame);
  }
  ++looks_;
  const auto first = sizes_m_.begin() + static_cast<std::ptrdiff_t>(before);
  const std::vector<double> now(first, sizes_m_.end());
  if (!now.empty()) ++measured_;
  // Fewer for people, so that a live stream does not wait long.
  const int enough = is_human_ ? 10 : 30;
  settled_ = measured_ >= enough || looks_ >= 3 * enough;
  if (is_human_ && !now.empty() && IsPerson(Median(now))) {
    sizes_m_.clear();
    settled_ = true;
  }
}

void SubjectGauge::SeePair(size_t a, size_t b, const DetectionFrame& frame) {
  // Of its size; different subjects differ by more.
  constexpr double kOne = 0.03;
  constexpr size_t kMostSeen = 8;  // in a view: more add no information
  const auto& seen_a = frame.views[a].detections;
  const auto& seen_b = frame.views[b].detections;
  for (size_t i = 0; i < std::min(seen_a.size(), kMostSeen); ++i) {
    if (!HasExtent(seen_a[i])) continue;
    Sighting best;
    for (size_t k = 0; k < std::min(seen_b.size(), kMostSeen); ++k) {
      if (!HasExtent(seen_b[k])) continue;
      Sighting one = Together(cameras_[a], seen_a[i], cameras_[b], seen_b[k]);
      if (one.off < best.off) best = std::move(one);
    }
    if (!(best.off < kOne)) continue;
    const auto size = SizeOf(best.pose, limbs_, is_human_);
    if (!size.has_value()) continue;
    const double size_m = cameras_m_ * *size;
    if (size_m > 0.0 && std::isfinite(size_m)) sizes_m_.push_back(size_m);
  }
}

SubjectScale SubjectGauge::Scale() const {
  if (stated_m_ > 0.0) {
    return is_human_ && IsPerson(stated_m_) ? SubjectScale()
                                            : SubjectScale::OfSize(stated_m_);
  }
  return ScaleOfSizes(sizes_m_, is_human_);
}

SubjectScale ScaleOf(const RunOptions& options, const CameraRig& cameras,
                     const DetectionSequence& detections) {
  SubjectGauge gauge(cameras, detections.header.skeleton, options.subject_m);
  for (const DetectionFrame& frame : detections.frames) {
    if (gauge.is_settled()) break;
    gauge.See(frame);
  }
  return gauge.Scale();
}

SubjectScale ScaleOf(const TrackSequence& tracks) {
  const Limbs limbs(tracks.header.skeleton);
  const bool is_human = IsHuman(tracks.header.skeleton);
  std::vector<double> sizes_m;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      const auto size = SizeOf(person.joints, limbs, is_human);
      if (size.has_value()) sizes_m.push_back(*size);
    }
  }
  return ScaleOfSizes(sizes_m, is_human);
}

}  // namespace kinegraph
