// The doctor's advice runs as printed, and removes that kind of finding.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/format.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/session/run.h"
#include "tests/support/faulty_scene.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::FaultyScene;
using testing::RunProgram;

struct Case {
  const char* kind;
  std::function<void(FaultyScene*)> spoil;
};

class Fixes : public ::testing::TestWithParam<Case> {};

std::vector<Case> Cases() {
  return {
      {"view_rate",
       [](FaultyScene* scene) {
         // All views but view 1 lose every second image. The stated rate is
         // theirs, half of that of view 1.
         auto& frames = scene->detections.frames;
         for (size_t k = 0; k < frames.size(); ++k) {
           for (size_t v = 0; v < 4; ++v) {
             if (v == 1) continue;
             frames[k].views[v].detections.clear();
             if (2 * k >= frames.size()) continue;
             frames[k].views[v].detections = frames[2 * k].views[v].detections;
           }
         }
         scene->detections.header.frame_rate_hz /= 2.0;
       }},
      {"frame_range",
       [](FaultyScene* scene) {
         auto& frames = scene->detections.frames;
         const size_t count = frames.size();
         for (size_t k = 0; k < count; ++k) {
           DetectionFrame late = frames[k];
           late.frame += 7000;
           for (size_t v = 0; v < 4; ++v) {
             if (v != 2) late.views[v].detections.clear();
           }
           frames[k].views[2].detections.clear();
           frames.push_back(std::move(late));
         }
       }},
      {"sides",
       [](FaultyScene* scene) {
         ExchangeSides({0, 1, 0, 0}, &scene->detections);
       }},
      {"image",  // y counts from the bottom in all views
       [](FaultyScene* scene) {
         for (size_t v = 0; v < 4; ++v) {
           const double bottom = scene->cameras[v].height_px() - 1.0;
           testing::ChangeJoints(scene, v, [=](Keypoint* joint) {
             joint->px.y() = bottom - joint->px.y();
           });
         }
       }},
      {"image",  // one view is rotated by 90 degrees and mirrored
       [](FaultyScene* scene) {
         testing::ChangeJoints(scene, 1, [](Keypoint* joint) {
           std::swap(joint->px.x(), joint->px.y());
         });
       }},
      {"image_size",
       [](FaultyScene* scene) {
         testing::ChangeJoints(scene, 1, [](Keypoint* joint) {
           joint->px = 0.5 * joint->px.array() - 0.25;
         });
       }},
      {"crop",
       [](FaultyScene* scene) {
         testing::ChangeJoints(scene, 3, [](Keypoint* joint) {
           joint->px -= Eigen::Vector2d(240.0, 120.0);
         });
       }},
      {"unit",
       [](FaultyScene* scene) {
         for (Camera& camera : scene->cameras) {
           camera =
               testing::WithExtrinsics(camera, camera.R(), 1000.0 * camera.t());
         }
       }},
      {"rotation",
       [](FaultyScene* scene) {
         scene->cameras[2] = testing::Turned(scene->cameras[2], 2.0, 9);
       }},
  };
}

nlohmann::json Doctor(const std::string& arguments, const std::string& out) {
  const auto outcome = RunProgram("doctor", arguments + " --out='" + out + "'");
  EXPECT_EQ(outcome.exit_code, 0) << arguments << ": " << outcome.errors;
  return nlohmann::json::parse(testing::ContentOf(out + "/doctor.json"));
}

// A recording written to a folder, and the flags and keys that read it.
struct Files {
  explicit Files(const std::string& folder) : path(folder) {}
  void Write(const std::function<void(FaultyScene*)>& spoil) {
    testing::FaultySceneOptions options = {21, 4, 2, 5.0};
    options.frame_rate_hz = 30.0;
    FaultyScene scene = testing::MakeFaultyScene(options);
    spoil(&scene);
    WriteCameras(path + "/cameras.json", scene.cameras);
    MemorySource source(scene.detections);
    LostFields lost_fields;
    FindDetectionFormat("openpose")
        ->write(path + "/det", {}, &source, &lost_fields);
    keys = "detections.skeleton=coco17;input.frame_rate=" +
           std::to_string(scene.detections.header.frame_rate_hz);
  }

