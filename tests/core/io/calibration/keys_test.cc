// No key of a calibration is passed over: the lens under any of its names, and
// every key that is read by nobody.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

// One camera of each format; `MORE` stands where another key may stand.
struct FormatSample {
  const char* file;
  std::string text;
  // A key with the value `value` in the syntax of the format.
  std::string (*member)(const std::string& key, const std::string& value);
};

std::string JsonMember(const std::string& key, const std::string& value) {
  return ", \"" + key + "\": " + value;
}
std::string TomlMember(const std::string& key, const std::string& value) {
  return key + " = " + value + "\n";
}
std::string YamlMember(const std::string& key, const std::string& value) {
  return key + ": " + value + "\n";
}
std::string EasymocapMember(const std::string& key, const std::string& value) {
  return key + "_1: " + value + "\n";
}

std::vector<FormatSample> KeySamples() {
  return {
      {"krt.json",
       R"({"0": {"K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
"RT": [1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3], "imgSize": [640, 480]MORE}})",
       JsonMember},
      {"longcw.json",
       R"({"cameras": {"Camera0": {"K": [[1.2, 0, 0.5], [0, 1.5, 0.45],
[0, 0, 1]], "Tw": [[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]
MORE}}})",
       JsonMember},
      {"panoptic.json",
       R"({"cameras": [{"name": "00_01", "resolution": [640, 480],
"K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]],
"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [[1], [2], [300]]MORE}]})",
       JsonMember},
      {"voxelpose.json",
       R"({"0": {"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
"T": [[1], [2], [-3000]], "fx": 600, "fy": 601, "cx": 320, "cy": 240MORE}})",
       JsonMember},
      {"pose2sim.toml",
       "[cam_01]\nsize = [ 640.0, 480.0]\n"
       "matrix = [ [ 600.0, 0.0, 320.0], [ 0.0, 600.0, 240.0], "
       "[ 0.0, 0.0, 1.0]]\n"
       "rotation = [ 0.1, 0.2, 0.3]\ntranslation = [ 1.0, 2.0, 3.0]\n"
       "MORE[metadata]\nerror = 0.1\n",
       TomlMember},
      {"opencv.yml",
       "image_width: 640\nimage_height: 480\n"
       "K: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\n"
       "camera_matrix: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\n"
       "rvec: [0, 0, 0]\ntvec: [1, 2, 3]\nMORE",
       YamlMember},
      {"easymocap.yml",
       "names: [\"1\"]\nK_1: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\n"
       "R_1: [0, 0, 0]\nT_1: [1, 2, 3]\nMORE",
       EasymocapMember},
  };
}

CameraRig Read(const FormatSample& sample, const std::string& more) {
  const TemporaryFolder folder;
  std::string text = sample.text;
  const size_t at = text.find("MORE");
  text.replace(at, 4, more);
  CameraReadOptions options;
  if (std::string(sample.file) == "longcw.json") {
    options.image_size = {640, 480};
  }
  return ReadCameras(folder.Write(sample.file, text), options);
}

class CalibrationKeys : public ::testing::TestWithParam<FormatSample> {};

TEST_P(CalibrationKeys, WithoutMoreIsAPinhole) {
  EXPECT_EQ(Read(GetParam(), "")[0].lens(), nullptr);
}

TEST_P(CalibrationKeys, TheLensIsReadUnderItsNames) {
  const FormatSample& sample = GetParam();
  for (const char* key :
       {"distCoeffs", "distCoeff", "distCoef", "dist_coeffs", "dist", "D",
        "distortion", "distortions", "distortion_coefficients"}) {
    const CameraRig cameras =
        Read(sample, sample.member(key, "[-0.2, 0.05, 0.001, -0.002, 0.01]"));
    ASSERT_NE(cameras[0].lens(), nullptr) << key;
    EXPECT_THAT(cameras[0].lens()->parameters(),
                ElementsAre(-0.2, 0.05, 0.001, -0.002, 0.01))
        << key;
  }
}

TEST_P(CalibrationKeys, TheLensIsReadTermByTerm) {
  const FormatSample& sample = GetParam();
  const CameraRig cameras = Read(
      sample, sample.member("k1", "-0.2") + sample.member("k2", "0.05") +
                  sample.member("k3", "0.01") + sample.member("p1", "0.001") +
                  sample.member("p2", "-0.002"));
  ASSERT_NE(cameras[0].lens(), nullptr);
  EXPECT_THAT(cameras[0].lens()->parameters(),
              ElementsAre(-0.2, 0.05, 0.001, -0.002, 0.01));
}

