#include "core/evaluation/markers/gait_events.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/constants.h"
#include "core/base/median.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// An extreme is the greatest value within this time before and after it [s].
constexpr double kWindowS = 0.2;
// Gaps up to this length hide no extreme [s].
constexpr double kGapS = 0.05;

// A joint's positions, NaN where it is missing.
std::vector<Vector3d> PointsOf(const TrackSequence& motion,
                               const std::string& joint) {
  std::vector<Vector3d> points;
  const int at = motion.header.skeleton.IndexOf(joint);
  for (const TrackFrame& frame : motion.frames) {
    const Joint3d here = at >= 0 && !frame.people.empty()
                             ? frame.people.front().joints[at]
                             : Joint3d{};
    points.push_back(here.present() ? here.position_m
                                    : Vector3d::Constant(kNan));
  }
  return points;
}

std::string SideOf(Foot foot) { return foot == Foot::kLeft ? "l_" : "r_"; }

class Finder {
 public:
  Finder(const TrackSequence& motion, const Vector3d& up)
      : motion_(motion), up_(up) {
    for (const TrackFrame& frame : motion.frames) {
      times_s_.push_back(ToSeconds(frame.time));
    }
    std::vector<double> steps_s;
    for (size_t i = 1; i < times_s_.size(); ++i) {
      steps_s.push_back(times_s_[i] - times_s_[i - 1]);
    }
    longest_gap_s_ = std::max(kGapS, 1.5 * Median(std::move(steps_s)));
    const std::vector<Vector3d> left = PointsOf(motion_, "l_hip");
    const std::vector<Vector3d> right = PointsOf(motion_, "r_hip");
    pelvis_ = PointsOf(motion_, "mid_hip");
    constexpr double kLeastWidthM = 0.05;
    for (size_t i = 0; i < pelvis_.size(); ++i) {
      const Vector3d middle = 0.5 * (left[i] + right[i]);
      if (middle.allFinite()) pelvis_[i] = middle;
      // NaN without hips, or with hips above each other.
      pelvis_faces_.push_back(up_.cross(right[i] - left[i]));
      const double width_m = pelvis_faces_.back().norm();
      pelvis_faces_.back() /= width_m > kLeastWidthM ? width_m : kNan;
    }
  }

  FootEvents Find() {
    FootEvents result;
    std::vector<std::vector<double>> heels, toes;
    double swing_m = std::numeric_limits<double>::infinity();
    for (const Foot foot : {Foot::kLeft, Foot::kRight}) {
      heels.push_back(Ahead(foot, {"heel", "ankle"}));
      toes.push_back(Ahead(foot, {"big_toe", "small_toe", "ankle"}));
      const auto [low_m, high_m] = RangeOf(heels.back());
      // NaN where the foot has no joints.
      swing_m = high_m >= low_m ? std::min(swing_m, high_m - low_m) : 0.0;
    }
    // In walking both heels swing farther than in a squat or a jump.
    constexpr double kLeastSwingM = 0.3;
    result.is_walk = swing_m > kLeastSwingM;
    for (const Foot foot : {Foot::kLeft, Foot::kRight}) {
      const auto side = static_cast<size_t>(foot);
      if (result.is_walk) {
        AddExtremes(foot, true, heels[side], &result.events);
        AddExtremes(foot, false, toes[side], &result.events);
      } else {
        AddVertical(foot, &result.events);
      }
    }
    std::sort(result.events.begin(), result.events.end(),
              [](const FootEvent& a, const FootEvent& b) {
                return a.foot != b.foot ? a.foot < b.foot : a.time_s < b.time_s;
              });
    return result;
  }

