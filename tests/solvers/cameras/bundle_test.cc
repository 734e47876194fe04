#include "solvers/cameras/bundle.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "solvers/cameras/refine.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::AngleBetween;
using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

BundleOptions Quick() {
  BundleOptions options;
  options.segments.max_segments = 500;
  return options;
}

SceneSegments SegmentsOf(const FaultyScene& scene,
                         const BundleOptions& options) {
  return MakeSegments(scene.cameras, scene.detections,
                      testing::MatchesOf(scene), options.segments);
}

// The scene with every camera rotated, each about another axis.
FaultyScene AllTurned(FaultyScene scene, double degrees, uint64_t seed) {
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    scene.cameras[v] = testing::Turned(scene.cameras[v], degrees, seed + v);
  }
  return scene;
}

BundleResult Adjusted(const FaultyScene& scene, const SceneSegments& segments,
                      const FreeParameters& free,
                      const BundleOptions& options = Quick()) {
  return AdjustBundle(scene.cameras, segments, free,
                      NoChanges(scene.cameras.size()), options);
}

Refinement Refined(const FaultyScene& scene, const RefineOptions& options) {
  return RefineScene(scene.cameras, scene.detections, testing::MatchesOf(scene),
                     options, Quick());
}

TEST(Bundle, RecoversRotations) {
  const FaultyScene scene = AllTurned(MakeFaultyScene({}), 0.5, 100);
  const CameraRig& truth = scene.scene.cameras;
  const SceneSegments segments = SegmentsOf(scene, Quick());
  ASSERT_GT(segments.segments.size(), 300u);
  FreeParameters free;
  free.rotation = true;
  const BundleResult result = Adjusted(scene, segments, free);
  ASSERT_TRUE(result.usable);
  const CameraRig refined = RefinedCameras(scene.cameras, result.changes);
  for (size_t v = 0; v < truth.size(); ++v) {
    // Required: a tenth of the introduced error, 0.05 degrees.
    EXPECT_LT(AngleBetween(refined[v], truth[v]), 0.05) << v;
    // Consistent with the covariance: an error beyond five sigmas has a
    // probability of 2e-5 if all three directions are equally certain.
    const double sigma =
        std::sqrt(result.covariance.block<3, 3>(3 * v, 3 * v).trace() / 3.0);
    EXPECT_LT(AngleBetween(refined[v], truth[v]) * M_PI / 180.0, 5.0 * sigma);
    EXPECT_GT(sigma, 0.0);
  }
}

TEST(Bundle, RecoversClocks) {
  FaultySceneOptions scene_options = {2};
  scene_options.clock_offset_s = {0.0, 0.04, -0.08, 0.06, 0.0};
  const FaultyScene scene = MakeFaultyScene(scene_options);
  const SceneSegments segments = SegmentsOf(scene, Quick());
  FreeParameters free;
  free.offset = true;
  const BundleResult result = Adjusted(scene, segments, free);
  ASSERT_TRUE(result.usable);
  EXPECT_EQ(result.changes[0][kOffsetAt], 0.0);  // the reference
  for (size_t v = 1; v < 5; ++v) {
    const auto at = static_cast<Eigen::Index>(v - 1);
    const double sigma_s = std::sqrt(result.covariance(at, at));
    // Five reported sigmas, which include the error of the reference view.
    EXPECT_NEAR(result.changes[v][kOffsetAt], scene_options.clock_offset_s[v],
                5.0 * sigma_s)
        << v;
    EXPECT_LT(sigma_s, 0.004) << v;
  }
}

TEST(Bundle, RecoversBothRadialTerms) {
  FaultyScene scene = MakeFaultyScene({4});
  CameraChange wrong = CameraChange::Zero();
  wrong[kLensAt] = -0.2;
  wrong[kLensK2At] = 0.5;
  for (Camera& camera : scene.cameras) camera = ChangedCamera(camera, wrong);
  const SceneSegments segments = SegmentsOf(scene, Quick());
  FreeParameters free;
  free.lens = free.lens_k2 = true;
  const BundleResult result = Adjusted(scene, segments, free);
  ASSERT_TRUE(result.usable);
  for (size_t v = 0; v < scene.cameras.size(); ++v) {
    for (const int place : {kLensAt, kLensK2At}) {
      // Within five reported sigmas, which are smaller than the terms.
      const double sigma = result.Sigma(v, place);
      EXPECT_NEAR(result.changes[v][place], -wrong[place], 5.0 * sigma) << v;
      EXPECT_LT(5.0 * sigma, std::abs(wrong[place])) << v;
    }
  }
}

