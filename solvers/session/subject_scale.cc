#include "solvers/session/subject_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/evaluation/statistics.h"
#include "core/geometry/triangulation.h"
#include "core/skeleton/body_joints.h"
#include "solvers/cameras/refine.h"
#include "solvers/session/subject_gauge.h"

namespace kinegraph {
namespace {

// From infants to the tallest, with what two views make of them.
constexpr double kLeastPerson_m = 0.5;
constexpr double kMostPerson_m = 2.3;

bool IsPerson(double size_m) {
  return size_m >= kLeastPerson_m && size_m <= kMostPerson_m;
}

// How large what was seen is [m]: the stature of a human, of others the extent,
// which nine of ten distances between joints stay below, so that one joint gone
// astray does not count. Of a human's joints 1.3 m in 1.7 m of stature.
std::optional<double> SizeOf(const Pose3d& pose, const Limbs& limbs,
                             bool is_human) {
  if (is_human) return limbs.HeightOf(pose);
  constexpr double kSizeOfExtent = kPersonSize_m / 1.3;
  std::vector<double> distances;
  for (size_t i = 0; i < pose.size(); ++i) {
    for (size_t k = i + 1; k < pose.size(); ++k) {
      if (pose[i].status != JointStatus::kObserved ||
          pose[k].status != JointStatus::kObserved) {
        continue;
      }
      distances.push_back((pose[i].position_m - pose[k].position_m).norm());
    }
  }
  if (distances.empty()) return std::nullopt;
  const double extent = Quantile(std::move(distances), 0.9);
  return extent > 0.0 ? std::optional<double>(kSizeOfExtent * extent)
                      : std::nullopt;
}

// People keep their size unless nearly all looks say that they are none.
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
    const double small = share([](double m) { return m < kLeastPerson_m; });
    const double large = share([](double m) { return m > kMostPerson_m; });
    if (sizes_m.size() < kEnough || std::max(small, large) < kNearlyAll) {
      return SubjectScale();
    }
  }
  return SubjectScale::OfSize(Median(sizes_m));
}

int FoundJoints(const Detection& detection) {
  return static_cast<int>(
      std::count_if(detection.joints.begin(), detection.joints.end(),
                    [](const Keypoint& joint) { return joint.found; }));
}

double DiagonalOf(const Detection& detection) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const Keypoint& joint : detection.joints) {
    if (!joint.found) continue;
    low = low.cwiseMin(joint.px);
    high = high.cwiseMax(joint.px);
  }
  return std::max(1.0, (high - low).norm());
}

// Two detections as one subject: its joints, and how far they miss what was
// seen, in the median, as a share of the subject's size in the images.
struct Sighting {
  Pose3d pose;
  double off = std::numeric_limits<double>::infinity();
};

Sighting Together(const Camera& camera_a, const Detection& a,
                  const Camera& camera_b, const Detection& b) {
  constexpr double kAstray = 0.1;  // another subject's, or a false one
  TriangulationOptions options;
  options.min_angle_rad = 0.1;  // else depth is a guess
  const double per_a = 0.5 / DiagonalOf(a);
  const double per_b = 0.5 / DiagonalOf(b);
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

void ScaleCentres(double factor, CameraRig* cameras) {
  if (factor == 1.0) return;
  for (Camera& camera : *cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.t *= factor;
    camera = Camera(std::move(parameters));
  }
}

// How far cameras stand from their middle [m]; 1 where they stand in one place.
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

ViewBias ScaledBias(double factor, ViewBias bias) {
  for (ViewBias::OfJoint& joint : bias.joints) {
    for (double& m : joint.across_m) m *= factor;
    for (double& m : joint.along_m) m *= factor;
  }
  return bias;
}

}  // namespace

SubjectScale SubjectScale::OfSize(double size_m) {
  SubjectScale scale;
  scale.metres_ = size_m / kPersonSize_m;
  return scale;
}

double SubjectScale::size_m() const { return kPersonSize_m * metres_; }

CameraRig SubjectScale::IntoRun(CameraRig cameras) const {
  ScaleCentres(1.0 / metres_, &cameras);
  return cameras;
}

CameraRig SubjectScale::IntoWorld(CameraRig cameras) const {
  ScaleCentres(metres_, &cameras);
  return cameras;
}