 private:
  // The first of these joints that the skeleton has.
  std::vector<Vector3d> Part(Foot foot,
                             const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      const std::string joint = SideOf(foot) + name;
      if (motion_.header.skeleton.IndexOf(joint) >= 0) {
        return PointsOf(motion_, joint);
      }
    }
    return PointsOf(motion_, "");
  }

  // Distance ahead of the pelvis [m], in the direction that it faces in each
  // frame, because people turn; where that is unknown, in the mean direction of
  // the feet or, without toes, of the pelvis's displacement over the recording.
  std::vector<double> Ahead(Foot foot, const std::vector<std::string>& names) {
    const std::vector<Vector3d> points = Part(foot, names);
    const std::vector<Vector3d> toes = Part(foot, {"big_toe", "small_toe"});
    const std::vector<Vector3d> heels = Part(foot, {"heel", "ankle"});
    Vector3d mean = Vector3d::Zero();
    for (size_t i = 0; i < points.size(); ++i) {
      const Vector3d sole = toes[i] - heels[i];
      if (sole.allFinite()) mean += sole - sole.dot(up_) * up_;
    }
    if (mean.isZero()) mean = Displacement();
    mean.normalize();
    std::vector<double> ahead;
    for (size_t i = 0; i < points.size(); ++i) {
      const Vector3d& faces = pelvis_faces_[i];
      ahead.push_back(
          (faces.allFinite() ? faces : mean).dot(points[i] - pelvis_[i]));
    }
    return ahead;
  }

  // Horizontal displacement of the pelvis over the recording.
  Vector3d Displacement() const {
    std::vector<Vector3d> places;
    for (const Vector3d& place : pelvis_) {
      if (place.allFinite()) places.push_back(place);
    }
    if (places.size() < 2) return Vector3d::Zero();
    const Vector3d way = places.back() - places.front();
    return way - way.dot(up_) * up_;
  }

  // The 5th and the 95th percentile of the values.
  static std::pair<double, double> RangeOf(std::vector<double> values) {
    values.erase(std::remove_if(values.begin(), values.end(),
                                [](double value) { return std::isnan(value); }),
                 values.end());
    return {Quantile(values, 0.05), Quantile(values, 0.95)};
  }

  // Whether value `i` times `sign` is the maximum within the window, and not at
  // the edge of what is known.
  bool IsPeak(const std::vector<double>& values, size_t i, double sign) const {
    if (std::isnan(values[i])) return false;
    for (int way : {-1, 1}) {
      bool reached = false;
      double known_s = times_s_[i];
      // Below 0 the index wraps around.
      for (size_t k = i; k < values.size(); k += static_cast<size_t>(way)) {
        // After a longer gap: the true peak may lie in the gap.
        if (std::abs(times_s_[k] - known_s) > longest_gap_s_) break;
        if (!std::isnan(values[k])) known_s = times_s_[k];
        if (std::abs(times_s_[k] - times_s_[i]) > kWindowS) {
          reached = true;
          break;
        }
        if (sign * values[k] > sign * values[i]) return false;
        if (way < 0 && k != i && values[k] == values[i]) return false;
      }
      if (!reached) return false;
    }
    return true;
  }

  // Contacts at maxima, foot off at minima.
  void AddExtremes(Foot foot, bool is_contact,
                   const std::vector<double>& values,
                   std::vector<FootEvent>* events) const {
    const double sign = is_contact ? 1.0 : -1.0;
    const auto [low, high] = RangeOf(values);
    const double middle = 0.5 * (low + high);
    for (size_t i = 1; i + 1 < values.size(); ++i) {
      if (sign * (values[i] - middle) <= 0.0 || !IsPeak(values, i, sign)) {
        continue;
      }
      // The parabola through the peak and its neighbours.
      const double bend = values[i - 1] - 2.0 * values[i] + values[i + 1];
      double shift = 0.5 * (values[i - 1] - values[i + 1]) / bend;
      if (!std::isfinite(shift)) shift = 0.0;
      events->push_back(
          {foot, is_contact,
           times_s_[i] + shift * 0.5 * (times_s_[i + 1] - times_s_[i - 1])});
    }
  }

  void AddVertical(Foot foot, std::vector<FootEvent>* events) const {
    constexpr double kLeastM_S = 0.8;  // shuffling feet rise more slowly
    const std::vector<Vector3d> toes =
        Part(foot, {"big_toe", "small_toe", "ankle"});
    std::vector<double> speed(toes.size(), kNan);
    for (size_t i = 1; i + 1 < toes.size(); ++i) {
      speed[i] = up_.dot(toes[i + 1] - toes[i - 1]) /
                 (times_s_[i + 1] - times_s_[i - 1]);
    }
    for (size_t i = 0; i < speed.size(); ++i) {
      if (speed[i] > kLeastM_S && IsPeak(speed, i, 1.0)) {
        AddCrossing(foot, false, speed, i, events);
      } else if (speed[i] < -kLeastM_S && IsPeak(speed, i, -1.0)) {
        AddCrossing(foot, true, speed, i, events);
      }
    }
  }

  // Adds an event where the speed is half of the peak: before it for foot off,
  // after it for a contact.
  void AddCrossing(Foot foot, bool is_contact, const std::vector<double>& speed,
                   size_t peak, std::vector<FootEvent>* events) const {
    const double half = 0.5 * speed[peak];
    size_t next = peak;
    for (size_t k = peak; k > 0 && k + 1 < speed.size(); k = next) {
      next = is_contact ? k + 1 : k - 1;
      if (std::isnan(speed[next])) return;
      if (std::abs(speed[next]) > std::abs(half) && speed[next] * half > 0.0) {
        continue;
      }
      const double share = (speed[k] - half) / (speed[k] - speed[next]);
      events->push_back({foot, is_contact,
                         times_s_[k] + share * (times_s_[next] - times_s_[k])});
      return;
    }
  }

  const TrackSequence& motion_;
  const Vector3d up_;
  std::vector<double> times_s_;
  double longest_gap_s_ = 0.0;  // between values; a longer one may hide a peak
  std::vector<Vector3d> pelvis_;
  std::vector<Vector3d> pelvis_faces_;  // horizontal unit vectors, or NaN
};

