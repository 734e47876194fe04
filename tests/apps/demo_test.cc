// The program kinegraph-demo: its table, its files and its errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"
#include "tests/apps/command.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// The numbers of each Markdown row, by its label, without counts in brackets.
std::map<std::string, std::vector<double>> RowsOf(const std::string& table) {
  std::map<std::string, std::vector<double>> rows;
  std::istringstream lines(table);
  std::string line;
  while (std::getline(lines, line) && !line.empty()) {
    std::istringstream cells(line);
    std::string cell;
    std::getline(cells, cell, '|');
    std::getline(cells, cell, '|');
    const std::string label = cell.substr(1, cell.find_last_not_of(' '));
    while (std::getline(cells, cell, '|')) {
      std::istringstream words(cell);
      double number = NAN;
      if (words >> number) rows[label].push_back(number);
    }
  }
  return rows;
}

class DemoTest : public CommandTest {
 protected:
  ProgramOutcome Run(const std::string& flags) const {
    return Done("demo", flags + " --out='" + out_.string() + "'");
  }

  const fs::path out_ = folder_.path() / "new/demo";
};

// The lines of README's table, from its header to the dots.
std::vector<std::string> TableOfReadme() {
  std::istringstream lines(ContentOf(ProjectFile("README.md")));
  std::vector<std::string> table;
  std::string line;
  while (std::getline(lines, line)) {
    const bool begins = line.rfind("against the truth ", 0) == 0;
    if (begins || (!table.empty() && line != "...")) table.push_back(line);
    if (!table.empty() && line == "...") break;
  }
  return table;
}

TEST_F(DemoTest, PrintsTheTableOfTheReadme) {
  const std::vector<std::string> table = TableOfReadme();
  ASSERT_GE(table.size(), 4u);
  const ProgramOutcome outcome = Run("");
  for (const std::string& line : table) {
    EXPECT_THAT(outcome.output, HasSubstr(line + "\n"));
  }
}

TEST_F(DemoTest, TracksInEveryModeAndScores) {
  const ProgramOutcome outcome = Run("--set=scene.duration=3");
  EXPECT_EQ(outcome.errors, "");

  // Exactly these files exist, and each is printed.
  std::set<std::string> there;
  for (const auto& entry : fs::directory_iterator(out_)) {
    there.insert(entry.path().filename().string());
    EXPECT_THAT(outcome.output, HasSubstr("  " + entry.path().string()));
  }
  EXPECT_EQ(there,
            (std::set<std::string>{"cameras.json", "detections.jsonl",
                                   "truth.jsonl", "scene.json", "scores.md",
                                   "tracks_paper.jsonl", "tracks_window.jsonl",
                                   "tracks_batch.jsonl", "page.html"}));

  const size_t cameras = ReadCameras((out_ / "cameras.json").string()).size();
  const DetectionSequence detections =
      ReadDetections((out_ / "detections.jsonl").string());
  EXPECT_EQ(detections.header.view_names.size(), cameras);
  const TrackSequence truth = ReadTracks((out_ / "truth.jsonl").string());
  for (const char* name : {"paper", "window", "batch"}) {
    const std::string file = std::string("tracks_") + name + ".jsonl";
    const TrackSequence tracks = ReadTracks((out_ / file).string());
    ASSERT_EQ(tracks.frames.size(), truth.frames.size()) << name;
    EXPECT_EQ(tracks.header.mode,
              std::string(name) == "paper" ? "paper" : "graph");
    size_t poses = 0;
    for (const TrackFrame& frame : tracks.frames) poses += frame.people.size();
    EXPECT_GT(poses, tracks.frames.size()) << name;
  }

  const auto rows = RowsOf(ContentOf(out_ / "scores.md"));
  EXPECT_GE(rows.size(), 9u);
  for (const auto& [label, numbers] : rows) {
    ASSERT_EQ(numbers.size(), 3u) << label;
    for (const double number : numbers) {
      EXPECT_TRUE(std::isfinite(number)) << label;
      if (label.find('%') != std::string::npos) {
        EXPECT_GE(number, 0.0) << label;
        EXPECT_LE(number, 100.0) << label;
      }
    }
  }
  // People are found, at about the right positions.
  for (const double percent : rows.at("people found (coverage), %")) {
    EXPECT_GT(percent, 50.0);
  }
  for (const double error_mm : rows.at("mean joint error (MPJPE), mm")) {
    EXPECT_GT(error_mm, 0.0);
    EXPECT_LT(error_mm, 100.0);
  }
  // stdout also has the table, recognised by one of its rows.
  EXPECT_THAT(outcome.output, HasSubstr("identity switches"));
}

TEST_F(DemoTest, WritesTheSameFilesEachTime) {
  Run("--set=scene.duration=1");
  std::map<std::string, std::string> first;
  for (const auto& entry : fs::directory_iterator(out_)) {
    first[entry.path().filename().string()] = ContentOf(entry.path());
  }
  // Overwrites the files of the first run.
  Run("--set=scene.duration=1");
  for (const auto& [name, content] : first) {
    EXPECT_FALSE(content.empty()) << name;
    EXPECT_EQ(content, ContentOf(out_ / name)) << name;
  }
}

TEST_F(DemoTest, BadInputGivesOneLineAndExitCodeTwo) {
  for (const std::string flags :
       {"--set=scene.peeple=3", "--set=scene.people=0", "--config=/none.toml",
        "--no_such_flag"}) {
    Refusal("demo", flags + " --out='" + out_.string() + "'");
    EXPECT_FALSE(fs::exists(out_)) << flags;
  }
  // Shipped configurations are found from any folder.
  EXPECT_THAT(Refusal("demo",
                      "--config=synthetic/hard.toml --set=scene.peeple=3 "
                      "--out='" +
                          out_.string() + "'"),
              HasSubstr("scene.peeple"));
  // A file is not accepted as a folder.
  Refusal("demo",
          "--set=scene.duration=1 --out='" + folder_.Write("file", "") + "'");
}

}  // namespace
}  // namespace kinegraph::testing
