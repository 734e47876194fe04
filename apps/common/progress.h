// Progress of long work: one line on a terminal; in a pipe at most one line per
// half minute.
#ifndef KINEGRAPH_APPS_COMMON_PROGRESS_H_
#define KINEGRAPH_APPS_COMMON_PROGRESS_H_

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace kinegraph {

// Thread-safe.
class Progress {
 public:
  // `label` names the work, such as "tracking"; `total` is the number of steps,
  // 0 if unknown.
  Progress(std::string label, int64_t total);
  // Clears the line for messages or results that follow.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Advance();  // one step
  void Set(int64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  void Show();  // limited in frequency

  const std::string label_;
  const int64_t total_;
  const bool on_terminal_;
  const Clock::time_point start_;
  std::mutex mutex_;  // protects the following members
  Clock::time_point last_drawn_;
  int64_t done_ = 0;
  bool drawn_ = false;
};

// "tracking  150/300  50 %  12 s left", at most 79 characters. The time left
// assumes that the remaining steps take as long as those done.
std::string ProgressLine(const std::string& label, int64_t done, int64_t total,
                         double elapsed_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_PROGRESS_H_
