// Consistency of documentation and configurations with the code.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "core/io/configuration/config.h"
#include "core/io/files/text_file.h"
#include "solvers/session/run.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const std::string& name) {
  return ReadTextFile(testing::ProjectFile(name).string());
}

TEST(DocsTest, ConfigurationPageListsEveryKey) {
  const std::string page = TextOf("docs/configuration.md");
  EXPECT_NE(page.find(KeyTables(KeysOf<RunOptions>())), std::string::npos)
      << "remake the tables with: ./kinegraph track --keys";
}

// A new key may require the removal of another.
TEST(DocsTest, KeysAreLimitedAndTablesNeedEverydayKeys) {
  EXPECT_LE(KeysOf<RunOptions>().size(), 130u);
  // A list that lacks the everyday keys cannot be sorted into tables.
  EXPECT_THROW(KeyTables(KeysOf<SynthesisOptions>()), std::logic_error);
}

TEST(DocsTest, DefaultConfigurationIsAsGenerated) {
  const std::string path =
      testing::ProjectFile("configs/default.toml").string();
  const std::string commented = CommentedConfig(
      KeysOf(ReadRunOptions(path, "", "")), KeysOf<RunOptions>());
  EXPECT_NE(ReadTextFile(path).find(commented), std::string::npos)
      << "remake it with: ./kinegraph track --keys "
         "--config=configs/default.toml";
  // A key whose line is commented out has its default: without the comment
  // signs the configuration is the same.
  const std::string all = std::regex_replace(
      commented, std::regex("#([a-z_]+ = )"), std::string("$1"));
  EXPECT_NE(all, commented);
  EXPECT_EQ(EffectiveConfigJson(ParseRunOptions(all, "", "")),
            EffectiveConfigJson(ReadRunOptions(path, "", "")));
}

TEST(DocsTest, SynthesisPageListsEveryKey) {
  const std::string page = TextOf("docs/synthesize.md");
  EXPECT_NE(page.find(KeyTable(KeysOf<SynthesisOptions>())), std::string::npos)
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

// README.md, CONTRIBUTING.md and every page of docs.
std::vector<fs::path> Pages() {
  std::vector<fs::path> pages = {testing::ProjectFile("README.md"),
                                 testing::ProjectFile("CONTRIBUTING.md")};
  for (const auto& entry :
       fs::directory_iterator(testing::ProjectFile("docs"))) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  return pages;
}

std::vector<std::string> Matches(const std::string& text,
                                 const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), regex);
       it != std::sregex_iterator(); ++it) {
    found.push_back((*it)[1].str());
  }
  return found;
}

// All keys of configurations and synthetic scenes; NAME matches any name.
std::set<std::string> KeysOfConfigurations() {
  const std::string reference =
      KeyTable(KeysOf<RunOptions>()) + KeyTable(KeysOf<SynthesisOptions>());
  std::set<std::string> keys;
  for (const std::string& key :
       Matches(reference, "\\| `([A-Za-z0-9_.]+)` \\|")) {
    keys.insert(key);
  }
  // Tables whose keys are names from the recording, or classes of joints.
  for (const std::string& key :
       Matches(reference,
               "\\| `([A-Za-z0-9_.]+)` \\| (?:`\\{\\}` \\||[^\n]* or by )")) {
    keys.insert(key + ".NAME");
  }
  return keys;
}

// Whether `word` is a key, a table of keys, or a key of a table of names.
bool IsKey(const std::string& word, const std::set<std::string>& keys) {
  if (keys.count(word) == 1) return true;
  const auto next = keys.lower_bound(word + ".");
  if (next != keys.end() && next->rfind(word + ".", 0) == 0) return true;
  return keys.count(word.substr(0, word.rfind('.')) + ".NAME") == 1;
}

