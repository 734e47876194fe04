#include "core/io/file_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

TEST(FileKind, IsToldByContent) {
  const std::multimap<FileKind, std::string> cases = {
      {FileKind::kCalibration, R"({"kinegraph_cameras": 1, "cameras": []})"},
      {FileKind::kCalibration, R"({"0": {"K": [], "RT": []}})"},
      {FileKind::kCalibration, "[cam_01]\nname = \"a\"\n"},
      {FileKind::kCalibration, "# cameras\n[cam_01]\n"},
      {FileKind::kCalibration, "%YAML:1.0\n---\nnames:\n"},
      {FileKind::kCalibration, "1,2,3,4\n5,6,7,8\n9,10,11,12\n"},
      {FileKind::kDetections, R"({"kinegraph_detections": 1})"},
      {FileKind::kDetections, R"([{"image_id": 3, "keypoints": []}])"},
      {FileKind::kDetections, R"({"image_wh": [3, 4], "frames": {}})"},
      {FileKind::kDetections, R"({"3d_pairs": {}})"},
      {FileKind::kTracks, R"({"kinegraph": 1})"},
      {FileKind::kTracks, R"([{"timestamp": 0.0, "poses": []}])"},
      {FileKind::kTracks, R"({"poses": []})"},
      {FileKind::kTracks, R"({"bodies": []})"},
      {FileKind::kTracks, "15 2\n0\n0\n"},
      {FileKind::kTracks, "MATLAB 5.0 MAT-file"}};
  const TemporaryFolder folder;
  for (const auto& [kind, text] : cases) {
    EXPECT_EQ(RecogniseKind(folder.Write("file", text)), kind) << text;
  }
}

TEST(FileKind, FoldersAreToldByTheirFiles) {
  const TemporaryFolder folder;
  const auto make = [&](const std::string& name) {
    fs::create_directories((folder.path() / name).parent_path());
    folder.Write(name, "[]");
  };
  make("tum/P0.txt");
  make("yaml/intri.yml");
  make("openpose/cam0/cam0_000000000000_keypoints.json");
  make("coco/cam0.json");
  fs::create_directories(folder.path() / "panoptic");
  folder.Write("panoptic/body3DScene_00000000.json", R"({"bodies": []})");
  const std::map<std::string, FileKind> cases = {
      {"tum", FileKind::kCalibration},
      {"yaml", FileKind::kCalibration},
      {"openpose", FileKind::kDetections},
      {"coco", FileKind::kDetections},
      {"panoptic", FileKind::kTracks}};
  for (const auto& [name, kind] : cases) {
    EXPECT_EQ(RecogniseKind((folder.path() / name).string()), kind) << name;
  }
}

TEST(FileKind, RefusesWhatIsNone) {
  const TemporaryFolder folder;
  for (const char* text : {"", "hello",
                           "\x7f"
                           "ELF"}) {
    const std::string path = folder.Write("file", text);
    EXPECT_THAT(InputErrorOf([&] { RecogniseKind(path); }),
                HasSubstr("is no calibration, detections or tracks"));
  }
  EXPECT_THAT(InputErrorOf([&] { RecogniseKind("missing.json"); }),
              HasSubstr("missing.json"));
  fs::create_directory(folder.path() / "empty");
  EXPECT_THAT(
      InputErrorOf([&] { RecogniseKind((folder.path() / "empty").string()); }),
      HasSubstr("is no calibration"));
}

// Whatever their bytes: XML in UTF-8 and UTF-16, a pickle, plain numbers.
TEST(FileKind, LaboratoriesCalibrations) {
  const TemporaryFolder folder;
  const std::string wide = std::string("\xff\xfe<\0a\0/\0>\0", 10);
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>{"cal.txt", "\n <calibration/>"},
        {"Cal.mcal", wide},
        {"camera", std::string("\x80\x04}.", 4)},
        {"00.mp4.calib", "1920\n1080\n1 0 0\n"}}) {
    EXPECT_EQ(RecogniseKind(folder.Write(name, text)), FileKind::kCalibration)
        << name;
  }
}

}  // namespace
}  // namespace kinegraph
