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

std::vector<int> CameraIdx(const std::vector<std::string>& views,
                           const CameraRig& cameras,
                           const std::map<std::string, std::string>& map = {}) {
  return PairViewsWithCameras(views, cameras, map).camera_of_view;
}

PairedBy How(const std::vector<std::string>& views,
             const std::vector<std::string>& cameras) {
  return PairViewsWithCameras(views, Rig(cameras)).paired_by;
}

std::string ErrorOf(const std::vector<std::string>& views,
                    const std::vector<std::string>& cameras,
                    const std::map<std::string, std::string>& map = {}) {
  return InputErrorOf([&] { CameraIdx(views, Rig(cameras), map); });
}

TEST(ViewPairing, TakesEqualNames) {
  EXPECT_THAT(CameraIdx({"left", "right"}, Rig({"right", "top", "left"})),
              ElementsAre(2, 0));
}

TEST(ViewPairing, TakesEqualLastIntegers) {
  // Campus: the calibration lists Camera1, Camera2, Camera0.
  EXPECT_THAT(CameraIdx({"cam0", "cam1", "cam2"},
                        Rig({"Camera1", "Camera2", "Camera0"})),
              ElementsAre(2, 0, 1));
  EXPECT_THAT(CameraIdx({"cam01_json", "v2_007"}, Rig({"P7", "cam_1"})),
              ElementsAre(1, 0));
  EXPECT_THAT(CameraIdx({"a00"}, Rig({"0"})), ElementsAre(0));
}

TEST(ViewPairing, PrefersTheNameToTheNumber) {
  EXPECT_THAT(CameraIdx({"00_01", "01_01"}, Rig({"01_01", "00_01"})),
              ElementsAre(1, 0));
}

TEST(ViewPairing, PrefersTheMapToTheName) {
  EXPECT_THAT(CameraIdx({"a", "b"}, Rig({"a", "b"}), {{"a", "b"}, {"b", "a"}}),
              ElementsAre(1, 0));
}

TEST(ViewPairing, ComparesNumbersOfAnySize) {
  const std::string big = "123456789012345678901234567890";
  EXPECT_THAT(CameraIdx({"cam" + big}, Rig({"x0" + big, "y1"})),
              ElementsAre(0));
}

TEST(ViewPairing, RefusesSeveralCandidates) {
  EXPECT_THAT(ErrorOf({"cam1"}, {"00_01", "01_01"}),
              HasSubstr("may belong to '00_01', '01_01'"));
}

TEST(ViewPairing, RefusesTwoViewsOfOneCamera) {
  const std::string message = ErrorOf({"a1", "b1"}, {"1", "2"});
  EXPECT_THAT(message, HasSubstr("'a1' and 'b1'"));
  EXPECT_THAT(message, HasSubstr("cameras.map"));
  EXPECT_THAT(ErrorOf({"a", "b"}, {"a", "b"}, {{"a", "b"}}),
              HasSubstr("both belong to camera 'b'"));
}

TEST(ViewPairing, RefusesAViewWithoutCamera) {
  EXPECT_THAT(ErrorOf({"cam3"}, {"0", "1"}), HasSubstr("view 'cam3'"));
  EXPECT_THAT(ErrorOf({"left", "right"}, {"links"}), HasSubstr("'links'"));
}

TEST(ViewPairing, FindsTheCamerasNameInTheViews) {
  const std::vector<std::string> cameras = {"Cam-C", "Cam-A", "Cam-B"};
  EXPECT_THAT(CameraIdx({"05272019_fly4_0_R1C24_Cam-A_rot-ccw-0.06_sec.rng=0",
                         "05272019_fly4_0_R1C24_Cam-B_rot-ccw-0.06_sec.rng=0",
                         "05272019_fly4_0_R1C24_Cam-C_rot-ccw-0.06_sec.rng=0"},
                        Rig(cameras)),
              ElementsAre(1, 2, 0));
  EXPECT_EQ(How({"x_cam_a", "x_CAM B", "x_cam-c_2"}, cameras),
            PairedBy::kWithin);
  // Not cam1 in cam10, and the longer name wins.
  EXPECT_THAT(
      CameraIdx({"rec_cam10_2024", "rec_cam1_2024"}, Rig({"cam1", "cam10"})),
      ElementsAre(1, 0));
  EXPECT_THAT(CameraIdx({"left_top", "left"}, Rig({"left", "left_top"})),
              ElementsAre(1, 0));
  EXPECT_THAT(
      CameraIdx({"a left top 7", "a left 7"}, Rig({"left", "left_top"})),
      ElementsAre(1, 0));
  // The other way round.
  EXPECT_THAT(CameraIdx({"cam2", "cam1"}, Rig({"cam1_4k", "cam2_4k"})),
              ElementsAre(1, 0));
}

