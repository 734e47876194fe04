// Calibrations of motion capture systems and of other programs. Original
// samples are read if available; all other files follow the makers'
// documentation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/calibration/format.h"
#include "tests/core/io/calibration/calibration_files.h"

namespace kinegraph {
namespace {

using ::testing::AllOf;
using testing::CamerasOf;
using ::testing::ElementsAre;
using testing::ExpectFaults;
using testing::ExpectInputError;
using testing::ExpectIntrinsics;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::LensOf;
using testing::NamesOf;
using ::testing::StartsWith;
using testing::TemporaryFolder;
using testing::WithReplaced;

// ---- Qualisys ----

// The camera looks along the world's x, with the top of the image towards z:
// the rows in the file are right (-y), up (z) and backwards (-x).
constexpr const char* kQca =
    R"(<?xml version="1.0" encoding="us-ascii"?>
<calibration calibrated="true" source="x.qca" qtm-version="2022.2" type="regular">
 <results std-dev="0.3"/>
 <cameras>
  <camera active="1" calibrated="true" serial="22707" model="Miqus Video" viewrotation="180" video_resolution="1080p">
   <fov_marker left="0" top="0" right="1919" bottom="1087"/>
   <fov_video left="512" top="192" right="1471" bottom="959"/>
   <transform x="-2000" y="500" z="1000" r11="0" r12="-1" r13="0" r21="0" r22="0" r23="1" r31="-1" r32="0" r33="0"/>
   <intrinsic focallength="9.2" sensorMinU="0" sensorMaxU="122879" sensorMinV="0" sensorMaxV="69631" focalLengthU="64000" focalLengthV="76800" centerPointU="61440" centerPointV="34816" skew="0" radialDistortion1="-0.05" radialDistortion2="0.1" radialDistortion3="0" tangentalDistortion1="0.001" tangentalDistortion2="-0.002"/>
  </camera>
  <camera active="1" serial="18089" model="Oqus 700+" viewrotation="0"/>
  <camera active="0" serial="1" model="Miqus Video" viewrotation="0"/>
  <camera active="1" calibrated="false" serial="2" model="Miqus Video"/>
 </cameras>
</calibration>
)";

TEST(QualisysCalibration, MatchesHandComputedValues) {
  const CameraRig cameras = CamerasOf("lab.qca.txt", kQca);
  ASSERT_EQ(cameras.size(), 1u)
      << "skips marker cameras, inactive and uncalibrated ones";
  const Camera& camera = cameras.front();
  ExpectIntrinsics(camera, "22707", {960, 768}, {1000.0, 1200.0, 448.0, 352.0});
  EXPECT_EQ(LensOf(camera),
            (std::vector<double>{-0.05, 0.1, 0.001, -0.002, 0.0}));
  EXPECT_LT((camera.centre() - Eigen::Vector3d(-2.0, 0.5, 1.0)).norm(), 1e-15);
  // Four metres ahead, 0.4 m to the left and 0.8 m above: x = -0.1, y = -0.2.
  const Eigen::Vector3d point(2.0, 0.9, 1.8);
  const double radial = 1.0 - 0.05 * 0.05 + 0.1 * 0.05 * 0.05;
  const double x = -0.1 * radial + 2 * 0.001 * 0.02 - 0.002 * (0.05 + 0.02);
  const double y = -0.2 * radial + 0.001 * (0.05 + 0.08) - 2 * 0.002 * 0.02;
  const auto px = camera.Project(point);
  ASSERT_TRUE(px.has_value());
  EXPECT_NEAR(px->x(), 1000.0 * x + 448.0, 1e-9);
  EXPECT_NEAR(px->y(), 1200.0 * y + 352.0, 1e-9);
}

// An image of 640 x 512 px shows the whole field of view of 960 x 768 px.
TEST(QualisysCalibration, ASmallerVideoIsScaled) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("cal.txt", kQca);
  CameraReadOptions options;
  options.image_size = {640.0, 512.0};
  const Camera camera = ReadCameras(path, options).front();
  EXPECT_EQ(camera.width_px(), 640);
  EXPECT_NEAR(camera.K()(1, 1), 800.0, 1e-12);
  // Edges map to edges: -0.5 and 959.5 become -0.5 and 639.5.
  EXPECT_NEAR(camera.K()(0, 2), (448.0 + 0.5) / 1.5 - 0.5, 1e-12);
  options.image_size = {640.0, 480.0};
  ExpectInputError([&] { ReadCameras(path, options); }, "960 x 768");
}

