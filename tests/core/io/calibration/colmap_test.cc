#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/core/io/calibration/calibration_files.h"

namespace kinegraph {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::ExpectIntrinsics;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::LensOf;
using testing::NamesOf;
using ::testing::StartsWith;
using testing::TemporaryFolder;

constexpr const char* kCameras =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    "# Number of cameras: 2\n"
    "1 SIMPLE_RADIAL 3072 2304 2559.81 1536 1152 -0.0218531\n"
    "7 PINHOLE 640 480 600 610 320 240\n";

// The second is turned by a quarter about z; the last has no line of points.
constexpr const char* kImages =
    "# Image list with two lines of data per image:\n"
    "12 1 0 0 0 1 2 3 7 cam_2.jpg\n"
    "10.5 20.5 -1 30 40 5\n"
    "3 0.70710678118654752 0 0 0.70710678118654752 0 0 4 1 left/cam_1.jpg\n"
    "\n"
    "4 1 0 0 0 0 0 5 1 left/cam_9.jpg";

std::string WriteModel(const TemporaryFolder& folder, const std::string& name,
                       const std::string& cameras, const std::string& images) {
  folder.Write(name + "/cameras.txt", cameras);
  folder.Write(name + "/images.txt", images);
  return (folder.path() / name).string();
}

TEST(ColmapCalibration, IsReadFromFolderAndFile) {
  const TemporaryFolder folder;
  const std::string path = WriteModel(folder, "sparse", kCameras, kImages);
  for (const std::string& where :
       {path, path + "/cameras.txt", path + "/images.txt"}) {
    const CameraRig cameras = ReadCameras(where);
    ASSERT_EQ(cameras.size(), 3u);
    // Pixels are counted from the middle of the first one here.
    ExpectIntrinsics(cameras[0], "cam_2", {640, 480},
                     {600.0, 610.0, 319.5, 239.5});
    ExpectIntrinsics(cameras[1], "left/cam_1", {3072, 2304},
                     {2559.81, 2559.81, 1535.5, 1151.5});
    EXPECT_EQ(cameras[0].lens(), nullptr);
    EXPECT_EQ(cameras[0].t(), Eigen::Vector3d(1, 2, 3));
    EXPECT_THAT(LensOf(cameras[1]),
                ElementsAre(-0.0218531, 0.0, 0.0, 0.0, 0.0));
    Eigen::Matrix3d turned;
    turned << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    EXPECT_LT((cameras[1].R() - turned).norm(), 1e-15);
  }
}

// As COLMAP is run on folders with an image of each camera.
TEST(ColmapCalibration, FoldersNameTheCamerasWhereEachHasItsOwn) {
  const TemporaryFolder folder;
  const std::string path = WriteModel(
      folder, "sparse", kCameras,
      "1 1 0 0 0 1 2 3 7 cam_1/0001.jpg\n\n2 1 0 0 0 1 2 4 7 cam_2/0001.jpg\n");
  EXPECT_THAT(NamesOf(ReadCameras(path)), ElementsAre("cam_1", "cam_2"));
}

// COLMAP's scale is its own.
TEST(ColmapCalibration, UnitCanBeTold) {
  const TemporaryFolder folder;
  CameraReadOptions options;
  options.unit = LengthUnit::kCentimetre;
  const CameraRig cameras =
      ReadCameras(WriteModel(folder, "sparse", kCameras, kImages), options);
  EXPECT_NEAR(cameras[0].t().z(), 0.03, 1e-17);
}

TEST(ColmapCalibration, BrokenFilesAreNamed) {
  const TemporaryFolder folder;
  const std::string image = "1 1 0 0 0 1 2 3 7 cam_2.jpg\n\n";
  const std::string camera = "7 PINHOLE 640 480 600 610 320 240\n";
  const struct {
    std::string cameras, images, said;
  } all[] = {
      {"7 FOV 9 9 1 1 1 1 0\n", image,
       "cameras.txt: line 1: the lens model 'FOV' is not read"},
      {"7 PINHOLE 640 480 600 610 320\n", image,
       "cameras.txt: line 1: found 3 parameters, expected the 4 of PINHOLE"},
      {"# a\n\n7 PINHOLE 640 480 600 nan 320 240\n", image,
       "cameras.txt: line 3: found 'nan'"},
      {"x PINHOLE 640 480 600 610 320 240\n", image, "found 'x'"},
      {"7 PINHOLE\n", image, "expected CAMERA_ID"},
      {camera + camera, image, "line 2: camera 7 appears twice"},
      {camera, "1 1 0 0 0 1 2 3 8 cam_2.jpg\n",
       "images.txt: line 1: camera 8 is not in cameras.txt"},
      {camera, "1 1 0 0 0 1 2 3 7\n", "images.txt: line 1: found 9 words"},
      {camera, "1 2 0 0 0 1 2 3 7 a.jpg\n", "no unit quaternion"},
      {camera, "1 1 0 0 0 1 2 inf 7 a.jpg\n", "found 'inf'"},
      {camera, "# nobody\n", "has no cameras"},
      {camera, image + image, "camera 'cam_2': appears twice"},
      {"7 FULL_OPENCV 640 480 600 610 320 240 0.1 0 0 0 0 0.2 0 0\n", image,
       "camera 'cam_2'"}};
  int number = 0;
  for (const auto& one : all) {
    const std::string path =
        WriteModel(folder, std::to_string(number++), one.cameras, one.images);
    EXPECT_THAT(InputErrorOf([&] { ReadCameras(path); }),
                AllOf(StartsWith(path), HasSubstr(one.said)));
  }
  const std::string alone = folder.Write("alone/cameras.txt", kCameras);
  testing::ExpectInputError([&] { ReadCameras(alone); }, "images.txt");
}

}  // namespace
}  // namespace kinegraph