// A renamed key must not remain on a page: copying it would give an error.
TEST(DocsTest, PagesNameOnlyKeysThatExist) {
  const std::set<std::string> keys = KeysOfConfigurations();
  std::set<std::string> tables;
  for (const std::string& key : keys) {
    if (key.find('.') != std::string::npos) {
      tables.insert(key.substr(0, key.find('.')));
    }
  }
  ASSERT_EQ(tables.count("graph"), 1u);
  ASSERT_FALSE(IsKey("graph.lag", keys));
  const std::set<std::string> extensions = {
      "md",  "json", "jsonl", "toml", "csv", "html", "h",  "cc",
      "trc", "npz",  "svg",   "png",  "js",  "py",   "txt"};
  int named = 0;
  for (const fs::path& page : Pages()) {
    const std::string text = ReadTextFile(page.string());
    for (const std::string& word :
         Matches(text, "(?:^|[^A-Za-z0-9_./-])([a-z]+(?:\\.[a-z0-9_]+)+)")) {
      if (tables.count(word.substr(0, word.find('.'))) == 0) continue;
      if (extensions.count(word.substr(word.rfind('.') + 1)) == 1) continue;
      ++named;
      EXPECT_TRUE(IsKey(word, keys)) << page << " names the key " << word;
    }
  }
  EXPECT_GT(named, 300);
}

// Files and folders of the project that pages spell out, and configurations in
// commands. Files made by builds or runs are excluded; NAME, ... and * are
// placeholders. The minimum numbers of matches, about half of the present ones
// or fewer, show that the patterns still match.
TEST(DocsTest, PagesNameOnlyFilesThatExist) {
  for (const auto& [pattern, least] :
       {std::pair{"`((?:apps|core|solvers|tests|docs|configs|examples|python|"
                  "cmake|workflow|packaging|include)/[A-Za-z0-9_./-]+)`",
                  50},
        {"(configs/[A-Za-z0-9_./-]+\\.toml)", 20}}) {
    int named = 0;
    for (const fs::path& page : Pages()) {
      for (const std::string& path :
           Matches(ReadTextFile(page.string()), pattern)) {
        if (path.find("...") != std::string::npos) continue;
        if (Matches(path, "([A-Z]{4,})").size() == 1) continue;
        ++named;
        EXPECT_TRUE(fs::exists(testing::ProjectFile(path)))
            << page << " names " << path;
      }
    }
    EXPECT_GT(named, least) << pattern;
  }
}

// The meaning of a key is one phrase, without a full stop.
TEST(DocsTest, KeyDescriptionsHaveNoFullStop) {
  const std::string page = TextOf("docs/configuration.md");
  const std::vector<std::string> phrases =
      Matches(page, "\n\\| `[^\n]*\\| ([^|\n]+) \\|");
  EXPECT_GT(phrases.size(), 100u);
  for (const std::string& phrase : phrases) {
    EXPECT_NE(phrase.back(), '.') << phrase;
  }
}

// All files state the version that a release sets (CONTRIBUTING.md). The
// changelog's newest numbered heading has this version and the citation's date;
// unreleased changes are above it.
TEST(DocsTest, VersionsAndDatesAgree) {
  const auto first = [](const char* file, const char* pattern) {
    const std::vector<std::string> found = Matches(TextOf(file), pattern);
    return found.empty() ? std::string() : found.front();
  };
  const std::string version =
      first("CMakeLists.txt", "VERSION ([0-9]+\\.[0-9]+\\.[0-9]+)");
  ASSERT_FALSE(version.empty());
  EXPECT_EQ(first("CITATION.cff", "\nversion: ([^\n]+)"), version);
  EXPECT_EQ(first("packaging/vcpkg/vcpkg.json", "\"version\": \"([^\"]+)\""),
            version);
  EXPECT_EQ(first("packaging/conda/meta.yaml", "\n  version: ([^\n]+)"),
            version);
  EXPECT_EQ(first("CHANGELOG.md", "\n## \\[([^\\]]*)\\]"), "Unreleased");
  EXPECT_EQ(first("CHANGELOG.md", "\n## \\[([0-9][^\\]]*)\\]"), version);
  const std::string day =
      first("CHANGELOG.md",
            "\n## \\[[0-9][^\\]]*\\] - ([0-9]{4}-[0-9]{2}-[0-9]{2})\n");
  EXPECT_FALSE(day.empty());
  EXPECT_EQ(first("CITATION.cff", "\ndate-released: ([^\n]+)"), day);
}

// The index links every page, and every link has a target.
TEST(DocsTest, LinksHaveTargets) {
  const fs::path docs = testing::ProjectFile("docs");
  const std::vector<fs::path> pages = Pages();
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
