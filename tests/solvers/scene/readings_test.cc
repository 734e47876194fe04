#include "solvers/scene/readings.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "solvers/scene/clock_search.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

ReadingSearch SearchOf(const FaultyScene& scene) {
  const std::vector<ViewPeople> raw = PeopleOfViews(scene.detections, 0.3);
  return SearchReadings(scene.cameras, raw, FramesToLookAt(raw, 20));
}

FaultyScene ShortScene(uint64_t seed) {
  FaultySceneOptions options;
  options.seed = seed;
  options.cameras = 4;
  options.duration_s = 4.0;
  return MakeFaultyScene(options);
}

TEST(Readings, ASoundCalibrationIsReadAsItIs) {
  const ReadingSearch search = SearchOf(ShortScene(1));
  EXPECT_TRUE(search.better.empty());
  EXPECT_GT(search.as_read.score(), 0.5);
}

// What a file holds when it was written under another convention, read as if
// it were world to camera.
struct Convention {
  const char* name;
  PoseReading reading;
  // The R and t that such a file holds of a camera.
  std::function<Camera(const Camera&)> stated;
};

std::vector<Convention> Conventions() {
  const auto pose = [](const Camera& camera, const Eigen::Matrix3d& R,
                       const Eigen::Vector3d& t) {
    return testing::WithExtrinsics(camera, R, t);
  };
  return {
      {"inverse", PoseReading::kInverse,
       [=](const Camera& c) { return pose(c, c.R().transpose(), c.centre()); }},
      {"centre", PoseReading::kCentre,
       [=](const Camera& c) { return pose(c, c.R(), c.centre()); }},
      {"translation", PoseReading::kTranslation,
       [=](const Camera& c) { return pose(c, c.R(), -(c.R() * c.t())); }},
      {"transposed", PoseReading::kTransposed,
       [=](const Camera& c) { return pose(c, c.R().transpose(), c.t()); }},
      {"axes", PoseReading::kAxesUp,
       [=](const Camera& c) {
         const Eigen::Vector3d signs(1.0, -1.0, -1.0);
         return pose(c, signs.asDiagonal() * c.R(), signs.asDiagonal() * c.t());
       }},
  };
}

TEST(Readings, ConventionsAreNamed) {
  for (const Convention& convention : Conventions()) {
    FaultyScene scene = ShortScene(2);
    const CameraRig truth = scene.cameras;
    for (Camera& camera : scene.cameras) camera = convention.stated(camera);
    const ReadingSearch search = SearchOf(scene);
    ASSERT_FALSE(search.better.empty()) << convention.name;
    const Reading& found = search.better.front().reading;
    EXPECT_EQ(found.pose, convention.reading) << convention.name;
    // The very cameras come back.
    const CameraRig cameras = CamerasOf(scene.cameras, found);
    for (size_t v = 0; v < truth.size(); ++v) {
      EXPECT_LT((cameras[v].centre() - truth[v].centre()).norm(), 1e-9);
      EXPECT_LT((cameras[v].R() - truth[v].R()).norm(), 1e-9);
    }
  }
}

TEST(Readings, ExchangedViewsAreNamed) {
  FaultyScene scene = ShortScene(3);
  std::swap(scene.cameras[1], scene.cameras[3]);
  const ReadingSearch search = SearchOf(scene);
  ASSERT_FALSE(search.better.empty());
  EXPECT_EQ(search.better.front().reading.camera_of_view,
            (std::vector<int>{0, 3, 2, 1}));
}

TEST(Readings, TurnedAndMirroredImagesAreNamed) {
  for (const ImageReading image :
       {ImageReading::kRotated90, ImageReading::kRotated180,
        ImageReading::kRotated270, ImageReading::kMirrored}) {
    FaultyScene scene = ShortScene(4);
    const double width = scene.cameras[2].width_px();
    const double height = scene.cameras[2].height_px();
    for (DetectionFrame& frame : scene.detections.frames) {
      for (Detection& detection : frame.views[2].detections) {
        for (Keypoint& joint : detection.joints) {
          const Eigen::Vector2d px = joint.px;
          if (image == ImageReading::kRotated90) {
            joint.px = {height - 1.0 - px.y(), px.x()};
          } else if (image == ImageReading::kRotated180) {
            joint.px = {width - 1.0 - px.x(), height - 1.0 - px.y()};
          } else if (image == ImageReading::kRotated270) {
            joint.px = {px.y(), width - 1.0 - px.x()};
          } else {
            joint.px = {width - 1.0 - px.x(), px.y()};
          }
        }
      }
    }
    const ReadingSearch search = SearchOf(scene);
    ASSERT_FALSE(search.better.empty()) << Describe(image);
    const Reading& found = search.better.front().reading;
    EXPECT_EQ(found.images[2], image);
    EXPECT_EQ(found.images[0], ImageReading::kAsRead);
    // A camera that sees the images as they were shown sees the people where
    // they were detected.
    const auto seeing = Seeing(scene.cameras[2], image);
    EXPECT_EQ(seeing.has_value(), image != ImageReading::kMirrored);
    if (!seeing.has_value()) continue;
    scene.cameras[2] = *seeing;
    EXPECT_TRUE(SearchOf(scene).better.empty()) << Describe(image);
  }
}

