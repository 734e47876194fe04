// Runs the commands shown on the pages, in order, in a folder that has the
// files they name, and compares the output: a fenced block named `output` holds
// lines printed by the previous block. A TOML block whose first line is `#
// NAME.toml` is written to that file.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/files/text_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

struct Block {
  std::string kind;  // the word after the fence
  std::string text;
};

// The fenced blocks of a page.
std::vector<Block> FencedBlocks(const std::string& page) {
  std::vector<Block> blocks;
  const std::string fence = "```";
  for (size_t open = page.find(fence); open != std::string::npos;) {
    const size_t name = open + fence.size();
    const size_t begin = page.find('\n', open) + 1;
    const size_t close = page.find(fence, begin);
    if (close == std::string::npos) break;
    blocks.push_back({page.substr(name, begin - 1 - name),
                      page.substr(begin, close - begin)});
    open = page.find(fence, close + fence.size());
  }
  return blocks;
}

bool RunsCommands(const Block& block) {
  if (block.text.find("./kinegraph ") == std::string::npos) return false;
  // Skips set-up and demo, which have their own tests; benchmarks and tuning,
  // which take long; and commands on videos that do not exist.
  for (const char* word :
       {"./kinegraph build", "./kinegraph test", "./kinegraph demo", "cmake ",
        "benchmark", "--tune", ".mp4"}) {
    if (block.text.find(word) != std::string::npos) return false;
  }
  return true;
}

