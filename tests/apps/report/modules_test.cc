// The page's script is written as modules and joined into one scope, in which
// no browser would detect a missing import. This test does.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "core/io/files/text_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

// All matches of the pattern's last group.
Names Matches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  Names names;
  for (auto it = std::sregex_iterator(text.begin(), text.end(), regex);
       it != std::sregex_iterator(); ++it) {
    names.insert((*it)[it->size() - 1].str());
  }
  return names;
}

struct Module {
  Names exported;
  std::map<std::string, Names> imported;  // by the module they come from
  Names used;  // words that may be names exported by other modules
};

Module ReadModule(const fs::path& path) {
  const std::string text = ReadTextFile(path.string());
  Module module;
  for (const std::string& line :
       Matches(text, "(?:^|\n)export (?:const|let) ([^\n]*)")) {
    for (const std::string& name : Matches(line, "(?:^|, )(\\w+) = ")) {
      module.exported.insert(name);
    }
  }
  module.exported.merge(
      Matches(text, "(?:^|\n)export (?:function|class) (\\w+)"));
  const std::regex imports(
      "(?:^|\n)import \\{([^}]*)\\} from '\\./(\\w+)\\.js'");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), imports);
       it != std::sregex_iterator(); ++it) {
    module.imported[(*it)[2]].merge(Matches((*it)[1], "(\\w+)"));
  }
  std::string code =
      std::regex_replace(text, std::regex("\nimport [^\n]*"), "");
  code = std::regex_replace(code,
                            std::regex("'(?:[^'\\\\\n]|\\\\.)*'|//[^\n]*"), "");
  // Words other than properties, keys of objects and methods of classes.
  module.used =
      Matches(code, "(?:^|[^\\w.$])(\\w+)(?!\\w|\\s*:|\\([^\n]*\\) \\{\n)");
  return module;
}

TEST(PageModulesTest, ImportExactlyTheUsedNames) {
  std::map<std::string, Module> modules;
  for (const auto& entry :
       fs::directory_iterator(testing::ProjectFile("apps/report/web"))) {
    if (entry.path().extension() == ".js") {
      modules[entry.path().stem().string()] = ReadModule(entry.path());
    }
  }
  ASSERT_GE(modules.size(), 10u);
  // Modules only import earlier ones: no cycles.
  std::string order =
      ReadTextFile(testing::ProjectFile("apps/report/modules.cmake").string());
  order.erase(0, order.find("set(page_modules "));
  for (const auto& [name, module] : modules) {
    for (const auto& [from, words] : module.imported) {
      EXPECT_LT(order.find(" " + from), order.find(" " + name))
          << name << ".js imports from " << from << ".js, which is not earlier";
    }
  }
  std::map<std::string, std::string> home;
  for (const auto& [name, module] : modules) {
    for (const std::string& word : module.exported) {
      EXPECT_TRUE(home.emplace(word, name).second)
          << word << " is exported by " << name << " and " << home[word];
    }
  }
  EXPECT_GE(home.size(), 55u);
  for (const auto& [name, module] : modules) {
    for (const auto& [from, words] : module.imported) {
      for (const std::string& word : words) {
        EXPECT_EQ(home[word], from) << name << ".js imports " << word;
        EXPECT_EQ(module.used.count(word), 1u)
            << name << ".js imports " << word << " and does not use it";
      }
    }
    for (const std::string& word : module.used) {
      const auto at = home.find(word);
      if (at == home.end() || at->second == name) continue;
      const auto from = module.imported.find(at->second);
      EXPECT_TRUE(from != module.imported.end() &&
                  from->second.count(word) == 1)
          << name << ".js uses " << word << " of " << at->second << ".js";
    }
  }
}

// In the joined script the later of two functions of one name would replace the
// earlier one.
TEST(PageModulesTest, FunctionsHaveDifferentNames) {
  Names seen;
  for (const auto& entry :
       fs::directory_iterator(testing::ProjectFile("apps/report/web"))) {
    if (entry.path().extension() != ".js") continue;
    for (const std::string& name :
         Matches(ReadTextFile(entry.path().string()),
                 "(?:^|\n)(?:export )?(?:function|class) (\\w+)")) {
      EXPECT_TRUE(seen.insert(name).second) << name << " in " << entry.path();
    }
  }
  EXPECT_GE(seen.size(), 55u);
}

}  // namespace
}  // namespace kinegraph
