// Processes detections from memory, one frame at a time, as a live program
// does, and uses each frame as soon as it is final. Here the detections are
// synthetic.
#include <kinegraph/kinegraph.h>

#include <cstdio>

#include "example_take.h"

int main() {
  const ExampleRecording recording = MakeExampleRecording();

  kinegraph::RunOptions options;
  options.estimators.mode = kinegraph::Mode::kGraph;
  options.estimators.graph.lag_s = 0.2;  // delay until a frame is final
  kinegraph::RunRequest request;
  request.cameras = recording.scene.cameras;
  kinegraph::Session session(options, request, recording.detections.header);

  const auto use = [](const std::vector<kinegraph::TrackFrame>& frames) {
    for (const kinegraph::TrackFrame& frame : frames) {
      for (const kinegraph::PersonPose& person : frame.people) {
        const kinegraph::Joint3d& nose = person.joints[0];
        if (!nose.present() || frame.frame % 25 != 0) continue;
        std::printf("frame %3lld person %lld nose at %.2f %.2f %.2f m\n",
                    static_cast<long long>(frame.frame),
                    static_cast<long long>(person.id.value()),
                    nose.position_m.x(), nose.position_m.y(),
                    nose.position_m.z());
      }
    }
  };
  for (const kinegraph::DetectionFrame& frame : recording.detections.frames) {
    use(session.Process(frame));
  }
  use(session.Finish());
  std::printf("%lld poses of %lld people\n",
              static_cast<long long>(session.summary().person_frames),
              static_cast<long long>(session.summary().people));
  return session.summary().person_frames > 0 ? 0 : 1;
}
