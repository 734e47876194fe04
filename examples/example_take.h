// A small synthetic take for the examples: two people for four seconds, whose
// truth is known. Yours comes from cameras and a detector.
#ifndef KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_
#define KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_

#include <kinegraph/kinegraph.h>

struct ExampleTake {
  kinegraph::Scene scene;
  kinegraph::DetectionSequence detections;
  kinegraph::TrackSequence truth;
};

inline ExampleTake MakeExampleTake(double sigma_px = 3.0) {
  kinegraph::SceneOptions options;
  options.people = 2;
  options.duration_s = 4.0;
  kinegraph::NoiseOptions noise;
  noise.joints.sigma_px = sigma_px;
  ExampleTake take;
  take.scene = kinegraph::MakeScene(options);
  take.detections = kinegraph::Observe(take.scene, noise, nullptr);
  take.truth = kinegraph::TruthOf(take.scene);
  return take;
}

#endif  // KINEGRAPH_EXAMPLES_EXAMPLE_TAKE_H_
