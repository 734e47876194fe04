#include "solvers/rig/tracklets.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/median.h"
#include "core/skeleton/body_joints.h"
#include "solvers/scene/plausible.h"

namespace kinegraph {
namespace {

constexpr double kGapS = 0.4;    // that a tracklet bridges, or
constexpr int kGapFrames = 4;    // so many frames where they are rare
constexpr double kLeastS = 1.0;  // of a tracklet
constexpr int kLeastDetections = 10;
constexpr int kLeastJoints = 4;
// How far the joints are from the last ones, in sizes of the person: at rest,
// and per second since.
constexpr double kGate = 0.1;
constexpr double kGatePerSecond = 2.0;
// Whoever is alone in the view may be so many times as far.
constexpr double kAlone = 4.0;
// Another one that is less than this many times as far may be meant as well.
constexpr double kClearly = 2.0;

NormalisedJoints Normalised(const Camera& camera, const Detection& detection,
                            const std::vector<int>& joints) {
  NormalisedJoints points(2, static_cast<Eigen::Index>(joints.size()));
  points.setConstant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::Matrix2d inverse = camera.K().topLeftCorner<2, 2>().inverse();
  for (size_t j = 0; j < joints.size(); ++j) {
    const Keypoint& joint = detection.joints[joints[j]];
    if (!joint.found || joint.confidence < kMinJointConfidence) continue;
    const auto ideal = camera.Undistort(joint.px);
    if (!ideal.has_value()) continue;
    points.col(static_cast<Eigen::Index>(j)) =
        inverse * (*ideal - camera.K().block<2, 1>(0, 2));
  }
  return points;
}

int CountFound(const NormalisedJoints& points) {
  int found = 0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    found += points.col(j).allFinite() ? 1 : 0;
  }
  return found;
}

double SizeOf(const NormalisedJoints& points) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e30);
  Eigen::Vector2d high = -low;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    if (!points.col(j).allFinite()) continue;
    low = low.cwiseMin(points.col(j));
    high = high.cwiseMax(points.col(j));
  }
  return (high - low).norm();
}

// Median distance of common joints; infinite where there are too few.
double DistanceOf(const NormalisedJoints& a, const NormalisedJoints& b) {
  std::vector<double> distances;
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    const double distance = (a.col(j) - b.col(j)).norm();
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  if (distances.size() < 3) return std::numeric_limits<double>::infinity();
  return Median(std::move(distances));
}

// Whom a detector found twice is there once: the one of more joints.
void DropFoundTwice(std::vector<std::pair<int, NormalisedJoints>>* people) {
  constexpr double kSame = 0.05;  // of the person's size
  std::stable_sort(people->begin(), people->end(),
                   [](const auto& a, const auto& b) {
                     return CountFound(a.second) > CountFound(b.second);
                   });
  std::vector<std::pair<int, NormalisedJoints>> kept;
  for (auto& person : *people) {
    const bool again =
        std::any_of(kept.begin(), kept.end(), [&](const auto& other) {
          return DistanceOf(person.second, other.second) <
                 kSame * SizeOf(other.second);
        });
    if (!again) kept.push_back(std::move(person));
  }
  *people = std::move(kept);
}

struct OpenTracklet {
  ViewTracklet tracklet;
  NormalisedJoints last;
  TimeNs time = 0;
  double size = 0.0;  // of the last
};

// One view's tracklets.
class Follower {
 public:
  Follower(int view, std::vector<ViewTracklet>* done)
      : view_(view), done_(done) {}

  void See(int frame, TimeNs time,
           const std::vector<std::pair<int, NormalisedJoints>>& people) {
    for (size_t s = open_.size(); s-- > 0;) {
      if (ToSeconds(time - open_[s].time) > kGapS &&
          frame - open_[s].tracklet.end() >= kGapFrames) {
        Close(s);
      }
    }
    // Who goes on with what: [person], -1 nobody.
    const size_t count = open_.size();
    Eigen::MatrixXd distance(people.size(), count);
    for (size_t p = 0; p < people.size(); ++p) {
      for (size_t s = 0; s < count; ++s) {
        const double gate =
            (people.size() == 1 && count == 1 ? kAlone : 1.0) * open_[s].size *
            (kGate + kGatePerSecond * ToSeconds(time - open_[s].time));
        const double d = DistanceOf(people[p].second, open_[s].last);
        distance(p, s) = d <= gate * kClearly
                             ? d / gate
                             : std::numeric_limits<double>::infinity();
      }
    }
    std::vector<char> unclear(count, 0);
    std::vector<int> goes_on(people.size(), -1);
    for (size_t p = 0; p < people.size(); ++p) {
      for (size_t s = 0; s < count; ++s) {
        if (distance(p, s) > 1.0) continue;
        if (IsClear(distance, p, s)) {
          goes_on[p] = static_cast<int>(s);
        } else {
          unclear[s] = 1;
        }
      }
    }
    for (size_t p = 0; p < people.size(); ++p) {
      Add(frame, time, goes_on[p], people[p]);
    }
    for (size_t s = count; s-- > 0;) {
      if (unclear[s] && open_[s].time < time) Close(s);
    }
  }