RunOptions SubjectScale::IntoRun(RunOptions options) const {
  if (is_one()) return options;
  options.tracker.gates.working_distance_m /= metres_;
  for (double& m : options.identity.entries) m /= metres_;
  std::shared_ptr<const ViewBias>& given =
      options.estimators.graph.given_view_bias;
  if (given != nullptr) {
    given = std::make_shared<ViewBias>(ScaledBias(1 / metres_, *given));
  }
  return options;
}

TrackFrame SubjectScale::Times(double factor, TrackFrame frame) {
  if (factor == 1.0) return frame;
  for (PersonPose& person : frame.people) {
    for (Joint3d& joint : person.joints) joint.position_m *= factor;
    for (auto& covariance : person.covariances) {
      if (covariance.has_value()) *covariance *= factor * factor;
    }
  }
  return frame;
}

LearntNoise SubjectScale::IntoWorld(LearntNoise noise) const {
  const double squared = metres_ * metres_;
  for (LearntNoise::OfClass& of_class : noise.classes) {
    of_class.sigma_px *= metres_;  // at a distance in metres
    of_class.process_noise *= squared;
    of_class.least_process_noise *= squared;
    of_class.greatest_process_noise *= squared;
  }
  return noise;
}

ViewBias SubjectScale::IntoWorld(ViewBias bias) const {
  return ScaledBias(metres_, std::move(bias));
}

void SubjectScale::IntoWorld(Refinement* refinement) const {
  if (is_one()) return;
  for (auto* changes : {&refinement->changes, &refinement->sigmas}) {
    for (CameraChange& change : *changes) {
      change.segment<3>(kCentreAt) *= metres_;
    }
  }
  if (refinement->covariance.size() == 0) return;
  Eigen::Index at = 0;
  for (const std::vector<int>& places : refinement->places) {
    for (const int place : places) {
      if (place >= kCentreAt && place < kCentreAt + 3) {
        refinement->covariance.row(at) *= metres_;
        refinement->covariance.col(at) *= metres_;
      }
      ++at;
    }
  }
}

SubjectGauge::SubjectGauge(CameraRig cameras, const Skeleton& detections,
                           double stated_m)
    : cameras_m_(SpreadOf(cameras)),
      cameras_(std::move(cameras)),
      stated_m_(stated_m),
      limbs_(detections),
      is_human_(IsHuman(detections)),
      // A point has no size, and one view measures none.
      settled_(stated_m > 0.0 || detections.joint_count() < 2 ||
               cameras_.size() < 2) {
  // What is triangulated depends a little on the unit of the world.
  ScaleCentres(1.0 / cameras_m_, &cameras_);
}

void SubjectGauge::See(const DetectionFrame& frame) {
  if (settled_) return;
  const auto seeing = std::count_if(
      frame.views.begin(), frame.views.end(), [](const ViewDetections& view) {
        return std::any_of(
            view.detections.begin(), view.detections.end(),
            [](const Detection& one) { return FoundJoints(one) > 1; });
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
  // A stream of people is not kept waiting.
  const int enough = is_human_ ? 10 : 30;
  settled_ = measured_ >= enough || looks_ >= 3 * enough;
  if (is_human_ && !now.empty() && IsPerson(Median(now))) {
    sizes_m_.clear();
    settled_ = true;
  }
}

void SubjectGauge::SeePair(size_t a, size_t b, const DetectionFrame& frame) {
  constexpr double kOne = 0.03;    // of its size; two subjects miss by more
  constexpr size_t kMostSeen = 8;  // of a view: more tell no more
  const auto& seen_a = frame.views[a].detections;
  const auto& seen_b = frame.views[b].detections;
  for (size_t i = 0; i < std::min(seen_a.size(), kMostSeen); ++i) {
    if (FoundJoints(seen_a[i]) < 2) continue;
    Sighting best;
    for (size_t k = 0; k < std::min(seen_b.size(), kMostSeen); ++k) {
      if (FoundJoints(seen_b[k]) < 2) continue;
      Sighting one = Together(cameras_[a], seen_a[i], cameras_[b], seen_b[k]);
      if (one.off < best.off) best = std::move(one);
    }
    if (!(best.off < kOne)) continue;
    const auto size = SizeOf(best.pose, limbs_, is_human_);
    if (size.has_value()) sizes_m_.push_back(cameras_m_ * *size);
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
