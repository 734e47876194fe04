// Rules that the build cannot keep, asserted on the sources themselves. Who may
// use which library of the project is the build's (kinegraph_library).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/test_data.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

// "core/geometry" of "core/geometry/camera.h"; solvers and apps count as one
// each.
std::string FolderOf(const std::string& path) {
  const size_t first = path.find('/');
  const std::string top = path.substr(0, first);
  if (top != "core" || first == std::string::npos) return top;
  return path.substr(0, path.find('/', first + 1));
}

bool StartsWith(const std::string& text, const std::string& beginning) {
  return text.rfind(beginning, 0) == 0;
}

// What only some folders may contain.
struct Reserved {
  std::regex pattern;
  std::vector<std::string> allowed_below;
  std::string rule;
};

const std::vector<Reserved>& ReservedIncludes() {
  static const std::vector<Reserved> reserved = {
      {std::regex("(ceres|suitesparse)/.*|cholmod.*\\.h|umfpack\\.h|"
                  "SuiteSparse.*"),
       {"solvers"},
       "Ceres and SuiteSparse are seen by solvers alone"},
      {std::regex("gflags/.*"), {"apps"}, "gflags is for apps alone"},
      {std::regex(
           "toml\\+\\+/.*|toml\\.hpp|simdjson.*|yaml-cpp/.*|matio.*|hdf5.*"),
       {"core/io"},
       "format libraries are for core/io alone"},
      {std::regex("nlohmann/.*"),
       {"core/io", "apps"},
       "JSON is read by core/io alone, and written by it and by commands"},
      {std::regex("fstream|filesystem"),
       {"core/io"},
       "files are touched by core/io alone"},
      {std::regex("iostream"), {"apps"}, "the library does not print"},
      {std::regex("(sys/.*|unistd|fcntl|poll|spawn|dirent|termios|dlfcn|glob|"
                  "pwd|pthread|sched|signal)\\.h|sys/.*|csignal"),
       {"core/system"},
       "the operating system is known to core/system alone"},
  };
  return reserved;
}

const std::vector<Reserved>& ReservedWords() {
  static const std::vector<Reserved> reserved = {
      {std::regex("\\b(FLAGS_\\w+|(DEFINE|DECLARE)_"
                  "(bool|int32|uint32|int64|uint64|double|string)\\b)"),
       {"apps"},
       "flags are for apps alone"},
      {std::regex("\\b(fopen|freopen)\\s*\\("),
       {"core/io"},
       "files are touched by core/io alone"},
      {std::regex("\\bstd::(cout|cerr)\\b|\\b(printf|puts|fprintf)\\s*\\("),
       {"apps"},
       "the library does not print"},
      {std::regex("\\brandom_device\\b"), {}, "every random number is seeded"},
  };
  return reserved;
}

bool IsAllowed(const Reserved& reserved, const std::string& folder) {
  for (const std::string& allowed : reserved.allowed_below) {
    if (folder == allowed) return true;
  }
  return false;
}

// The rule that including `included` from a file of `folder` breaks; empty
// when it breaks none.
std::string BrokenByInclude(const std::string& folder,
                            const std::string& included) {
  for (const Reserved& reserved : ReservedIncludes()) {
    if (std::regex_match(included, reserved.pattern) &&
        !IsAllowed(reserved, folder)) {
      return reserved.rule;
    }
  }
  if (StartsWith(included, "tests/")) return "tests are used by tests alone";
  return "";
}

std::string BrokenByWords(const std::string& folder, const std::string& line) {
  for (const Reserved& reserved : ReservedWords()) {
    if (std::regex_search(line, reserved.pattern) &&
        !IsAllowed(reserved, folder)) {
      return reserved.rule;
    }
  }
  return "";
}

// Every broken rule of one source as "path:line: rule: the line".
std::vector<std::string> Violations(const std::string& path,
                                    const std::string& source) {
  static const std::regex kInclude(
      "^\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  const std::string folder = FolderOf(path);
  std::vector<std::string> found;
  std::istringstream lines(source);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    // What a comment says is no use of anything.
    const std::string code = line.substr(0, line.find("//"));
    std::smatch match;
    const bool includes = std::regex_match(line, match, kInclude);
    const std::string rule = includes ? BrokenByInclude(folder, match[1])
                                      : BrokenByWords(folder, code);
    if (rule.empty()) continue;
    found.push_back(path + ":" + std::to_string(number) + ": " + rule + ": " +
                    line);
  }
  return found;
}

std::string ReadAll(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  return content.str();
}

struct TreeReport {
  std::set<std::string> folders;  // in which sources were read
  std::vector<std::string> violations;
};