  void Finish() {
    while (!open_.empty()) Close(open_.size() - 1);
  }

 private:
  static bool IsClear(const Eigen::MatrixXd& distance, size_t person,
                      size_t tracklet) {
    const double own = distance(person, tracklet);
    for (Eigen::Index s = 0; s < distance.cols(); ++s) {
      if (s != static_cast<Eigen::Index>(tracklet) &&
          distance(person, s) < kClearly * own) {
        return false;
      }
    }
    for (Eigen::Index p = 0; p < distance.rows(); ++p) {
      if (p != static_cast<Eigen::Index>(person) &&
          distance(p, tracklet) < kClearly * own) {
        return false;
      }
    }
    return true;
  }

  void Add(int frame, TimeNs time, int goes_on,
           const std::pair<int, NormalisedJoints>& person) {
    if (goes_on < 0) {
      goes_on = static_cast<int>(open_.size());
      open_.emplace_back();
      open_.back().tracklet.view = view_;
      open_.back().tracklet.first = frame;
    }
    OpenTracklet& open = open_[goes_on];
    const auto length = static_cast<size_t>(frame - open.tracklet.first) + 1;
    open.tracklet.detections.resize(length, -1);
    open.tracklet.joints.resize(length);
    open.tracklet.detections.back() = person.first;
    open.tracklet.joints.back() = person.second;
    open.last = person.second;
    open.time = time;
    open.size = SizeOf(person.second);
  }

  void Close(size_t index) {
    ViewTracklet& tracklet = open_[index].tracklet;
    std::vector<double> sizes;
    for (const NormalisedJoints& joints : tracklet.joints) {
      if (joints.size() > 0) sizes.push_back(SizeOf(joints));
    }
    if (sizes.size() >= kLeastDetections) {
      tracklet.size = Median(std::move(sizes));
      done_->push_back(std::move(tracklet));
    }
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(index));
  }

  int view_;
  std::vector<ViewTracklet>* done_;
  std::vector<OpenTracklet> open_;
};

}  // namespace

std::vector<int> RigJoints(const Skeleton& skeleton) {
  std::vector<int> joints;
  for (int j = 0; IsHuman(skeleton) && j < skeleton.joint_count(); ++j) {
    if (IsBodyJoint(skeleton.joint_class(j))) joints.push_back(j);
  }
  return joints.empty() ? skeleton.association_joints() : joints;
}

std::vector<ViewTracklet> FollowInViews(const CameraRig& cameras,
                                        const DetectionSequence& detections,
                                        const std::vector<int>& joints) {
  std::vector<ViewTracklet> tracklets;
  for (size_t v = 0; v < cameras.size(); ++v) {
    Follower follower(static_cast<int>(v), &tracklets);
    for (size_t k = 0; k < detections.frames.size(); ++k) {
      const DetectionFrame& frame = detections.frames[k];
      std::vector<std::pair<int, NormalisedJoints>> people;
      const auto& found = frame.views[v].detections;
      for (size_t d = 0; d < found.size(); ++d) {
        NormalisedJoints points = Normalised(cameras[v], found[d], joints);
        if (CountFound(points) < kLeastJoints) continue;
        people.emplace_back(static_cast<int>(d), std::move(points));
      }
      DropFoundTwice(&people);
      follower.See(static_cast<int>(k), frame.time, people);
    }
    follower.Finish();
  }
  const auto is_short = [&](const ViewTracklet& tracklet) {
    const auto& frames = detections.frames;
    return ToSeconds(frames[tracklet.end() - 1].time -
                     frames[tracklet.first].time) < kLeastS;
  };
  tracklets.erase(std::remove_if(tracklets.begin(), tracklets.end(), is_short),
                  tracklets.end());
  return tracklets;
}

}  // namespace kinegraph
