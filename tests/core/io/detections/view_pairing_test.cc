#include "core/io/detections/view_pairing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/core/io/input_error.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;

CameraRig Rig(const std::vector<std::string>& names) {
  CameraRig cameras;
  for (const std::string& name : names) {
    CameraParameters parameters;
    parameters.name = name;
    cameras.emplace_back(parameters);
  }
  return cameras;
}

using Names = std::vector<std::string>;
using Map = std::map<std::string, std::string>;

std::string ErrorOf(const Names& views, const Names& cameras,
                    const Map& map = {}) {
  return InputErrorOf([&] { PairViewsWithCameras(views, Rig(cameras), map); });
}

TEST(ViewPairing, AppliesTheMostReliableRuleThatFits) {
  const std::string big = "123456789012345678901234567890";
  const std::string fly = "05272019_fly4_0_R1C24_Cam-";
  const std::string rest = "_rot-ccw-0.06_sec.rng=0";
  const struct {
    Names views, cameras;
    std::vector<int> camera_of_view;
    PairedBy paired_by;
  } cases[] = {
      {{"left", "right"}, {"right", "top", "left"}, {2, 0}, PairedBy::kName},
      {{"b", "a"}, {"a", "b"}, {1, 0}, PairedBy::kName},
      // Names have precedence over numbers.
      {{"00_01", "01_01"}, {"01_01", "00_01"}, {1, 0}, PairedBy::kName},
      // Campus: the calibration lists Camera1, Camera2, Camera0.
      {{"cam0", "cam1", "cam2"},
       {"Camera1", "Camera2", "Camera0"},
       {2, 0, 1},
       PairedBy::kNumber},
      {{"cam01_json", "v2_007"}, {"P7", "cam_1"}, {1, 0}, PairedBy::kNumber},
      {{"cam02_json", "cam01_json"},
       {"cam_01", "cam_02"},
       {1, 0},
       PairedBy::kNumber},
      {{"a00"}, {"0"}, {0}, PairedBy::kNumber},
      {{"cam" + big}, {"x0" + big, "y1"}, {0}, PairedBy::kNumber},
      // The view's name contains the camera's, in any case and with any
      // separators.
      {{fly + "A" + rest, fly + "B" + rest, fly + "C" + rest},
       {"Cam-C", "Cam-A", "Cam-B"},
       {1, 2, 0},
       PairedBy::kWithin},
      {{"x_cam_a", "x_CAM B", "x_cam-c_2"},
       {"Cam-C", "Cam-A", "Cam-B"},
       {1, 2, 0},
       PairedBy::kWithin},
      // cam10 does not contain cam1, and the longer name has precedence.
      {{"rec_cam10_2024", "rec_cam1_2024"},
       {"cam1", "cam10"},
       {1, 0},
       PairedBy::kWithin},
      {{"left_top", "left"}, {"left", "left_top"}, {1, 0}, PairedBy::kName},
      {{"a left top 7", "a left 7"},
       {"left", "left_top"},
       {1, 0},
       PairedBy::kWithin},
      // The camera's name contains the view's.
      {{"cam2", "cam1"}, {"cam1_4k", "cam2_4k"}, {1, 0}, PairedBy::kWithin},
      {{"trial_cam2_20240101", "trial_cam1_20240101"},
       {"Camera1", "Camera02"},
       {1, 0},
       PairedBy::kDistinct},
      // Numbers are matched as a whole: 10 and 11 are not 0 and 1.
      {{"cam10", "cam11"}, {"cam0", "cam1"}, {0, 1}, PairedBy::kOrder},
      // Views count from 0 and cameras from 1, or have no numbers in common.
      {{"cam_0", "cam_1", "cam_2"},
       {"1", "2", "3"},
       {0, 1, 2},
       PairedBy::kOrder},
      {{"cam_2", "cam_1"}, {"26585", "26578"}, {0, 1}, PairedBy::kOrder},
  };
  for (const auto& one : cases) {
    SCOPED_TRACE(one.views.front());
    const ViewPairing found = PairViewsWithCameras(one.views, Rig(one.cameras));
    EXPECT_EQ(found.camera_of_view, one.camera_of_view);
    EXPECT_EQ(found.paired_by, one.paired_by);
  }
}

