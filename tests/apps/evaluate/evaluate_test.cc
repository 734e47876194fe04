// The program kinegraph-evaluate as its users meet it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/io/text/json.h"
#include "core/skeleton/skeleton.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

using ::testing::HasSubstr;

struct Outcome {
  int exit_code = -1;
  std::string output;  // stdout and stderr
};

Outcome Evaluate(const std::string& flags) {
  const std::string command = "'" +
                              BuildFile("apps/kinegraph-evaluate").string() +
                              "' " + flags + " 2>&1";
  Outcome outcome;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return outcome;
  char buffer[4096];
  while (const size_t count = std::fread(buffer, 1, sizeof(buffer), pipe)) {
    outcome.output.append(buffer, count);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  return outcome;
}

Json ReadJson(const std::string& path) {
  std::ifstream stream(path);
  std::ostringstream text;
  text << stream.rdbuf();
  return ParseJson(text.str(), path);
}

// One person of tum14 in frames 300 and 301; `lift` moves one ankle up [m].
std::string TrackFile(double lift) {
  std::ostringstream text;
  text << R"({"kinegraph": 1, "units": {"length": "m", "time": "s"},)"
       << R"( "skeleton": {"name": "tum14", "joints": ["r_ankle", "r_knee",)"
       << R"( "r_hip", "l_hip", "l_knee", "l_ankle", "r_wrist", "r_elbow",)"
       << R"( "r_shoulder", "l_shoulder", "l_elbow", "l_wrist",)"
       << R"( "head_bottom", "head_top"], "bones": [[0, 1]]},)"
       << R"( "mode": "paper", "frame_rate": 25.0, "config": {}})"
       << "\n";
  for (int frame = 300; frame < 302; ++frame) {
    text << R"({"frame": )" << frame << R"(, "time": )" << frame / 25.0
         << R"(, "people": [{"id": 0, "joints": [[0.1, 0, )" << lift
         << R"(], [0.1, 0, 0.5],)"
         << R"( [0.1, 0, 1], [-0.1, 0, 1], [-0.1, 0, 0.5], [-0.1, 0, 0],)"
         << R"( [0.3, 0, 1], [0.3, 0, 1.2], [0.2, 0, 1.5], [-0.2, 0, 1.5],)"
         << R"( [-0.3, 0, 1.2], [-0.3, 0, 1], [0, 0, 1.5], [0, 0, 1.8]],)"
         << R"( "status": [)";
    for (int j = 0; j < 14; ++j) text << (j ? ", " : "") << R"("observed")";
    text << "]}]}\n";
  }
  return text.str();
}

class EvaluateProgramTest : public ::testing::Test {
 protected:
  // The flags that compare a file with a truth.
  std::string Against(const std::string& tracks, const std::string& truth) {
    return " --tracks='" + tracks + "' --ground_truth='" + truth + "'";
  }

  TemporaryFolder folder_;
  std::string truth_ = folder_.Write("truth.jsonl", TrackFile(0.0));
  // 0.6 m off: the lower leg's mean error is 0.3 m of 0.5 m.
  std::string found_ = folder_.Write("found.jsonl", TrackFile(0.6));
};

TEST_F(EvaluateProgramTest, PcpAsTextAndJson) {
  const std::string json = (folder_.path() / "result.json").string();
  const Outcome outcome = Evaluate(
      "--protocol=shelf" + Against(found_, truth_) + " --json='" + json + "'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("90.00 (18/20)"));
  EXPECT_THAT(outcome.output, HasSubstr("frames 300:601"));
  EXPECT_THAT(outcome.output, HasSubstr("covered, %: 100.00 (2/2)"));
  const Json result = ReadJson(json)["result"];
  EXPECT_EQ(result["actors"][0]["parts"]["total"]["count"], 18);
  EXPECT_EQ(result["lost"].size(), 2u);
  EXPECT_EQ(result["lost"][0]["part"], "r_lower_leg");
  EXPECT_NEAR(result["lost"][0]["first_error_m"].get<double>(), 0.6, 1e-12);
  EXPECT_EQ(result["protocol"]["head"], "chu");
  EXPECT_EQ(result["person_frames"].size(), 2u);
}

TEST_F(EvaluateProgramTest, FlagsOverrideTheProtocol) {
  const Outcome outcome = Evaluate(
      "--protocol=shelf --head=mvpose --endpoints=each --matching=one_to_one "
      "--frames=300:301,500:501 --lost" +
      Against(found_, truth_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              HasSubstr("head mvpose, endpoints each, matching one_to_one, "
                        "frames 300:301,500:501"));
  EXPECT_THAT(outcome.output, HasSubstr("90.00 (9/10)"));
  EXPECT_THAT(outcome.output, HasSubstr("error of first end m"));
}

TEST_F(EvaluateProgramTest, Parity) {
  Outcome outcome = Evaluate("--protocol=parity" + Against(truth_, truth_));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("100.0000 (28/28)"));
  outcome = Evaluate("--protocol=parity" + Against(found_, truth_));
  EXPECT_THAT(outcome.output, HasSubstr("(26/28)"));
  EXPECT_THAT(outcome.output, HasSubstr("600.0000 (r_ankle, person 0, frame"));
}

TEST_F(EvaluateProgramTest, OtherProtocols) {
  // One of 14 joints is 600 mm off.
  const Outcome mpjpe = Evaluate("--protocol=mpjpe" + Against(found_, truth_));
  ASSERT_EQ(mpjpe.exit_code, 0) << mpjpe.output;
  EXPECT_THAT(mpjpe.output, HasSubstr("42.9"));
  const Outcome identity =
      Evaluate("--protocol=identity" + Against(found_, truth_));
  ASSERT_EQ(identity.exit_code, 0) << identity.output;
  EXPECT_THAT(identity.output, HasSubstr("MOTA, %"));
  const Outcome panoptic =
      Evaluate("--protocol=panoptic" + Against(found_, truth_));
  ASSERT_EQ(panoptic.exit_code, 0) << panoptic.output;
  EXPECT_THAT(panoptic.output, HasSubstr("AP, %"));
}

// Some names are another program's, some nobody's: each that is known counts.
TEST_F(EvaluateProgramTest, JointsUnderOtherNames) {
  const auto renamed =
      [](const std::vector<std::pair<std::string, std::string>>& names) {
        std::string text = TrackFile(0.6);
        for (const auto& [ours, theirs] : names) {
          text.replace(text.find('"' + ours + '"'), ours.size() + 2,
                       '"' + theirs + '"');
        }
        return text;
      };
  const std::string some = folder_.Write(
      "some.jsonl",
      renamed(
          {{"tum14", "mine"}, {"r_ankle", "RAnkle"}, {"r_knee", "patella"}}));
  // 600 mm in one of 13 joints.
  const Outcome mpjpe = Evaluate("--protocol=mpjpe" + Against(some, truth_));
  ASSERT_EQ(mpjpe.exit_code, 0) << mpjpe.output;
  EXPECT_THAT(mpjpe.output, HasSubstr("46.2"));
  std::vector<std::pair<std::string, std::string>> all = {{"tum14", "mine"}};
  for (const std::string& joint : Tum14().joints()) {
    all.emplace_back(joint, "p" + std::to_string(all.size()));
  }
  const std::string none = folder_.Write("none.jsonl", renamed(all));
  for (const char* protocol :
       {"mpjpe", "identity", "parity", "shelf", "panoptic"}) {
    const Outcome outcome =
        Evaluate(std::string("--protocol=") + protocol + Against(none, truth_));
    EXPECT_EQ(outcome.exit_code, 2) << protocol;
    EXPECT_THAT(outcome.output, HasSubstr("none.jsonl: has no joint in common"))
        << protocol;
  }
}

struct BadUsage {
  std::string flags;
  std::string message;
};

TEST_F(EvaluateProgramTest, BadUsageIsOneLineAndTwo) {
  const std::string both = Against(found_, truth_);
  const std::vector<BadUsage> all = {
      {"", "--protocol is required"},
      {"--protocol=shelf", "--tracks is required"},
      {"--protocol=shelf --tracks='" + truth_ + "'",
       "--ground_truth is required"},
      {"--protocol=mall" + both, "found 'mall', expected shelf"},
      {"--protocol=shelf --head=ear" + both, "--head: found 'ear'"},
      {"--protocol=shelf --endpoints=x" + both, "--endpoints: found 'x'"},
      {"--protocol=shelf --matching=x" + both, "--matching: found 'x'"},
      {"--protocol=shelf --frames=5:3" + both, "--frames: found '5:3'"},
      {"--protocol=shelf --frames=1:3" + both, "nobody is annotated"},
      {"--protocol=parity --head=chu" + both, "--head has no meaning"},
      {"--protocol=mpjpe --lost" + both, "--lost has no meaning"},
      {"--protocol=shelf --cameras=x" + both, "--cameras has no meaning"},
      {"--protocol=held_out_camera" + both, "--tracks has no meaning"},
      {"--protocol=held_out_camera --cameras=x", "--detections is required"},
      {"--protocol=shelf --tracks=/nowhere --ground_truth='" + truth_ + "'",
       "/nowhere"},
      {"--protocol=shelf --json=/dev/null/x.json" + both, "/dev/null"},
  };
  for (const BadUsage& bad : all) {
    SCOPED_TRACE(bad.flags);
    const Outcome outcome = Evaluate(bad.flags);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.output, HasSubstr(bad.message));
    EXPECT_THAT(outcome.output, HasSubstr("kinegraph-evaluate: error: "));
  }
}

TEST(EvaluateProgramOnShelfTest, HeldOutCamerasOfGivenRuns) {
  KINEGRAPH_DATA_OR_SKIP(shelf, "shelf");
  const std::string reference = shelf + "/reference/";
  std::string runs;
  for (int camera = 0; camera < 5; ++camera) {
    runs += (camera ? "," : "") + reference + "paper_code_shelf_without_cam" +
            std::to_string(camera) + ".json";
  }
  const std::string scoring =
      "--protocol=held_out_camera --cameras=" + shelf +
      "/calibration.json --detections=" + shelf + "/detections/openpose" +
      " --held_out_set=" + reference + "held_out_set.json";
  const Outcome outcome =
      Evaluate(scoring + " --reference=" + reference +
               "paper_code_shelf_warm3.json --runs=" + runs);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* known : {"11.01 [", "45.69 [", "13.77 [",
                            "93.05 (46146/49594)", "93.93 (3421/3642)"}) {
    EXPECT_THAT(outcome.output, HasSubstr(known));
  }
  EXPECT_EQ(Evaluate(scoring + " --runs=" + runs).exit_code, 2);  // whose set?
  const Outcome too_few =
      Evaluate(scoring + " --runs=" + runs.substr(0, runs.find(',')));
  EXPECT_EQ(too_few.exit_code, 2);
  EXPECT_THAT(too_few.output, HasSubstr("expected one for each of the 5"));
}

}  // namespace
}  // namespace kinegraph::testing
