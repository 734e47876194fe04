// Progress of long work: one line on a terminal, in a pipe a line
// every half minute at most.
#ifndef KINEGRAPH_APPS_COMMON_PROGRESS_H_
#define KINEGRAPH_APPS_COMMON_PROGRESS_H_

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace kinegraph {

// Several threads may move it.
class Progress {
 public:
  // `label` says what is done, as "tracking"; `total` is the number of steps,
  // 0 when it is not known.
  Progress(std::string label, int64_t total);
  // Wipes the line, so that a message or a result follows on a clean one.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Advance(int64_t steps = 1);
  void Set(int64_t done);

 private:
  using Clock = std::chrono::steady_clock;

  void Show();  // not too often

  const std::string label_;
  const int64_t total_;
  const bool on_terminal_;
  const Clock::time_point start_;
  std::mutex mutex_;  // of what follows
  Clock::time_point last_drawn_;
  int64_t done_ = 0;
  bool drawn_ = false;
};

// "tracking  150/300  50 %  12 s left", at most 79 characters. The time left
// assumes that the steps to come take as long as those done.
std::string ProgressLine(const std::string& label, int64_t done, int64_t total,
                         double elapsed_s);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_PROGRESS_H_