  std::string path;
  std::string cameras = "--cameras='" + path + "/cameras.json'";
  std::string detections = " --detections='" + path + "/det'";
  std::string keys;
};

TEST_P(Fixes, RunAsPrintedAndResolveTheFinding) {
  const Case& one = GetParam();
  const testing::TemporaryFolder folder;
  Files files(folder.path().string());
  files.Write(one.spoil);
  const auto& [path, cameras, detections, keys] = files;
  const std::string inputs = detections + " --set='" + keys + "'";
  const auto found = Doctor(cameras + inputs, path + "/first");
  ASSERT_FALSE(found.at("findings").empty()) << one.kind;
  for (const auto& finding : found.at("findings")) {
    const auto fix = finding.at("fix").get<std::string>();
    // Skips findings of low confidence: a shift equivalent to the rotation, or
    // the remainder of a crop that is estimated to a few pixels.
    if (finding.at("confidence").get<double>() <= 0.5 &&
        (finding.at("kind") == "shift" || finding.at("kind") != one.kind)) {
      continue;
    }
    EXPECT_EQ(finding.at("kind"), one.kind) << finding.dump();
    std::string arguments = fix + inputs;
    if (const size_t set = fix.find("--set="); set != std::string::npos) {
      // One --set holds all keys.
      const std::string mark = set == 0 ? "'" : "";
      const bool has_cameras = fix.rfind("--cameras=", 0) == 0;
      arguments = (has_cameras ? "" : cameras) + detections + " " + mark +
                  std::string(fix).insert(set + 6, keys + ";") + mark;
    } else {
      ASSERT_EQ(fix.rfind("--cameras=", 0), 0u) << fix;
    }
    const auto run =
        RunProgram("track", arguments + " --out='" + path + "/t.jsonl'");
    EXPECT_EQ(run.exit_code, 0) << arguments << ": " << run.errors;
    const auto then = Doctor(arguments, path + "/then");
    for (const auto& again : then.at("findings")) {
      EXPECT_NE(again.at("kind"), one.kind) << again.dump();
    }
    std::filesystem::remove_all(path + "/then");
  }
}

// The advice of `track` on a rotated camera is a command that runs (here with
// another --out) and finds the recording suspect.
TEST(Advice, CommandPrintedByTrackRuns) {
  const testing::TemporaryFolder folder;
  Files files(folder.path().string());
  files.Write([](FaultyScene* scene) {
    scene->cameras[2] = testing::Turned(scene->cameras[2], 4.0, 9);
  });
  const auto run = RunProgram(
      "track", files.cameras + files.detections + " --set='" + files.keys +
                   "' --out='" + files.path + "/t.jsonl'");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto summary =
      nlohmann::json::parse(testing::ContentOf(files.path + "/t.summary.json"));
  const std::string start = "kinegraph doctor ";
  const std::string end = " --out=doctor";
  int commands = 0;
  for (const auto& warning : summary.at("warnings")) {
    const auto advice = warning.at("try").get<std::string>();
    if (advice.rfind(start, 0) != 0 || commands++ > 0) continue;
    ASSERT_EQ(advice.substr(advice.size() - end.size()), end) << advice;
    const auto found = Doctor(
        advice.substr(start.size(), advice.size() - start.size() - end.size()),
        files.path + "/doctor");
    EXPECT_EQ(found.at("verdict"), "suspect") << found.dump();
  }
  EXPECT_GT(commands, 0) << summary.at("warnings").dump();
}

TEST(Frames, OutsideTheRecordingAreRefused) {
  const testing::TemporaryFolder folder;
  Files files(folder.path().string());
  files.Write([](FaultyScene*) {});
  const auto run =
      RunProgram("doctor", files.cameras + files.detections + " --set='" +
                               files.keys + "' --frames=5000:5100 --out='" +
                               files.path + "/new/doctor'");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.errors.find("no frame to examine in --frames=5000:5100, the "
                            "recording has "),
            std::string::npos)
      << run.errors;
  EXPECT_FALSE(std::filesystem::exists(files.path + "/new"));
}

