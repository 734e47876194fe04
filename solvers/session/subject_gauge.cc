#include "solvers/session/subject_gauge.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/data/box.h"
#include "core/skeleton/anthropometry.h"
#include "core/skeleton/body_joints.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/view_agreement.h"

namespace kinegraph {
namespace {

// Limbs and their length relative to the stature.
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

// Size of a subject [m]: the stature of a human. For other subjects, the median
// distance of joints is multiplied by the ratio that holds for humans, whose
// joints are 0.55 m apart at a stature of 1.7 m. The median over joints hardly
// depends on points that are not part of the body. The size of a few points,
// such as the corners of a box, is their distance.
std::optional<double> SizeOf(const Pose3d& pose, const Limbs& limbs,
                             bool is_human) {
  if (is_human) return limbs.HeightOf(pose);
  constexpr size_t kFewPoints = 4;
  const double of_distance =
      pose.size() <= kFewPoints ? 1.0 : kPersonSize_m / 0.55;
  std::vector<double> usual_m;
  for (size_t i = 0; i < pose.size(); ++i) {
    std::vector<double> distances_m;
    for (size_t k = 0; k < pose.size(); ++k) {
      const auto distance_m =
          ObservedDistance(pose, static_cast<int>(i), static_cast<int>(k));
      if (k != i && distance_m) distances_m.push_back(*distance_m);
    }
    if (!distances_m.empty()) usual_m.push_back(Median(distances_m));
  }
  if (usual_m.empty()) return std::nullopt;
  return of_distance * Median(usual_m);
}

// Adds the size of a subject, if known. `metres`: per unit of the pose.
void AddSize(const Pose3d& pose, const Limbs& limbs, bool is_human,
             double metres, std::vector<double>* sizes_m) {
  const double size_m = metres * SizeOf(pose, limbs, is_human).value_or(0.0);
  if (size_m > 0.0 && std::isfinite(size_m)) sizes_m->push_back(size_m);
}

// The scale of humans is 1 unless at least ten sizes are measured and their
// median is impossible.
SubjectScale ScaleOfSizes(std::vector<double> sizes_m, bool is_human) {
  constexpr size_t kEnough = 10;
  if (sizes_m.size() < (is_human ? kEnough : 1)) return SubjectScale();
  const double size_m = Median(std::move(sizes_m));
  if (is_human && IsStature(size_m)) return SubjectScale();
  return SubjectScale::OfSize(size_m);
}

// Whether a detection can be measured. Some detectors place all joints that
// were not found at one point; the distances between these are only noise.
bool HasExtent(const Detection& detection) {
  constexpr double kNoise_px = 10.0;  // upper bound of the detector's noise
  return CountFound(detection) > 1 &&
         DiagonalPx(BoxAround(detection.joints)) > kNoise_px;
}

// The greatest distance of a camera from the first [m]; 1 if all coincide.
double SpreadOf(const CameraRig& cameras) {
  double spread = 0.0;
  for (const Camera& camera : cameras) {
    spread =
        std::max(spread, (camera.centre() - cameras.front().centre()).norm());
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

std::optional<Eigen::Vector3d> ObservedMiddle(const Pose3d& pose, int a,
                                              int b) {
  if (!ObservedDistance(pose, a, b)) return std::nullopt;
  return 0.5 * (pose[a].position_m + pose[b].position_m);
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
  const auto shoulders = ObservedMiddle(pose, shoulders_.a, shoulders_.b);
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
  return ObservedMiddle(pose, hips_.a, hips_.b);
}

SubjectGauge::SubjectGauge(CameraRig cameras, const Skeleton& detections,
                           double stated_m)
    : cameras_m_(SpreadOf(cameras)),
      // Triangulation depends slightly on the unit of the world.
      cameras_(Rescaled(cameras, 1.0 / cameras_m_)),
      stated_m_(stated_m),
      limbs_(detections),
      is_human_(IsHuman(detections)),
      // A point has no size, and one view cannot measure any.
      settled_(stated_m > 0.0 || detections.joint_count() < 2 ||
               cameras_.size() < 2) {
  header_.skeleton = detections;
  header_.view_names.resize(cameras_.size());
}

void SubjectGauge::See(const DetectionFrame& frame) {
  if (settled_) return;
  constexpr int kEnough = 10;
  constexpr double kLongestWait_s = 10.0;
  if (has_begun() && ++waited_ >= 3 * kEnough &&
      ToSeconds(frame.time - begun_) > kLongestWait_s) {
    settled_ = is_human_ || measured_ > 0;
    looks_ = waited_ = 0;
    return;
  }
  DetectionSequence seen = {header_, {frame}};
  int seeing = 0;
  for (ViewDetections& view : seen.frames[0].views) {
    auto& all = view.detections;
    all.erase(
        std::remove_if(all.begin(), all.end(),
                       [](const Detection& one) { return !HasExtent(one); }),
        all.end());
    seeing += all.empty() ? 0 : 1;
  }
  if (seeing < 2) return;
  seen = WithUsualConfidences(std::move(seen));
  const std::vector<int>& joints = header_.skeleton.association_joints();
  std::vector<double> now_m;
  for (const PlacedPerson& placed :
       PlacePeople(cameras_, IdealPeople(seen, cameras_), {0})) {
    Pose3d pose(header_.skeleton.joint_count());
    for (size_t j = 0; j < joints.size(); ++j) {
      if (!placed.joints[j]) continue;
      pose[joints[j]] = {*placed.joints[j], JointStatus::kObserved};
    }
    AddSize(pose, limbs_, is_human_, cameras_m_, &now_m);
  }
  if (looks_++ == 0) begun_ = frame.time;
  measured_ += now_m.empty() ? 0 : 1;
  settled_ = measured_ >= kEnough || looks_ >= 3 * kEnough;
  if (is_human_ && !now_m.empty() && IsStature(Median(now_m))) {
    sizes_m_.clear();
    settled_ = true;
    return;
  }
  sizes_m_.insert(sizes_m_.end(), now_m.begin(), now_m.end());
}

SubjectScale SubjectGauge::Scale() const {
  if (stated_m_ > 0.0) {
    return is_human_ && IsStature(stated_m_) ? SubjectScale()
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
      AddSize(person.joints, limbs, is_human, 1.0, &sizes_m);
    }
  }
  return ScaleOfSizes(std::move(sizes_m), is_human);
}

}  // namespace kinegraph
