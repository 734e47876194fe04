// A recording with constant bone lengths, for formats that store rotations of
// rigid bones.
#ifndef KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_
#define KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_

#include <vector>

#include "tests/core/io/tracks/recordings.h"

namespace kinegraph::testing {

// A person of RigidTruth() with covariances and views.
inline PersonPose PersonOf(const TrackFrame& rigid, int64_t id) {
  PersonPose person = rigid.people[0];
  person.id = TrackId(id);
  for (size_t j = 0; j < person.joints.size(); ++j) {
    if (j % 5 == 4) person.joints[j].status = JointStatus::kInferred;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    covariance *= 1e-6 * static_cast<double>(1 + j * j);
    covariance(0, 1) = covariance(1, 0) = 2e-7;
    person.covariances.emplace_back(covariance);
    person.inlier_views.push_back(static_cast<int>(j % 4));
  }
  return person;
}

// Frames 300 to 339 at 50 Hz, without 311. Person 3 is present throughout,
// person 12 from 305 to 331 but not from 315 to 318; the right wrist of person
// 3 is missing in 308 to 310, the left elbow of person 12 in all frames.
inline TrackSequence MakeRecording() {
  TrackSequence recording;
  recording.header.skeleton = Body25();
  recording.header.frame_rate_hz = 50.0;
  recording.header.mode = "graph";
  const auto wrist = static_cast<size_t>(Body25().IndexOf("r_wrist"));
  const auto elbow = static_cast<size_t>(Body25().IndexOf("l_elbow"));
  const std::vector<TrackFrame> rigid = RigidTruth(Body25(), 80).frames;
  for (int64_t f = 300; f < 340; ++f) {
    if (f == 311) continue;
    const auto at = static_cast<size_t>(f - 300);
    TrackFrame frame;
    frame.frame = f;
    frame.time = f * 20'000'000;
    frame.people.push_back(PersonOf(rigid[at], 3));
    if (f >= 308 && f <= 310) {
      frame.people[0].joints[wrist] = {};
      frame.people[0].covariances[wrist].reset();
    }
    if (f >= 305 && f <= 331 && !(f >= 315 && f <= 318)) {
      frame.people.push_back(PersonOf(rigid[at + 40], 12));
      frame.people[1].joints[elbow] = {};
      frame.people[1].covariances[elbow].reset();
    }
    recording.frames.push_back(frame);
  }
  return recording;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_
