// Tests the answers of the hypotheses about files, images and clocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "solvers/scene/clock_search.h"
#include "solvers/scene/hypothesis.h"
#include "tests/support/faulty_scene.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::FaultySceneOptions;
using testing::MakeFaultyScene;

std::optional<Answer> AnswerTo(const FaultyScene& scene) {
  DoctorInput input;
  input.cameras = scene.cameras;
  input.detections = scene.detections;
  const DoctorOptions options;
  SetUp set_up(input, options);
  set_up.Look();
  return AskForOtherReading(set_up);
}

FaultyScene ShortScene(uint64_t seed) {
  return MakeFaultyScene({seed, 4, 4, 4.0});
}

// Files written in another convention are read as world to camera.
TEST(Readings, PoseConventionsAreIdentified) {
  using Stated = std::function<Camera(const Camera&)>;
  const auto pose = testing::WithExtrinsics;
  const Eigen::Vector3d signs(1.0, -1.0, -1.0);
  const std::vector<std::pair<std::string, Stated>> conventions = {
      {"camera to world",
       [=](const Camera& c) { return pose(c, c.R().transpose(), c.centre()); }},
      {"the translation is the camera's position in the world",
       [=](const Camera& c) { return pose(c, c.R(), c.centre()); }},
      {"what the file gives as the camera's position is the translation from "
       "world to camera",
       [=](const Camera& c) { return pose(c, c.R(), -(c.R() * c.t())); }},
      {"the rotation is transposed",
       [=](const Camera& c) { return pose(c, c.R().transpose(), c.t()); }},
      {"the camera's y points up and its z backwards", [=](const Camera& c) {
         return pose(c, signs.asDiagonal() * c.R(), signs.asDiagonal() * c.t());
       }}};
  for (const auto& [words, stated] : conventions) {
    FaultyScene scene = ShortScene(2);
    const CameraRig truth = scene.cameras;
    for (Camera& camera : scene.cameras) camera = stated(camera);
    const auto answer = AnswerTo(scene);
    ASSERT_TRUE(answer.has_value()) << words;
    EXPECT_EQ(answer->findings.front().kind, "convention");
    EXPECT_NE(answer->findings.front().evidence.find(words), std::string::npos);
    // Exactly the same cameras are recovered.
    for (size_t v = 0; v < truth.size(); ++v) {
      const Camera& found = (*answer->cameras)[v];
      EXPECT_LT((found.centre() - truth[v].centre()).norm(), 1e-9);
      EXPECT_LT((found.R() - truth[v].R()).norm(), 1e-9);
    }
  }
}

TEST(Readings, ExchangedViewsAreIdentified) {
  FaultyScene scene = ShortScene(3);
  std::swap(scene.cameras[1], scene.cameras[3]);
  const auto answer = AnswerTo(scene);
  ASSERT_TRUE(answer.has_value());
  const std::vector<std::string>& views = scene.detections.header.view_names;
  EXPECT_EQ(answer->findings.front().fix, "'--set=cameras.map." + views[1] +
                                              "=" + scene.cameras[3].name() +
                                              ";cameras.map." + views[3] + "=" +
                                              scene.cameras[1].name() + "'");
}

// Images rotated and mirrored before detection, in all combinations. The
// returned camera, including its lens, must project to the detector's pixels,
// after the flag has mirrored them back if needed.
TEST(Readings, RotatedAndMirroredImagesAreIdentified) {
  FaultySceneOptions options = {4, 4, 4, 4.0};
  options.distortion = {-0.1, 0.02, 0.004, -0.003, 0.0};
  const FaultyScene taken = MakeFaultyScene(options);
  const Camera& camera = taken.cameras[2];
  const double right = camera.width_px() - 1.0;
  const double bottom = camera.height_px() - 1.0;
  using Map = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;
  struct Image {
    std::string words;
    Map turned;
    std::string mirror;  // value of the key
  };
  const Map as_taken = [](const auto& p) { return p; };
  const Map clockwise = [=](const auto& p) {
    return Eigen::Vector2d(bottom - p.y(), p.x());
  };
  const Map half = [=](const auto& p) {
    return Eigen::Vector2d(right - p.x(), bottom - p.y());
  };
  const Map anticlockwise = [=](const auto& p) {
    return Eigen::Vector2d(p.y(), right - p.x());
  };
  const auto of_width = [](double width) { return MirrorText('x', width); };
  const std::vector<Image> images = {
      {"were rotated by 90 degrees clockwise;", clockwise, ""},
      {"were rotated by 180 degrees;", half, ""},
      {"were rotated by 90 degrees anticlockwise;", anticlockwise, ""},
      {"the images were mirrored;", as_taken, of_width(right)},
      {"y counts from the bottom of the images;", as_taken,
       MirrorText('y', bottom)},
      {"were rotated by 90 degrees clockwise and mirrored;", clockwise,
       of_width(bottom)},
      {"were rotated by 90 degrees anticlockwise and mirrored;", anticlockwise,
       of_width(bottom)}};
  const std::string& view = taken.detections.header.view_names[2];
  for (const auto& [words, turned, mirror] : images) {
    FaultyScene scene = taken;
    testing::ChangeJoints(
        &scene, 2, [&, &turn = turned, &axis = mirror](Keypoint* joint) {
          joint->px = turn(joint->px);
          if (axis.empty()) return;
          double& at = axis[0] == 'x' ? joint->px.x() : joint->px.y();
          at = std::stod(axis.substr(1)) - at;
        });
    const auto answer = AnswerTo(scene);
    ASSERT_TRUE(answer.has_value()) << words;
    ASSERT_EQ(answer->findings.size(), 1u);
    EXPECT_EQ(answer->findings[0].kind, "image");
    EXPECT_EQ(answer->findings[0].camera, camera.name());
    EXPECT_NE(answer->findings[0].evidence.find(words), std::string::npos);
    EXPECT_EQ(answer->detections.has_value(), !mirror.empty());
    const std::string& fix = answer->findings[0].fix;
    EXPECT_EQ(fix.find(kUseCorrected) == 0,
              turned(Eigen::Vector2d(1.0, 2.0)) != Eigen::Vector2d(1.0, 2.0))
        << fix;
    EXPECT_EQ(fix.find("'--set=detections.mirror_px." + view + "=" + mirror +
                       "'") != std::string::npos,
              !mirror.empty())
        << fix;
    // The flag mirrors the detections back, so that only the rotation remains.
    if (!mirror.empty()) {
      const auto& people = answer->detections->frames[0].views[2].detections;
      const auto& own = taken.detections.frames[0].views[2].detections;
      ASSERT_EQ(people.size(), own.size());
      for (size_t d = 0; d < own.size(); ++d) {
        EXPECT_LT((people[d].joints[0].px - turned(own[d].joints[0].px)).norm(),
                  1e-9);
      }
    }
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0.5, 0.3, 1.0), Eigen::Vector3d(-1.0, 0.8, 0.2)}) {
      const Eigen::Vector2d px = *camera.Project(point);
      // Exact except for rounding.
      EXPECT_LT((*(*answer->cameras)[2].Project(point) - turned(px)).norm(),
                1e-9)
          << words;
    }
  }
}