TEST(QualisysCalibration, MarkerCamerasAreReadWithoutVideoCameras) {
  std::string text = WithReplaced(kQca, "Miqus Video", "Oqus 700+");
  text = WithReplaced(text, "<camera active=\"1\" serial=\"18089\"",
                      "<camera active=\"0\" serial=\"18089\"");
  EXPECT_EQ(CamerasOf("a.txt", text).size(), 1u);
}

TEST(QualisysCalibration, ErrorsNameTheFault) {
  ExpectFaults(
      "cal.txt",
      {
          {WithReplaced(kQca, "focalLengthU=\"64000\"", ""),
           "line 9: <intrinsic> has no attribute focalLengthU"},
          {WithReplaced(kQca, "r13=\"0\"", "r13=\"zero\""),
           "r13: found 'zero'"},
          {WithReplaced(kQca, "</cameras>", "</camera>"), "is not XML"},
          {WithReplaced(kQca, "sensorMaxU=\"122879\"", "sensorMaxU=\"1919\""),
           "sensorMaxU"},
          {WithReplaced(kQca, "<camera active=\"1\" calibrated=\"true\"",
                        "<camera active=\"0\""),
           "intrinsic"},  // the Oqus is read instead, and has none
          {"<html></html>", "is not a calibration"},
      });
}

// Largest distances between the cameras of two rigs: of the images of points in
// a room [px], and of the cameras' positions [m]. `points`: number of points
// that both cameras see, summed over the rig.
struct Apart {
  double px = 0.0;
  double m = 0.0;
  int points = 0;
};
Apart Compare(const CameraRig& a, const CameraRig& b) {
  Apart apart;
  for (size_t c = 0; c < a.size(); ++c) {
    apart.m = std::max(apart.m, (a[c].centre() - b[c].centre()).norm());
    for (double x = -1.5; x <= 1.5; x += 0.5) {
      for (double y = -1.5; y <= 1.5; y += 0.5) {
        for (double z = 0.0; z <= 2.0; z += 0.5) {
          const auto one = a[c].Project({x, y, z});
          const auto other = b[c].Project({x, y, z});
          if (!one.has_value() || !other.has_value()) continue;
          apart.px = std::max(apart.px, (*one - *other).norm());
          ++apart.points;
        }
      }
    }
  }
  return apart;
}

// Pose2Sim converted the calibration of QTM into these TOML files.
TEST(QualisysCalibration, EqualsTheTomlConvertedByPose2Sim) {
  KINEGRAPH_DATA_OR_SKIP(folder, "takes/pose2sim_static");
  const CameraRig qca = ReadCameras(folder + "/Calib.qca.txt");
  for (const char* name : {"Calib_qca.toml", "Calib_qualisys.toml"}) {
    const CameraRig toml = ReadCameras(folder + "/" + name);
    ASSERT_EQ(qca.size(), toml.size());
    const Apart apart = Compare(qca, toml);
    EXPECT_GT(apart.points, 500);
    // Rounding: the TOML has eight digits.
    EXPECT_LT(apart.px, 0.001);
    EXPECT_LT(apart.m, 1e-6);
  }
}

// The cameras surround the people and face them.
TEST(QualisysCalibration, TheExportForTheiaIsRead) {
  KINEGRAPH_DATA_OR_SKIP(file, "markers/qualisys_theia/qualisys_cal.txt");
  const CameraRig cameras = ReadCameras(file);
  ASSERT_EQ(cameras.size(), 8u) << "video cameras, of 20";
  for (const Camera& camera : cameras) {
    EXPECT_EQ(camera.width_px(), 960);
    // The first recording shows a person near the origin; the point is at the
    // height of the trunk.
    const auto px = camera.Project({0.0, 0.0, 1.0});
    ASSERT_TRUE(px.has_value()) << camera.name();
    EXPECT_GT(px->minCoeff(), -200.0) << camera.name();
    EXPECT_LT(px->maxCoeff(), 1200.0) << camera.name();
    EXPECT_GT(camera.centre().z(), 0.5);
  }
}

