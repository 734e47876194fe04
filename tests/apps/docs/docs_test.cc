// Documentation and configurations that must keep up with the code.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "apps/common/synthesis.h"
#include "core/io/config.h"
#include "core/io/text_file.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

TEST(DocsTest, ConfigurationPageListsEveryKey) {
  const std::string page =
      ReadTextFile(testing::ProjectFile("docs/configuration.md").string());
  const std::string reference = ConfigReference<RunOptions>();
  EXPECT_NE(page.find(reference), std::string::npos)
      << "remake the table with: ./kinegraph track --keys";
}

TEST(DocsTest, SynthesisPageListsEveryKey) {
  const std::string page =
      ReadTextFile(testing::ProjectFile("docs/synthesize.md").string());
  EXPECT_NE(page.find(ConfigReference<SynthesisOptions>()), std::string::npos)
      << "remake the table with: ./kinegraph synthesize --keys";
}

std::vector<std::string> TrackingConfigurations() {
  std::vector<std::string> paths;
  for (const char* folder :
       {"configs/paper", "configs/graph", "configs/benchmark"}) {
    const fs::path path = testing::ProjectFile(folder);
    if (!fs::exists(path)) continue;
    for (const auto& entry : fs::directory_iterator(path)) {
      paths.push_back(entry.path().string());
    }
  }
  return paths;
}

TEST(DocsTest, EveryConfigurationIsRead) {
  const std::vector<std::string> paths = TrackingConfigurations();
  EXPECT_GE(paths.size(), 4u);
  for (const std::string& path : paths) {
    EXPECT_NO_THROW(ReadRunOptions(path, "", "")) << path;
    // Any configuration is valid in both modes.
    EXPECT_NO_THROW(ReadRunOptions(path, "", "paper")) << path;
    EXPECT_NO_THROW(ReadRunOptions(path, "", "graph")) << path;
  }
}

TEST(DocsTest, PagesNameOnlyConfigurationsThatExist) {
  std::vector<fs::path> pages = {testing::ProjectFile("README.md")};
  for (const auto& entry :
       fs::directory_iterator(testing::ProjectFile("docs"))) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  int named = 0;
  for (const fs::path& page : pages) {
    const std::string text = ReadTextFile(page.string());
    const std::string end = ".toml";
    for (size_t at = text.find("configs/"); at != std::string::npos;
         at = text.find("configs/", at + 1)) {
      const size_t stop = text.find_first_of(" `\n)\\,;|{", at);
      const std::string name = text.substr(at, stop - at);
      if (name.size() < end.size() ||
          name.compare(name.size() - end.size(), end.size(), end) != 0) {
        continue;
      }
      ++named;
      EXPECT_TRUE(fs::exists(testing::ProjectFile(name)))
          << page << " names " << name;
    }
  }
  EXPECT_GT(named, 0);
}

}  // namespace
}  // namespace kinegraph
