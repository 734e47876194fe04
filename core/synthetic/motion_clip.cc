#include <algorithm>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/synthetic/recorded_people.h"

namespace kinegraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Longest gap of a person that the spline bridges [s]; during a longer one the
// person is not in the scene.
constexpr double kLongestClipGap = 0.25;

// The frames of one person.
struct Knots {
  std::vector<double> times_s;
  std::vector<const PersonPose*> poses;
  std::vector<int64_t> frames;
};

std::string FrameName(int64_t frame) {
  return "frame " + std::to_string(frame);
}

// Frames in which a person or one of the mapped joints is missing have no knot.
std::map<TrackId, Knots> KnotsOf(const MotionClip& clip,
                                 const std::vector<int>& map) {
  std::map<TrackId, Knots> people;
  if (clip.tracks.frames.empty()) {
    throw InputError(clip.name, "", "no frames: the file contains no motion");
  }
  const std::vector<TrackFrame>& frames = clip.tracks.frames;
  for (size_t f = 0; f < frames.size(); ++f) {
    const TrackFrame& frame = frames[f];
    if (f > 0 && frame.time <= frames[f - 1].time) {
      throw InputError(clip.name, FrameName(frame.frame),
                       "its time is not later than the previous frame's; a "
                       "clip needs times or a frame rate");
    }
    for (const PersonPose& person : frame.people) {
      Knots& knots = people[person.id];
      const bool complete = std::all_of(map.begin(), map.end(), [&](int j) {
        return person.joints[j].present();
      });
      if (!complete) continue;
      knots.times_s.push_back(ToSeconds(frame.time - frames.front().time));
      knots.poses.push_back(&person);
      knots.frames.push_back(frame.frame);
    }
  }
  if (people.empty()) {
    throw InputError(clip.name, "", "no people: the file contains no motion");
  }
  return people;
}

// For each joint of `to` its index in the clip.
std::vector<int> MapJoints(const MotionClip& clip, const Skeleton& to) {
  const Skeleton& from = clip.tracks.header.skeleton;
  std::vector<int> map = MapByName(from, to);
  for (size_t j = 0; j < map.size(); ++j) {
    if (map[j] >= 0) continue;
    throw InputError(clip.name, "",
                     "skeleton '" + from.name() + "' has no joint '" +
                         to.joints()[j] + "', which skeleton '" + to.name() +
                         "' of the scene needs");
  }
  return map;
}

MatrixXd ValuesOf(const MotionClip& clip, const Knots& knots, size_t begin,
                  size_t end, const std::vector<int>& map) {
  MatrixXd values(3 * Index(map.size()), Index(end - begin));
  for (size_t k = begin; k < end; ++k) {
    for (size_t j = 0; j < map.size(); ++j) {
      const Joint3d& joint = knots.poses[k]->joints[map[j]];
      if (!joint.position_m.allFinite()) {
        const auto& names = clip.tracks.header.skeleton.joints();
        throw InputError(clip.name, FrameName(knots.frames[k]),
                         "joint '" + names[map[j]] + "' is not finite");
      }
      values.block<3, 1>(3 * Index(j), Index(k - begin)) = joint.position_m;
    }
  }
  return values;
}

// Segments of frames without a long gap between them.
std::vector<KnotSpline> PiecesOf(const MotionClip& clip, const Knots& knots,
                                 const std::vector<int>& map) {
  std::vector<KnotSpline> pieces;
  const size_t count = knots.times_s.size();
  for (size_t begin = 0, end = 1; begin < count; begin = end++) {
    while (end < count &&
           knots.times_s[end] - knots.times_s[end - 1] <= kLongestClipGap) {
      ++end;
    }
    const MatrixXd values = ValuesOf(clip, knots, begin, end, map);
    if (end - begin < 2) continue;  // a single frame is no motion
    pieces.emplace_back(std::vector<double>(knots.times_s.begin() + begin,
                                            knots.times_s.begin() + end),
                        values);
  }
  return pieces;
}

}  // namespace

Skeleton JointsOfClips(const std::vector<MotionClip>& clips,
                       const Skeleton& skeleton) {
  std::vector<int> place(skeleton.joint_count(), 0);  // in the result, or -1
  std::vector<std::string> joints;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const std::string& name = skeleton.joints()[j];
    const bool lacking =
        std::any_of(clips.begin(), clips.end(), [&](const MotionClip& clip) {
          return clip.tracks.header.skeleton.IndexOf(name) < 0;
        });
    place[j] = lacking ? -1 : static_cast<int>(joints.size());
    if (!lacking) joints.push_back(name);
  }
  if (static_cast<int>(joints.size()) == skeleton.joint_count()) {
    return skeleton;
  }
  std::vector<Bone> bones;
  for (const Bone& bone : skeleton.bones()) {
    if (place[bone.a] < 0 || place[bone.b] < 0) continue;
    bones.push_back({place[bone.a], place[bone.b]});
  }
  return Skeleton(skeleton.name() + "_part", joints, bones);
}

std::vector<RecordedMotion> MotionsOf(const MotionClip& clip,
                                      const Skeleton& skeleton) {
  const std::vector<int> map = MapJoints(clip, skeleton);
  const std::map<TrackId, Knots> people = KnotsOf(clip, map);
  std::vector<RecordedMotion> motions;
  for (const auto& [id, knots] : people) {
    RecordedMotion motion;
    motion.clip = clip.name;
    motion.id = id;
    motion.skeleton = skeleton;
    motion.pieces = PiecesOf(clip, knots, map);
    if (!motion.pieces.empty()) motions.push_back(std::move(motion));
  }
  if (motions.empty()) {
    throw InputError(
        clip.name, "",
        "no person is present with every joint in two frames at most "
        "0.25 s apart");
  }
  return motions;
}

}  // namespace kinegraph
