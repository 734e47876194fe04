// Recordings that the tests of track formats write.
#ifndef KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_
#define KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_

#include <cstdlib>
#include <string>

#include "core/base/random.h"
#include "core/io/tracks/format.h"

namespace kinegraph::testing {

inline bool HasNumpy() {
  return std::system("/usr/bin/python3 -c 'import numpy' > /dev/null 2>&1") ==
         0;
}

// What the format loses.
inline LostFields WriteAs(const std::string& format, const std::string& path,
                          const TrackSequence& tracks,
                          const TrackExportOptions& options = {}) {
  LostFields lost_fields;
  FindTrackFormat(format)->write(path, tracks, options, &lost_fields);
  return lost_fields;
}

// Three people who come and go, among them nobody for a frame, numbers of all
// digits, every status. Frames have no gaps.
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
        // Somebody without any joint would not be there in most formats.
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

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_CORE_IO_TRACKS_RECORDINGS_H_
