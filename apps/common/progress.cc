#include "apps/common/progress.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "core/system/file.h"

namespace kinegraph {
namespace {

constexpr std::chrono::milliseconds kBetweenDrawings(100);
// When not on a terminal.
constexpr std::chrono::milliseconds kBetweenLines(30'000);
constexpr size_t kMaxLineLength = 79;  // characters; fits 80 columns
// Carriage return, then "erase to the end of the line" (ECMA-48 EL).
constexpr char kWipe[] = "\r\033[K";

bool StderrIsTerminal() {
  if (!IsTerminal(kStandardError)) return false;
  const char* term = std::getenv("TERM");
  return term != nullptr && std::string(term) != "dumb";
}

std::string Duration(double duration_s) {
  const auto seconds = static_cast<int64_t>(std::ceil(duration_s));
  if (seconds < 60) return std::to_string(seconds) + " s";
  const int64_t minutes = seconds / 60;
  if (minutes < 60) {
    return std::to_string(minutes) + " min " + std::to_string(seconds % 60) +
           " s";
  }
  return std::to_string(minutes / 60) + " h " + std::to_string(minutes % 60) +
         " min";
}

}  // namespace

std::string ProgressLine(const std::string& label, int64_t done, int64_t total,
                         double elapsed_s) {
  std::string line = label + "  " + std::to_string(done);
  if (total > 0) {
    const double share = static_cast<double>(done) / static_cast<double>(total);
    line += "/" + std::to_string(total) + "  " +
            std::to_string(static_cast<int>(100.0 * share)) + " %";
    // In the first second, and before the first step is done, an estimate would
    // be unstable.
    if (done > 0 && done < total && elapsed_s >= 1.0) {
      line += "  " + Duration(elapsed_s * (1.0 - share) / share) + " left";
    }
  }
  return line.substr(0, kMaxLineLength);
}

Progress::Progress(std::string label, int64_t total)
    : label_(std::move(label)),
      total_(total),
      on_terminal_(StderrIsTerminal()),
      start_(Clock::now()),
      last_drawn_(start_) {}

Progress::~Progress() {
  if (drawn_) std::fputs(kWipe, stderr);
}

void Progress::Advance() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++done_;
  Show();
}

void Progress::Set(int64_t done) {
  const std::lock_guard<std::mutex> lock(mutex_);
  done_ = done;
  Show();
}

void Progress::Show() {
  const Clock::time_point now = Clock::now();
  if (now - last_drawn_ < (on_terminal_ ? kBetweenDrawings : kBetweenLines)) {
    return;
  }
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string line = ProgressLine(label_, done_, total_, elapsed_s);
  // Not on a terminal: in a pipe or log each update is a separate line.
  std::fputs((on_terminal_ ? kWipe + line : line + "\n").c_str(), stderr);
  std::fflush(stderr);
  last_drawn_ = now;
  drawn_ = on_terminal_;
}

}  // namespace kinegraph