// ---- Vicon ----

// Rotated by 90 degrees about x: x_cam = X, y_cam = -Z, z_cam = Y.
constexpr const char* kXcp =
    R"(<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<Cameras NAME="" VERSION="1.0">
 <Camera ACTIVE_THRESHOLD="1" DEVICEID="2118670" DISPLAY_TYPE="Vue" NAME="" PIXEL_ASPECT_RATIO="1.25" SENSOR_SIZE="1920 1080" SKEW="0" TYPE="VideoCamera" USERID="1">
  <KeyFrames>
   <KeyFrame FOCAL_LENGTH="1500" FRAME="0" ORIENTATION="0.70710678118654752 0 0 0.70710678118654752" POSITION="100 -4000 1500" PRINCIPAL_POINT="960 540" VICON_RADIAL2="ViconRadial2 960 540 RADIAL"/>
  </KeyFrames>
 </Camera>
 <Camera DEVICEID="7" DISPLAY_TYPE="Vantage5" TYPE="DxCore" SENSOR_SIZE="2432 2048"><KeyFrames/></Camera>
</Cameras>
)";

std::string XcpWith(const std::string& radial) {
  return WithReplaced(kXcp, "RADIAL\"/>", radial + "\"/>");
}

TEST(ViconCalibration, MatchesHandComputedValues) {
  const CameraRig cameras = CamerasOf("lab.xcp", XcpWith("0 0 0"));
  ASSERT_EQ(cameras.size(), 1u);
  const Camera& camera = cameras.front();
  EXPECT_EQ(camera.name(), "2118670");
  EXPECT_EQ(camera.K()(1, 1), 1200.0);
  EXPECT_EQ(camera.lens(), nullptr);
  // 4 m ahead, 0.4 m right, 0.8 m below: x = 0.1, y = 0.2.
  const auto px = camera.Project({0.5, 0.0, 0.7});
  ASSERT_TRUE(px.has_value());
  EXPECT_NEAR(px->x(), 960 + 150, 1e-9);
  EXPECT_NEAR(px->y(), 540 + 240, 1e-9);
}

// Terms in px map a raw point to its pinhole position.
TEST(ViconCalibration, RadialTermsMapRawToUndistortedPixels) {
  const std::string text = WithReplaced(XcpWith("3e-8 -4e-15 0"), "1.25", "1");
  const Camera camera = CamerasOf("lab.xcp", text).front();
  for (double r_px = 50.0; r_px < 1100.0; r_px += 50.0) {
    const Eigen::Vector2d offset = r_px * Eigen::Vector2d(0.8, -0.6);
    const double factor = 1.0 + 3e-8 * r_px * r_px - 4e-15 * std::pow(r_px, 4);
    const Eigen::Vector2d middle(960, 540);
    const auto ideal = camera.Undistort(middle + offset);
    ASSERT_TRUE(ideal.has_value());
    // The lens is fitted with OpenCV's terms to 0.1 px.
    EXPECT_LT((*ideal - middle - factor * offset).norm(), 0.1) << r_px;
  }
}

// Other programs write terms without unit. As terms in px they would displace a
// corner by more than its whole radius.
TEST(ViconCalibration, DimensionlessTermsAreOpenCvTerms) {
  const Camera camera = CamerasOf("lab.xcp", XcpWith("-0.1 0.05 0.01")).front();
  EXPECT_EQ(LensOf(camera), (std::vector<double>{-0.1, 0.05, 0.0, 0.0, 0.01}));
}

TEST(ViconCalibration, ErrorsNameTheFault) {
  ExpectFaults(
      "lab.xcp",
      {
          {XcpWith("0 0"), "found 4 numbers, expected 5"},
          {WithReplaced(XcpWith("0 0 0"), "0.70710678118654752 0 0", "0.9 0 0"),
           "not a unit quaternion"},
          {WithReplaced(XcpWith("0 0 0"), "1920 1080", "1920"), "SENSOR_SIZE"},
      });
}

// ---- OptiTrack ----

// The columns of OrientMatrix are the camera's axes: right (-y), up (z),
// backwards (-x), as in kQca; the world is Motive's, in metres.
constexpr const char* kMcal =
    R"(<?xml version="1.0" encoding="UTF-16"?>
