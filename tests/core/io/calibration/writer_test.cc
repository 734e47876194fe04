#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <string>

#include "core/base/random.h"
#include "core/io/calibration/format.h"
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/calibration/calibration_files.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using testing::ExpectInputError;
using testing::ExpectSameCameras;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::NamesOf;
using testing::TemporaryFolder;

enum class WithLens { kNo, kYes };

// Twelve cameras with random parameters of full precision.
CameraRig RigWith(WithLens with_lens) {
  Random random(3);
  CameraRig cameras;
  for (int c = 0; c < 12; ++c) {
    CameraParameters parameters;
    parameters.name = "cam-" + std::to_string(11 - c);
    parameters.width_px = 1920 - c;
    parameters.height_px = 1080 + c;
    parameters.K << random.Uniform(500.0, 2000.0), 0.0,
        random.Uniform(400.0, 900.0), 0.0, random.Uniform(500.0, 2000.0),
        random.Uniform(400.0, 900.0), 0.0, 0.0, 1.0;
    const Eigen::Vector3d axis(random.Normal(), random.Normal(),
                               random.Normal());
    parameters.R =
        Eigen::AngleAxisd(random.Uniform(0.0, 3.14159), axis.normalized())
            .toRotationMatrix();
    parameters.t = {random.Normal(), random.Normal(), random.Uniform(1.0, 9.0)};
    if (with_lens == WithLens::kYes) {
      const double k3 = c % 2 == 0 ? 0.0 : 0.01 * random.Normal();
      parameters.lens =
          MakeLens("opencv5", {0.1 * random.Normal(), 0.01 * random.Normal(),
                               1e-5 * random.Normal(), 1e-3, k3});
    }
    cameras.emplace_back(parameters);
  }
  return cameras;
}

CameraRig WithSize(CameraRig cameras, int width_px, int height_px) {
  for (Camera& camera : cameras) {
    CameraParameters parameters = camera.parameters();
    parameters.width_px = width_px;
    parameters.height_px = height_px;
    camera = Camera(parameters);
  }
  return cameras;
}

// A format, and what it keeps of the cameras of RigWith.
struct Case {
  std::string format;
  double tolerance;  // see ExpectSameCameras
  bool keeps_size;
  bool keeps_lens;
};

// Tolerances: the unit roundoff, 1.1e-16, times the number of roundings, with a
// margin. A change of unit has two; a centre, a rotation vector or a quaternion
// has a dozen; the decomposition of a projection matrix has some fifty, times
// the condition of K.
constexpr double kExact = 0.0;
constexpr double kUnit = 4e-16;
constexpr double kRotated = 1e-14;
constexpr double kDecomposed = 1e-11;

// Values that some other formats cannot represent: any name, no size, a skew,
// -0, tiny lens terms.
TEST(OwnCalibration, IsReadBackExactly) {
  CameraRig cameras;
  for (const Camera& camera : RigWith(WithLens::kYes)) {
    CameraParameters p = camera.parameters();
    p.name += " \"x\"\t\xC3\xA9";
    p.K(0, 1) = -0.3;
    p.t.z() = -0.0;
    if (cameras.size() % 2 == 0) p.width_px = p.height_px = 0;
    if (cameras.size() % 3 == 0) p.lens = nullptr;
    if (cameras.size() % 3 == 1)
      p.lens = MakeLens("opencv5", {0, 0, 0, 0, 1e-300});
    cameras.emplace_back(p);
  }
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "cameras.json").string();
  WriteCameras(path, cameras);
  const CameraRig read = ReadCameras(path);
  ASSERT_EQ(NamesOf(read), NamesOf(cameras));
  ExpectSameCameras(read, cameras, kExact);
  for (size_t c = 0; c < cameras.size(); ++c) {
    EXPECT_EQ(read[c].P(), cameras[c].P());
    EXPECT_EQ(read[c].width_px(), cameras[c].width_px());
    EXPECT_EQ(read[c].height_px(), cameras[c].height_px());
  }
  CameraReadOptions options;
  options.unit = LengthUnit::kMetre;
  EXPECT_EQ(ReadCameras(path, options).size(), cameras.size());
  options.unit = LengthUnit::kMillimetre;
  ExpectInputError([&] { ReadCameras(path, options); }, "cameras.unit");
}

TEST(OwnCalibration, WritingRequiresTheFolderAndReadingRequiresACamera) {
  const TemporaryFolder folder;
  EXPECT_THROW(WriteCameras((folder.path() / "none" / "c.json").string(), {}),
               InputError);
  const std::string path = (folder.path() / "c.json").string();
  WriteCameras(path, {});
  ExpectInputError([&] { ReadCameras(path); }, "has no cameras");
}

