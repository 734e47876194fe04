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

// From the index every page is one step away, and no link leads nowhere.
TEST(DocsTest, LinksLeadSomewhere) {
  const fs::path docs = testing::ProjectFile("docs");
  std::vector<fs::path> pages = {testing::ProjectFile("README.md"),
                                 testing::ProjectFile("CONTRIBUTING.md")};
  for (const auto& entry : fs::directory_iterator(docs)) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  int links = 0;
  for (const fs::path& page : pages) {
    const std::string text = ReadTextFile(page.string());
    for (size_t at = text.find("]("); at != std::string::npos;
         at = text.find("](", at + 1)) {
      const size_t end = text.find_first_of(")#", at);
      const std::string target = text.substr(at + 2, end - at - 2);
      if (target.empty() || target.find(':') != std::string::npos) continue;
      ++links;
      EXPECT_TRUE(fs::exists(page.parent_path() / target))
          << page << " links to " << target;
    }
  }
  EXPECT_GT(links, 20);
  const std::string index = ReadTextFile((docs / "README.md").string());
  for (const fs::path& page : pages) {
    const std::string name = page.filename().string();
    if (page.parent_path() != docs || name == "README.md") continue;
    EXPECT_NE(index.find("(" + name + ")"), std::string::npos)
        << "docs/README.md does not name " << name;
  }
}

}  // namespace
}  // namespace kinegraph
