// A simulation for the estimators: a ring of cameras, one person whose motion
// is drawn from the motion prior or is a walk, and detections with noise that a
// test chooses.
#ifndef KINEGRAPH_TESTS_SUPPORT_SIMULATED_PERSON_H_
#define KINEGRAPH_TESTS_SUPPORT_SIMULATED_PERSON_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/random.h"
#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph::testing {

// `count` cameras on a circle around the z axis at a height of 1 m, looking
// horizontally at the axis; images of 2000 x 2000 px. With a radius of 1e8 m
// the cameras are affine to within 1e-8 of the image size.
CameraRig RingOfCameras(int count, double radius_m, double focal_px,
                        bool with_lens = false);

// The defaults with the options' pixel noise, process noise and bone sigmas
// instead of learnt ones. A common factor of all pixel sigmas is still
// estimated (estimate_noise_scale).
GraphOptions FixedNoise();

// Shoulder, elbow and wrist with two bones.
Skeleton SmallSkeleton();

// A scene with SmallSkeleton and these cameras.
SceneModel SmallScene(CameraRig cameras, double frame_rate_hz);

struct SimulatedNoise {
  double sigma_scale = 1.0;  // times the noise model's sigma
  double correlation_time_s = 0.0;
  double missing = 0.0;   // probability that a joint is not found
  double outliers = 0.0;  // approximate share of gross outliers
  int outlier_burst = 1;  // duration of an outlier [frames]
  // Its size is uniform between these; the offset is constant during a burst.
  double outlier_low_px = 30.0;
  double outlier_high_px = 200.0;
  double confidence_low = 1.0;  // uniform between these
  double confidence_high = 1.0;
  // If false, only the first frame has an initial pose, with all joints at
  // `centre`, so that estimator and simulation have the same priors and sigmas.
  bool initial_poses = true;
};

struct SimulatedRecording {
  // By joint and frame.
  std::vector<std::vector<State>> truth;
  // Detections of `frames`, by frame and view.
  std::vector<std::vector<std::vector<Keypoint>>> keypoints;
  std::vector<EstimatorFrame> frames;

  // Copies edited `keypoints` into `frames`.
  void Connect();
};

// Motion drawn from the priors of `options`: birth around `centre`, white noise
// on acceleration. By joint and frame.
std::vector<std::vector<State>> MotionFromPrior(const SceneModel& scene,
                                                const GraphOptions& options,
                                                const Eigen::Vector3d& centre,
                                                int frame_count,
                                                Random* random);

// A rigid body that walks on a circle with a radius of 1 m at 1 m/s and
// bounces: bone lengths are constant. By joint and frame.
std::vector<std::vector<State>> WalkingMotion(const SceneModel& scene,
                                              int frame_count);

// Detections of the motion `truth` in every camera; sigmas follow the noise
// model of `options`. The initial position of a joint is the least-squares
// point of all rays including outliers, so it is worse than the tracker's;
// without SimulatedNoise::initial_poses it is `centre`.
SimulatedRecording Simulate(const SceneModel& scene,
                            const GraphOptions& options,
                            std::vector<std::vector<State>> truth,
                            const SimulatedNoise& noise,
                            const Eigen::Vector3d& centre, Random* random);
// The same with the origin as `centre` and random numbers from `seed`.
SimulatedRecording Simulate(const SceneModel& scene,
                            const GraphOptions& options,
                            std::vector<std::vector<State>> truth,
                            const SimulatedNoise& noise, uint64_t seed);

// The frames as a problem with the noise of `options`.
PersonProblem Assemble(const SceneModel& scene, const GraphOptions& options,
                       const std::vector<EstimatorFrame>& frames);

// The batch estimator or the window estimator.
std::unique_ptr<Estimator> MakeEstimator(bool batch, const SceneModel& scene,
                                         const GraphOptions& options);

// Runs all frames through an estimator and returns its finals.
std::vector<FinalPose> Run(Estimator* estimator,
                           const std::vector<EstimatorFrame>& frames);

// Distance [m] between two positions of a joint.
inline double Apart(const Joint3d& a, const Joint3d& b) {
  return (a.position_m - b.position_m).norm();
}
inline double Apart(const Joint3d& joint, const State& truth) {
  return (joint.position_m - truth.head<3>()).norm();
}

// Root mean square 3D error over present joints of frames from `first` on [m].
double RootMeanSquare(const std::vector<std::vector<State>>& truth,
                      const std::vector<FinalPose>& finals, size_t first = 0);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_SIMULATED_PERSON_H_
