// The commands that the pages show are run, in the order of each page, in a
// folder where their names mean something.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/files/text_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// Contents of the fenced blocks of a page that run our commands.
std::vector<std::string> CommandBlocks(const std::string& page) {
  std::vector<std::string> blocks;
  const std::string fence = "```";
  for (size_t open = page.find(fence); open != std::string::npos;) {
    const size_t begin = page.find('\n', open) + 1;
    const size_t close = page.find(fence, begin);
    if (close == std::string::npos) break;
    const std::string block = page.substr(begin, close - begin);
    // Set-up and the demo have tests of their own; benchmarks take long.
    const bool ours = block.find("./kinegraph ") != std::string::npos;
    bool other = false;
    for (const char* word : {"./kinegraph build", "./kinegraph test",
                             "./kinegraph demo", "cmake ", "benchmark"}) {
      other = other || block.find(word) != std::string::npos;
    }
    if (ours && !other) blocks.push_back(block);
    open = page.find(fence, close + fence.size());
  }
  return blocks;
}

class DocsCommandsTest : public ::testing::TestWithParam<const char*> {};

TEST_P(DocsCommandsTest, Run) {
  KINEGRAPH_DATA_OR_SKIP(data, "shelf/detections/openpose");
  const fs::path root = fs::canonical(*testing::FindData(""));
  const testing::TemporaryFolder folder;
  const auto link = [&](const std::string& name, const fs::path& target) {
    fs::create_symlink(target, folder.path() / name);
  };
  link("data", root);
  link("DATA", root);
  link("configs", testing::ProjectFile("configs"));
  link("calibration.json", root / "shelf/calibration.json");
  link("openpose", root / "shelf/detections/openpose");
  link("actorsGT.mat", root / "shelf/tum/actorsGT.mat");
  fs::create_directory(folder.path() / "out");
  // The driver would build first; the programs are there already.
  const std::string driver =
      folder.Write("kinegraph", "#!/bin/bash\nname=$1\nshift\nexec '" +
                                    testing::BuildFile("apps").string() +
                                    "'/kinegraph-\"$name\" \"$@\"\n");
  fs::permissions(driver, fs::perms::owner_all);

  const std::string page =
      ReadTextFile(testing::ProjectFile(GetParam()).string());
  const std::vector<std::string> blocks = CommandBlocks(page);
  EXPECT_FALSE(blocks.empty());
  for (const std::string& block : blocks) {
    const std::string script = folder.Write("block.sh", "set -e\n" + block);
    const std::string line =
        "cd '" + folder.path().string() + "' && bash block.sh > log.txt 2>&1";
    EXPECT_EQ(std::system(line.c_str()), 0)
        << block << "\nprints\n"
        << ReadTextFile((folder.path() / "log.txt").string());
  }
}

INSTANTIATE_TEST_SUITE_P(Pages, DocsCommandsTest,
                         ::testing::Values("README.md", "docs/paper_mode.md",
                                           "docs/inputs.md", "docs/convert.md",
                                           "docs/report.md",
                                           "docs/results_reading.md",
                                           "docs/kinematics.md",
                                           "docs/synthesize.md"),
                         [](const ::testing::TestParamInfo<const char*>& page) {
                           std::string name = page.param;
                           for (char& c : name) {
                             if (c == '/' || c == '.') c = '_';
                           }
                           return name;
                         });

}  // namespace
}  // namespace kinegraph