// A recording hardly distinguishes a rotation from a shift of the image, so the
// priors determine how the error is divided between them. Checks errors of the
// shift relative to the reported sigmas, with calibrations drawn from the
// priors.
TEST(Bundle, ReportedSigmasMatchErrorsIfPriorsDominate) {
  constexpr int kSeeds = 40;
  BundleOptions options = Quick();
  options.segments.max_segments = 150;
  options.rotation_sigma_rad = 0.004;
  options.shift_sigma_px = 5.0;
  FreeParameters free;
  free.rotation = free.shift = true;
  double sum = 0.0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    FaultyScene scene = MakeFaultyScene({seed, 4, 2, 4.0});
    Random random(seed);
    std::vector<Eigen::Vector2d> shifts_px;
    for (Camera& camera : scene.cameras) {
      Eigen::Vector3d turn;
      for (int i = 0; i < 3; ++i) {
        turn[i] = options.rotation_sigma_rad * random.Normal();
      }
      shifts_px.emplace_back(options.shift_sigma_px * random.Normal(),
                             options.shift_sigma_px * random.Normal());
      camera = testing::Shifted(
          testing::WithExtrinsics(
              camera,
              Eigen::AngleAxisd(turn.norm(), turn.normalized()) * camera.R(),
              Eigen::AngleAxisd(turn.norm(), turn.normalized()) * camera.t()),
          shifts_px.back().x(), shifts_px.back().y());
    }
    const SceneSegments segments = SegmentsOf(scene, options);
    const BundleOptions lasting = WithLastingErrors(options, segments);
    ASSERT_GT(lasting.samples_at_once, 4.0);
    const BundleResult result = Adjusted(scene, segments, free, lasting);
    ASSERT_TRUE(result.usable);
    for (size_t v = 0; v < scene.cameras.size(); ++v) {
      for (int axis = 0; axis < 2; ++axis) {
        const double off =
            result.changes[v][kShiftAt + axis] + shifts_px[v][axis];
        const double sigma = result.Sigma(v, kShiftAt + axis);
        // The priors dominate: without rotations, the recording would determine
        // a shift to a fraction of a pixel.
        EXPECT_GT(sigma, 0.2 * options.shift_sigma_px);
        sum += off * off / (sigma * sigma) / (8.0 * kSeeds);
      }
    }
  }
  // The mean of eight squares of one seed has a standard deviation of at most
  // 2^0.5, that of 40 seeds 0.22. The tolerance is three of these.
  EXPECT_GT(sum, 1.0 - 0.67);
  EXPECT_LT(sum, 1.0 + 0.67);
}

// Mean squared error of the poses of four cameras along the eigenvectors of
// their covariance, in units of the eigenvalues, without the seven directions
// of the gauge. The scene's cameras are the truth.
double MeanSquareOf(const BundleResult& result) {
  constexpr Eigen::Index kHeld = 7;
  Eigen::VectorXd error(24);
  for (Eigen::Index v = 0; v < 4; ++v) {
    error.segment<6>(6 * v) = result.changes[v].head<6>();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      result.covariance);
  const Eigen::ArrayXd squares =
      (solver.eigenvectors().transpose() * error).array().square() /
      solver.eigenvalues().array();
  return squares.tail(error.size() - kHeld).mean();
}

// Four seconds consist of 20 blocks of time, fewer than the 24 parameters:
// without shrinkage, the scores of the blocks have no variance in some
// directions.
TEST(Bundle, FewTimeBlocksDoNotUnderestimateAnyDirection) {
  constexpr int kSeeds = 20;
  BundleOptions options = Quick();
  options.segments.max_segments = 300;
  const FreeParameters free = CameraParametersOf(RefineKind::kPose);
  double sum = 0.0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const FaultyScene scene = MakeFaultyScene({seed, 4, 2, 4.0});
    const BundleResult result =
        Adjusted(scene, SegmentsOf(scene, options), free, options);
    ASSERT_TRUE(result.usable);
    sum += MeanSquareOf(result) / kSeeds;
  }
  // The mean square of 340 normalised errors has a standard deviation of 0.08.
  // The limits of 0.5 and 2 allow for errors that persist longer than a block.
  EXPECT_GT(sum, 0.5);
  EXPECT_LT(sum, 2.0);
}

// Squared errors of rotations [rad] and of logarithms of focal lengths, summed
// over the views; the scene's cameras are the truth.
Eigen::Vector2d SquaresOf(const BundleResult& result) {
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  for (const CameraChange& change : result.changes) {
    squares[0] += change.segment<3>(kRotationAt).squaredNorm();
    squares[1] += change[kFocalAt] * change[kFocalAt];
  }
  return squares;
}

