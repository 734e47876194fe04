// A custom factor: feet near the floor rest on it. It is a cost function of
// Ceres on the states of the solve, position and velocity of a joint in a
// frame; estimates and covariances include it. Prints the error of the ankles
// in a synthetic scene without and with it.
#include <ceres/autodiff_cost_function.h>
#include <kinegraph/kinegraph.h>

#include <cstdio>
#include <string>
#include <vector>

#include "example_take.h"

// Residuals in sigmas: an ankle at rest is at one height and does not move.
struct FloorContact {
  static constexpr double kHeightM = 0.07, kSigmaM = 0.01;
  static constexpr double kSigmaMps = 0.1;

  template <typename T>
  bool operator()(const T* state, T* residuals) const {  // [p; v], m and m/s
    residuals[0] = (state[2] - kHeightM) / kSigmaM;
    for (int i = 0; i < 3; ++i) residuals[1 + i] = state[3 + i] / kSigmaMps;
    return true;
  }
};

// Called for each frame of each person, with the triangulated pose if there is
// one.
std::vector<kinegraph::UserFactor> FeetOnTheFloor(
    const kinegraph::UserFrame& frame) {
  std::vector<kinegraph::UserFactor> factors;
  if (frame.initial == nullptr) return factors;
  for (const char* name : {"l_ankle", "r_ankle"}) {
    const int joint = frame.skeleton->IndexOf(name);
    const kinegraph::Joint3d& ankle = (*frame.initial)[joint];
    if (!ankle.present() || ankle.position_m.z() > 0.10) continue;
    kinegraph::UserFactor contact;
    contact.factor = kinegraph::FromCeres(
        new ceres::AutoDiffCostFunction<FloorContact, 4, 6>(new FloorContact));
    contact.states = {{joint, 0}};
    // The loss releases a foot that swings low without contact.
    contact.loss = kinegraph::LossKind::kGemanMcClure;
    contact.loss_scale = 2.0;
    factors.push_back(contact);
  }
  return factors;
}

double AnkleError(const kinegraph::TrackSequence& truth,
                  const kinegraph::TrackSequence& tracks) {
  double sum_m = 0.0;
  for (const kinegraph::JointError& joint :
       kinegraph::EvaluateMpjpe(truth, tracks).joints) {
    if (joint.joint == "l_ankle" || joint.joint == "r_ankle") {
      sum_m += joint.raw_m;
    }
  }
  return sum_m / 2.0;
}

int main() {
  const ExampleRecording recording = MakeExampleRecording(6.0);

  kinegraph::RunOptions options;
  options.estimators.mode = kinegraph::Mode::kGraph;
  options.estimators.graph.solver = kinegraph::GraphSolver::kCeres;
  kinegraph::RunRequest request;
  request.cameras = recording.scene.cameras;
  const double without_m = AnkleError(
      recording.truth,
      kinegraph::TrackSequenceOf(options, request, recording.detections));
  options.estimators.graph.user_factors = FeetOnTheFloor;
  const double with_m = AnkleError(
      recording.truth,
      kinegraph::TrackSequenceOf(options, request, recording.detections));
  std::printf("mean error of the ankles: %.1f mm, with the floor %.1f mm\n",
              1e3 * without_m, 1e3 * with_m);
  return with_m < without_m ? 0 : 1;
}
