#include "core/association/all_view_matching.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/association/options.h"

namespace kinegraph {
namespace {

// Standard deviations of the expected position and of the expected velocity,
// which is measured from two such positions.
constexpr double kPositionSigma = 0.1;  // m
constexpr double kVelocitySigma = 0.5;  // m/s
// A detected point may be anywhere within the body's outline, which is half a
// metre wide: the standard deviation of a uniform distribution of that width.
constexpr double kBodySigma = 0.15;  // m
// Probability that a detected joint is misplaced, and the same for a joint that
// another person hides.
constexpr double kMisplaced = 0.05;
constexpr double kHiddenMisplaced = 0.5;
// Width of the region in which a misplaced joint, or a joint of another person,
// may lie: the height of a person.
constexpr double kElsewhere = 2.0;  // m
// Half of a body's width: in the image a person hides whatever lies behind them
// within this distance of their joints.
constexpr double kHalfWidth = 0.25;  // m
// Odds that a view detects a person in its image.
constexpr double kSeenOdds = 3.0;
// A detection is not considered if all of its joints are farther than this from
// the expected ones.
constexpr double kFarSigmas = 6.0;
// Hypotheses kept of one person with equally many detections.
constexpr size_t kMostHypotheses = 30;
constexpr double kLeastImprovement = 1e-9;  // nats

// The part of an image that a person covers; empty if behind the camera.
struct Outline {
  Eigen::AlignedBox2d box;
  double depth_m = 0.0;
};

Outline OutlineOf(const Pose3d& pose, const std::vector<int>& joints,
                  const Camera& camera) {
  Outline outline;
  const std::optional<Eigen::Vector3d> centre = MeanPosition(pose);
  if (!centre.has_value()) return outline;
  outline.depth_m = camera.Depth(*centre);
  if (!(outline.depth_m > 0.0)) return outline;
  const Eigen::Vector2d half_px = Eigen::Vector2d::Constant(
      kHalfWidth * camera.focal_px() / outline.depth_m);
  for (const int j : joints) {
    if (!pose[j].present()) continue;
    const auto px = camera.Project(pose[j].position_m);
    if (!px.has_value()) continue;
    outline.box.extend(*px - half_px);
    outline.box.extend(*px + half_px);
  }
  return outline;
}

}  // namespace

double ExpectedSigma(double age_s) {
  return std::hypot(kPositionSigma, kVelocitySigma * age_s);
}

bool AllViewMatcher::AppliesTo(const Skeleton& skeleton) {
  return static_cast<double>(skeleton.association_joints().size()) <
         kFewestJoints;
}

bool AllViewMatcher::GainsMore(const Hypothesis& a, const Hypothesis& b) {
  return a.gain > b.gain;
}

AllViewMatcher::AllViewMatcher(const CameraRig& cameras,
                               std::vector<int> joints, double detector_px)
    : cameras_(&cameras),
      joints_(std::move(joints)),
      detector_px_(detector_px) {}

bool AllViewMatcher::IsNear(const ExpectedPerson& expected, size_t view,
                            const Observation& observation) const {
  const Camera& camera = (*cameras_)[view];
  return std::any_of(joints_.begin(), joints_.end(), [&](int j) {
    const Joint3d& joint = (*expected.pose)[j];
    if (!joint.present() || !observation.joints[j].found) return false;
    const double detector_m =
        detector_px_ * camera.Depth(joint.position_m) / camera.focal_px();
    return DistanceToRay(camera, observation.ideal_px[j], joint.position_m) <
           kFarSigmas *
               std::hypot(expected.sigma_m, std::hypot(kBodySigma, detector_m));
  });
}

bool AllViewMatcher::Extend(const Pose3d& expected, size_t view, int detection,
                            Span<Observation> observations,
                            Hypothesis* hypothesis) const {
  const Camera& camera = (*cameras_)[view];
  const Observation& observation = observations[detection];
  // A priori each detection of the view is equally likely to show the person.
  double gain = std::log(kSeenOdds / static_cast<double>(observations.size()));
  bool any = false;
  for (const int j : joints_) {
    if (!expected[j].present() || !observation.joints[j].found) continue;
    // Distances from the ray on two axes perpendicular to it.
    const Eigen::Vector3d from_camera =
        expected[j].position_m + hypothesis->shift_m - camera.centre();
    const Eigen::Vector3d ray = camera.RayDirection(observation.ideal_px[j]);
    const double depth_m = camera.Depth(camera.centre() + from_camera);
    if (!(depth_m > 0.0)) return false;
    const Eigen::Vector3d one = ray.unitOrthogonal();
    Eigen::Matrix<double, 2, 3> across;
    across.row(0) = one.transpose();
    across.row(1) = ray.cross(one).transpose();
    const Eigen::Vector2d residual_m = -(across * from_camera);
    const double sigma_m =
        std::hypot(kBodySigma, detector_px_ * depth_m / camera.focal_px());
    const Eigen::Matrix<double, 3, 2> to_residual =
        hypothesis->covariance_m2 * across.transpose();
    const Eigen::Matrix2d variance =
        across * to_residual + sigma_m * sigma_m * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d information = variance.inverse();
    const double wrong =
        hidden_[view][hypothesis->person][j] ? kHiddenMisplaced : kMisplaced;
    const double placed =
        std::log((1.0 - wrong) * kElsewhere * kElsewhere / (2.0 * M_PI)) -
        0.5 * (residual_m.dot(information * residual_m) +
               std::log(variance.determinant()));
    const double misplaced = std::log(wrong);
    gain += std::max(placed, misplaced);
    if (!(placed > misplaced)) continue;
    any = true;
    const Eigen::Matrix<double, 3, 2> weight = to_residual * information;
    hypothesis->shift_m += weight * residual_m;
    hypothesis->covariance_m2 -= weight * to_residual.transpose();
  }
  hypothesis->gain += gain;
  hypothesis->detections[view] = detection;
  return any && gain > 0.0;
}

void AllViewMatcher::Explain(size_t person, const ExpectedPerson& expected,
                             const std::vector<Span<Observation>>& views,
                             const std::vector<std::vector<char>>& barred) {
  Hypothesis unseen;
  unseen.person = person;
  unseen.detections.assign(views.size(), -1);
  unseen.covariance_m2 =
      expected.sigma_m * expected.sigma_m * Eigen::Matrix3d::Identity();
  open_.assign(1, unseen);
  near_.resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    const size_t count = views[v].size();
    near_[v].clear();
    for (size_t k = 0; k < count; ++k) {
      if (!barred[v].empty() && barred[v][person * count + k]) continue;
      if (IsNear(expected, v, views[v][k])) {
        near_[v].push_back(static_cast<int>(k));
      }
    }
  }
  // Each round extends each hypothesis by one view, in all possible ways. The
  // same detections can be reached in several orders, of which the one with the
  // greatest gain is kept.
  for (size_t round = 0; round < views.size() && !open_.empty(); ++round) {
    longer_.clear();
    for (const Hypothesis& one : open_) {
      for (size_t v = 0; v < views.size(); ++v) {
        if (one.detections[v] >= 0) continue;
        for (const int k : near_[v]) {
          Hypothesis extended = one;
          if (Extend(*expected.pose, v, k, views[v], &extended)) {
            longer_.push_back(std::move(extended));
          }
        }
      }
    }
    std::sort(longer_.begin(), longer_.end(),
              [](const Hypothesis& a, const Hypothesis& b) {
                return a.detections != b.detections
                           ? a.detections < b.detections
                           : a.gain > b.gain;
              });
    longer_.erase(std::unique(longer_.begin(), longer_.end(),
                              [](const Hypothesis& a, const Hypothesis& b) {
                                return a.detections == b.detections;
                              }),
                  longer_.end());
    std::stable_sort(longer_.begin(), longer_.end(), GainsMore);
    if (longer_.size() > kMostHypotheses) longer_.resize(kMostHypotheses);
    std::swap(open_, longer_);
    all_.insert(all_.end(), open_.begin(), open_.end());
  }
}