class RoundTrip : public ::testing::TestWithParam<Case> {};

TEST_P(RoundTrip, ReadsBackWhatTheFormatKeeps) {
  const Case& format = GetParam();
  CameraRig cameras =
      RigWith(format.keeps_lens ? WithLens::kYes : WithLens::kNo);
  // longcw has one image size for all cameras, which is given when reading;
  // opencv's cameras are in the order of their names.
  const bool is_longcw = format.format == "longcw";
  if (is_longcw) cameras = WithSize(cameras, 1920, 1080);
  if (format.format == "opencv") {
    std::sort(cameras.begin(), cameras.end(),
              [](const Camera& a, const Camera& b) {
                return a.name() + ".yml" < b.name() + ".yml";
              });
  }
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  LostFields lost_fields;
  WriteCalibration(path, format.format, cameras, &lost_fields);
  for (const std::string& read : {std::string("auto"), format.format}) {
    CameraReadOptions options;
    options.format = read;
    if (is_longcw) options.image_size = {1920.0, 1080.0};
    const CameraRig again = ReadCameras(path, options);
    ExpectSameCameras(cameras, again, format.tolerance);
    if (format.format != "tum") {
      EXPECT_EQ(NamesOf(cameras), NamesOf(again));
    }
    const bool has_size = format.keeps_size || is_longcw;
    for (size_t c = 0; c < again.size(); ++c) {
      EXPECT_EQ(again[c].width_px(), has_size ? cameras[c].width_px() : 0);
      EXPECT_EQ(again[c].height_px(), has_size ? cameras[c].height_px() : 0);
    }
  }
  EXPECT_EQ(lost_fields.empty(), format.keeps_size)
      << "losses must be reported";
  EXPECT_EQ(ListFolder(folder.path().string()).size(), 1u)
      << "files other than the result";
}

INSTANTIATE_TEST_SUITE_P(
    Formats, RoundTrip,
    ::testing::Values(Case{"kinegraph", kExact, true, true},
                      Case{"krt", kExact, true, true},
                      Case{"panoptic", kUnit, true, true},
                      Case{"voxelpose", kRotated, false, true},
                      Case{"pose2sim", kRotated, true, true},
                      Case{"easymocap", kRotated, true, true},
                      Case{"opencv", kExact, true, true},
                      Case{"longcw", kRotated, false, true},
                      Case{"colmap", kRotated, true, true},
                      Case{"tum", kDecomposed, false, false}));

// Rotations by zero, by 180 degrees and by a tiny angle.
TEST(CalibrationWriter, KeepsSpecialRotations) {
  CameraRig cameras;
  for (const double angle : {0.0, M_PI, 1e-9}) {
    CameraParameters parameters;
    parameters.name = std::to_string(cameras.size());
    parameters.R = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -2) / 3.0)
                       .toRotationMatrix();
    cameras.emplace_back(parameters);
  }
  const TemporaryFolder folder;
  LostFields lost_fields;
  for (const char* format : {"pose2sim", "easymocap"}) {
    const std::string path = folder.path() / std::to_string(lost_fields.size());
    WriteCalibration(path, format, cameras, &lost_fields);
    ExpectSameCameras(cameras, ReadCameras(path), kRotated);
  }
  EXPECT_EQ(lost_fields.size(), 2u) << "no image size is known";
}

TEST(CalibrationWriter, EasymocapNamesMayEndInOtherNames) {
  CameraRig cameras;
  for (const char* name : {"left", "front_left"}) {
    CameraParameters parameters = RigWith(WithLens::kYes)[0].parameters();
    parameters.name = name;
    parameters.t.x() = static_cast<double>(cameras.size());
    cameras.emplace_back(parameters);
  }
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  LostFields lost_fields;
  WriteCalibration(path, "easymocap", cameras, &lost_fields);
  const CameraRig again = ReadCameras(path);
  EXPECT_EQ(NamesOf(again), NamesOf(cameras));
  ExpectSameCameras(again, cameras, kRotated);
}

