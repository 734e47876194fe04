#include "core/io/calibration/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "tests/core/io/calibration/calibration_files.h"

namespace kinegraph {
namespace {

using testing::CamerasOf;
using ::testing::ElementsAre;
using testing::ExpectInputError;
using testing::ExpectIntrinsics;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::LensOf;
using testing::NamesOf;
using testing::OpencvMatrix;
using testing::TemporaryFolder;
using testing::WithReplaced;

const Camera& Named(const CameraRig& cameras, const std::string& name) {
  const auto at =
      std::find_if(cameras.begin(), cameras.end(),
                   [&](const Camera& camera) { return camera.name() == name; });
  if (at == cameras.end()) throw std::runtime_error("no camera " + name);
  return *at;
}

// Largest distance [px] between the images of a point in two cameras, over
// points of a box. Skips points less than 1 m in front of `a` and images far
// outside; 1e9 if one camera does not see a point.
double LargestDistancePx(const Camera& a, const Camera& b,
                         const Eigen::Vector3d& low,
                         const Eigen::Vector3d& high) {
  double largest = 0.0;
  constexpr int kSteps = 5;
  for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
    const Eigen::Vector3d share(i % kSteps, i / kSteps % kSteps,
                                i / kSteps / kSteps);
    const Eigen::Vector3d point =
        low + (high - low).cwiseProduct(share / (kSteps - 1));
    if (a.Depth(point) < 1.0) continue;
    const auto px_a = a.Project(point);
    const auto px_b = b.Project(point);
    if (!px_a.has_value() || !px_b.has_value()) return 1e9;
    if (px_a->cwiseAbs().maxCoeff() > 2000.0) continue;  // far off the image
    largest = std::max(largest, (*px_a - *px_b).norm());
  }
  return largest;
}

// ---- Shelf ----

// The area where people walk [m].
const Eigen::Vector3d kShelfLow(-2.0, -2.0, 0.0);
const Eigen::Vector3d kShelfHigh(2.0, 2.0, 2.0);

TEST(Calibration, ReadsShelf) {
  KINEGRAPH_DATA_OR_SKIP(path, "shelf/calibration.json");
  const CameraRig cameras = ReadCameras(path);
  EXPECT_THAT(NamesOf(cameras), ElementsAre("0", "1", "2", "3", "4"));
  for (const Camera& camera : cameras) {
    EXPECT_EQ(camera.width_px(), 1032);
    EXPECT_EQ(camera.height_px(), 776);
    EXPECT_EQ(camera.lens(), nullptr);
  }
  EXPECT_DOUBLE_EQ(cameras[0].K()(0, 0), 1063.5121);
  EXPECT_DOUBLE_EQ(cameras[0].K()(1, 2), 350.08829);
  EXPECT_DOUBLE_EQ(cameras[0].t().x(), -0.5942785);
  // -R^T t in metres; VoxelPose's file states it in mm.
  EXPECT_NEAR(cameras[0].centre().x(), -1.58645, 1e-5);
}

TEST(Calibration, ShelfFormatsAgree) {
  KINEGRAPH_DATA_OR_SKIP(krt_path, "shelf/calibration.json");
  KINEGRAPH_DATA_OR_SKIP(voxelpose_path, "shelf/calibration_voxelpose.json");
  KINEGRAPH_DATA_OR_SKIP(tum_path, "shelf/tum");
  const CameraRig krt = ReadCameras(krt_path);
  const CameraRig voxelpose = ReadCameras(voxelpose_path);
  const CameraRig tum = ReadCameras(tum_path);
  ASSERT_EQ(voxelpose.size(), 5u);
  EXPECT_THAT(NamesOf(tum), ElementsAre("P0", "P1", "P2", "P3", "P4"));
  for (size_t c = 0; c < 5; ++c) {
    // Rotations have six decimals: an error of 5e-7 in each entry, with 1000 px
    // of focal length and at most three terms, stays below 0.01 px.
    EXPECT_LT(LargestDistancePx(krt[c], Named(voxelpose, krt[c].name()),
                                kShelfLow, kShelfHigh),
              0.01);
    EXPECT_LT(
        (krt[c].centre() - Named(voxelpose, krt[c].name()).centre()).norm(),
        1e-5);
    // Entries have five digits: a relative error of at most 5e-5 (2.4e-5 before
    // scaling to K(2,2) = 1, according to the data's README).
    const double scale = krt[c].P().cwiseAbs().maxCoeff();
    EXPECT_LT((tum[c].P() - krt[c].P()).cwiseAbs().maxCoeff() / scale, 5e-5);
    // The decomposition of P amplifies its rounding.
    EXPECT_LT((tum[c].R() - krt[c].R()).cwiseAbs().maxCoeff(), 2e-3);
    EXPECT_GT(tum[c].Depth(Eigen::Vector3d(0.0, 0.0, 1.0)), 0.0);
  }
}

// ---- Campus ----

CameraReadOptions CampusOptions() {
  CameraReadOptions options;
  options.image_size = {360, 288};
  options.ignore_distortion = true;
  return options;
}

TEST(Calibration, ReadsCampus) {
  KINEGRAPH_DATA_OR_SKIP(path, "campus/calibration.json");
  const CameraRig cameras = ReadCameras(path, CampusOptions());
  EXPECT_THAT(NamesOf(cameras), ElementsAre("Camera1", "Camera2", "Camera0"));
  EXPECT_EQ(cameras[0].width_px(), 360);
  EXPECT_NEAR(cameras[0].centre().x(), -6.240579909342257, 1e-12);
  EXPECT_NEAR(cameras[0].K()(0, 0), 360.0 * 1.1945368357487924, 1e-9);
  ExpectInputError([&] { ReadCameras(path); }, "cameras.image_size");
}

TEST(Calibration, CampusFormatsAgree) {
  KINEGRAPH_DATA_OR_SKIP(longcw_path, "campus/calibration.json");
  KINEGRAPH_DATA_OR_SKIP(voxelpose_path, "campus/calibration_voxelpose.json");
  KINEGRAPH_DATA_OR_SKIP(tum_path, "campus/tum");
  const CameraRig longcw = ReadCameras(longcw_path, CampusOptions());
  const CameraRig voxelpose = ReadCameras(voxelpose_path, CampusOptions());
  const CameraRig tum = ReadCameras(tum_path, CampusOptions());
  const Eigen::Vector3d low(-1.0, 2.0, 0.0);
  const Eigen::Vector3d high(6.0, 7.0, 2.0);
  for (const std::string number : {"0", "1", "2"}) {
    const Camera& camera = Named(longcw, "Camera" + number);
    // Both files have full precision.
    EXPECT_LT(LargestDistancePx(camera, Named(voxelpose, number), low, high),
              1e-6);
    // P has five digits: 0.01 px near the people (README), more with the
    // distance from the image centre.
    EXPECT_LT(LargestDistancePx(camera, Named(tum, "P" + number), low, high),
              0.1);
  }
}

// ---- Panoptic ----

TEST(Calibration, ReadsPanoptic) {
  KINEGRAPH_DATA_OR_SKIP(path, "panoptic/calibration_160422_ultimatum1.json");
  const CameraRig cameras = ReadCameras(path);
  EXPECT_EQ(cameras.size(), 520u);
  EXPECT_EQ(cameras[0].name(), "01_01");
  // The names are PANEL_CAMERA; the HD cameras are panel 0.
  const auto is_hd = [](const Camera& camera) {
    return camera.name().rfind("00_", 0) == 0;
  };
  EXPECT_EQ(std::count_if(cameras.begin(), cameras.end(), is_hd), 31);
  for (const Camera& camera : cameras) {
    if (is_hd(camera)) {
      EXPECT_EQ(camera.width_px(), 1920);
      EXPECT_EQ(camera.height_px(), 1080);
    }
    ASSERT_NE(camera.lens(), nullptr);
    // The dome has a radius of 2.75 m about the middle of the floor.
    EXPECT_LT(camera.centre().norm(), 5.0);
    EXPECT_GT(camera.centre().norm(), 1.0);
  }
  EXPECT_DOUBLE_EQ(cameras[0].t().z(), 288.2857244 / 100.0);
}

TEST(Calibration, UseSelectsCamerasInGivenOrder) {
  KINEGRAPH_DATA_OR_SKIP(path, "panoptic/calibration_160422_ultimatum1.json");
  CameraReadOptions options;
  options.use = {"00_16", "00_00", "00_03"};
  EXPECT_THAT(NamesOf(ReadCameras(path, options)),
              ElementsAre("00_16", "00_00", "00_03"));
  options.use = {"00_99"};
  ExpectInputError([&] { ReadCameras(path, options); },
                   "has no camera '00_99'");
}

// A rotation by 90 degrees about the optical axis, as a matrix and as a vector.
constexpr const char* kCaliscopeArray =
    "[cameras.0]\ncam_id = 0\nrotation_count = 0\nerror = 0.4\n"
    "exposure = -8\ngrid_count = 39\nignore = false\nsize = [1280, 720]\n"
    "matrix = [[900.0, 0.0, 640.0], [0.0, 910.0, 360.0], [0.0, 0.0, 1.0]]\n"
    "distortions = [-0.3, 0.05, -0.004, 0.004, 0.07]\n"
    "verified_resolutions = [[640, 480], [1280, 720]]\n"
    "translation = [0.1, -0.2, 0.7]\n"
    "rotation = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]\n"
    "world_position = [0.2, 0.1, -0.7]\n"  // newer FreeMoCap
    "world_orientation = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]\n"
    "[cameras.2]\ncam_id = 2\nignore = true\nsize = [1280, 720]\n"
    "matrix = [[900.0, 0.0, 640.0], [0.0, 910.0, 360.0], [0.0, 0.0, 1.0]]\n"
    "distortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n";

constexpr const char* kCaliscopeConfig =
    "camera_count = 2\ncreation_date = 2025-05-16T09:47:38.225432\n"
    "fps_sync_stream_processing = 1\nsave_tracked_points_video = true\n"
    "[cam_0]\nport = 0\nrotation_count = 0\nerror = 0.4\n"
    "exposure = \"null\"\ngrid_count = 20\nsize = [1280, 720]\n"
    "matrix = [[900.0, 0.0, 640.0], [0.0, 910.0, 360.0], [0.0, 0.0, 1.0]]\n"
    "distortions = [-0.3, 0.05, -0.004, 0.004, 0.07]\n"
    "translation = [0.1, -0.2, 0.7]\n"
    "rotation = [0.0, 0.0, 1.5707963267948966]\n"
    "[cam_4]\nport = 4\nsize = [1280, 720]\n"
    "matrix = [[900.0, 0.0, 640.0], [0.0, 910.0, 360.0], [0.0, 0.0, 1.0]]\n"
    "distortions = [0.0, 0.0, 0.0, 0.0, 0.0]\n"
    "translation = \"null\"\nrotation = \"null\"\n"
    "[capture_volume]\nstage = 1\n"
    "[charuco]\ncolumns = 6\nunits = \"inch\"\n"
    "[stereo_0_4]\nRMSE = 3.1\nrotation = [[1.0, 0.0, 0.0]]\n";

TEST(Calibration, ReadsCaliscope) {
  for (const char* text : {kCaliscopeArray, kCaliscopeConfig}) {
    const CameraRig cameras = CamerasOf("array.toml", text);
    ASSERT_THAT(NamesOf(cameras), ElementsAre("cam_0"))
        << "cameras without a pose are skipped";
    EXPECT_EQ(cameras[0].width_px(), 1280);
    EXPECT_EQ(cameras[0].K()(1, 1), 910.0);
    EXPECT_EQ(cameras[0].t(), Eigen::Vector3d(0.1, -0.2, 0.7));
    EXPECT_LT(
        (cameras[0].R() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY())
            .norm(),
        1e-15);
    ASSERT_NE(cameras[0].lens(), nullptr);
  }
  // A camera may be named like Caliscope's pairs.
  const std::string stereo =
      WithReplaced(kCaliscopeConfig, "[cam_0]", "[stereo_left]");
  EXPECT_THAT(NamesOf(CamerasOf("array.toml", stereo)),
              ElementsAre("stereo_left"));
  // A table that could be a camera is not ignored.
  EXPECT_THAT(FaultOf("array.toml", std::string(kCaliscopeConfig) +
                                        "[kamera_5]\nsize = [1280, 720]\n"),
              HasSubstr("camera 'kamera_5'"));
}

TEST(Calibration, ReadsFreeMoCapInMillimetres) {
  const TemporaryFolder folder;
  const std::string camera =
      "[cam_0]\nname = \"Camera_000\"\nsize = [1280, 720]\n"
      "matrix = [[900.0, 0.0, 640.0], [0.0, 900.0, 360.0], [0.0, 0.0, 1.0]]\n"
      "distortions = [0.1, 0.0, 0.0, 0.0, 0.0]\n"
      "rotation = [0.0, 0.0, 0.0]\ntranslation = [100.0, -200.0, 700.0]\n";
  const auto with = [&](const std::string& square) {
    return folder.Write("freemocap.toml",
                        camera +
                            "[metadata]\nadjusted = false\nerror = 0.0\n"
                            "charuco_square_size = " +
                            square + "\ngroundplane_calibration = false\n");
  };
  EXPECT_LT((ReadCameras(with("39.0"))[0].t() - Eigen::Vector3d(0.1, -0.2, 0.7))
                .norm(),
            1e-15);
  // 1 is the default: lengths are then in squares of unknown size.
  EXPECT_EQ(ReadCameras(with("1.0"))[0].t(),
            Eigen::Vector3d(100.0, -200.0, 700.0));
  CameraReadOptions options;
  options.unit = LengthUnit::kCentimetre;
  EXPECT_EQ(ReadCameras(with("39.0"), options)[0].t(),
            Eigen::Vector3d(1.0, -2.0, 7.0));
}

// ---- Handwritten samples ----

// The text with Windows line ends.
std::string Crlf(const std::string& text) {
  std::string lines;
  for (const char one : text) lines += one == '\n' ? "\r\n" : std::string{one};
  return lines;
}

const std::string kNames = "%YAML:1.0\n---\nnames:\n  - \"01\"\n  - \"02\"\n";
const std::string kIntri = Crlf(
    kNames +
    OpencvMatrix("K_01", "3", "3",
                 "1000.0, 0.0, 960.0, 0.0, 1010.0, 540.0, 0.0, 0.0, 1.0") +
    OpencvMatrix("dist_01", "1", "5", "-0.1, 0.02, 0.001, -0.002, 0.003") +
    "H_01: 1080\nW_01: 1920\n" +
    OpencvMatrix("K_02", "3", "3",
                 " 1.1e+03, 0., 950., 0., 1110., 530., 0., 0.,\n      1. ") +
    OpencvMatrix("dist_02", "5", "1", "0., 0., 0., 0., 0."));
const std::string kExtri =
    Crlf(kNames + OpencvMatrix("R_01", "3", "1", "0.0, 0.0, 1.570796") +
         OpencvMatrix("Rot_01", "3", "3",
                      "0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0") +
         OpencvMatrix("T_01", "3", "1", "0.5, -0.25, 4.0") +
         OpencvMatrix("Rot_02", "3", "3", "1, 0, 0, 0, 1, 0, 0, 0, 1") +
         OpencvMatrix("T_02", "3", "1", "0, 0, 3"));

void ExpectEasymocapSample(const CameraRig& cameras) {
  ASSERT_THAT(NamesOf(cameras), ElementsAre("01", "02"));
  const Camera& first = cameras[0];
  ExpectIntrinsics(first, "01", {1920, 1080}, {1000.0, 1010.0, 960.0, 540.0});
  EXPECT_THAT(LensOf(first), ElementsAre(-0.1, 0.02, 0.001, -0.002, 0.003));
  // A rotation vector of 90 degrees about z, written with six decimals.
  EXPECT_NEAR(first.R()(1, 0), 1.0, 1e-6);
  EXPECT_EQ(first.t(), Eigen::Vector3d(0.5, -0.25, 4.0));
  EXPECT_EQ(cameras[1].lens(), nullptr);
  EXPECT_EQ(cameras[1].K()(0, 0), 1100.0);
  EXPECT_EQ(cameras[1].width_px(), 0);
}

TEST(Calibration, ReadsEasymocap) {
  const TemporaryFolder folder;
  const std::string intri = folder.Write("intri.yml", kIntri);
  const std::string extri = folder.Write("extri.yml", kExtri);
  ExpectEasymocapSample(ReadCameras(folder.path().string()));
  ExpectEasymocapSample(ReadCameras(intri));
  CameraReadOptions options;
  options.format = "easymocap";
  ExpectEasymocapSample(ReadCameras(extri, options));
}

TEST(Calibration, EasymocapRotationsMustAgree) {
  const TemporaryFolder folder;
  folder.Write("intri.yml", kIntri);
  folder.Write("extri.yml", WithReplaced(kExtri, "1.570796", "1.500000"));
  ExpectInputError([&] { ReadCameras(folder.path()); }, "Rot_01");
}

TEST(Calibration, OpencvCamerasAreNamedByFiles) {
  const TemporaryFolder folder;
  const std::string text =
      "camera_matrix: [[600, 0, 320], [0, 601, 240], [0, 0, 1]]\n"
      "rvec: [0, 0, 0]\ntvec: [0.5, 0, 2]\n";
  const std::string left = folder.Write("left.yml", text);
  folder.Write("right.yaml", text);
  folder.Write("._left.yml", std::string("\0\5\x16\7", 4));  // of macOS
  EXPECT_THAT(NamesOf(ReadCameras(folder.path().string())),
              ElementsAre("left", "right"));
  EXPECT_THAT(NamesOf(ReadCameras(left)), ElementsAre("left"));
}

Eigen::Matrix3d RandomRotation(Random* random) {
  Eigen::Quaterniond q(random->Normal(), random->Normal(), random->Normal(),
                       random->Normal());
  return q.normalized().toRotationMatrix();
}

// P = s K [R | t] with a positive or negative scale s and a skewed K.
TEST(Calibration, ProjectionMatricesOfAnySignAndScaleAreDecomposed) {
  Random random(3);
  for (const double scale : {1.0, -1.0, -3e-4, 250.0}) {
    CameraParameters p;
    p.name = "P";
    p.K << 900.0, 2.0, 500.0, 0.0, 950.0, 400.0, 0.0, 0.0, 1.0;
    p.R = RandomRotation(&random);
    p.t << 0.3, -0.4, 5.0;
    const Camera truth(p);
    std::string text;
    for (int i = 0; i < 12; ++i) {
      char number[40];
      std::snprintf(number, sizeof(number), "%.17g%c",
                    scale * truth.P()(i / 4, i % 4), i % 4 == 3 ? '\n' : ' ');
      text += number;
    }
    const Camera camera = CamerasOf("P.txt", text).front();
    // Relative to K, 1e-10 px is 1e-13: a few hundred roundings in the
    // decomposition of a 3 x 3 matrix. R and t may have ten times this error.
    EXPECT_LT((camera.K() - p.K).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((camera.R() - p.R).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((camera.t() - p.t).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Calibration, ProjectionFilesAreOrderedByNumber) {
  const TemporaryFolder folder;
  for (const char* name : {"P10.txt", "P2.txt", "P1.txt", "Px.txt", "Q1.txt"}) {
    folder.Write(name, "1 0 0 0\n0 1 0 0\n0 0 1 1\n");
  }
  EXPECT_THAT(NamesOf(ReadCameras(folder.path().string())),
              ElementsAre("P1", "P2", "P10"));
}

// ---- Options ----

constexpr const char* kSmallKrt =
    R"({"0": {"K": [9,0,4, 0,9,3, 0,0,1], "RT": [1,0,0,100, 0,1,0,200,
       0,0,1,300], "imgSize": [8, 6]}})";

TEST(Calibration, UnitIsAppliedAndSizeIsChecked) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("c.json", kSmallKrt);
  CameraReadOptions options;
  for (const auto& [unit, z_m] : {std::pair{LengthUnit::kAuto, 300.0},
                                  {LengthUnit::kMillimetre, 0.3},
                                  {LengthUnit::kCentimetre, 3.0}}) {
    options.unit = unit;
    EXPECT_EQ(ReadCameras(path, options)[0].t().z(), z_m);
  }
  options.image_size = {8, 6};
  EXPECT_EQ(ReadCameras(path, options)[0].width_px(), 8);
  options.image_size = {8, 7};
  ExpectInputError([&] { ReadCameras(path, options); },
                   "8 x 6 px, but cameras.image_size is 8 x 7");
  for (const std::vector<double>& size : std::vector<std::vector<double>>{
           {8}, {8, 6, 3}, {8.5, 6}, {0, 6}, {1e300, 6}}) {
    options.image_size = size;
    EXPECT_THROW(ReadCameras(path, options), OptionError);
  }
}