TEST(Bundle, PersistentOffsetsHardlyBiasCameras) {
  FaultyScene scene = MakeFaultyScene({1, 5, 4, 16.0});
  testing::AddLastingOffsets(4, 1.0, &scene);
  BundleOptions options;
  const SceneSegments segments = SegmentsOf(scene, options);
  FreeParameters free = CameraParametersOf(RefineKind::kPose);
  free.focal = true;
  const BundleResult without = Adjusted(scene, segments, free, options);
  options.lasting_offset_m = 0.011;
  const BundleResult with = Adjusted(scene, segments, free, options);
  ASSERT_TRUE(without.usable && with.usable);
  // The error is at least halved.
  EXPECT_LT(4.0 * SquaresOf(with)[0], SquaresOf(without)[0]);
  EXPECT_LT(4.0 * SquaresOf(with)[1], SquaresOf(without)[1]);
  // The prior must not bias all focal lengths in one direction. The tolerance
  // is five sigmas of the least certain focal length.
  double mean = 0.0;
  double sigma = 0.0;
  for (size_t v = 0; v < with.changes.size(); ++v) {
    mean +=
        with.changes[v][kFocalAt] / static_cast<double>(with.changes.size());
    sigma = std::max(sigma, with.Sigma(v, kFocalAt));
  }
  EXPECT_LT(std::abs(mean), 5.0 * sigma);
}

// The scene's cameras are the truth: every change of a lens or a rotation is an
// effect of the detector's offsets.
TEST(Bundle, PriorsThatCountPersistentErrorsOnceKeepLensesAccurate) {
  double lens[2] = {0.0, 0.0};  // squares, in units of the priors
  double rotation[2] = {0.0, 0.0};
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    FaultyScene scene = MakeFaultyScene({seed, 4, 4, 8.0});
    testing::AddLastingOffsets(seed, 1.0, &scene);
    BundleOptions options = Quick();
    options.lasting_offset_m = 0.007;
    options.shift_sigma_px = 15.0;
    options.lens_sigma = 0.2;
    const SceneSegments segments = SegmentsOf(scene, options);
    FreeParameters free = CameraParametersOf(RefineKind::kPose);
    free.shift = free.lens = free.lens_k2 = true;
    for (const bool once : {false, true}) {
      const BundleResult result =
          Adjusted(scene, segments, free,
                   once ? WithLastingErrors(options, segments) : options);
      ASSERT_TRUE(result.usable);
      for (const CameraChange& change : result.changes) {
        lens[once] += (change.segment<2>(kShiftAt) / options.shift_sigma_px)
                          .squaredNorm() +
                      std::pow(change[kLensAt] / options.lens_sigma, 2) +
                      std::pow(change[kLensK2At] / options.lens_sigma, 2);
        rotation[once] += change.segment<3>(kRotationAt).squaredNorm();
      }
    }
  }
  // With these seeds the squares fall to less than a quarter.
  EXPECT_LT(2.0 * lens[1], lens[0]);
  EXPECT_LT(2.0 * rotation[1], rotation[0]);
}

// The prior assumes offsets of 7 mm. Standard deviations must follow the actual
// offsets, with a root mean square of 18 mm or 37 mm per axis.
TEST(Bundle, StandardDeviationsFollowTheRecordingsOffsets) {
  constexpr int kSeeds = 8;
  BundleOptions options = Quick();
  options.lasting_offset_m = 0.007;
  options.segments.max_segments = 500;
  const FreeParameters free = CameraParametersOf(RefineKind::kPose);
  std::vector<double> sigmas(2, 0.0);
  double sum = 0.0;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    for (const int scale : {1, 2}) {
      FaultyScene scene = MakeFaultyScene({seed, 4, 4, 8.0});
      testing::AddLastingOffsets(seed, scale, &scene);
      const BundleResult result =
          Adjusted(scene, SegmentsOf(scene, options), free, options);
      ASSERT_TRUE(result.usable);
      for (size_t v = 0; v < 4; ++v) {
        sigmas[scale - 1] += result.Sigma(v, kRotationAt);
      }
      sum += MeanSquareOf(result) / (2 * kSeeds);
    }
  }
  // Doubled offsets nearly double the standard deviations; the noise that does
  // not persist is the same.
  EXPECT_GT(sigmas[1], 1.5 * sigmas[0]);
  EXPECT_LT(sigmas[1], 2.0 * sigmas[0]);
  // The mean square of 272 normalised errors has a standard deviation of 0.09.
  // The offsets of this scene have no common part, for which the covariance
  // allows: it may be up to three times as large as needed. The upper limit
  // allows for the few large offsets of a heavy-tailed distribution.
  EXPECT_GT(sum, 0.3);
  EXPECT_LT(sum, 2.0);
}

