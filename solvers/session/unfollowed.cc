#include "solvers/session/unfollowed.h"

#include <algorithm>
#include <utility>

#include "core/base/median.h"
#include "core/base/time.h"
#include "core/data/box.h"

namespace kinegraph {
namespace {

// Much longer than an entering person takes to be confirmed (by default
// 0.08 s).
constexpr double kLeastS = 3.0;
constexpr double kAwayS = 0.4;  // a lost track ends by default after this

}  // namespace

UnfollowedPeople::UnfollowedPeople(const CameraRig& cameras,
                                   std::vector<int> map, int least_joints)
    : cameras_(cameras), map_(std::move(map)), least_joints_(least_joints) {}

bool UnfollowedPeople::IsFollowed(const Detection& detection, size_t view,
                                  const TrackFrame& tracked) const {
  constexpr double kNear = 0.15;  // of the detection's size
  const double near_px = kNear * DiagonalPx(BoxAround(detection.joints));
  for (const PersonPose& person : tracked.people) {
    std::vector<double> distances;
    for (size_t j = 0; j < person.joints.size(); ++j) {
      if (map_[j] < 0 || !person.joints[j].present()) continue;
      const Keypoint& joint = detection.joints[static_cast<size_t>(map_[j])];
      if (!joint.found) continue;
      const auto px = cameras_[view].Project(person.joints[j].position_m);
      if (px.has_value()) distances.push_back((*px - joint.px).norm());
    }
    if (!distances.empty() && Median(std::move(distances)) < near_px) {
      return true;
    }
  }
  return false;
}

void UnfollowedPeople::See(const DetectionFrame& seen,
                           const TrackFrame& tracked) {
  constexpr double kLongestStepS = 1.0;
  // Whether the clock stopped or stepped back, so that its times do not show
  // for how long a person was absent.
  bool stopped = false;
  if (frames_++ > 0) {
    const double passed_s = ToSeconds(seen.time - last_time_);
    stopped = passed_s <= 0.0;
    if (passed_s < kLongestStepS) step_s_ = std::max(step_s_, passed_s);
    if (passed_s >= 0.0) {
      ++steps_;
      passed_ += seen.time - last_time_;
    }
  }
  last_time_ = seen.time;
  const int64_t before = std::exchange(last_frame_, seen.frame);
  const double away_s = std::max(kAwayS, 1.5 * step_s_);
  for (size_t i = chains_.size(); i-- > 0;) {
    if (stopped ? chains_[i].person.last_frame == before
                : ToSeconds(seen.time - chains_[i].time) <= away_s) {
      if (stopped) chains_[i].time = seen.time;  // of the clock from here on
      continue;
    }
    if (IsLong(chains_[i])) ended_.push_back(chains_[i]);
    chains_.erase(chains_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  // Bounds memory; keeps the most frequent chains.
  constexpr size_t kMostEnded = 256;
  if (ended_.size() > kMostEnded) {
    std::sort(ended_.begin(), ended_.end(), [](const Chain& a, const Chain& b) {
      return a.frames > b.frames;
    });
    ended_.resize(kMostEnded / 2);
  }
  for (size_t v = 0; v < seen.views.size(); ++v) {
    std::vector<int> matched;
    for (const PersonPose& person : tracked.people) {
      for (const ViewMatch& match : person.matches) {
        if (match.view_idx == static_cast<int>(v)) {
          matched.push_back(match.detection_idx);
        }
      }
    }
    for (const Detection& detection : seen.views[v].detections) {
      if (CountFound(detection) < least_joints_ ||
          std::count(matched.begin(), matched.end(), detection.index_in_file) >
              0 ||
          IsFollowed(detection, v, tracked)) {
        continue;
      }
      Continue(BoxAround(detection.joints), v, seen);
    }
  }
}

void UnfollowedPeople::Continue(const Eigen::AlignedBox2d& box, size_t view,
                                const DetectionFrame& seen) {
  // Distance between the centres, as a fraction of the larger diagonal.
  constexpr double kNear = 0.3;
  Chain* nearest = nullptr;
  double nearest_px = 0.0;
  for (Chain& chain : chains_) {
    if (chain.person.view != view || chain.person.last_frame == seen.frame) {
      continue;
    }
    const double distance_px = (chain.box.center() - box.center()).norm();
    if (distance_px >
        kNear * std::max(DiagonalPx(chain.box), DiagonalPx(box))) {
      continue;
    }
    if (nearest == nullptr || distance_px < nearest_px) {
      nearest = &chain;
      nearest_px = distance_px;
    }
  }
  if (nearest == nullptr) {
    nearest = &chains_.emplace_back();
    nearest->person = {view, 0.0, seen.frame, seen.frame};
  }
  nearest->box = box;
  nearest->time = seen.time;
  nearest->person.last_frame = seen.frame;
  ++nearest->frames;
}

bool UnfollowedPeople::IsLong(const Chain& chain) const {
  if (steps_ == 0) return false;
  const double step_s = ToSeconds(passed_) / static_cast<double>(steps_);
  return static_cast<double>(chain.frames) * step_s >= kLeastS;
}

std::vector<UnfollowedPerson> UnfollowedPeople::Often() const {
  constexpr double kOften = 0.2;  // fraction of the frames
  std::vector<UnfollowedPerson> often;
  for (const std::vector<Chain>* chains : {&chains_, &ended_}) {
    for (const Chain& chain : *chains) {
      const auto frames = static_cast<double>(chain.frames);
      if (!IsLong(chain) || frames < kOften * static_cast<double>(frames_)) {
        continue;
      }
      often.push_back(chain.person);
      often.back().share = frames / static_cast<double>(frames_);
    }
  }
  std::sort(often.begin(), often.end(),
            [](const UnfollowedPerson& a, const UnfollowedPerson& b) {
              return a.share != b.share ? a.share > b.share : a.view < b.view;
            });
  return often;
}

}  // namespace kinegraph