// The file name of a TOML block, from its first line `# NAME.toml`.
std::string NameOfToml(const Block& block) {
  static const std::regex kName("# ([a-z_]+\\.toml)");
  const std::string first = block.text.substr(0, block.text.find('\n'));
  std::smatch match;
  return block.kind == "toml" && std::regex_match(first, match, kName)
             ? match[1].str()
             : "";
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// A line split into words and numbers. Numbers are replaced by # in the words;
// white space is collapsed, because column widths depend on the numbers.
struct Parts {
  std::string words;
  std::vector<std::string> numbers;
};

Parts PartsOf(const std::string& line) {
  static const std::regex kNumber("[0-9]+(?:\\.[0-9]+)?");
  static const std::regex kSpace("\\s+");
  Parts parts;
  for (auto it = std::sregex_iterator(line.begin(), line.end(), kNumber);
       it != std::sregex_iterator(); ++it) {
    parts.numbers.push_back(it->str());
  }
  parts.words =
      std::regex_replace(std::regex_replace(line, kNumber, "#"), kSpace, " ");
  return parts;
}

// Rounding differs between processors and may change single decisions: the
// tolerance is two per cent, or a unit of the last decimal shown.
bool AreAlike(const std::string& shown, const std::string& printed) {
  const double a = std::stod(shown);
  const double b = std::stod(printed);
  const size_t point = shown.find('.');
  const double unit =
      point == std::string::npos
          ? 0.0
          : 1.01 *
                std::pow(10.0, -static_cast<double>(shown.size() - point - 1));
  return std::abs(a - b) <= std::max(unit, 0.02 * std::max(a, b));
}

bool SaysTheSame(const std::string& shown, const std::string& printed) {
  const Parts a = PartsOf(shown);
  const Parts b = PartsOf(printed);
  if (a.words != b.words) return false;
  for (size_t i = 0; i < a.numbers.size(); ++i) {
    if (!AreAlike(a.numbers[i], b.numbers[i])) return false;
  }
  return true;
}

// The first line of `shown` that is missing in `printed`, in order; "(the end)"
// if lines of `printed` remain after the last; empty if all match. A line "..."
// matches any lines.
std::string NotPrinted(const std::string& shown, const std::string& printed) {
  // On a busy machine a progress line is printed every half minute.
  static const std::regex kProgress(".*[0-9]/[0-9]+ .* left\\s*");
  std::vector<std::string> lines = Lines(printed);
  lines.erase(std::remove_if(lines.begin(), lines.end(),
                             [](const std::string& line) {
                               return std::regex_match(line, kProgress);
                             }),
              lines.end());
  size_t next = 0;
  bool gap = false;
  for (const std::string& line : Lines(shown)) {
    if (line == "...") {
      gap = true;
      continue;
    }
    while (gap && next < lines.size() && !SaysTheSame(line, lines[next])) {
      ++next;
    }
    if (next >= lines.size() || !SaysTheSame(line, lines[next])) return line;
    ++next;
    gap = false;
  }
  return gap || next == lines.size() ? "" : "(the end)";
}

TEST(DocsOutput, MatchesWordsExactlyAndNumbersWithinTolerance) {
  const std::string printed = "301 frames\nview   error\ncam0   6.2\nend\n";
  EXPECT_EQ(NotPrinted("301 frames\n...\ncam0 6.3\nend\n", printed), "");
  EXPECT_EQ(NotPrinted("301 frames\n...\n", printed), "");
  EXPECT_EQ(NotPrinted("301 frames\n...\n",
                       "tracking  126/250  50 %  2 min 38 s left\n" + printed),
            "");
  EXPECT_EQ(NotPrinted("...\nend\n", printed), "");
  EXPECT_EQ(NotPrinted("301 frames\ncam0 6.2\n...\n", printed), "cam0 6.2");
  EXPECT_EQ(NotPrinted("301 frames\n...\ncam0 6.4\n...\n", printed),
            "cam0 6.4");
  EXPECT_EQ(NotPrinted("290 frames\n...\n", printed), "290 frames");
  EXPECT_EQ(NotPrinted("301 pictures\n...\n", printed), "301 pictures");
  EXPECT_EQ(NotPrinted("301 frames\n", printed), "(the end)");
  EXPECT_EQ(NotPrinted("...\nend\nand more\n", printed), "and more");
}

class DocsCommandsTest : public ::testing::TestWithParam<const char*> {};

TEST_P(DocsCommandsTest, RunAndPrintTheDocumentedOutput) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const fs::path root = fs::canonical(*testing::FindData(""));
  const testing::TemporaryFolder folder;
  const auto link = [&](const std::string& name, const fs::path& target) {
    fs::create_symlink(target, folder.path() / name);
  };
  link("data", root);
  link("DATA", root);
  link("configs", testing::ProjectFile("configs"));
  link("examples", testing::ProjectFile("examples"));
  link("calibration.json", root / "shelf/calibration.json");
  link("openpose", root / "shelf/detections/openpose");
  link("actorsGT.mat", root / "shelf/tum/actorsGT.mat");
  link("calibration.toml", root / "pose2sim/calibration/Calib.toml");
  link("detections", root / "pose2sim/single/pose");
  fs::create_directory(folder.path() / "out");
  // Replaces the script `kinegraph`, which would build first, by one that runs
  // the existing programs.
  const std::string driver =
      folder.Write("kinegraph", "#!/bin/bash\nname=$1\nshift\nexec '" +
                                    testing::BuildFile("apps").string() +
                                    "'/kinegraph-\"$name\" \"$@\"\n");
  fs::permissions(driver, fs::perms::owner_all);

  const std::string page =
      ReadTextFile(testing::ProjectFile(GetParam()).string());
  int runs = 0;
  std::string printed;
  for (const Block& block : FencedBlocks(page)) {
    if (block.kind == "output") {
      EXPECT_EQ(NotPrinted(block.text, printed), "") << printed;
    } else if (const std::string name = NameOfToml(block); !name.empty()) {
      folder.Write(name, block.text);
    } else if (RunsCommands(block)) {
      ++runs;
      const std::string script =
          folder.Write("block.sh", "set -e\n" + block.text);
      const std::string line = "cd '" + folder.path().string() +
                               "' && bash block.sh > log.txt 2>&1 </dev/null";
      const int outcome = std::system(line.c_str());
      printed = ReadTextFile((folder.path() / "log.txt").string());
      EXPECT_EQ(outcome, 0) << block.text << "\nprints\n" << printed;
    }
  }
  EXPECT_GT(runs, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Pages, DocsCommandsTest,
    ::testing::Values("README.md", "docs/paper_mode.md", "docs/inputs.md",
                      "docs/convert.md", "docs/report.md", "docs/kinematics.md",
                      "docs/synthesize.md", "docs/own_take.md",
                      "docs/cameras.md", "docs/doctor.md", "docs/identity.md",
                      "docs/batch.md", "docs/opensim.md", "docs/compare.md",
                      "docs/calibrate.md", "docs/validate.md"),
    [](const ::testing::TestParamInfo<const char*>& page) {
      std::string name = page.param;
      for (char& c : name) {
        if (c == '/' || c == '.') c = '_';
      }
      return name;
    });

}  // namespace
}  // namespace kinegraph