TreeReport CheckTree(const fs::path& root) {
  TreeReport report;
  for (const std::string top : {"core", "solvers", "apps"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      const std::string path =
          entry.path().lexically_relative(root).generic_string();
      report.folders.insert(FolderOf(path));
      for (std::string& found : Violations(path, ReadAll(entry.path()))) {
        report.violations.push_back(std::move(found));
      }
    }
  }
  return report;
}

TEST(Layering, TheSourcesKeepTheRules) {
  const TreeReport report = CheckTree(ProjectFile(""));
  // These folders have stood from the beginning: they were really read.
  for (const std::string folder : {"core/base", "core/data", "apps"}) {
    EXPECT_EQ(report.folders.count(folder), 1u) << folder;
  }
  for (const std::string& violation : report.violations) {
    ADD_FAILURE() << violation;
  }
}

// Two types of one name in one namespace are one type to the linker: it keeps
// one of the two sets of functions, and memory of the other is written over.
TEST(Layering, NoTwoHeadersDefineATypeOfOneName) {
  const std::regex definition(
      R"(^(?:struct|class|enum class) ([A-Za-z0-9_]+)(?: final)?(?: :[^;]*)?(?: \{)?$)");
  std::map<std::string, std::string> places;
  for (const std::string top : {"core", "solvers", "apps"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(ProjectFile(top))) {
      if (entry.path().extension() != ".h") continue;
      std::istringstream lines(ReadAll(entry.path()));
      for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (!std::regex_match(line, match, definition)) continue;
        const auto [at, fresh] =
            places.emplace(match[1], entry.path().string());
        // One header may define a type twice, for two compilers.
        EXPECT_TRUE(fresh || at->second == entry.path().string())
            << match[1] << ": " << entry.path().string() << " and "
            << at->second;
      }
    }
  }
  EXPECT_GT(places.size(), 200u);  // they were really read
}

// Debian's libceres is built without wide vectors. Eigen aligns differently
// with them, and memory handed across the boundary is then freed wrongly.
TEST(Layering, NoBuildFileAsksForTheMachinesOwnInstructions) {
  std::vector<fs::path> files = {ProjectFile("CMakeLists.txt"),
                                 ProjectFile("CMakePresets.json"),
                                 ProjectFile("kinegraph")};
  for (const std::string top : {"cmake", "core", "solvers", "apps"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(ProjectFile(top))) {
      const fs::path& path = entry.path();
      if (path.filename() == "CMakeLists.txt" || path.extension() == ".cmake") {
        files.push_back(path);
      }
    }
  }
  ASSERT_GE(files.size(), 6u);
  for (const fs::path& file : files) {
    std::string content = ReadAll(file);
    ASSERT_FALSE(content.empty()) << file;
    if (file.filename() == "KinegraphTargets.cmake") {
      // For files of their own: see the test below.
      content = std::regex_replace(
          content,
          std::regex("source MATCHES \"_avx\\w+[^\"]*\"\\)\\s*"
                     "list\\(APPEND options -mavx\\w+\\)"),
          "");
    }
    EXPECT_EQ(content.find("-march="), std::string::npos) << file;
    EXPECT_EQ(content.find("-mavx"), std::string::npos) << file;
  }
}

// What a source of the project includes, directly or not, system headers too.
void CollectIncludes(const fs::path& root, const fs::path& file,
                     std::set<std::string>* includes) {
  static const std::regex kInclude(
      "^\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  std::istringstream lines(ReadAll(root / file));
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, kInclude)) continue;
    const std::string included = match[1];
    if (!includes->insert(included).second) continue;
    if (fs::exists(root / included)) CollectIncludes(root, included, includes);
  }
}

// Files for one instruction set: whatever they share with others would be
// compiled for that set too, and run on machines that do not have it.
TEST(Layering, FilesForWiderRegistersIncludeOnlyPacks) {
  const fs::path root = ProjectFile("");
  int files = 0;
  for (const std::string top : {"core", "solvers", "apps"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string name = entry.path().filename().string();
      if (!std::regex_match(name, std::regex(".*_avx\\w+\\.cc"))) continue;
      ++files;
      std::set<std::string> includes;
      CollectIncludes(root, entry.path().lexically_relative(root), &includes);
      EXPECT_EQ(includes.count("core/base/pack.h"), 1u) << name;
      for (const std::string& included : includes) {
        static const std::set<std::string> kHarmless = {
            "cstdint", "cstddef", "cmath", "algorithm", "type_traits"};
        EXPECT_TRUE(fs::exists(root / included) || kHarmless.count(included))
            << name << " includes " << included;
      }
    }
  }
  EXPECT_GE(files, 2);
}

