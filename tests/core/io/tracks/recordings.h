// Recordings that the tests of track formats write.
#ifndef KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_
#define KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tree_motion.h"
#include "tests/support/standing_person.h"

namespace kinegraph::testing {

// Whether Debian's Python has these modules.
inline bool HasPython(const std::string& modules) {
  return std::system(
             ("/usr/bin/python3 -c 'import " + modules + "' > /dev/null 2>&1")
                 .c_str()) == 0;
}

// Writes tracks in a format; returns its notes on what it cannot store.
inline LostFields WriteAs(const std::string& format, const std::string& path,
                          const TrackSequence& tracks,
                          const TrackExportOptions& options = {}) {
  LostFields lost_fields;
  FindTrackFormat(format)->write(path, tracks, options, &lost_fields);
  return lost_fields;
}

// Frames 300 to 309 with the people 0, 2 (from frame 303) and 5, but nobody in
// frame 304; coordinates with all digits of a double, every status.
inline TrackSequence RandomTracks(const Skeleton& skeleton) {
  Random random(11);
  TrackSequence tracks;
  tracks.header.skeleton = skeleton;
  tracks.header.frame_rate_hz = 25.0;
  for (int64_t f = 300; f < 310; ++f) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    frame.time = FrameClock(25.0).TimeOf(f);
    for (const int64_t id : {0, 2, 5}) {
      if (f == 304 || (id == 2 && f < 303)) continue;
      PersonPose& person = frame.people.emplace_back();
      person.id = TrackId(id);
      for (int j = 0; j < skeleton.joint_count(); ++j) {
        Joint3d& joint = person.joints.emplace_back();
        // Most formats cannot represent a person without joints.
        joint.status = j == 0 ? JointStatus::kObserved
                              : static_cast<JointStatus>(random.Index(3));
        if (joint.present()) {
          joint.position_m = {random.Normal() / 3.0, random.Normal() * 1e-7,
                              -random.Uniform()};
        }
        person.inlier_views.push_back(static_cast<int>(random.Index(5)));
        auto& covariance = person.covariances.emplace_back();
        if (joint.present() && random.Chance(0.7)) {
          covariance = Eigen::Matrix3d::Identity() * random.Uniform();
          (*covariance)(0, 1) = (*covariance)(1, 0) = 1e-3 * random.Normal();
        }
      }
    }
  }
  return tracks;
}

// A person who moves some two metres along x. Each pose is changed by `change`,
// translated, and then rotated by `world`.
inline TrackSequence Walk(
    const Eigen::Matrix3d& world = Eigen::Matrix3d::Identity(),
    const std::function<void(PosedPerson*)>& change = {}) {
  TrackSequence tracks;
  tracks.header.skeleton = Body25();
  tracks.header.frame_rate_hz = 25.0;
  for (int64_t f = 0; f < 50; ++f) {
    PosedPerson person;
    if (change) change(&person);
    for (Joint3d& joint : person.pose().joints) {
      joint.position_m.x() += 0.04 * static_cast<double>(f);
      joint.position_m.y() += 2.0;
      joint.position_m = world * joint.position_m;
    }
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    frame.time = f * 40'000'000;
    frame.people = {person.pose()};
    frame.people[0].id = TrackId(0);
  }
  return tracks;
}

// ---- Bodies with constant bone lengths, for animation formats ----

inline JointTree TreeOf(const Skeleton& skeleton) {
  return MakeJointTree(skeleton,
                       std::vector<bool>(skeleton.joints().size(), true),
                       /*pivots=*/false);
}

// A rotation that oscillates over frames by up to 1 rad, about a separate axis
// for each joint.
inline Eigen::Quaterniond Swing(size_t joint, int64_t frame) {
  const double phase = 1.7 * static_cast<double>(joint);
  const Eigen::Vector3d axis(std::sin(phase), std::cos(2.3 * phase),
                             std::sin(1.0 + 3.1 * phase));
  return Eigen::Quaterniond(Eigen::AngleAxisd(
      std::sin(0.3 * static_cast<double>(frame) + phase), axis.normalized()));
}

// Bone offsets of an asymmetric body, except that left and right hips and
// shoulders are opposite, because their mean may be a joint.
inline std::vector<Eigen::Vector3d> OffsetsOf(const JointTree& tree,
                                              double size_m) {
  std::vector<Eigen::Vector3d> offsets_m(tree.size(), Eigen::Vector3d::Zero());
  const auto place_of = [&](const std::string& name) {
    for (size_t j = 0; j < tree.size(); ++j) {
      if (tree[j].name == name) return j;
    }
    return tree.size();
  };
  for (size_t j = 1; j < tree.size(); ++j) {
    const double phase = 2.1 * static_cast<double>(j);
    offsets_m[j] =
        size_m * (0.6 + 0.4 * std::sin(5.0 * phase)) *
        Eigen::Vector3d(std::cos(phase), std::sin(phase), std::sin(1.9 * phase))
            .normalized();
  }
  for (const std::string part : {"hip", "shoulder"}) {
    const size_t left = place_of("l_" + part);
    const size_t right = place_of("r_" + part);
    if (left < tree.size() && right < tree.size()) {
      offsets_m[right] = -offsets_m[left];
    }
  }
  return offsets_m;
}

// A person whose joints rotate about each other at constant lengths: the
// children of a joint form a rigid shape. The chest does not bend against the
// spine, which is one of the bones that define its rotation.
inline TrackSequence RigidTruth(const Skeleton& skeleton, int64_t frames,
                                double size_m = 0.25) {
  const JointTree tree = TreeOf(skeleton);
  const std::vector<Eigen::Vector3d> offsets_m = OffsetsOf(tree, size_m);
  TrackSequence tracks;
  tracks.header.skeleton = skeleton;
  tracks.header.frame_rate_hz = 30.0;
  for (int64_t f = 0; f < frames; ++f) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    PersonPose& person = frame.people.emplace_back();
    person.id = TrackId(0);
    person.joints.resize(skeleton.joints().size());
    std::vector<Eigen::Quaterniond> rotations(tree.size());
    std::vector<Eigen::Vector3d> positions_m(tree.size());
    for (size_t j = 0; j < tree.size(); ++j) {
      const size_t p = tree[j].parent;
      rotations[j] = j == 0             ? Swing(j, f)
                     : tree[j].is_chest ? rotations[p]
                                        : rotations[p] * Swing(j, f);
      positions_m[j] =
          j == 0
              ? Eigen::Vector3d(0.02 * static_cast<double>(f), 0.1, 1.0)
              : Eigen::Vector3d(positions_m[p] + rotations[p] * offsets_m[j]);
      if (tree[j].sources.size() > 1) continue;
      person.joints[static_cast<size_t>(tree[j].sources[0])] = {
          positions_m[j], JointStatus::kObserved};
    }
  }
  return tracks;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_
