// `reproduce` on folders laid out like the official downloads
// (docs/official_data.md), with a small synthetic recording in them.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/evaluation/pcp.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "tests/apps/command.h"
#include "tests/support/mat_file.h"
#include "tests/support/rig.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int64_t kFirstDetected = 297;
constexpr int64_t kFirstScored = 300;
constexpr int64_t kEnd = 320;

// Actor 0 walks, actor 1 stands.
std::vector<Pose3d> PeopleAt(int64_t frame) {
  const double y = -0.5 + 0.04 * static_cast<double>(frame - kFirstDetected);
  return {testing::StandingPerson(-0.9, y), testing::StandingPerson(1.0, 0.2)};
}

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

class OfficialDataTest : public testing::CommandTest {
 protected:
  OfficialDataTest() {
    const Tum14Converter to_tum14(Coco17(), HeadConversion::kChu);
    testing::AnnotatedActors actors(2);
    for (int64_t frame = kFirstScored; frame < kEnd; ++frame) {
      const std::vector<Pose3d> people = PeopleAt(frame);
      for (size_t a = 0; a < people.size(); ++a) {
        actors[a][frame] = to_tum14(people[a]);
      }
    }
    ground_truth_ = testing::ActorsGroundTruth(actors, kEnd);
  }

  void WriteSet(const std::string& set, const std::string& calibration) {
    fs::create_directories(Path(set + "/" + calibration));
    fs::create_directories(Path(set + "/detections"));
    folder_.Write(set + "/actorsGT.mat", ground_truth_);
    for (size_t v = 0; v < cameras_.size(); ++v) {
      std::string P;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) {
          P += Number(cameras_[v].P()(row, column)) + (column < 3 ? "," : "\n");
        }
      }
      folder_.Write(set + "/" + calibration + "/P" + std::to_string(v) + ".txt",
                    P);
      folder_.Write(set + "/detections/cam" + std::to_string(v) + ".json",
                    CocoResults(cameras_[v]));
    }
  }

  static std::string CocoResults(const Camera& camera) {
    std::string text = "[";
    for (int64_t frame = kFirstDetected; frame < kEnd; ++frame) {
      for (const Pose3d& person : PeopleAt(frame)) {
        const Detection seen = testing::Project(person, camera);
        text += std::string(text.size() > 1 ? ",\n" : "") +
                "{\"image_id\": " + std::to_string(frame) +
                ", \"category_id\": 1, \"score\": 1, \"keypoints\": [";
        for (size_t j = 0; j < seen.joints.size(); ++j) {
          const Keypoint& joint = seen.joints[j];
          text += (j > 0 ? ", " : "") + Number(joint.px.x()) + ", " +
                  Number(joint.px.y()) + ", " + (joint.found ? "0.9" : "0");
        }
        text += "]}";
      }
    }
    return text + "]\n";
  }

  std::string Flags(const std::string& more = "") const {
    return "--data='" + Path("") + "' --out='" + Path("out") + "' " + more;
  }
  // Returns the tables made.
  Json Reproduce(const std::string& more = "") const {
    testing::Done("reproduce", Flags(more));
    const std::string path = Path("out/reproduce.json");
    return ParseJson(ReadTextFile(path), path)["tables"];
  }

  const CameraRig cameras_ = testing::RingOfCameras(4);
  std::string ground_truth_;
};

TEST_F(OfficialDataTest, ShelfFoldersGiveAllTablesOfShelf) {
  WriteSet("Shelf", "Calibration");
  const Json tables = Reproduce();
  // Without the campus folder there is no campus table.
  EXPECT_FALSE(tables.contains("campus"));
  for (const char* table :
       {"shelf", "parts", "ablation", "runtime", "sensitivity"}) {
    EXPECT_TRUE(tables.contains(table)) << table;
  }
  const Json& measured = tables["shelf"]["measured"];
  ASSERT_FALSE(measured.empty());
  EXPECT_EQ(measured[0]["method"], "paper mode, text");
  for (const Json& row : measured) {
    const Json& score = row["scores"][0];
    for (const char* actor : {"0", "1"}) {
      // 20 annotated frames of ten parts. Detections are exact and begin three
      // frames before the first scored frame, so every part is correct.
      EXPECT_EQ(score["actors"][actor]["parts"], 200) << row["method"];
      EXPECT_EQ(score["actors"][actor]["right"], 200) << row["method"];
    }
  }
  for (const char* file :
       {"reproduce.md", "details.md", "images/sensitivity_shelf.svg"}) {
    EXPECT_TRUE(fs::exists(Path("out/") + file)) << file;
  }
}

TEST_F(OfficialDataTest, MakesOneTableWithACalibrationBesideTheGroundTruth) {
  WriteSet("shelf", ".");
  EXPECT_EQ(Reproduce("--table=shelf").size(), 1u);
}

TEST_F(OfficialDataTest, ReportContainsChangedKeys) {
  WriteSet("shelf", ".");
  const std::string set =
      "--set='reconstruction.alpha_epi=50;detections.max_per_view=20'";
  Reproduce("--table=shelf " + set);
  const std::string report = ReadTextFile(Path("out/reproduce.md"));
  EXPECT_THAT(report, HasSubstr("was changed by `" + set + "`."));
  EXPECT_THAT(report, HasSubstr("reproduce --data=DATA --table=shelf " + set +
                                " --out=DIR`"));
  const std::string path = Path("out/reproduce.json");
  EXPECT_EQ(ParseJson(ReadTextFile(path), path)["set"],
            "reconstruction.alpha_epi=50;detections.max_per_view=20");
}

TEST_F(OfficialDataTest, ErrorsNameWhatIsMissing) {
  const auto refusal = [&](const std::string& more) {
    return testing::Refusal("reproduce", Flags(more));
  };
  EXPECT_THAT(refusal(""), HasSubstr("shelf/actorsGT.mat"));
  EXPECT_THAT(refusal("--table=shlef"), HasSubstr("campus_extended"));
  WriteSet("shelf", "Calibration");
  for (const std::string table : {"campus", "campus_extended"}) {
    EXPECT_THAT(refusal("--table=" + table),
                HasSubstr("has no Campus, which --table=" + table + " needs"));
  }
  fs::remove_all(Path("shelf/detections"));
  EXPECT_THAT(refusal(""), HasSubstr("no detections"));
  fs::remove_all(Path("shelf/Calibration"));
  EXPECT_THAT(refusal(""), HasSubstr("no calibration"));
}

TEST_F(OfficialDataTest, RefusesDetectionsWithOtherFrameNumbers) {
  WriteSet("shelf", "Calibration");
  for (size_t v = 0; v < cameras_.size(); ++v) {
    std::string text = CocoResults(cameras_[v]);
    // Frame numbers beyond the annotation: 297 becomes 7297.
    for (size_t at = text.find("\"image_id\": "); at != std::string::npos;
         at = text.find("\"image_id\": ", at + 1)) {
      text.insert(at + 12, "7");
    }
    folder_.Write("shelf/detections/cam" + std::to_string(v) + ".json", text);
  }
  EXPECT_THAT(testing::Refusal("reproduce", Flags("--table=shelf")),
              HasSubstr("frame numbers count from 0"));
}

}  // namespace
}  // namespace kinegraph
