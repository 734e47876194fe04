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

std::string ErrorOf(const std::vector<std::string>& views,
                    const std::vector<std::string>& cameras,
                    const std::map<std::string, std::string>& map = {}) {
  return InputErrorOf([&] { PairViewsWithCameras(views, Rig(cameras), map); });
}

TEST(ViewPairing, TakesEqualNames) {
  EXPECT_THAT(
      PairViewsWithCameras({"left", "right"}, Rig({"right", "top", "left"})),
      ElementsAre(2, 0));
}

TEST(ViewPairing, TakesEqualLastIntegers) {
  // Campus: the calibration lists Camera1, Camera2, Camera0.
  EXPECT_THAT(PairViewsWithCameras({"cam0", "cam1", "cam2"},
                                   Rig({"Camera1", "Camera2", "Camera0"})),
              ElementsAre(2, 0, 1));
  EXPECT_THAT(
      PairViewsWithCameras({"cam01_json", "v2_007"}, Rig({"P7", "cam_1"})),
      ElementsAre(1, 0));
  EXPECT_THAT(PairViewsWithCameras({"a00"}, Rig({"0"})), ElementsAre(0));
}

TEST(ViewPairing, PrefersTheNameToTheNumber) {
  EXPECT_THAT(PairViewsWithCameras({"00_01", "01_01"}, Rig({"01_01", "00_01"})),
              ElementsAre(1, 0));
}

TEST(ViewPairing, PrefersTheMapToTheName) {
  EXPECT_THAT(PairViewsWithCameras({"a", "b"}, Rig({"a", "b"}),
                                   {{"a", "b"}, {"b", "a"}}),
              ElementsAre(1, 0));
}

TEST(ViewPairing, ComparesNumbersOfAnySize) {
  const std::string big = "123456789012345678901234567890";
  EXPECT_THAT(PairViewsWithCameras({"cam" + big}, Rig({"x0" + big, "y1"})),
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
  EXPECT_THAT(ErrorOf({"left"}, {"links"}), HasSubstr("'links'"));
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