// A camera that sees turned images has a lens that turns with them.
TEST(Readings, TurnedCamerasKeepTheirLens) {
  FaultySceneOptions options;
  options.distortion = {-0.1, 0.02, 0.004, -0.003, 0.0};
  options.duration_s = 1.0;
  const FaultyScene scene = MakeFaultyScene(options);
  const Camera& camera = scene.cameras[0];
  const double width = camera.width_px();
  const double height = camera.height_px();
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.5, 0.3, 1.0), Eigen::Vector3d(-1.0, 0.8, 0.2)}) {
    const Eigen::Vector2d px = *camera.Project(point);
    const auto seen = [&](ImageReading image) {
      return *Seeing(camera, image)->Project(point);
    };
    // Exact but for rounding.
    EXPECT_LT((seen(ImageReading::kRotated90) -
               Eigen::Vector2d(height - 1.0 - px.y(), px.x()))
                  .norm(),
              1e-9);
    EXPECT_LT((seen(ImageReading::kRotated180) -
               Eigen::Vector2d(width - 1.0 - px.x(), height - 1.0 - px.y()))
                  .norm(),
              1e-9);
    EXPECT_LT((seen(ImageReading::kRotated270) -
               Eigen::Vector2d(px.y(), width - 1.0 - px.x()))
                  .norm(),
              1e-9);
  }
}

TEST(ClockSearch, FindsLagsOfSeconds) {
  FaultySceneOptions options;
  options.seed = 5;
  options.cameras = 4;
  options.people = 3;
  options.duration_s = 14.0;
  options.clock_offset_s = {0.0, 0.96, 0.0, -0.8};
  const FaultyScene scene = MakeFaultyScene(options);
  const std::vector<ViewPeople> people = PeopleOfViews(scene.detections, 0.3);
  const ClockSearch search = SearchClocks(scene.cameras, people, 100);
  ASSERT_TRUE(search.found());
  // A view that looks 0.96 s later shows the first view's moment 24 frames
  // before. A frame either way is left to what comes after.
  EXPECT_NEAR(search.lag_frames[1], -24, 1);
  EXPECT_NEAR(search.lag_frames[2], 0, 1);
  EXPECT_NEAR(search.lag_frames[3], 20, 1);
  EXPECT_GT(search.all.gain(), 0.0);
}

TEST(ClockSearch, SynchronousViewsHaveNoLag) {
  const FaultyScene scene = ShortScene(6);
  const std::vector<ViewPeople> people = PeopleOfViews(scene.detections, 0.3);
  EXPECT_FALSE(SearchClocks(scene.cameras, people, 30).found());
}

// 120 ms of one view are too little for all views together, whose others agree,
// and too much for stretches of a fifth of a second.
TEST(ClockSearch, OneViewOfFiveThatIsThreeFramesLateIsFound) {
  for (const uint64_t seed : {31, 32, 33}) {
    for (const size_t view : {0, 3}) {
      FaultySceneOptions options;
      options.seed = seed;
      options.clock_offset_s.assign(5, 0.0);
      options.clock_offset_s[view] = 0.12;
      const FaultyScene scene = MakeFaultyScene(options);
      const std::vector<ViewPeople> people =
          PeopleOfViews(scene.detections, 0.3);
      const ClockSearch search = SearchClocks(scene.cameras, people, 250);
      for (size_t v = 0; v < 5; ++v) {
        const int lag = (v == view ? -3 : 0) - (view == 0 ? -3 : 0);
        // A frame either way is left to what comes after.
        EXPECT_NEAR(search.lag_frames[v], lag, v == view || view == 0 ? 1 : 0)
            << "seed " << seed << ", view " << view << ", lag of " << v;
      }
    }
  }
}

// Of many lags some agree better by chance where little was compared.
TEST(ClockSearch, FewNoisyPeopleProveNoLag) {
  FaultySceneOptions options;
  options.cameras = 2;
  options.people = 1;
  options.duration_s = 2.0;
  options.noise_px = 20.0;
  for (options.seed = 1; options.seed <= 12; ++options.seed) {
    const FaultyScene scene = MakeFaultyScene(options);
    const std::vector<ViewPeople> people = PeopleOfViews(scene.detections, 0.3);
    EXPECT_FALSE(SearchClocks(scene.cameras, people, 30).found())
        << "seed " << options.seed;
  }
}

}  // namespace
}  // namespace kinegraph
