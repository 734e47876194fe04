// Tests that the detector's bias by viewing direction is learnt from recordings
// with a known bias.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "solvers/noise/bias_model.h"
#include "solvers/session/run.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

// One person who walks for 20 s in view of four cameras.
FaultyScene Walker() { return MakeFaultyScene({31, 4, 1, 20.0}); }

// The bias of a detector that displaces hips by 4 cm times sin 2p, where p is
// the camera's azimuth. The bias is 0 in frontal, side and rear views.
ViewBias BiasOfHips() {
  ViewBias bias;
  ViewBias::OfJoint& hip = bias.joints.emplace_back();
  hip.joint = "hip";
  hip.used = true;
  hip.across_m[4] = 0.04;
  return bias;
}

void AddBias(const ViewBias& bias, FaultyScene* scene) {
  const TrackSequence truth = TruthOf(scene->scene);
  const DetectionPredictor detector(truth.header.skeleton, bias);
  for (size_t k = 0; k < truth.frames.size(); ++k) {
    ASSERT_EQ(truth.frames[k].frame, scene->detections.frames[k].frame);
    ASSERT_EQ(truth.frames[k].people.size(), 1u);
    const PersonPose& person = truth.frames[k].people[0];
    for (size_t v = 0; v < scene->cameras.size(); ++v) {
      for (Detection& seen : scene->detections.frames[k].views[v].detections) {
        for (size_t j = 0; j < seen.joints.size(); ++j) {
          seen.joints[j].px +=
              detector.BiasOf(person, static_cast<int>(j), scene->cameras[v]);
        }
      }
    }
  }
}

struct Outcome {
  ViewBias bias;
  double hips_mm = 0.0;  // root mean square error
  double all_mm = 0.0;
};

Outcome Track(const FaultyScene& scene, ViewBiasUse use, int threads = 1) {
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  options.estimators.output = OutputKind::kBatch;
  options.estimators.graph.solver = GraphSolver::kBlockTridiagonal;
  options.estimators.graph.pixel_noise_from = NoiseFrom::kRecording;
  options.estimators.graph.process_noise_from = NoiseFrom::kRecording;
  options.estimators.graph.view_bias = use;
  options.tracker.life.second_pass = true;
  RunRequest request;
  request.cameras = scene.cameras;
  request.threads = threads;
  Outcome outcome;
  const TrackSequence tracks =
      TrackSequenceOf(options, request, scene.detections, &outcome.bias);
  const TrackSequence truth = TruthOf(scene.scene);
  double hips = 0.0, all = 0.0;
  int hip_count = 0, count = 0;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        const double square = (person.joints[j].position_m -
                               truth.frames[static_cast<size_t>(frame.frame)]
                                   .people[0]
                                   .joints[j]
                                   .position_m)
                                  .squaredNorm();
        all += square;
        ++count;
        const std::string& name = truth.header.skeleton.joints()[j];
        if (name != "l_hip" && name != "r_hip") continue;
        hips += square;
        ++hip_count;
      }
    }
  }
  EXPECT_GT(hip_count, 900);  // of 1000
  outcome.hips_mm = 1000.0 * std::sqrt(hips / hip_count);
  outcome.all_mm = 1000.0 * std::sqrt(all / count);
  return outcome;
}

TEST(SessionViewBias, KnownBiasIsLearntAndRemoved) {
  FaultyScene scene = Walker();
  AddBias(BiasOfHips(), &scene);
  const Outcome off = Track(scene, ViewBiasUse::kOff);
  const Outcome learnt = Track(scene, ViewBiasUse::kAuto);
  RecordProperty("hips_mm", std::to_string(off.hips_mm) + " to " +
                                std::to_string(learnt.hips_mm));
  EXPECT_LT(learnt.hips_mm, 0.8 * off.hips_mm);
  for (const ViewBias::OfJoint& joint : learnt.bias.joints) {
    if (joint.joint != "hip") continue;
    EXPECT_TRUE(joint.used);
    EXPECT_NEAR(joint.across_m[4], 0.04, 0.01);  // to a quarter of the bias
  }
}

TEST(SessionViewBias, UnbiasedDetectionsLoseNoAccuracy) {
  const FaultyScene scene = Walker();
  const Outcome off = Track(scene, ViewBiasUse::kOff);
  const Outcome learnt = Track(scene, ViewBiasUse::kAuto);
  EXPECT_LT(learnt.all_mm, 1.01 * off.all_mm);
}

TEST(SessionViewBias, ThreadsDoNotChangeResults) {
  FaultyScene scene = Walker();
  AddBias(BiasOfHips(), &scene);
  const Outcome one = Track(scene, ViewBiasUse::kOn, 1);
  const Outcome three = Track(scene, ViewBiasUse::kOn, 3);
  EXPECT_EQ(one.hips_mm, three.hips_mm);
  ASSERT_EQ(one.bias.joints.size(), three.bias.joints.size());
  for (size_t i = 0; i < one.bias.joints.size(); ++i) {
    EXPECT_EQ(one.bias.joints[i].across_m, three.bias.joints[i].across_m);
    EXPECT_EQ(one.bias.joints[i].along_m, three.bias.joints[i].along_m);
  }
}

}  // namespace
}  // namespace kinegraph
