#include "core/evaluation/motion.h"

#include <array>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {
namespace {

// The joints and bones that are scored, as indices.
struct Scope {
  std::vector<int> joints;
  std::vector<Bone> bones;
};

// Limbs, girdles and sides.
constexpr std::array<std::pair<const char*, const char*>, 12> kBodyBones = {{
    {"l_shoulder", "l_elbow"},
    {"r_shoulder", "r_elbow"},
    {"l_elbow", "l_wrist"},
    {"r_elbow", "r_wrist"},
    {"l_hip", "l_knee"},
    {"r_hip", "r_knee"},
    {"l_knee", "l_ankle"},
    {"r_knee", "r_ankle"},
    {"l_shoulder", "r_shoulder"},
    {"l_hip", "r_hip"},
    {"l_shoulder", "l_hip"},
    {"r_shoulder", "r_hip"},
}};

Scope MakeScope(const Skeleton& skeleton, MotionScope wanted) {
  Scope scope;
  if (wanted == MotionScope::kBody) {
    for (const JointPair& pair : CommonBodyJoints(skeleton, skeleton)) {
      scope.joints.push_back(pair.a);
    }
    for (const auto& [a, b] : kBodyBones) {
      const Bone bone = {skeleton.IndexOf(a), skeleton.IndexOf(b)};
      if (bone.a >= 0 && bone.b >= 0) scope.bones.push_back(bone);
    }
    return scope;
  }
  for (int j = 0; j < skeleton.joint_count(); ++j) scope.joints.push_back(j);
  scope.bones = skeleton.bones();
  return scope;
}

struct PersonAt {
  int64_t frame = 0;
  const Pose3d* pose = nullptr;
};
using People = std::map<TrackId, std::vector<PersonAt>>;

People ByIdentity(const TrackSequence& tracks,
                  const std::vector<FrameRange>& frames) {
  People people;
  for (const TrackFrame& frame : tracks.frames) {
    if (!ContainsFrame(frames, frame.frame)) continue;
    for (const PersonPose& person : frame.people) {
      people[person.id].push_back({frame.frame, &person.joints});
    }
  }
  return people;
}

// Sum over the joints of the second differences [m], and their number.
RatioUnit SecondDifferences(const Pose3d& before, const Pose3d& now,
                            const Pose3d& after,
                            const std::vector<int>& joints) {
  const auto observed = [](const Joint3d& joint) {
    return joint.status == JointStatus::kObserved;
  };
  RatioUnit unit;
  for (const int j : joints) {
    if (!observed(before[j]) || !observed(now[j]) || !observed(after[j])) {
      continue;
    }
    unit.sum +=
        (after[j].position_m - 2.0 * now[j].position_m + before[j].position_m)
            .norm();
    unit.weight += 1.0;
  }
  return unit;
}

RatioSeries Accelerations(const std::vector<PersonAt>& person,
                          const std::vector<int>& joints, double scale) {
  RatioSeries series;
  for (size_t k = 1; k + 1 < person.size(); ++k) {
    if (person[k].frame - person[k - 1].frame != 1 ||
        person[k + 1].frame - person[k].frame != 1) {
      continue;
    }
    RatioUnit unit = SecondDifferences(*person[k - 1].pose, *person[k].pose,
                                       *person[k + 1].pose, joints);
    unit.sum *= scale;
    series.push_back(unit);
  }
  return series;
}

void AddAcceleration(const People& people, const std::vector<int>& joints,
                     double frame_rate_hz, const BootstrapOptions& options,
                     MotionResult* result) {
  std::vector<RatioSeries> all;
  for (const auto& [id, person] : people) {
    all.push_back(Accelerations(person, joints, frame_rate_hz * frame_rate_hz));
    for (const RatioUnit& unit : all.back()) {
      result->acceleration_count += static_cast<int64_t>(unit.weight);
    }
  }
  result->acceleration_m_s2 = PooledRatio(all);
  result->acceleration_interval = PooledRatioInterval(all, options);
}

void AddBoneSpread(const People& people, const std::vector<Bone>& bones,
                   MotionResult* result) {
  std::vector<double> spreads;
  for (const auto& [id, person] : people) {
    for (const Bone& bone : bones) {
      std::vector<double> lengths;
      for (const PersonAt& at : person) {
        const Joint3d& a = (*at.pose)[bone.a];
        const Joint3d& b = (*at.pose)[bone.b];
        if (!a.present() || !b.present()) continue;
        lengths.push_back((a.position_m - b.position_m).norm());
      }
      if (lengths.size() >= 2) spreads.push_back(StandardDeviation(lengths));
    }
  }
  result->bone_count = static_cast<int64_t>(spreads.size());
  result->bone_length_spread_m = Mean(spreads);
}

}  // namespace

MotionResult EvaluateMotion(const TrackSequence& tracks, double frame_rate_hz,
                            const MotionOptions& options,
                            const BootstrapOptions& bootstrap) {
  if (!(frame_rate_hz > 0.0)) {
    throw OptionError("frame rate", "must be known for an acceleration");
  }
  const Scope scope = MakeScope(tracks.header.skeleton, options.scope);
  const People people = ByIdentity(tracks, options.frames);
  MotionResult result;
  AddAcceleration(people, scope.joints, frame_rate_hz, bootstrap, &result);
  AddBoneSpread(people, scope.bones, &result);
  return result;
}

Share EvaluateCoverage(const TrackSequence& truth, const TrackSequence& tracks,
                       const std::vector<FrameRange>& frames) {
  const JointPairs joints =
      CommonJoints(truth.header.skeleton, tracks.header.skeleton);
  Share covered;
  for (const TrackFrame& true_frame : truth.frames) {
    if (!ContainsFrame(frames, true_frame.frame)) continue;
    const TrackFrame* frame = FindFrame(tracks, true_frame.frame);
    for (const PersonPose& person : true_frame.people) {
      bool found = false;
      for (size_t i = 0; frame != nullptr && i < frame->people.size(); ++i) {
        const auto distance =
            MeanDistance(person.joints, frame->people[i].joints, joints);
        found = found || (distance && *distance <= kPersonGateM);
      }
      covered.Add(found);
    }
  }
  return covered;
}

}  // namespace kinegraph
