// A person who walks in a circle in view of four cameras, and the resulting
// recording, to which a test adds a fault. input.match returns the true
// matches.
#ifndef KINEGRAPH_TESTS_SUPPORT_WALKERS_ROOM_H_
#define KINEGRAPH_TESTS_SUPPORT_WALKERS_ROOM_H_

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "solvers/scene/hypothesis.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {

// A person who walks on a circle with a radius of 1 m at 1 m/s, at 25 frames
// per second.
inline Pose3d WalkerOnARound(int frame) {
  return StandingPerson(std::cos(0.04 * frame), std::sin(0.04 * frame));
}

struct WalkersRoom {
  CameraRig cameras = RingOfCameras(4);
  DoctorInput input;
  DoctorOptions options;

  explicit WalkersRoom(int frames) {
    input.detections = SeenBy(cameras, frames, [](int frame) {
      return std::vector<Pose3d>{WalkerOnARound(frame)};
    });
    // The person is the first detection of every view that has one.
    input.match = [](const CameraRig&, const DetectionSequence& seen) {
      FrozenMatches matches;
      FrozenPerson& person = matches.people.emplace_back();
      for (const DetectionFrame& frame : seen.frames) {
        person.frames.push_back({frame.frame, frame.time, {}, true});
        for (size_t v = 0; v < frame.views.size(); ++v) {
          if (frame.views[v].detections.empty()) continue;
          person.frames.back().detections.push_back({static_cast<int>(v), 0});
        }
      }
      return matches;
    };
    options.bundle.segments.max_segments = 120;
  }

  ViewDetections& View(size_t frame, size_t view) {
    return input.detections.frames[frame].views[view];
  }

  // White Gaussian noise on every joint.
  void AddNoise(double sigma_px) {
    Random random(1);
    for (DetectionFrame& frame : input.detections.frames) {
      for (ViewDetections& view : frame.views) {
        for (Detection& detection : view.detections) {
          for (Keypoint& joint : detection.joints) {
            joint.px.x() += random.Normal(0.0, sigma_px);
            joint.px.y() += random.Normal(0.0, sigma_px);
          }
        }
      }
    }
  }

  SetUp Looked() {
    input.cameras = cameras;
    SetUp set_up(input, options);
    set_up.Look();
    return set_up;
  }
  SetUp Matched() {
    SetUp set_up = Looked();
    set_up.Match();
    return set_up;
  }
};

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_WALKERS_ROOM_H_