// Copies of measurements multiply the scores by n and their variance by n^2,
// but the information only by n.
TEST(Bundle, CopiesOfMeasurementsAreNoNewSamples) {
  const FaultyScene scene = MakeFaultyScene({1, 4, 2, 8.0});
  const BundleOptions options = Quick();
  const FreeParameters free = CameraParametersOf(RefineKind::kPose);
  SceneSegments segments = SegmentsOf(scene, options);
  const std::vector<MotionSegment> all = segments.segments;
  const auto with_copies = [&](int count) {
    segments.segments.clear();
    for (int copy = 0; copy < count; ++copy) {
      segments.segments.insert(segments.segments.end(), all.begin(), all.end());
    }
    return Adjusted(scene, segments, free, options).samples_at_once;
  };
  EXPECT_EQ(with_copies(1), 1.0);  // errors of this scene hardly persist
  const double four = with_copies(4);
  EXPECT_GT(four, 1.0);
  // The priors, which are not copied, have a small share of the information.
  EXPECT_NEAR(with_copies(8) / four, 2.0, 0.02);
}

// Allocates many small blocks of memory and frees about a third of them in
// random order, so that the heap reuses them in random order.
std::vector<std::vector<char>> ShuffledHeap() {
  std::vector<std::vector<char>> pieces;
  for (size_t i = 0; i < 40000; ++i) pieces.emplace_back(16 + 16 * (i / 2 % 8));
  Random random(1);
  for (size_t i = 1; i < pieces.size(); i += 2) {
    const auto count = static_cast<int64_t>(pieces.size() / 2);
    std::vector<char>().swap(pieces[2 * random.Index(count) + 1]);
  }
  return pieces;
}

TEST(Bundle, ResultDoesNotDependOnTheHeap) {
  FaultyScene scene = MakeFaultyScene({1, 3, 4, 8.0});
  testing::AddLastingOffsets(4, 1.0, &scene);
  BundleOptions options = Quick();
  options.lasting_offset_m = 0.011;
  options.max_iterations = 5;
  const SceneSegments segments = SegmentsOf(scene, options);
  const FreeParameters free = CameraParametersOf(RefineKind::kPose);
  const BundleResult first = Adjusted(scene, segments, free, options);
  const auto held = ShuffledHeap();
  const BundleResult second = Adjusted(scene, segments, free, options);
  ASSERT_TRUE(first.usable && second.usable);
  for (size_t v = 0; v < first.changes.size(); ++v) {
    EXPECT_NE(first.changes[v], CameraChange::Zero()) << v;
    EXPECT_EQ(first.changes[v], second.changes[v]) << v;  // to the bit
  }
  EXPECT_GT(first.covariance.trace(), 0.0);
  EXPECT_TRUE(first.covariance == second.covariance);
}

TEST(Bundle, FocalPriorIsRelativeToTheGivenFocalLength) {
  FaultyScene scene = MakeFaultyScene(FaultySceneOptions());
  const SceneSegments segments = SegmentsOf(scene, Quick());
  FreeParameters free;
  free.focal = true;
  BundleOptions options = Quick();
  options.focal_sigma = 1e-4;  // comparable to the recording's information
  // The prior's focal lengths are 1 % greater than those of the cameras.
  options.focal_prior.assign(scene.cameras.size(), 0.01);
  const BundleResult first = Adjusted(scene, segments, free, options);
  const CameraRig refined = RefinedCameras(scene.cameras, first.changes);
  for (size_t v = 0; v < refined.size(); ++v) {
    options.focal_prior[v] -= first.changes[v][kFocalAt];
  }
  const BundleResult second =
      AdjustBundle(refined, segments, free, NoChanges(refined.size()), options);
  for (size_t v = 0; v < refined.size(); ++v) {
    EXPECT_GT(first.changes[v][kFocalAt], 1e-4) << v;
    // The same minimum up to the solver's termination.
    EXPECT_LT(std::abs(second.changes[v][kFocalAt]), 1e-5) << v;
  }
}

