// A small synthetic recording with known truth: two people for four seconds.
#ifndef KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_
#define KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_

#include <kinegraph/kinegraph.h>

struct ExampleRecording {
  kinegraph::Scene scene;
  kinegraph::DetectionSequence detections;
  kinegraph::TrackSequence truth;
};

inline ExampleRecording MakeExampleRecording(double sigma_px = 3.0) {
  kinegraph::SceneOptions options;
  options.people = 2;
  options.duration_s = 4.0;
  kinegraph::NoiseOptions noise;
  noise.joints.sigma_px = sigma_px;
  ExampleRecording recording;
  recording.scene = kinegraph::MakeScene(options);
  recording.detections = kinegraph::Observe(recording.scene, noise, nullptr);
  recording.truth = kinegraph::TruthOf(recording.scene);
  return recording;
}

#endif  // KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_