TEST(ViewPairing, PrefersTheMapToTheName) {
  EXPECT_THAT(PairViewsWithCameras({"a", "b"}, Rig({"a", "b"}),
                                   {{"a", "b"}, {"b", "a"}})
                  .camera_of_view,
              ElementsAre(1, 0));
}

TEST(ViewPairing, ExcludedViewDoesNotShiftOtherCameras) {
  const auto without_first = [](const Names& cameras) {
    return PairViewsWithCameras({"cam_0", "cam_1", "cam_2"}, Rig(cameras), {},
                                UnpairedViews::kRefuse, {"cam_0"})
        .camera_of_view;
  };
  EXPECT_THAT(without_first({"1", "2", "3"}), ElementsAre(0, 1, 2));
  EXPECT_THAT(without_first({"1", "2"}), ElementsAre(-1, 0, 1));
}

TEST(ViewPairing, RefusesAmbiguousPairs) {
  const struct {
    Names views, cameras;
    Map map;
    const char* said;
  } cases[] = {
      {{"cam1"},
       {"00_01", "01_01"},
       {},
       "matches the cameras '00_01', '01_01'"},
      {{"a1", "b1"}, {"1", "2"}, {}, "'a1' and 'b1'"},
      {{"a1", "b1"}, {"1", "2"}, {}, "cameras.map"},
      {{"a", "b"}, {"a", "b"}, {{"a", "b"}}, "both match camera 'b'"},
      {{"cam3"}, {"0", "1"}, {}, "view 'cam3'"},
      {{"left", "right"}, {"links"}, {}, "'links'"},
      {{"cam_2", "cam_3"}, {"1", "2"}, {}, "view 'cam_3' has no camera"},
      // A missing number does not mean that counting starts elsewhere.
      {{"cam_1", "cam_2", "cam_4"},
       {"1", "2", "3"},
       {},
       "view 'cam_4' has no camera"},
      {{"a", "b"}, {}, {}, "there are no cameras for the views 'a', 'b'"},
      {{"a"}, {"a"}, {{"c", "a"}}, "view 'c'"},
      {{"a"}, {"a"}, {{"a", "z"}}, "camera 'z'"},
  };
  for (const auto& one : cases) {
    EXPECT_THAT(ErrorOf(one.views, one.cameras, one.map), HasSubstr(one.said));
  }
}

TEST(ViewPairing, ReturnsCamerasInTheOrderOfViews) {
  const CameraRig paired =
      ChooseViews({"cam0", "cam1"}, Rig({"Camera1", "Camera0"})).cameras;
  ASSERT_EQ(paired.size(), 2u);
  EXPECT_EQ(paired[0].name(), "Camera0");
  EXPECT_EQ(paired[1].name(), "Camera1");
}

TEST(ViewPairing, LeavesOutViewsOfOtherCameras) {
  CameraReadOptions options;
  options.use = {"cam2", "cam0"};
  const UsedViews used =
      ChooseViews({"cam0", "cam1", "cam2"}, Rig(options.use), options);
  EXPECT_THAT(used.views, ElementsAre(0, 2));
  ASSERT_EQ(used.cameras.size(), 2u);
  EXPECT_EQ(used.cameras[1].name(), "cam2");
  DetectionSequence detections;
  detections.header.view_names = {"cam0", "cam1", "cam2"};
  detections.frames.emplace_back().views.resize(3);
  detections.frames[0].views[2].detections.emplace_back();
  KeepViews(used.views, &detections);
  EXPECT_THAT(detections.header.view_names, ElementsAre("cam0", "cam2"));
  ASSERT_EQ(detections.frames[0].views.size(), 2u);
  EXPECT_EQ(detections.frames[0].views[1].detections.size(), 1u);
}

TEST(ViewPairing, ViewsThatAreLeftOutNeedNoCamera) {
  const UsedViews used =
      ChooseViews({"cam0", "cam1"}, Rig({"cam0"}), {}, {"cam1"});
  EXPECT_THAT(used.views, ElementsAre(0));
  EXPECT_THAT(
      InputErrorOf([] { ChooseViews({"cam0"}, Rig({"cam0"}), {}, {"cam9"}); }),
      HasSubstr("no view or camera is named 'cam9'"));
}

}  // namespace
}  // namespace kinegraph
