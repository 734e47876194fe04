#include "solvers/rig/tracklets.h"

#include <Eigen/Geometry>
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

constexpr double kGapS = 0.4;    // longest gap in a tracklet, or
constexpr int kGapFrames = 4;    // this many frame intervals, if longer
constexpr double kLeastS = 1.0;  // minimum duration of a tracklet
constexpr int kLeastDetections = 10;
// Minimum numbers of joints in a detection, and of joints common to two frames;
// all joints for smaller skeletons, such as a wand.
constexpr int kLeastJoints = 4;
constexpr int kLeastCommon = 3;
// The size used for the gate shrinks by at most this factor per detection, so
// that a stick that points at the camera or a partly occluded person keeps its
// gate.
constexpr double kShrinks = 0.9;
// Gate on the distance from the joints of the tracklet's last detection, in
// units of the person's size: constant part, and growth per second since that
// detection.
constexpr double kGate = 0.1;
constexpr double kGatePerSecond = 2.0;
// Factor on the gate if there is only one person and one open tracklet.
constexpr double kAlone = 4.0;
// A candidate is ambiguous if another is less than this many times as far away.
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
  return static_cast<int>(points.array().isFinite().colwise().all().count());
}

double SizeOf(const NormalisedJoints& points) {
  Eigen::AlignedBox2d box;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    if (points.col(j).allFinite()) box.extend(points.col(j));
  }
  return box.diagonal().norm();
}

// Median distance of the common joints; infinite if there are too few.
double DistanceOf(const NormalisedJoints& a, const NormalisedJoints& b) {
  std::vector<double> distances;
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    const double distance = (a.col(j) - b.col(j)).norm();
    if (std::isfinite(distance)) distances.push_back(distance);
  }
  if (static_cast<int>(distances.size()) <
      std::min(kLeastCommon, static_cast<int>(a.cols()))) {
    return std::numeric_limits<double>::infinity();
  }
  return Median(std::move(distances));
}

// Of several detections of the same person, keeps the one with the most joints.
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
  double size = 0.0;  // at the last detection
};

// Follows the people of one view.
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
    // distance: by person and open tracklet, in units of the gate.
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
    std::vector<int> goes_on(people.size(), -1);  // tracklet of each person
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
    const double near = kClearly * distance(person, tracklet);
    // The pair's own distance is also counted, unless it is 0.
    return (distance.row(person).array() < near).count() <= 1 &&
           (distance.col(tracklet).array() < near).count() <= 1;
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
    open.size = std::max(SizeOf(person.second), kShrinks * open.size);
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

// ---- Motion signals ----

constexpr double kSamplesPerSecond = 12.5;
constexpr double kHighPassS = 0.8;  // half the window of the high-pass filter

// Mean of the finite samples among k - reach .. k + reach; 0 if there are none.
Eigen::MatrixXf MovingMean(const Eigen::MatrixXf& values, int reach) {
  Eigen::MatrixXf mean(values.rows(), values.cols());
  for (Eigen::Index r = 0; r < values.rows(); ++r) {
    for (Eigen::Index k = 0; k < values.cols(); ++k) {
      const Eigen::Index from = std::max<Eigen::Index>(0, k - reach);
      const Eigen::Index to =
          std::min<Eigen::Index>(values.cols(), k + reach + 1);
      float sum = 0.0F;
      int count = 0;
      for (Eigen::Index i = from; i < to; ++i) {
        if (!std::isfinite(values(r, i))) continue;
        sum += values(r, i);
        ++count;
      }
      mean(r, k) = count > 0 ? sum / static_cast<float>(count) : 0.0F;
    }
  }
  return mean;
}

// The joints whose mean is the body's centre: both shoulders and both hips; all
// joints of skeletons without these four.
std::vector<int> MiddleOf(const std::vector<int>& joints,
                          const Skeleton& skeleton) {
  std::vector<int> middle;
  std::vector<int> all;
  for (size_t j = 0; j < joints.size(); ++j) {
    const JointClass kind = skeleton.joint_class(joints[j]);
    if (kind == JointClass::kShoulder || kind == JointClass::kHip) {
      middle.push_back(static_cast<int>(j));
    }
    all.push_back(static_cast<int>(j));
  }
  return middle.size() == 4 ? middle : all;
}

