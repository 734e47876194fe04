// A recording whose bones keep their lengths, for formats that turn rigid
// bones.
#ifndef KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_
#define KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <string>

#include "core/data/pose.h"

namespace kinegraph::testing {

// A direction that moves smoothly, another for each seed.
inline Eigen::Vector3d Direction(int64_t frame, double seed) {
  const double t = 0.04 * static_cast<double>(frame);
  return Eigen::Vector3d(std::sin(t * 1.1 + 3.1 * seed) + 0.2,
                         std::cos(t * 0.7 + 1.7 * seed),
                         std::sin(t * 0.5 + 0.9 * seed) + 0.3)
      .normalized();
}

inline Eigen::Quaterniond Turn(int64_t frame, double seed) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(
      0.05 * static_cast<double>(frame) + seed, Direction(0, seed)));
}

// Every joint of BODY_25 for one person in a frame.
inline std::map<std::string, Eigen::Vector3d> Body25At(int64_t frame,
                                                       double seed) {
  using Eigen::Vector3d;
  std::map<std::string, Vector3d> at;
  at["mid_hip"] = {0.02 * static_cast<double>(frame) + seed, 1.0 - seed, 0.95};
  const Vector3d hips = Direction(frame, seed + 1.0);
  at["l_hip"] = at["mid_hip"] + 0.11 * hips;
  at["r_hip"] = at["mid_hip"] - 0.11 * hips;
  at["neck"] = at["mid_hip"] + 0.52 * Direction(frame, seed + 2.0);
  const Vector3d shoulders = Direction(frame, seed + 3.0);
  at["l_shoulder"] = at["neck"] + 0.17 * shoulders;
  at["r_shoulder"] = at["neck"] - 0.17 * shoulders;
  double limb = seed + 4.0;
  const auto bone = [&](const std::string& from, const std::string& to,
                        double length_m) {
    limb += 1.3;
    at[to] = at[from] + length_m * Direction(frame, limb);
  };
  bone("neck", "nose", 0.24);
  for (const std::string side : {"l_", "r_"}) {
    bone(side + "shoulder", side + "elbow", 0.30);
    bone(side + "elbow", side + "wrist", 0.25);
    bone(side + "hip", side + "knee", 0.42);
    bone(side + "knee", side + "ankle", 0.41);
    bone("nose", side + "eye", 0.04);
    bone(side + "eye", side + "ear", 0.11);
    // A foot is rigid.
    const Eigen::Quaterniond foot = Turn(frame, limb);
    at[side + "big_toe"] =
        at[side + "ankle"] + foot * Vector3d(0.18, 0.03, -0.06);
    at[side + "small_toe"] =
        at[side + "ankle"] + foot * Vector3d(0.15, -0.05, -0.07);
    at[side + "heel"] = at[side + "ankle"] + foot * Vector3d(-0.05, 0.0, -0.08);
  }
  return at;
}

inline PersonPose PersonAt(int64_t frame, int64_t id) {
  PersonPose person;
  person.id = TrackId(id);
  const auto at = Body25At(frame, 0.3 * static_cast<double>(id));
  size_t j = 0;
  for (const std::string& joint : Body25().joints()) {
    person.joints.push_back({at.at(joint), j % 5 == 4
                                               ? JointStatus::kInferred
                                               : JointStatus::kObserved});
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    covariance *= 1e-6 * static_cast<double>(1 + j * j);
    covariance(0, 1) = covariance(1, 0) = 2e-7;
    person.covariances.emplace_back(covariance);
    person.inlier_views.push_back(static_cast<int>(j % 4));
    ++j;
  }
  return person;
}

// 40 frames from 300 on at 50 Hz without 311. Person 3 is there throughout,
// person 12 from 305 to 331 but not from 315 to 318; the right wrist of person
// 3 is missing in 308 to 310, the left elbow of person 12 in all frames.
inline TrackSequence MakeRecording() {
  TrackSequence recording;
  recording.header.skeleton = Body25();
  recording.header.frame_rate_hz = 50.0;
  recording.header.mode = "graph";
  const auto wrist = static_cast<size_t>(Body25().IndexOf("r_wrist"));
  const auto elbow = static_cast<size_t>(Body25().IndexOf("l_elbow"));
  for (int64_t f = 300; f < 340; ++f) {
    if (f == 311) continue;
    TrackFrame frame;
    frame.frame = f;
    frame.time = f * 20'000'000;
    frame.people.push_back(PersonAt(f, 3));
    if (f >= 308 && f <= 310) {
      frame.people[0].joints[wrist] = {};
      frame.people[0].covariances[wrist].reset();
    }
    if (f >= 305 && f <= 331 && !(f >= 315 && f <= 318)) {
      frame.people.push_back(PersonAt(f, 12));
      frame.people[1].joints[elbow] = {};
      frame.people[1].covariances[elbow].reset();
    }
    recording.frames.push_back(frame);
  }
  return recording;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_APPS_FORMATS_RECORDING_H_