// A joint is hidden in a view where it is expected within the outline of a
// person nearer to the camera.
void AllViewMatcher::FindHidden(Span<ExpectedPerson> people) {
  hidden_.resize(cameras_->size());
  std::vector<Outline> outlines;
  for (size_t v = 0; v < cameras_->size(); ++v) {
    const Camera& camera = (*cameras_)[v];
    outlines.clear();
    for (const ExpectedPerson& person : people) {
      outlines.push_back(OutlineOf(*person.pose, joints_, camera));
    }
    hidden_[v].resize(people.size());
    for (size_t p = 0; p < people.size(); ++p) {
      const Pose3d& pose = *people[p].pose;
      hidden_[v][p].assign(pose.size(), 0);
      for (const int j : joints_) {
        if (!pose[j].present()) continue;
        const auto px = camera.Project(pose[j].position_m);
        if (!px.has_value()) continue;
        hidden_[v][p][j] = std::any_of(
            outlines.begin(), outlines.end(), [&](const Outline& other) {
              return other.depth_m < outlines[p].depth_m &&
                     other.box.contains(*px);
            });
      }
    }
  }
}

void AllViewMatcher::Match(Span<ExpectedPerson> people,
                           const std::vector<Span<Observation>>& views,
                           const std::vector<std::vector<char>>& barred,
                           std::vector<std::vector<int>>* matches) {
  matches->resize(views.size());
  for (size_t v = 0; v < views.size(); ++v) {
    (*matches)[v].assign(people.size(), -1);
  }
  all_.clear();
  FindHidden(people);
  for (size_t p = 0; p < people.size(); ++p) {
    Explain(p, people[p], views, barred);
  }
  std::stable_sort(all_.begin(), all_.end(), GainsMore);
  Choose(people.size(), views);
  for (size_t p = 0; p < people.size(); ++p) {
    if (chosen_[p] < 0) continue;
    const Hypothesis& one = all_[chosen_[p]];
    for (size_t v = 0; v < views.size(); ++v) {
      (*matches)[v][p] = one.detections[v];
    }
  }
}

