#include "core/system/process.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>
#include <string>

#include "core/system/file.h"

namespace kinegraph {
namespace {

// Runs a shell script without input for at most `most_ms`.
ProcessEnd EndOf(const std::string& script, int most_ms, bool* was_ended) {
  RunningProgram program({"/bin/sh", "-c", script}, -1, kStandardOutput,
                         kStandardError);
  const ProcessEnd end = program.Wait(most_ms);
  *was_ended = program.was_ended();
  return end;
}

constexpr int kLong_ms = 60'000;

TEST(RunningProgramTest, ReportsExitCodeOrSignal) {
  bool was_ended = true;
  EXPECT_TRUE(EndOf("true", kLong_ms, &was_ended).well());
  EXPECT_FALSE(was_ended);
  EXPECT_EQ(EndOf("exit 3", kLong_ms, &was_ended).code, 3);
  EXPECT_EQ(EndOf("kill -SEGV $$", kLong_ms, &was_ended).signal, SIGSEGV);
  EXPECT_FALSE(was_ended);
}

TEST(RunningProgramTest, IsKilledAfterTheTimeout) {
  bool was_ended = false;
  // With exec, because a shell's child would survive and keep the output open.
  EXPECT_EQ(EndOf("exec sleep 600", 50, &was_ended).signal, SIGKILL);
  EXPECT_TRUE(was_ended);
}

TEST(RunningProgramTest, HasNoInput) {
  bool was_ended = true;
  EXPECT_EQ(EndOf("read line", kLong_ms, &was_ended).code, 1);
}

TEST(RunningProgramTest, AMissingProgramIsNotStarted) {
  RunningProgram program({"/no/such/program"}, -1, kStandardOutput,
                         kStandardError);
  EXPECT_NE(program.Wait(kLong_ms).not_started, 0);
}

TEST(RunInFolderTest, ReportsWhyAProgramWasNotStarted) {
  const std::string folder = ::testing::TempDir();
  const auto run = [](const std::string& program, const std::string& where) {
    return RunInFolder({program}, where, "/dev/null", "/dev/null").not_started;
  };
  EXPECT_EQ(run("/bin/true", folder), 0);
  EXPECT_EQ(run("/no/such/program", folder), ENOENT);
  EXPECT_EQ(run("/etc/passwd", folder), EACCES);
  EXPECT_EQ(run("/bin/true", folder + "/none"), ENOENT);
}

// With SIGCHLD ignored, the system discards exit codes.
TEST(RunInFolderTest, ALostExitCodeIsNoSuccess) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  const ProcessEnd end = RunInFolder({"/bin/false"}, ::testing::TempDir(),
                                     "/dev/null", "/dev/null");
  std::signal(SIGCHLD, before);
  EXPECT_EQ(end.not_started, ECHILD);
  EXPECT_FALSE(end.well());
}

}  // namespace
}  // namespace kinegraph