<Profile Name="Cal 2024"><Calibration><Cameras>
<Camera Serial="C11764"><Properties CameraID="13"/>
<Attributes ImagerPixelWidth="1920" ImagerPixelHeight="1080"/>
<Intrinsic LensCenterX="1" LensCenterY="1" HorizontalFocalLength="1" VerticalFocalLength="1" KC1="9"/>
<IntrinsicStandardCameraModel LensCenterX="960" LensCenterY="540" HorizontalFocalLength="1000" VerticalFocalLength="1200" k1="-0.05" k2="0.1" k3="0.0" TangentialX="0.001" TangentialY="-0.002"/>
<Extrinsic X="-2" Y="0.5" Z="1" OrientMatrix0="0" OrientMatrix1="0" OrientMatrix2="-1" OrientMatrix3="-1" OrientMatrix4="0" OrientMatrix5="0" OrientMatrix6="0" OrientMatrix7="1" OrientMatrix8="0"/>
</Camera></Cameras></Calibration></Profile>
)";

std::string Utf16(const std::string& text) {
  std::string wide = "\xFF\xFE";
  for (const char c : text) wide += {c, '\0'};
  return wide;
}

TEST(OptiTrackCalibration, IsReadInBothEncodings) {
  const std::string plain = WithReplaced(kMcal, "UTF-16", "UTF-8");
  for (const std::string& text : {plain, Utf16(kMcal)}) {
    const CameraRig cameras = CamerasOf("Cal.mcal", text);
    ASSERT_EQ(cameras.size(), 1u);
    const Camera& camera = cameras.front();
    EXPECT_EQ(camera.name(), "C11764");
    EXPECT_EQ(camera.width_px(), 1920);
    // Like the camera of kQca, whose image is a crop: its principal point
    // differs by 512 and 188 px.
    const Camera qualisys = CamerasOf("a.txt", kQca).front();
    EXPECT_LT((camera.R() - qualisys.R()).norm(), 1e-15);
    const Eigen::Vector3d point(2.0, 0.9, 1.8);
    EXPECT_LT((*camera.Project(point) - Eigen::Vector2d(512.0, 188.0 + 0.0) -
               *qualisys.Project(point))
                  .norm(),
              1e-9);
  }
}

// UTF-16 as written by PowerShell's `>`. Only XML specifies its encoding.
TEST(OptiTrackCalibration, OtherTextsInUtf16AreRefused) {
  for (const std::string text :
       {"[cam_1]\nname = \"cam_1\"\n", "{\"cameras\": []}", "%YAML:1.0\n---\n",
        "1 0 0 0\n"}) {
    std::string turned = "\xFE\xFF";  // the other byte order
    for (const char c : text) turned += {'\0', c};
    for (const char* name : {"a.toml", "a.json", "a.mcal", "a.txt"}) {
      EXPECT_THAT(FaultOf(name, Utf16(text)), HasSubstr("is UTF-16 text"));
      EXPECT_THAT(FaultOf(name, turned), HasSubstr("is UTF-16 text"));
    }
  }
}

TEST(OptiTrackCalibration, MotiveLensModelIsRefused) {
  const std::string text =
      WithReplaced(WithReplaced(kMcal, "UTF-16", "UTF-8"),
                   "IntrinsicStandardCameraModel", "Other");
  EXPECT_THAT(FaultOf("Cal.mcal", text),
              HasSubstr("IntrinsicStandardCameraModel"));
}

// ---- bioCV ----

constexpr const char* kCalib =
    "1920\n1080\n1500 0 960 \n0 1510 540 \n0 0 1 \n\n"
    "0 -1 0 100 \n1 0 0 -200 \n0 0 1 3000 \n0 0 0 1 \n\n"
    "-0.1 0.05 0.001 -0.002 0.01 \n";