TEST(Calibration, ImageSizeMayBeNull) {
  const CameraRig cameras =
      CamerasOf("c.json", WithReplaced(kSmallKrt, "[8, 6]", "null"));
  EXPECT_EQ(cameras[0].width_px(), 0);
}

TEST(Calibration, LongModelsWithZeroTermsHaveFiveCoefficients) {
  const std::string text = WithReplaced(
      kSmallKrt, "}}", R"(, "distCoeff": [0.1, 0, 0, 0, 0, 0, 0, 0]}})");
  const CameraRig cameras = CamerasOf("c.json", text);
  ASSERT_NE(cameras[0].lens(), nullptr);
  EXPECT_THAT(cameras[0].lens()->parameters(), ElementsAre(0.1, 0, 0, 0, 0));
}

TEST(Calibration, NumberedTermsMayBeOmitted) {
  const auto lens_with = [](const std::string& terms) {
    return LensOf(
        CamerasOf("c.json", WithReplaced(kSmallKrt, "}}", terms + "}}"))[0]);
  };
  EXPECT_THAT(lens_with(R"(, "k1": -0.1)"), ElementsAre(-0.1, 0, 0, 0, 0));
  EXPECT_THAT(lens_with(R"(, "k1": -0.1, "k2": 0.02, "p1": 0.003)"),
              ElementsAre(-0.1, 0.02, 0.003, 0, 0));
  EXPECT_THAT(lens_with(R"(, "fisheye": true, "k1": -0.1)"),
              ElementsAre(-0.1, 0, 0, 0));
}

}  // namespace
}  // namespace kinegraph