// A camera without a view stays in the calibration, unless a finding changes
// all cameras.
TEST(Cameras, WithoutAViewAreKept) {
  for (const double scale : {1.0, 1000.0}) {
    const testing::TemporaryFolder folder;
    Files files(folder.path().string());
    files.Write([&](FaultyScene* scene) {
      scene->cameras.push_back(
          Edited(scene->cameras[0], [](CameraParameters* camera) {
            camera->name = "spare";
            camera->t.x() += 0.5;
          }));
      for (Camera& camera : scene->cameras) {
        camera =
            testing::WithExtrinsics(camera, camera.R(), scale * camera.t());
      }
    });
    const auto report =
        Doctor(files.cameras + files.detections + " --set='" + files.keys + "'",
               files.path + "/doctor");
    const CameraRig cameras =
        ReadCameras(files.path + "/doctor/cameras.json", {});
    const bool is_kept = scale == 1.0;
    ASSERT_EQ(cameras.size(), is_kept ? 5u : 4u) << report.dump();
    EXPECT_EQ(cameras.back().name() == "spare", is_kept);
    EXPECT_EQ(report.at("notes").dump().find("'spare'") == std::string::npos,
              is_kept)
        << report.dump();
  }
}

// `doctor` and `calibrate` cannot read a stream.
TEST(Advice, NamesAFileInsteadOfAStream) {
  const testing::TemporaryFolder folder;
  Files files(folder.path().string());
  files.Write([&](FaultyScene* scene) {
    scene->cameras[2] = testing::Turned(scene->cameras[2], 4.0, 9);
    MemorySource source(scene->detections);
    LostFields lost_fields;
    FindDetectionFormat("kinegraph")
        ->write(files.path + "/det.jsonl", {}, &source, &lost_fields);
  });
  const auto run = RunProgram(
      "track", files.cameras + " --detections=- --out='" + files.path +
                   "/t.jsonl' < '" + files.path + "/det.jsonl'");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const std::string warnings =
      nlohmann::json::parse(testing::ContentOf(files.path + "/t.summary.json"))
          .at("warnings")
          .dump();
  EXPECT_NE(warnings.find("--detections=FILE"), std::string::npos) << warnings;
  EXPECT_EQ(warnings.find("--detections=-"), std::string::npos) << warnings;
}

// Clocks recorded in a calibration are applied to the recording: without them
// it is suspect, with them it is sound, and the record is passed on.
TEST(Records, ClocksInACalibrationAreApplied) {
  const testing::TemporaryFolder folder;
  const std::string path = folder.path().string();
  testing::FaultySceneOptions options = {21, 4, 2, 5.0};
  options.clock_offset_s = {0.0, 0.4, 0.0, -0.28};
  const FaultyScene scene = testing::MakeFaultyScene(options);
  MemorySource source(scene.detections);
  LostFields lost_fields;
  FindDetectionFormat("kinegraph")
      ->write(path + "/det.jsonl", {}, &source, &lost_fields);
  nlohmann::json cameras = nlohmann::json::array();
  for (size_t v = 0; v < 4; ++v) {
    cameras.push_back(
        {{"name", scene.cameras[v].name()},
         {"clock", {{"offset_s", options.clock_offset_s[v]}, {"drift", 0.0}}}});
  }
  const nlohmann::json record = {{"cameras", cameras}};
  const std::string detections = " --detections='" + path + "/det.jsonl'";
  WriteCameras(path + "/without.json", scene.cameras);
  WriteCameras(path + "/with.json", scene.cameras, record.dump());
  const auto without =
      Doctor("--cameras='" + path + "/without.json'" + detections, path + "/a");
  EXPECT_EQ(without.at("verdict"), "suspect");
  const auto with =
      Doctor("--cameras='" + path + "/with.json'" + detections, path + "/b");
  EXPECT_EQ(with.at("verdict"), "sound") << with.dump();
  const auto handed_on =
      nlohmann::json::parse(testing::ContentOf(path + "/b/cameras.json"));
  EXPECT_EQ(
      handed_on.at("refinement").at("cameras")[1].at("clock").at("offset_s"),
      0.4);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Fixes, ::testing::ValuesIn(Cases()),
                         [](const auto& test) {
                           return test.param.kind + std::to_string(test.index);
                         });

}  // namespace
}  // namespace kinegraph