TEST(BioCvCalibration, IsReadFromFileAndFolder) {
  const TemporaryFolder folder;
  for (const std::string name : {"10", "02", "00"}) {
    folder.Write("calib/" + name + ".mp4.calib", kCalib);
  }
  folder.Write("calib/frameOffset", "3");
  const std::string path = (folder.path() / "calib").string();
  const CameraRig cameras = ReadCameras(path);
  ASSERT_THAT(NamesOf(cameras), ElementsAre("00", "02", "10"));
  for (const Camera& camera :
       {cameras[1], ReadCameras(path + "/02.mp4.calib").front()}) {
    ExpectIntrinsics(camera, "02", {1920, 1080},
                     {1500.0, 1510.0, 960.0, 540.0});
    EXPECT_LT((camera.t() - Eigen::Vector3d(0.1, -0.2, 3.0)).norm(), 1e-15);
    EXPECT_EQ(camera.R()(0, 1), -1.0);
    EXPECT_THAT(LensOf(camera), ElementsAre(-0.1, 0.05, 0.001, -0.002, 0.01));
  }
}

TEST(BioCvCalibration, ErrorsNameTheFault) {
  ExpectFaults("a.calib",
               {
                   {std::string(kCalib) + "7\n", "33 numbers"},
                   {WithReplaced(kCalib, "0 0 0 1", "0 0 1 1"), "0 0 0 1"},
                   {WithReplaced(kCalib, "1510", "1510.5.5"), "line 4"},
               });
}

// ---- Sessions ----

constexpr const char* kArray = R"([cameras.0]
cam_id = 0
size = [1280, 720]
matrix = [[600.0, 0.0, 640.0], [0.0, 600.0, 360.0], [0.0, 0.0, 1.0]]
distortions = [-0.02, 0.01, -0.003, 0.001]
fisheye = true
rotation = [0.1, 0.2, 0.3]
translation = [0.0, 0.0, 2.0]
[cameras.1]
cam_id = 1
ignore = true
size = [1280, 720]
matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
rotation = [0.0, 0.0, 0.0]
translation = [0.0, 0.0, 2.0]
[cameras.2]
cam_id = 2
size = [1280, 720]
[cameras.10]
cam_id = 10
size = [1280, 720]
matrix = [[600.0, 0.0, 640.0], [0.0, 600.0, 360.0], [0.0, 0.0, 1.0]]
distortions = [0.0, 0.0, 0.0, 0.0, 0.0]
fisheye = false
rotation = [0.1, 0.2, 0.3]
translation = [0.5, 0.0, 2.0]
)";

TEST(SessionFolder, CaliscopeSessionIsReadFromCameraArray) {
  const TemporaryFolder folder;
  folder.Write("session/camera_array.toml", kArray);
  folder.Write("session/config.toml", "CreationDate = 2023-05-06\n");
  const CameraRig cameras = ReadCameras(folder.path() / "session");
  ASSERT_THAT(NamesOf(cameras), ElementsAre("cam_0", "cam_10"))
      << "one is ignored, one has no pose";
  EXPECT_THAT(LensOf(cameras[0]), ElementsAre(-0.02, 0.01, -0.003, 0.001));
  EXPECT_EQ(cameras[0].lens()->model(), kFisheyeModel);
  EXPECT_EQ(cameras[1].lens(), nullptr);
}

constexpr const char* kTable = R"([cam_0]
name = "back"
size = [ 1280, 1024,]
matrix = [ [ 769.9, 0.0, 639.5,], [ 0.0, 769.9, 511.5,], [ 0.0, 0.0, 1.0,],]
distortions = [ -0.28, 0.0, 0.0, 0.0, 0.0,]
rotation = [ 0.0, 0.0, 0.0,]
translation = [ 100.0, 0.0, 2000.0,]
[metadata]
)";

TEST(SessionFolder, BoardFileDeterminesTheUnit) {
  const TemporaryFolder folder;
  folder.Write("mice/calibration.toml", kTable);
  folder.Write("mice/back/a.h5", "anything");
  const std::string path = (folder.path() / "mice").string();
  const std::string file = path + "/calibration.toml";
  EXPECT_EQ(ReadCameras(path).front().t().z(), 2000.0);
  EXPECT_EQ(ReadCameras(file).front().t().z(), 2000.0);
  folder.Write("mice/board.toml", "square_length = 24.0\n");
  EXPECT_EQ(ReadCameras(path).front().t().z(), 2.0);
  EXPECT_EQ(ReadCameras(file).front().t().z(), 2.0);
  // A calibration that another program wrote into the folder has its own unit.
  folder.Write("mice/Calib.toml", kTable);
  EXPECT_EQ(ReadCameras(path + "/Calib.toml").front().t().z(), 2000.0);
  CameraReadOptions centimetres;
  centimetres.unit = LengthUnit::kCentimetre;
  EXPECT_EQ(ReadCameras(path, centimetres).front().t().z(), 20.0);
}