// Times at which the load crosses the threshold, and whether upwards; without
// loads and pauses shorter than kKnockS.
std::vector<std::pair<double, bool>> Crossings(const ForcePlate& plate) {
  constexpr double kThresholdN = 20.0;
  constexpr double kKnockS = 0.05;
  std::vector<std::pair<double, bool>> crossings;
  if (plate.load_n.empty()) return crossings;
  bool loaded = plate.load_n.front() > kThresholdN;
  for (size_t i = 1; i < plate.load_n.size(); ++i) {
    if ((plate.load_n[i] > kThresholdN) == loaded) continue;
    loaded = !loaded;
    const double time_s =
        plate.first_s + static_cast<double>(i) / plate.rate_hz;
    if (!crossings.empty() && time_s - crossings.back().first < kKnockS) {
      crossings.pop_back();
      continue;
    }
    crossings.push_back({time_s, loaded});
  }
  return crossings;
}

}  // namespace

FootEvents FindFootEvents(const TrackSequence& motion, const Vector3d& up) {
  return Finder(motion, up).Find();
}

double StrideTime(const FootEvents& events) {
  std::vector<double> strides_s;
  const FootEvent* last = nullptr;
  for (const FootEvent& event : events.events) {
    if (!event.is_contact) continue;
    if (last != nullptr && last->foot == event.foot) {
      strides_s.push_back(event.time_s - last->time_s);
    }
    last = &event;
  }
  return events.is_walk ? Quantile(strides_s, 0.5) : kNan;
}

std::vector<TimedEvent> CompareWithPlates(const std::vector<ForcePlate>& plates,
                                          const FootEvents& found,
                                          const TrackSequence& motion,
                                          const Vector3d& up) {
  constexpr double kNearS = 0.15;
  const std::vector<Vector3d> ankles[] = {PointsOf(motion, "l_ankle"),
                                          PointsOf(motion, "r_ankle")};
  std::vector<TimedEvent> timed;
  for (const ForcePlate& plate : plates) {
    for (const auto& [time_s, loaded] : Crossings(plate)) {
      size_t frame = 0;
      while (frame + 1 < motion.frames.size() &&
             ToSeconds(motion.frames[frame].time) < time_s) {
        ++frame;
      }
      const auto distance_of = [&](Foot foot) {
        const Vector3d way =
            ankles[static_cast<size_t>(foot)][frame] - plate.centre_m;
        const double distance_m = (way - way.dot(up) * up).norm();
        return std::isnan(distance_m) ? std::numeric_limits<double>::infinity()
                                      : distance_m;
      };
      TimedEvent event;
      event.plate = {distance_of(Foot::kRight) < distance_of(Foot::kLeft)
                         ? Foot::kRight
                         : Foot::kLeft,
                     loaded, time_s};
      event.found_minus_plate_s = kNan;
      for (const FootEvent& one : found.events) {
        const double difference_s = one.time_s - time_s;
        if (one.foot != event.plate.foot || one.is_contact != loaded ||
            std::abs(difference_s) > kNearS ||
            std::abs(difference_s) >= std::abs(event.found_minus_plate_s)) {
          continue;
        }
        event.found_minus_plate_s = difference_s;
      }
      timed.push_back(event);
    }
  }
  return timed;
}

}  // namespace kinegraph
