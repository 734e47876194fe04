#include "apps/report/moments.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/base/median.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

constexpr double kApartSeconds = 0.5;
// No velocity is computed across longer pauses of a track.
constexpr double kMaxStepSeconds = 0.25;
constexpr double kSamePersonM = 1.0;

Moment At(MomentKind kind, const TrackFrame& frame, TrackId id) {
  return {kind, frame.frame, frame.time, id, 0.0, ""};
}

struct Step {
  const Pose3d* pose = nullptr;
  TimeNs time = 0;
  std::vector<Eigen::Vector3d> velocity;  // m/s, NaN where undefined
};

std::vector<Eigen::Vector3d> VelocityOf(const Pose3d& now, const Pose3d& before,
                                        double dt_s) {
  std::vector<Eigen::Vector3d> velocity(now.size(),
                                        Eigen::Vector3d::Constant(NAN));
  for (size_t j = 0; j < now.size(); ++j) {
    if (!now[j].present() || !before[j].present()) continue;
    velocity[j] = (now[j].position_m - before[j].position_m) / dt_s;
  }
  return velocity;
}

double BoneLength(const Pose3d& pose, const Bone& bone) {
  const Joint3d& a = pose[static_cast<size_t>(bone.a)];
  const Joint3d& b = pose[static_cast<size_t>(bone.b)];
  if (!a.present() || !b.present()) return NAN;
  return (a.position_m - b.position_m).norm();
}

// Medians of each person's bone lengths; NaN for bones that were never seen.
std::map<TrackId, std::vector<double>> MedianBones(
    const TrackSequence& tracks) {
  const std::vector<Bone>& bones = tracks.header.skeleton.bones();
  std::map<TrackId, std::vector<std::vector<double>>> lengths;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      auto& of_person = lengths[person.id];
      of_person.resize(bones.size());
      for (size_t b = 0; b < bones.size(); ++b) {
        const double length = BoneLength(person.joints, bones[b]);
        if (std::isfinite(length)) of_person[b].push_back(length);
      }
    }
  }
  std::map<TrackId, std::vector<double>> medians;
  for (auto& [id, of_person] : lengths) {
    for (auto& of_bone : of_person) {
      medians[id].push_back(of_bone.empty() ? NAN : Median(of_bone));
    }
  }
  return medians;
}

// The threshold of Largest.
double FarOut(const std::vector<Moment>& moments) {
  std::vector<double> values;
  for (const Moment& moment : moments) values.push_back(moment.value);
  const double lower = Quantile(values, 0.25);
  const double upper = Quantile(values, 0.75);
  return upper + 3.0 * (upper - lower);
}

double MeanDistance(const Pose3d& a, const Pose3d& b,
                    const std::vector<int>& b_of_a) {
  double sum = 0.0;
  int count = 0;
  for (size_t j = 0; j < a.size(); ++j) {
    if (b_of_a[j] < 0 || !a[j].present()) continue;
    const Joint3d& other = b[static_cast<size_t>(b_of_a[j])];
    if (!other.present()) continue;
    sum += (a[j].position_m - other.position_m).norm();
    ++count;
  }
  return count == 0 ? -1.0 : sum / count;
}

}  // namespace

const char* ToString(MomentKind kind) {
  constexpr const char* kNames[] = {"residual",   "speed", "bone",
                                    "difference", "start", "end"};
  return kNames[static_cast<int>(kind)];
}

std::vector<Moment> Largest(std::vector<Moment> moments, size_t count) {
  const double least = FarOut(moments);
  std::stable_sort(moments.begin(), moments.end(),
                   [](const Moment& a, const Moment& b) {
                     return std::make_tuple(-a.value, a.frame, a.id.value()) <
                            std::make_tuple(-b.value, b.frame, b.id.value());
                   });
  std::vector<Moment> largest;
  for (Moment& moment : moments) {
    if (largest.size() == count || !(moment.value > least)) break;
    const bool is_repeated =
        std::any_of(largest.begin(), largest.end(), [&](const Moment& other) {
          return other.id == moment.id &&
                 std::abs(ToSeconds(other.time - moment.time)) < kApartSeconds;
        });
    if (!is_repeated) largest.push_back(std::move(moment));
  }
  return largest;
}