TEST(ClockSearch, FindsLagsOfAboutASecond) {
  FaultySceneOptions options = {5, 4, 3, 14.0};
  options.clock_offset_s = {0.0, 0.96, 0.0, -0.8};
  const FaultyScene scene = MakeFaultyScene(options);
  const std::vector<ViewPeople> people = PeopleOfViews(scene.detections);
  const ClockSearch search = SearchClocks(scene.cameras, people, 100);
  ASSERT_TRUE(search.found());
  // A view that captures 0.96 s later shows the same instant as the first view
  // 24 frames earlier. Later stages correct an error of one frame.
  EXPECT_NEAR(search.lag_frames[1], -24, 1);
  EXPECT_NEAR(search.lag_frames[2], 0, 1);
  EXPECT_NEAR(search.lag_frames[3], 20, 1);
  EXPECT_GT(search.all.gain(), 0.0);
}

// Of many views, each is compared with eight others; lags and exchanged cameras
// are still found through intermediate views.
TEST(ComparedPairs, EachOfManyViewsIsComparedWithEight) {
  for (const size_t views : {2u, 9u, 10u, 13u, 32u}) {
    std::vector<int> met(views, 0);
    for (const auto& [a, b] : ComparedPairs(views)) {
      EXPECT_LT(a, b);
      ++met[a];
      ++met[b];
    }
    const int expected = static_cast<int>(std::min<size_t>(views - 1, 8));
    EXPECT_EQ(met, std::vector<int>(views, expected));
  }
  FaultySceneOptions options = {7, 12, 3, 8.0};
  options.clock_offset_s.assign(12, 0.0);
  options.clock_offset_s[7] = 0.48;
  FaultyScene scene = MakeFaultyScene(options);
  const ClockSearch search =
      SearchClocks(scene.cameras, PeopleOfViews(scene.detections), 100);
  for (size_t v = 0; v < 12; ++v) {
    EXPECT_NEAR(search.lag_frames[v], v == 7 ? -12 : 0, 1) << v;
  }
  std::swap(scene.cameras[2], scene.cameras[5]);
  const auto answer = AnswerTo(scene);
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->findings.front().kind, "swapped_views");
}

// An offset of 120 ms in one view hardly changes the agreement of all views,
// but is too large for segments of 0.2 s.
TEST(ClockSearch, FindsOneOfFiveViewsLateByThreeFrames) {
  for (const uint64_t seed : {31, 32, 33}) {
    for (const size_t view : {0, 3}) {
      FaultySceneOptions options = {seed};
      options.clock_offset_s.assign(5, 0.0);
      options.clock_offset_s[view] = 0.12;
      const FaultyScene scene = MakeFaultyScene(options);
      const std::vector<ViewPeople> people = PeopleOfViews(scene.detections);
      const ClockSearch search = SearchClocks(scene.cameras, people, 250);
      for (size_t v = 0; v < 5; ++v) {
        const int lag = (v == view ? -3 : 0) - (view == 0 ? -3 : 0);
        // An error of one frame is left to later stages.
        EXPECT_NEAR(search.lag_frames[v], lag, v == view || view == 0 ? 1 : 0)
            << "seed " << seed << ", view " << view << ", lag of " << v;
      }
    }
  }
}

// With few comparisons, some of the many lags agree better by chance.
TEST(ClockSearch, NoLagIsFoundForFewNoisyPeople) {
  FaultySceneOptions options = {1, 2, 1, 2.0};
  options.noise_px = 20.0;
  for (options.seed = 1; options.seed <= 12; ++options.seed) {
    const FaultyScene scene = MakeFaultyScene(options);
    const std::vector<ViewPeople> people = PeopleOfViews(scene.detections);
    EXPECT_FALSE(SearchClocks(scene.cameras, people, 30).found())
        << "seed " << options.seed;
  }
}

}  // namespace
}  // namespace kinegraph
