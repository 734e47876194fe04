// OpenCap's pickles, which an adapter reads.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "tests/core/io/input_error.h"
#include "tests/support/base64.h"
#include "tests/support/opencap_pickles.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::ExpectInputError;
using testing::FromBase64;
using testing::kOpencapProtocol2;
using testing::kOpencapProtocol5;
using testing::TemporaryFolder;

std::string Replaced(std::string text, const std::string& from,
                     const std::string& to) {
  for (size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

void ExpectTheCamera(const CameraRig& cameras, const std::string& name) {
  ASSERT_EQ(cameras.size(), 1u);
  const Camera& camera = cameras.front();
  EXPECT_EQ(camera.name(), name);
  EXPECT_EQ(camera.width_px(), 1280);
  EXPECT_EQ(camera.height_px(), 720);
  Eigen::Matrix3d K;
  K << 1300.5, 0, 640.25, 0, 1301.5, 360.75, 0, 0, 1;
  EXPECT_EQ(camera.K(), K);
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_EQ(camera.R(), R);
  // The division by 1000 rounds 0.1 and -0.2.
  EXPECT_LT((camera.t() - Eigen::Vector3d(0.1, -0.2, 3.0)).norm(), 1e-15);
  ASSERT_NE(camera.lens(), nullptr);
  EXPECT_EQ(camera.lens()->parameters(),
            (std::vector<double>{0.1, -0.2, 0.001, -0.002, 0.05}));
}

TEST(OpenCapCalibration, IsReadInPickleProtocols2And5) {
  const TemporaryFolder folder;
  for (const char* text : {kOpencapProtocol2, kOpencapProtocol5}) {
    const std::string path = folder.Write(
        "Cam0/cameraIntrinsicsExtrinsics.pickle", FromBase64(text));
    ExpectTheCamera(ReadCameras(path), "Cam0");
  }
}

// NumPy 2 names its modules numpy._core; names are preceded by their lengths.
TEST(OpenCapCalibration, IsReadAsWrittenByNumPy2) {
  const TemporaryFolder folder;
  std::string bytes = FromBase64(kOpencapProtocol5);
  bytes = Replaced(bytes, std::string("\x8c\x12") + "numpy.core.numeric",
                   std::string("\x8c\x13") + "numpy._core.numeric");
  ASSERT_NE(bytes.find("numpy._core"), std::string::npos);
  ExpectTheCamera(ReadCameras(folder.Write("left.pickle", bytes)), "left");
}

TEST(OpenCapCalibration, ASessionHasOneFolderPerCamera) {
  const TemporaryFolder folder;
  const std::string bytes = FromBase64(kOpencapProtocol2);
  for (const char* camera : {"Cam10", "Cam2", "Cam0"}) {
    folder.Write("session/Videos/" + std::string(camera) +
                     "/cameraIntrinsicsExtrinsics.pickle",
                 bytes);
  }
  folder.Write("session/Videos/mappingCamDevice.pickle", "anything");
  for (const char* where : {"session", "session/Videos"}) {
    const CameraRig cameras = ReadCameras(folder.path() / where);
    ASSERT_EQ(cameras.size(), 3u);
    EXPECT_EQ(cameras[0].name(), "Cam0");
    EXPECT_EQ(cameras[1].name(), "Cam2");
    EXPECT_EQ(cameras[2].name(), "Cam10");
  }
  CameraReadOptions metres;
  metres.unit = LengthUnit::kMetre;
  EXPECT_NEAR(ReadCameras(folder.path() / "session", metres)[0].t().z(), 3000.0,
              1e-12);
}

TEST(OpenCapCalibration, AFileWithoutPoseIsRefused) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("cameraIntrinsics.pickle",
                   Replaced(FromBase64(kOpencapProtocol5), "\x8c\x08rotation",
                            "\x8c\x08_otation"));
  ExpectInputError([&] { ReadCameras(path); }, "has no rotation");
}

// See also tests/adapters/adapters_test.py.
TEST(OpenCapCalibration, PickleCodeIsNotExecuted) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("left.pickle",
                                        "\x80\x02"
                                        "cos\nsystem\nU\x02ls\x85R.");
  ExpectInputError([&] { ReadCameras(path); }, "calls 'os.system'");
}

}  // namespace
}  // namespace kinegraph