TEST(SessionFolder, OldCaliscopeSessionIsReadFromConfig) {
  const TemporaryFolder folder;
  folder.Write("old/config.toml", kTable);
  folder.Write("other/config.toml", "mode = 'graph'\n");
  EXPECT_EQ(ReadCameras(folder.path() / "old").size(), 1u);
  ExpectInputError([&] { ReadCameras(folder.path() / "other"); },
                   "is a folder without");
}

// Reading the folder of a session and reading its file give the same cameras.
TEST(SessionFolder, PublicSamplesAreRead) {
  KINEGRAPH_DATA_OR_SKIP(found, "takes");
  const std::filesystem::path recordings = found;
  for (const char* name :
       {"caliscope_human/config.toml", "caliscope_board/camera_array.toml"}) {
    const CameraRig file = ReadCameras(recordings / name);
    const CameraRig folder = ReadCameras((recordings / name).parent_path());
    ASSERT_EQ(file.size(), 4u);
    ASSERT_EQ(folder.size(), 4u);
    EXPECT_EQ(Compare(file, folder).px, 0.0);
    EXPECT_EQ(folder[3].name(), "cam_3");
  }
  const CameraRig mouse =
      ReadCameras(recordings / "mouse_sleap/minimal_session");
  ASSERT_EQ(mouse.size(), 4u);
  EXPECT_NEAR(mouse[0].t().z(), -0.122279, 1e-6) << "millimetres";
}

// ---- COLMAP ----

constexpr const char* kCameras =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    "# Number of cameras: 2\n"
    "1 SIMPLE_RADIAL 3072 2304 2559.81 1536 1152 -0.0218531\n"
    "7 PINHOLE 640 480 600 610 320 240\n";

// The second image is rotated by 90 degrees about z; the last has no line of
// points.
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
    // kinegraph's pixel coordinates begin at the centre of the first pixel.
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

// COLMAP was run on one folder of images per camera.
TEST(ColmapCalibration, OneImageFolderPerCameraNamesTheCameras) {
  const TemporaryFolder folder;
  const std::string path = WriteModel(
      folder, "sparse", kCameras,
      "1 1 0 0 0 1 2 3 7 cam_1/0001.jpg\n\n2 1 0 0 0 1 2 4 7 cam_2/0001.jpg\n");
  EXPECT_THAT(NamesOf(ReadCameras(path)), ElementsAre("cam_1", "cam_2"));
}

TEST(ColmapCalibration, NamesOfImagesMayHaveSpaces) {
  const TemporaryFolder folder;
  const std::string path = WriteModel(folder, "sparse", kCameras,
                                      "1 1 0 0 0 1 2 3 7 cam 1.jpg\n\n"
                                      "2 1 0 0 0 1 2 4 7 cam 2.jpg\n1 2 -1\n");
  EXPECT_THAT(NamesOf(ReadCameras(path)), ElementsAre("cam 1", "cam 2"));
}

// COLMAP's scale is arbitrary.
TEST(ColmapCalibration, UnitOptionScalesTheWorld) {
  const TemporaryFolder folder;
  CameraReadOptions options;
  options.unit = LengthUnit::kCentimetre;
  const CameraRig cameras =
      ReadCameras(WriteModel(folder, "sparse", kCameras, kImages), options);
  EXPECT_NEAR(cameras[0].t().z(), 0.03, 1e-17);
}