std::vector<Moment> SpeedJumps(const TrackSequence& tracks) {
  const std::vector<std::string>& names = tracks.header.skeleton.joints();
  std::map<TrackId, Step> last;
  std::vector<Moment> moments;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      Step& before = last[person.id];
      Step now{&person.joints, frame.time, {}};
      const double dt_s = ToSeconds(frame.time - before.time);
      if (before.pose != nullptr && dt_s > 0.0 && dt_s <= kMaxStepSeconds) {
        now.velocity = VelocityOf(person.joints, *before.pose, dt_s);
        Moment moment = At(MomentKind::kSpeedJump, frame, person.id);
        for (size_t j = 0; j < before.velocity.size(); ++j) {
          const double jump = (now.velocity[j] - before.velocity[j]).norm();
          if (!(jump > moment.value)) continue;  // rejects NaN
          moment.value = jump;
          moment.detail = names[j];
        }
        if (!before.velocity.empty()) moments.push_back(std::move(moment));
      }
      before = std::move(now);
    }
  }
  return moments;
}

std::vector<Moment> BoneDeviations(const TrackSequence& tracks) {
  const Skeleton& skeleton = tracks.header.skeleton;
  const auto medians = MedianBones(tracks);
  std::vector<Moment> moments;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      Moment moment = At(MomentKind::kBone, frame, person.id);
      for (size_t b = 0; b < skeleton.bones().size(); ++b) {
        const Bone& bone = skeleton.bones()[b];
        const double deviation = std::abs(BoneLength(person.joints, bone) -
                                          medians.at(person.id)[b]);
        if (!(deviation > moment.value)) continue;
        moment.value = deviation;
        moment.detail = skeleton.joints()[static_cast<size_t>(bone.a)] +
                        " to " + skeleton.joints()[static_cast<size_t>(bone.b)];
      }
      moments.push_back(std::move(moment));
    }
  }
  return moments;
}

std::vector<Moment> StartsAndEnds(const TrackSequence& tracks) {
  struct Life {
    const TrackFrame* first = nullptr;
    const TrackFrame* last = nullptr;
  };
  std::map<TrackId, Life> lives;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      Life& life = lives[person.id];
      if (life.first == nullptr) life.first = &frame;
      life.last = &frame;
    }
  }
  std::vector<Moment> moments;
  for (const auto& [id, life] : lives) {
    if (life.first != &tracks.frames.front()) {
      moments.push_back(At(MomentKind::kStart, *life.first, id));
    }
    if (life.last != &tracks.frames.back()) {
      moments.push_back(At(MomentKind::kEnd, *life.last, id));
    }
  }
  std::stable_sort(
      moments.begin(), moments.end(),
      [](const Moment& a, const Moment& b) { return a.frame < b.frame; });
  return moments;
}

std::vector<std::vector<double>> DifferencesTo(const TrackSequence& other,
                                               const TrackSequence& tracks) {
  const std::vector<int> map =
      MapByName(other.header.skeleton, tracks.header.skeleton);
  std::vector<std::vector<double>> differences;
  for (const TrackFrame& frame : tracks.frames) {
    differences.emplace_back(frame.people.size(), -1.0);
    const TrackFrame* at = FindFrame(other, frame.frame);
    if (at == nullptr) continue;
    for (size_t p = 0; p < frame.people.size(); ++p) {
      double nearest = kSamePersonM;
      for (const PersonPose& candidate : at->people) {
        const double distance =
            MeanDistance(frame.people[p].joints, candidate.joints, map);
        if (distance < 0.0 || distance >= nearest) continue;
        nearest = distance;
        differences.back()[p] = distance;
      }
    }
  }
  return differences;
}

}  // namespace kinegraph