TEST_P(CalibrationKeys, TwoLensesMustBeOne) {
  const FormatSample& sample = GetParam();
  const std::string first = sample.member("distCoeffs", "[-0.2, 0.05, 0, 0]");
  EXPECT_NO_THROW(
      Read(sample, first + sample.member("dist", "[-0.2, 0.05, 0, 0, 0]")));
  EXPECT_THAT(InputErrorOf([&] {
                Read(sample, first + sample.member("dist", "[0.2, 0, 0, 0]"));
              }),
              HasSubstr("states its lens twice"));
}

TEST_P(CalibrationKeys, AModelThatIsNoPolynomialIsRefused) {
  const FormatSample& sample = GetParam();
  EXPECT_NO_THROW(Read(sample, sample.member("camera_model", "\"pinhole\"")));
  for (const char* model : {"\"mei\"", "\"double_sphere\"", "\"omni\""}) {
    EXPECT_THAT(InputErrorOf([&] {
                  Read(sample, sample.member("distortion_model", model));
                }),
                HasSubstr("distortion_model"));
  }
  EXPECT_THAT(InputErrorOf(
                  [&] { Read(sample, sample.member("omnidirectional", "1")); }),
              HasSubstr("omnidirectional"));
}

TEST_P(CalibrationKeys, AFisheyeLensIsOneUnderAnyName) {
  const FormatSample& sample = GetParam();
  for (const char* mark : {"distortion_model", "fisheye_model"}) {
    const std::string value =
        std::string(mark) == "fisheye_model" ? "1" : "\"equidistant\"";
    const Camera camera =
        Read(sample, sample.member(mark, value) +
                         sample.member("dist", "[0.1, -0.02, 0.003, 0.0]"))[0];
    ASSERT_NE(camera.lens(), nullptr);
    EXPECT_EQ(camera.lens()->model(), kFisheyeModel);
  }
}

TEST_P(CalibrationKeys, AnUnknownKeyIsRefusedByName) {
  const FormatSample& sample = GetParam();
  for (const char* key : {"distorsion", "R_rect", "orientation", "camera_pose",
                          "extrinsics", "skew", "xi", "thin_prism"}) {
    const std::string message = InputErrorOf(
        [&] { Read(sample, sample.member(key, "[0.1, 0.2, 0.3]")); });
    EXPECT_THAT(message, HasSubstr(sample.file));
    EXPECT_THAT(message, HasSubstr(std::string("'") + key)) << message;
    EXPECT_THAT(message, HasSubstr("could carry lens or pose"));
  }
}

TEST_P(CalibrationKeys, WhatProgramsWriteBesideIsPassedOver) {
  const FormatSample& sample = GetParam();
  std::string more;
  for (const char* key :
       {"date", "calibration_time", "serialNumber", "rms", "flags", "comment",
        "avg_reprojection_error", "square_size", "fps", "_note"}) {
    more += sample.member(key, "\"some text\"");
  }
  EXPECT_NO_THROW(Read(sample, more));
}

INSTANTIATE_TEST_SUITE_P(
    EachFormat, CalibrationKeys, ::testing::ValuesIn(KeySamples()),
    [](const ::testing::TestParamInfo<FormatSample>& sample) {
      const std::string file = sample.param.file;
      return file.substr(0, file.find('.'));
    });

// The unit may stand beside the cameras.
TEST(CalibrationUnit, IsReadWhereItIsStated) {
  const TemporaryFolder folder;
  const std::string text =
      R"({"0": {"K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
"RT": [1, 0, 0, 1000, 0, 1, 0, 2000, 0, 0, 1, 3000]}, "unit": "mm"})";
  const CameraRig cameras = ReadCameras(folder.Write("krt.json", text));
  EXPECT_EQ(cameras[0].t(), Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_THAT(InputErrorOf([&] {
                std::string feet = text;
                feet.replace(feet.find("\"mm\""), 4, "\"ft\"");
                ReadCameras(folder.Write("krt.json", feet));
              }),
              HasSubstr("unit: found the text 'ft'"));
}

// Two ways of writing one pose must say the same.
TEST(CalibrationPose, TwoSpellingsMustAgree) {
  const TemporaryFolder folder;
  const std::string text =
      "K: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\n"
      "rvec: [0, 0, 0]\ntvec: [1, 2, 3]\n"
      "R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  const auto read = [&](const std::string& more) {
    CameraReadOptions options;
    options.format = "opencv";
    return ReadCameras(folder.Write("a.yml", text + more), options);
  };
  EXPECT_NO_THROW(read("T: [1, 2, 3]\n"));
  EXPECT_THAT(InputErrorOf([&] { read("T: [1, 2, 4]\n"); }),
              HasSubstr("does not say the same as tvec"));
}

}  // namespace
}  // namespace kinegraph
