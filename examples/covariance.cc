// Uncertainty of a joint: prints, for every tenth frame if one person is in it,
// the longest 95 % half-axis of the left wrist next to its true error in a
// synthetic scene.
#include <kinegraph/kinegraph.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>

#include "example_take.h"

int main() {
  const ExampleRecording recording = MakeExampleRecording();

  kinegraph::RunOptions options;
  options.estimators.mode = kinegraph::Mode::kGraph;
  kinegraph::RunRequest request;
  request.cameras = recording.scene.cameras;
  const kinegraph::TrackSequence tracks =
      kinegraph::TrackSequenceOf(options, request, recording.detections);

  // 95 % of a Gaussian in three dimensions lie within 2.795 sigmas.
  constexpr double kSigmas = 2.795;
  const int wrist = recording.scene.skeleton.IndexOf("l_wrist");
  int count = 0;
  for (size_t k = 0; k < tracks.frames.size(); k += 10) {
    // With one person in the frame, no matching with the truth is needed.
    if (tracks.frames[k].people.size() != 1) continue;
    if (recording.truth.frames[k].people.size() != 1) continue;
    const kinegraph::PersonPose& person = tracks.frames[k].people[0];
    if (!person.joints[wrist].present()) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
        *person.covariances[wrist]);
    const double error_m =
        (person.joints[wrist].position_m -
         recording.truth.frames[k].people[0].joints[wrist].position_m)
            .norm();
    std::printf("frame %3lld: %s, error %4.1f mm, 95 %% half-axis %4.1f mm\n",
                static_cast<long long>(tracks.frames[k].frame),
                ToString(person.joints[wrist].status), 1e3 * error_m,
                1e3 * kSigmas * std::sqrt(axes.eigenvalues().maxCoeff()));
    ++count;
  }
  return count > 0 ? 0 : 1;
}
