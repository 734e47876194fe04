// Small hand-made people for the tests of this folder.
#ifndef KINEGRAPH_TESTS_CORE_EVALUATION_PEOPLE_H_
#define KINEGRAPH_TESTS_CORE_EVALUATION_PEOPLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/data/pose.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph::testing {

inline Joint3d Observed(double x, double y, double z) {
  return {{x, y, z}, JointStatus::kObserved};
}

// A person standing at (x, y), facing +y, in Tum14: z is up, right is +x. All
// coordinates are exact in binary, so that limits can be hit exactly.
inline Pose3d StandingTum14(double x = 0.0, double y = 0.0) {
  return {
      Observed(x + 0.125, y, 0.0),  // 0 r_ankle
      Observed(x + 0.125, y, 0.5),  // 1 r_knee
      Observed(x + 0.125, y, 1.0),  // 2 r_hip
      Observed(x - 0.125, y, 1.0),  // 3 l_hip
      Observed(x - 0.125, y, 0.5),  // 4 l_knee
      Observed(x - 0.125, y, 0.0),  // 5 l_ankle
      Observed(x + 0.25, y, 1.0),   // 6 r_wrist
      Observed(x + 0.25, y, 1.25),  // 7 r_elbow
      Observed(x + 0.25, y, 1.5),   // 8 r_shoulder
      Observed(x - 0.25, y, 1.5),   // 9 l_shoulder
      Observed(x - 0.25, y, 1.25),  // 10 l_elbow
      Observed(x - 0.25, y, 1.0),   // 11 l_wrist
      Observed(x, y, 1.5),          // 12 head_bottom
      Observed(x, y, 1.75),         // 13 head_top
  };
}

inline PersonPose Person(int64_t id, Pose3d joints) {
  PersonPose person;
  person.id = TrackId(id);
  person.joints = std::move(joints);
  return person;
}

// Frames of 25 Hz.
inline TrackFrame Frame(int64_t frame, std::vector<PersonPose> people) {
  return {frame, FrameClock(25.0).TimeOf(frame), std::move(people)};
}

inline TrackSequence Tracks(std::vector<TrackFrame> frames,
                            const Skeleton& skeleton = Tum14()) {
  TrackSequence tracks;
  tracks.header.skeleton = skeleton;
  tracks.header.frame_rate_hz = 25.0;
  tracks.frames = std::move(frames);
  return tracks;
}

// One person in frames 0, 1, ..., always the same.
inline TrackSequence Alone(const Pose3d& pose = StandingTum14(), int64_t id = 0,
                           int64_t frames = 1) {
  TrackSequence tracks = Tracks({});
  for (int64_t frame = 0; frame < frames; ++frame) {
    tracks.frames.push_back(Frame(frame, {Person(id, pose)}));
  }
  return tracks;
}

// Frames 0, 1, ... of people standing on the x axis, ID@X [m]: "0@0 1@3 | 0@0"
// are two frames.
inline TrackSequence Standing(const std::string& text) {
  TrackSequence tracks = Tracks({Frame(0, {})});
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const size_t at = word.find('@');
    if (at == std::string::npos) {
      tracks.frames.push_back(
          Frame(static_cast<int64_t>(tracks.frames.size()), {}));
      continue;
    }
    tracks.frames.back().people.push_back(
        Person(std::stoi(word), StandingTum14(std::stod(word.substr(at + 1)))));
  }
  return tracks;
}

// `pose` with all joints moved.
inline Pose3d Moved(Pose3d pose, double x, double y = 0.0, double z = 0.0) {
  for (Joint3d& joint : pose) joint.position_m += Eigen::Vector3d(x, y, z);
  return pose;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_EVALUATION_PEOPLE_H_
