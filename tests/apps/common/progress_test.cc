#include "apps/common/progress.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

namespace kinegraph {
namespace {

TEST(ProgressLine, ShowsShareAndRemainingTime) {
  const struct {
    const char* label;
    int64_t done, total;
    double elapsed_s;
    const char* line;
  } kCases[] = {
      // Half is done in 12 s, so 12 s are left.
      {"tracking", 150, 300, 12.0, "tracking  150/300  50 %  12 s left"},
      // A quarter in 100 s: 300 s are left.
      {"tracking", 1, 4, 100.0, "tracking  1/4  25 %  5 min 0 s left"},
      // 1 of 101 in 72 s: 7200 s are left.
      {"tracking", 1, 101, 72.0, "tracking  1/101  0 %  2 h 0 min left"},
      // No estimate too early or at the end.
      {"x", 0, 10, 5.0, "x  0/10  0 %"},
      {"x", 1, 10, 0.5, "x  1/10  10 %"},
      {"x", 10, 10, 5.0, "x  10/10  100 %"},
      // Unknown total.
      {"reading", 7, 0, 5.0, "reading  7"}};
  for (const auto& one : kCases) {
    EXPECT_EQ(ProgressLine(one.label, one.done, one.total, one.elapsed_s),
              one.line);
  }
  // Limited to one line of the terminal.
  EXPECT_EQ(ProgressLine(std::string(200, 'x'), 1, 2, 3.0).size(), 79u);
}

// Draws progress with stderr redirected to the descriptor `fd`.
void DrawTo(int fd) {
  std::fflush(stderr);
  const int saved = dup(STDERR_FILENO);
  dup2(fd, STDERR_FILENO);
  {
    Progress progress("working", 4);
    // Longer than the pause between two drawings (0.1 s).
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    progress.Advance();
    progress.Advance();
  }
  std::fflush(stderr);
  dup2(saved, STDERR_FILENO);
  close(saved);
}

// Reads up to the end, or until the other side is closed.
std::string ReadAll(int fd) {
  std::string all;
  char buffer[1000];
  while (true) {
    const ssize_t count = read(fd, buffer, sizeof(buffer));
    if (count <= 0) return all;
    all.append(buffer, static_cast<size_t>(count));
  }
}

TEST(Progress, ShortWorkWritesNothingToAPipe) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  DrawTo(ends[1]);
  close(ends[1]);
  EXPECT_EQ(ReadAll(ends[0]), "");
  close(ends[0]);
}

TEST(Progress, DrawsOnATerminalAndWipesTheLine) {
  setenv("TERM", "xterm", 1);
  int terminal = 0;
  int user = 0;
  ASSERT_EQ(openpty(&terminal, &user, nullptr, nullptr, nullptr), 0);
  DrawTo(user);
  close(user);
  // The first step is drawn, the second comes too soon after it.
  EXPECT_EQ(ReadAll(terminal), "\r\033[Kworking  1/4  25 %\r\033[K");
  close(terminal);
}

}  // namespace
}  // namespace kinegraph