TEST(Bundle, GaugeConstraintsHold) {
  const FaultyScene scene = AllTurned(MakeFaultyScene({3}), 0.3, 200);
  const SceneSegments segments = SegmentsOf(scene, Quick());
  const BundleResult result =
      Adjusted(scene, segments, CameraParametersOf(RefineKind::kPose));
  ASSERT_TRUE(result.usable);
  Eigen::Vector3d turned = Eigen::Vector3d::Zero();
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Camera& camera : scene.cameras) middle += camera.centre() / 5.0;
  double stretched = 0.0;
  double squares = 0.0;
  for (size_t v = 0; v < 5; ++v) {
    const CameraChange& change = result.changes[v];
    const Eigen::Vector3d arm = scene.cameras[v].centre() - middle;
    turned +=
        scene.cameras[v].R().transpose() * change.segment<3>(kRotationAt) / 5.0;
    moved += change.segment<3>(kCentreAt) / 5.0;
    stretched += arm.dot(change.segment<3>(kCentreAt));
    squares += arm.squaredNorm();
  }
  // The constraints have sigmas of 1e-5 (m, rad, ratio), compared with which
  // the recording's information is negligible.
  EXPECT_LT(turned.norm(), 1e-4);
  EXPECT_LT(moved.norm(), 1e-4);
  EXPECT_LT(std::abs(stretched / squares), 1e-4);
}

TEST(Refine, DoesNotChangeCorrectCameras) {
  const FaultyScene scene = MakeFaultyScene({4});
  RefineOptions options;
  options.refine = RefineKind::kRotation;
  options.refine_clock = true;
  const Refinement refinement = Refined(scene, options);
  ASSERT_EQ(refinement.steps.size(), 2u);
  for (const RefineStep& step : refinement.steps) {
    EXPECT_FALSE(step.taken) << step.what;
    EXPECT_FALSE(step.reason.empty());
  }
  for (const CameraChange& change : refinement.changes) {
    EXPECT_EQ(change, CameraChange::Zero());
  }
}

TEST(Refine, AcceptsAGainOnTheHeldOutHalf) {
  const FaultyScene scene = AllTurned(MakeFaultyScene({5}), 0.5, 300);
  RefineOptions options;
  options.refine = RefineKind::kRotation;
  const Refinement refinement = Refined(scene, options);
  ASSERT_EQ(refinement.steps.size(), 1u);
  const RefineStep& step = refinement.steps[0];
  EXPECT_TRUE(step.taken);
  EXPECT_TRUE(step.gain.certain());
  EXPECT_LT(step.gain.after_px, step.gain.before_px);
}

TEST(Refine, RejectsTooFewMatches) {
  const FaultyScene scene = MakeFaultyScene({1, 5, 4, 2.0});
  RefineOptions options;
  options.refine = RefineKind::kShift;
  const Refinement refinement = RefineScene(scene.cameras, scene.detections,
                                            FrozenMatches(), options, Quick());
  ASSERT_EQ(refinement.steps.size(), 1u);
  EXPECT_FALSE(refinement.steps[0].taken);
  EXPECT_EQ(refinement.steps[0].reason, "too few matches");
}

// Frames 0, 1, ... at 25 Hz; a clock that is 70 ms late moves a measurement by
// two frames.
TEST(Refine, LateMeasurementsMoveToTheNearestFrame) {
  DetectionSequence detections;
  detections.header.view_names = {"a", "b"};
  for (int k = 0; k < 10; ++k) {
    DetectionFrame& frame = detections.frames.emplace_back();
    frame.frame = k;
    frame.time = FromSeconds(0.04 * k);
    frame.views.resize(2);
    for (ViewDetections& view : frame.views) {
      view.capture_time = frame.time;
      view.detections.resize(1);
      view.detections[0].index_in_file = k;
    }
  }
  std::vector<CameraChange> changes(2, CameraChange::Zero());
  changes[1][kOffsetAt] = 0.07;
  const DetectionSequence moved = WithClocks(detections, changes);
  ASSERT_EQ(moved.frames.size(), 10u);
  for (size_t k = 2; k < 10; ++k) {
    EXPECT_EQ(moved.frames[k].views[0].detections[0].index_in_file,
              static_cast<int>(k));
    ASSERT_EQ(moved.frames[k].views[1].detections.size(), 1u) << k;
    EXPECT_EQ(moved.frames[k].views[1].detections[0].index_in_file,
              static_cast<int>(k) - 2);
    EXPECT_EQ(moved.frames[k].views[1].capture_time,
              detections.frames[k - 2].time + FromSeconds(0.07));
  }
  EXPECT_TRUE(moved.frames[0].views[1].detections.empty());
  EXPECT_TRUE(moved.frames[1].views[1].detections.empty());
}

}  // namespace
}  // namespace kinegraph