TEST(ViewPairing, LooksAtWhatTellsTheNamesApart) {
  const std::vector<std::string> views = {"trial_cam2_20240101",
                                          "trial_cam1_20240101"};
  EXPECT_THAT(CameraIdx(views, Rig({"Camera1", "Camera02"})),
              ElementsAre(1, 0));
  EXPECT_EQ(How(views, {"Camera1", "Camera02"}), PairedBy::kDistinct);
  // A number is not cut in two: 10 and 11 are no 0 and 1.
  EXPECT_EQ(How({"cam10", "cam11"}, {"cam0", "cam1"}), PairedBy::kOrder);
}

TEST(ViewPairing, CountsFromZeroAndFromOne) {
  const std::vector<std::string> views = {"cam_0", "cam_1", "cam_2"};
  EXPECT_THAT(CameraIdx(views, Rig({"1", "2", "3"})), ElementsAre(0, 1, 2));
  EXPECT_EQ(How(views, {"1", "2", "3"}), PairedBy::kOrder);
  // Who leaves out a view leaves the others their cameras.
  EXPECT_THAT(PairViewsWithCameras(views, Rig({"1", "2", "3"}), {},
                                   UnpairedViews::kRefuse, {"cam_0"})
                  .camera_of_view,
              ElementsAre(0, 1, 2));
  EXPECT_THAT(PairViewsWithCameras(views, Rig({"1", "2"}), {},
                                   UnpairedViews::kRefuse, {"cam_0"})
                  .camera_of_view,
              ElementsAre(-1, 0, 1));
  EXPECT_THAT(ErrorOf({"cam_2", "cam_3"}, {"1", "2"}),
              HasSubstr("view 'cam_3' has no camera"));
  // A number that is missing is no other way of counting.
  EXPECT_THAT(ErrorOf({"cam_1", "cam_2", "cam_4"}, {"1", "2", "3"}),
              HasSubstr("view 'cam_4' has no camera"));
}

TEST(ViewPairing, TakesTheOrderOfNamesOfTwoKinds) {
  EXPECT_THAT(CameraIdx({"cam_2", "cam_1"}, Rig({"26585", "26578"})),
              ElementsAre(0, 1));
  EXPECT_EQ(How({"cam_2", "cam_1"}, {"26585", "26578"}), PairedBy::kOrder);
  EXPECT_EQ(How({"b", "a"}, {"a", "b"}), PairedBy::kName);
  EXPECT_EQ(How({"cam1", "cam0"}, {"Camera0", "Camera1"}), PairedBy::kNumber);
  EXPECT_EQ(How({"cam02_json", "cam01_json"}, {"cam_01", "cam_02"}),
            PairedBy::kNumber);
}

TEST(ViewPairing, RefusesAMapOfUnknownNames) {
  EXPECT_THAT(ErrorOf({"a"}, {"a"}, {{"c", "a"}}), HasSubstr("view 'c'"));
  EXPECT_THAT(ErrorOf({"a"}, {"a"}, {{"a", "z"}}), HasSubstr("camera 'z'"));
}

TEST(ViewPairing, GivesCamerasInTheOrderOfTheViews) {
  const CameraRig paired =
      CamerasOfViews({"cam0", "cam1"}, Rig({"Camera1", "Camera0"}));
  ASSERT_EQ(paired.size(), 2u);
  EXPECT_EQ(paired[0].name(), "Camera0");
  EXPECT_EQ(paired[1].name(), "Camera1");
}

}  // namespace
}  // namespace kinegraph