TEST(ColmapCalibration, ErrorsNameFileAndLine) {
  const TemporaryFolder folder;
  const std::string image = "1 1 0 0 0 1 2 3 7 cam_2.jpg\n\n";
  const std::string camera = "7 PINHOLE 640 480 600 610 320 240\n";
  const struct {
    std::string cameras, images, said;
  } all[] = {
      {"7 FOV 9 9 1 1 1 1 0\n", image,
       "cameras.txt: line 1: the lens model 'FOV' is not supported"},
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
      {camera, "1 2 0 0 0 1 2 3 7 a.jpg\n", "not a unit quaternion"},
      {camera, "1 1 0 0 0 1 2 inf 7 a.jpg\n", "found 'inf'"},
      {camera, "# a\n1 1 0 0 0 1 2 3 7 a.jpg\n2 1 0 0 0 1 2 3 7 b.jpg\n",
       "images.txt: line 3: expected the points of the image"},
      {camera, "1 1 0 0 0 1 2 3 7 a.jpg\n2 1 0 0 0 1 2 3 7 cam b 2.jpg\n",
       "images.txt: line 2: expected the points of the image"},
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
  ExpectInputError([&] { ReadCameras(alone); }, "images.txt");
}

// ---- Fisheye lenses in files of other programs ----

TEST(FisheyeCalibration, ColmapsModelsAreRead) {
  const TemporaryFolder folder;
  const CameraRig cameras = ReadCameras(WriteModel(
      folder, "m",
      "1 OPENCV_FISHEYE 640 480 300 310 320 240 0.1 -0.02 0.003 1e-4\n"
      "2 RADIAL_FISHEYE 640 480 300 320 240 0.1 -0.02\n"
      "3 SIMPLE_RADIAL_FISHEYE 640 480 300 320 240 0.1\n"
      "4 OPENCV_FISHEYE 640 480 300 310 320 240 0 0 0 0\n",
      "1 1 0 0 0 0 0 4 1 a.jpg\n\n2 1 0 0 0 0 0 4 2 b.jpg\n\n"
      "3 1 0 0 0 0 0 4 3 c.jpg\n\n4 1 0 0 0 0 0 4 4 d.jpg\n\n"));
  const std::vector<std::vector<double>> terms = {{0.1, -0.02, 0.003, 1e-4},
                                                  {0.1, -0.02, 0, 0},
                                                  {0.1, 0, 0, 0},
                                                  {0, 0, 0, 0}};
  ASSERT_EQ(cameras.size(), 4u);
  for (size_t c = 0; c < 4; ++c) {
    ASSERT_NE(cameras[c].lens(), nullptr);
    EXPECT_EQ(cameras[c].lens()->model(), kFisheyeModel);
    EXPECT_EQ(LensOf(cameras[c]), terms[c]);
    EXPECT_EQ(cameras[c].K()(0, 2), 319.5);
  }
}

TEST(FisheyeCalibration, FiveTermsAreRefused) {
  const std::string text = WithReplaced(kTable, "0.0, 0.0,]\nrotation",
                                        "0.0, 0.2,]\nfisheye = true\nrotation");
  EXPECT_THAT(FaultOf("a.toml", text),
              HasSubstr("5 coefficients of a fisheye lens"));
}

TEST(FisheyeCalibration, EveryFormatKeepsTheLensOrRefusesIt) {
  CameraParameters p;
  p.name = "a";
  p.width_px = 1920;
  p.height_px = 1440;
  p.K << 600, 0, 960, 0, 610, 720, 0, 0, 1;
  p.t = {0.1, 0.2, 4.0};
  p.lens = MakeLens(kFisheyeModel, {-0.02, 0.015, -0.01, 0.002});
  const CameraRig cameras = {Camera(p)};
  std::vector<std::string> written;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    const TemporaryFolder folder;
    const std::string path = folder.path() / "result";
    LostFields lost_fields;
    try {
      WriteCalibration(path, format.name, cameras, &lost_fields);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("camera 'a'")) << format.name;
      EXPECT_FALSE(std::filesystem::exists(path)) << format.name;
      continue;
    }
    written.push_back(format.name);
    const CameraRig back = ReadCameras(path);
    ASSERT_EQ(back.size(), 1u);
    // COLMAP's K is shifted by half a pixel, which rounds it.
    EXPECT_LT(Compare(cameras, back).px, 1e-9) << format.name;
    EXPECT_EQ(LensOf(back[0]), LensOf(cameras[0])) << format.name;
  }
  EXPECT_THAT(written,
              ElementsAre("kinegraph", "pose2sim", "opencv", "colmap"));
}

}  // namespace
}  // namespace kinegraph
