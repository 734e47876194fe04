// Calls that the system refuses in the middle, where that once went unsaid;
// failing_calls.py tries the calls of every command.
#include <gtest/gtest.h>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

// The library that refuses calls, or nothing without a compiler.
const std::string& Injector() {
  static const auto* const folder = new TemporaryFolder;
  static const auto* const path = new std::string([] {
    const std::string library = (folder->path() / "refuse.so").string();
    const ProgramOutcome made = RunShell(
        "gcc -shared -fPIC -w -o '" + library + "' '" +
        ProjectFile("tests/apps/faults/failing_calls.c").string() + "' -ldl");
    return made.exit_code == 0 ? library : "";
  }());
  return *path;
}

std::string Refusing(const std::string& call, int number) {
  return "LD_PRELOAD='" + Injector() + "' INJECT_CALL=" + call +
         " INJECT_AT=" + std::to_string(number) + " ";
}

int CountOf(const std::string& call, const std::string& line) {
  const TemporaryFolder folder;
  const std::string count = (folder.path() / "count").string();
  const ProgramOutcome outcome =
      RunShell(Refusing(call, 0) + "INJECT_COUNT='" + count + "' " + line);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return std::atoi(ContentOf(count).c_str());
}

int LinesIn(const std::string& text) {
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

TEST(InjectedTest, AMergeThatCannotLookNeverCountsLess) {
  if (Injector().empty()) GTEST_SKIP() << "needs gcc";
  const TemporaryFolder folder;
  const std::string manifest = folder.Write(
      "study.toml",
      "[[takes]]\nname = \"a\"\ncameras = \"" + DemoScene("0.4") +
          "/cameras.json\"\ndetections = \"" + DemoScene("0.4") +
          "/detections.jsonl\"\nframes = \"0:5\"\n[[configurations]]\n"
          "name = \"b\"\nconfig = \"" +
          ProjectFile("configs/synthetic/track_paper.toml").string() + "\"\n");
  const std::string out = (folder.path() / "out").string();
  const ProgramOutcome made =
      RunProgram("batch", "--manifest=" + manifest + " --out=" + out);
  ASSERT_EQ(made.exit_code, 0) << made.errors;
  const std::string merge =
      "'" + ProgramPath("batch") + "' --merge --out='" + out + "'";
  for (const std::string call : {"stat", "openat", "readdir", "open"}) {
    const int count = CountOf(call, merge);
    EXPECT_GT(count, 0) << call;
    for (int n = 1; n <= count; ++n) {
      const ProgramOutcome outcome = RunShell(Refusing(call, n) + merge);
      if (outcome.exit_code == 0) {
        EXPECT_EQ(outcome.output, "1 of 1 tasks -> " + out + "/batch.md\n")
            << call << " " << n;
      } else {
        EXPECT_EQ(LinesIn(outcome.errors), 1) << outcome.errors;
      }
    }
  }
}

}  // namespace
}  // namespace kinegraph::testing