TEST(CalibrationWriter, RefusesWhatTheFormatCannotExpress) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "result";
  const auto expect = [&](const char* format, const CameraRig& rig,
                          const char* said) {
    LostFields lost_fields;
    ExpectInputError([&] { WriteCalibration(path, format, rig, &lost_fields); },
                     said);
  };
  expect("tum", RigWith(WithLens::kYes), "camera 'cam-11': has a lens");
  expect("longcw", RigWith(WithLens::kNo), "has another image size");
  CameraParameters parameters;
  parameters.name = "a b";
  for (const char* format : {"easymocap", "opencv", "colmap"}) {
    expect(format, {Camera(parameters)}, "camera 'a b': the name");
  }
  parameters.name = "a";
  for (const char* format : {"longcw", "colmap"}) {
    expect(format, {Camera(parameters)}, "--image_size");
  }
  parameters.width_px = parameters.height_px = 100;
  parameters.K(0, 1) = 0.5;
  for (const char* format : {"voxelpose", "colmap"}) {
    expect(format, {Camera(parameters)}, "a skewed K");
  }
  expect("xml", {Camera(parameters)},
         "found 'xml', expected one of kinegraph, krt");
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty())
      << "a rejected write left a file";
}

TEST(CalibrationWriter, RefusesCamerasOfOneName) {
  CameraParameters parameters;
  parameters.name = "a";
  parameters.width_px = parameters.height_px = 100;
  const TemporaryFolder folder;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    LostFields lost_fields;
    ExpectInputError(
        [&] {
          WriteCalibration(folder.path() / "result", format.name,
                           {Camera(parameters), Camera(parameters)},
                           &lost_fields);
        },
        "'a' appears twice");
  }
  EXPECT_THAT(ListFolder(folder.path().string()), IsEmpty());
}

TEST(CalibrationWriter, ReportsAnOmittedSkew) {
  CameraParameters parameters;
  parameters.name = "a";
  parameters.width_px = parameters.height_px = 100;
  parameters.K(0, 1) = -0.005;
  for (const char* format : {"voxelpose", "colmap"}) {
    const TemporaryFolder folder;
    LostFields lost_fields;
    WriteCalibration(folder.path() / "out", format, {Camera(parameters)},
                     &lost_fields);
    EXPECT_THAT(lost_fields,
                Contains("a skew of up to 0.005000 px is omitted"));
  }
}

TEST(CalibrationWriter, NeverReplacesAFolderWithFiles) {
  const TemporaryFolder folder;
  folder.Write("mine.txt", "keep");
  LostFields lost_fields;
  ExpectInputError(
      [&] {
        WriteCalibration(folder.path(), "tum", RigWith(WithLens::kNo),
                         &lost_fields);
      },
      "exists already");
  EXPECT_THAT(ListFolder(folder.path().string()), ElementsAre("mine.txt"));
}

// Numbers that TOML readers would take for integers, and odd names.
TEST(CalibrationWriter, TomlHasDecimalsAndEscapes) {
  CameraParameters parameters;
  parameters.name = "a \"b\" \\ [c]";
  parameters.K << 1000, 0, 500, 0, 1000, 400, 0, 0, 1;
  const TemporaryFolder folder;
  const std::string path = folder.path() / "calib.toml";
  LostFields lost_fields;
  WriteCalibration(path, "pose2sim", {Camera(parameters)}, &lost_fields);
  EXPECT_THAT(ReadTextFile(path),
              HasSubstr("matrix = [[1000.0, 0.0, 500.0], [0.0, 1000.0, 400.0], "
                        "[0.0, 0.0, 1.0]]"));
  EXPECT_EQ(ReadCameras(path).front().name(), parameters.name);
}

// Recognition does not depend on the order of CalibrationFormats().
TEST(CalibrationFormats, OnlyTheWrittenFormatRecognisesAFile) {
  const CameraRig cameras = WithSize(RigWith(WithLens::kNo), 1920, 1080);
  for (const CalibrationFormat& written : CalibrationFormats()) {
    EXPECT_EQ(FindCalibrationFormat(written.name), &written);
    EXPECT_FALSE(written.layout.empty()) << written.name;
    if (written.write == nullptr) continue;
    const TemporaryFolder folder;
    const std::string path = folder.path() / "result";
    LostFields lost_fields;
    written.write(path, cameras, &lost_fields);
    const CalibrationHead head = LookAtCalibration(path);
    for (const CalibrationFormat& format : CalibrationFormats()) {
      if (format.recognise == nullptr) continue;  // recognised by an adapter
      EXPECT_EQ(format.recognise(head), &format == &written)
          << written.name << " by " << format.name;
    }
    EXPECT_EQ(RecogniseKind(path), FileKind::kCalibration) << written.name;
  }
  EXPECT_EQ(FindCalibrationFormat("auto"), nullptr);
}

}  // namespace
}  // namespace kinegraph