// The list of what a port needs is complete: whatever uses a header or a file
// that not every system has stands in it.
TEST(Layering, WhatIsNotEverywhereIsListedForPorts) {
  const fs::path root = ProjectFile("");
  const std::string list = ReadAll(root / "docs/porting.md");
  ASSERT_FALSE(list.empty());
  const std::regex system(
      "#include <(sys/.*|unistd|fcntl|poll|spawn|dirent|termios|dlfcn|glob|pwd|"
      "pthread|sched)(\\.h)?>|\"/proc/|__builtin_cpu|vector_size");
  int files = 0;
  for (const std::string top : {"core", "solvers", "apps", "python"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const fs::path extension = entry.path().extension();
      if (extension != ".h" && extension != ".cc") continue;
      if (!std::regex_search(ReadAll(entry.path()), system)) continue;
      ++files;
      EXPECT_NE(list.find(entry.path().filename().string()), std::string::npos)
          << entry.path() << " is not in docs/porting.md";
    }
  }
  EXPECT_GE(files, 6);  // they were really read
}

// ---- The test of the test --------------------------------------------------

struct WrongLine {
  std::string path;
  std::string line;
  std::string part_of_message;
};

std::ostream& operator<<(std::ostream& out, const WrongLine& wrong) {
  return out << wrong.path << " with " << wrong.line;
}

class LayeringFinds : public ::testing::TestWithParam<WrongLine> {};

TEST_P(LayeringFinds, AWrongLine) {
  const WrongLine& wrong = GetParam();
  const std::string source =
      "// A fine comment.\n#include <vector>\n" + wrong.line + "\nint x = 0;\n";
  const std::vector<std::string> found = Violations(wrong.path, source);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].rfind(wrong.path + ":3: ", 0), 0u) << found[0];
  EXPECT_NE(found[0].find(wrong.part_of_message), std::string::npos)
      << found[0];
}

INSTANTIATE_TEST_SUITE_P(
    EachRule, LayeringFinds,
    ::testing::Values(
        WrongLine{"core/data/x.h", "#include <ceres/ceres.h>", "Ceres"},
        WrongLine{"apps/x.cc", "#include \"ceres/problem.h\"", "Ceres"},
        WrongLine{"core/data/x.h", "#include <gflags/gflags.h>", "gflags"},
        WrongLine{"solvers/window/x.cc", "  if (FLAGS_threads > 1) {", "flags"},
        WrongLine{"core/io/x.cc", "DEFINE_string(a, \"\", \"\");", "flags"},
        WrongLine{"core/io/x.cc", "DECLARE_bool(a);", "flags"},
        WrongLine{"core/evaluation/x.cc", "#include <fstream>", "files"},
        WrongLine{"apps/x.cc", "#include <filesystem>", "files"},
        WrongLine{"core/io/files/x.cc", "#include <unistd.h>", "core/system"},
        WrongLine{"apps/x.cc", "#include <sys/stat.h>", "core/system"},
        WrongLine{"solvers/x.cc", "  FILE* file = fopen(name, \"r\");",
                  "files"},
        WrongLine{"core/data/x.cc", "#include <toml++/toml.h>", "format"},
        WrongLine{"core/tracking/x.cc", "#include \"simdjson.h\"", "format"},
        WrongLine{"apps/x.cc", "#include <simdjson.h>", "format"},
        WrongLine{"solvers/x.cc", "#include <nlohmann/json.hpp>", "JSON"},
        WrongLine{"core/synthetic/x.cc", "#include <yaml-cpp/yaml.h>",
                  "format"},
        WrongLine{"core/evaluation/x.cc", "#include <matio.h>", "format"},
        WrongLine{"core/data/x.cc", "#include <iostream>", "print"},
        WrongLine{"core/data/x.cc", "  std::printf(\"%d\", x);", "print"},
        WrongLine{"core/data/x.cc", "std::random_device d;", "seeded"},
        WrongLine{"core/data/x.h", "#include \"tests/support/y.h\"", "tests"}));

TEST(Layering, AllowsWhatTheRulesAllow) {
  EXPECT_TRUE(Violations("core/io/x.cc",
                         "#include <filesystem>\n#include \"simdjson.h\"\n"
                         "#include \"core/data/pose.h\"\n"
                         "#include \"core/io/y.h\"\n"
                         "  std::snprintf(text, 3, \"%d\", 1);\n")
                  .empty());
  EXPECT_TRUE(Violations("solvers/window/x.cc",
                         "#include <ceres/ceres.h>\n"
                         "#include \"core/tracking/estimator.h\"\n"
                         "#include \"solvers/factors/y.h\"\n")
                  .empty());
  EXPECT_TRUE(Violations("apps/track.cc",
                         "#include <gflags/gflags.h>\n"
                         "#include \"solvers/factory.h\"\n"
                         "DEFINE_string(out, \"\", \"\");\n")
                  .empty());
  EXPECT_TRUE(Violations("core/data/x.h", "// FLAGS_x is not used\n").empty());
}

}  // namespace
}  // namespace kinegraph::testing