// The upward direction in each view's image: the mean direction from hips to
// shoulders, or -y if none were found.
std::vector<Eigen::Vector2d> UpInViews(
    const std::vector<ViewTracklet>& tracklets, const std::vector<int>& joints,
    const Skeleton& skeleton, int view_count) {
  std::vector<Eigen::Vector2d> ups(static_cast<size_t>(view_count),
                                   Eigen::Vector2d::Zero());
  for (const ViewTracklet& tracklet : tracklets) {
    for (const NormalisedJoints& points : tracklet.joints) {
      Eigen::Vector2d up = Eigen::Vector2d::Zero();
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        const JointClass kind = skeleton.joint_class(joints[j]);
        if (kind == JointClass::kShoulder) up += points.col(j);
        if (kind == JointClass::kHip) up -= points.col(j);
      }
      if (up.allFinite() && up.norm() > 0.0) {
        ups[tracklet.view] += up.normalized();
      }
    }
  }
  for (Eigen::Vector2d& up : ups) {
    up = up.norm() > 0.0 ? up.normalized() : -Eigen::Vector2d::UnitY();
  }
  return ups;
}

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
        if (CountFound(points) <
            std::min(kLeastJoints, static_cast<int>(joints.size()))) {
          continue;
        }
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

MotionSignals::MotionSignals(const std::vector<ViewTracklet>& tracklets,
                             const std::vector<int>& joints,
                             const Skeleton& skeleton, int view_count,
                             double frame_rate_hz) {
  step_ = std::max(
      1, static_cast<int>(std::lround(frame_rate_hz / kSamplesPerSecond)));
  const double per_second = frame_rate_hz / step_;
  least_samples_ = std::max(8, static_cast<int>(std::lround(per_second)));
  const int reach = std::max(2, static_cast<int>(kHighPassS * per_second));
  const std::vector<int> middle = MiddleOf(joints, skeleton);
  const auto ups = UpInViews(tracklets, joints, skeleton, view_count);
  const auto count = static_cast<Eigen::Index>(joints.size());
  for (const ViewTracklet& tracklet : tracklets) {
    Signal signal;
    signal.first = (tracklet.first + step_ - 1) / step_;
    const int samples =
        std::max(0, (tracklet.end() - 1) / step_ - signal.first + 1);
    const Eigen::Vector2d up = ups[tracklet.view];
    const float missing = std::numeric_limits<float>::quiet_NaN();
    Eigen::MatrixXf x = Eigen::MatrixXf::Constant(count, samples, missing);
    Eigen::MatrixXf y = x;
    for (int k = 0; k < samples; ++k) {
      const int frame = (signal.first + k) * step_;
      if (!tracklet.SeenAt(frame)) continue;
      const NormalisedJoints& points = tracklet.At(frame);
      Eigen::Vector2d centre = Eigen::Vector2d::Zero();
      for (const int j : middle) centre += points.col(j);
      centre /= static_cast<double>(middle.size());
      for (Eigen::Index j = 0; j < count; ++j) {
        const Eigen::Vector2d off = (points.col(j) - centre) / tracklet.size;
        y(j, k) = static_cast<float>(off.dot(up));
        x(j, k) = static_cast<float>(off.x() * up.y() - off.y() * up.x());
      }
    }
    Eigen::MatrixXf speed = Eigen::MatrixXf::Constant(count, samples, missing);
    for (int k = 1; k + 1 < samples; ++k) {
      speed.col(k) = ((x.col(k + 1) - x.col(k - 1)).array().square() +
                      (y.col(k + 1) - y.col(k - 1)).array().square())
                         .sqrt();
    }
    signal.values.resize(2 * count, samples);
    signal.values.topRows(count) = y - MovingMean(y, reach);
    signal.values.bottomRows(count) = speed - MovingMean(speed, reach);
    signal.values = signal.values.array().isFinite().select(
        signal.values, Eigen::MatrixXf::Zero(2 * count, samples));
    signal.energy.assign(1, 0.0);
    for (int k = 0; k < samples; ++k) {
      signal.energy.push_back(signal.energy.back() +
                              signal.values.col(k).squaredNorm());
    }
    signals_.push_back(std::move(signal));
  }
}

MotionSignals::Likeness MotionSignals::Compare(size_t a, size_t b,
                                               int lag) const {
  const Signal& one = signals_[a];
  const Signal& other = signals_[b];
  const int begin = std::max(one.first, other.first - lag);
  const int end =
      std::min(one.first + static_cast<int>(one.values.cols()),
               other.first + static_cast<int>(other.values.cols()) - lag);
  Likeness likeness;
  if (end - begin < least_samples_) return likeness;
  likeness.samples = end - begin;
  const int at_one = begin - one.first;
  const int at_other = begin + lag - other.first;
  const double product =
      one.values.middleCols(at_one, end - begin)
          .cwiseProduct(other.values.middleCols(at_other, end - begin))
          .sum();
  const auto energy = [&](const Signal& signal, int at) {
    return signal.energy[at + end - begin] - signal.energy[at];
  };
  const double norm = std::sqrt(energy(one, at_one) * energy(other, at_other));
  if (norm > 0.0) likeness.correlation = product / norm;
  return likeness;
}

}  // namespace kinegraph