bool AllViewMatcher::IsFree(const Hypothesis& one) const {
  for (size_t v = 0; v < one.detections.size(); ++v) {
    const int k = one.detections[v];
    if (k >= 0 && owner_[v][k] >= 0) return false;
  }
  return true;
}

void AllViewMatcher::Take(int hypothesis) {
  const Hypothesis& one = all_[hypothesis];
  chosen_[one.person] = hypothesis;
  for (size_t v = 0; v < one.detections.size(); ++v) {
    const int k = one.detections[v];
    if (k >= 0) owner_[v][k] = static_cast<int>(one.person);
  }
}

double AllViewMatcher::Release(size_t person) {
  if (chosen_[person] < 0) return 0.0;
  const Hypothesis& one = all_[chosen_[person]];
  chosen_[person] = -1;
  for (size_t v = 0; v < one.detections.size(); ++v) {
    const int k = one.detections[v];
    if (k >= 0) owner_[v][k] = -1;
  }
  return one.gain;
}

double AllViewMatcher::TakeBestFree(size_t person) {
  for (size_t h = 0; h < all_.size(); ++h) {
    if (all_[h].person != person || !IsFree(all_[h])) continue;
    Take(static_cast<int>(h));
    return all_[h].gain;
  }
  return 0.0;
}

bool AllViewMatcher::Improve(int hypothesis) {
  const Hypothesis& one = all_[hypothesis];
  if (chosen_[one.person] == hypothesis) return false;
  const std::vector<int> before = chosen_;
  double lost = Release(one.person);
  std::vector<size_t> others;
  for (size_t v = 0; v < one.detections.size(); ++v) {
    const int k = one.detections[v];
    if (k < 0) continue;
    const int owner = owner_[v][k];
    if (owner < 0) continue;
    others.push_back(static_cast<size_t>(owner));
    lost += Release(others.back());
  }
  std::sort(others.begin(), others.end());
  Take(hypothesis);
  double won = one.gain;
  for (const size_t other : others) won += TakeBestFree(other);
  if (won > lost + kLeastImprovement) return true;
  for (const size_t other : others) Release(other);
  Release(one.person);
  for (const size_t other : others) {
    if (before[other] >= 0) Take(before[other]);
  }
  if (before[one.person] >= 0) Take(before[one.person]);
  return false;
}

void AllViewMatcher::Choose(size_t people,
                            const std::vector<Span<Observation>>& views) {
  chosen_.assign(people, -1);
  owner_.assign(views.size(), {});
  for (size_t v = 0; v < views.size(); ++v) {
    owner_[v].assign(views[v].size(), -1);
  }
  for (size_t h = 0; h < all_.size(); ++h) {
    if (chosen_[all_[h].person] < 0 && IsFree(all_[h])) {
      Take(static_cast<int>(h));
    }
  }
  // Terminates because every change raises the total gain.
  for (bool improved = true; improved;) {
    improved = false;
    for (size_t h = 0; h < all_.size(); ++h) {
      improved = Improve(static_cast<int>(h)) || improved;
    }
  }
}

}  // namespace kinegraph
