// Cancellation of long work, for instance when the user presses Ctrl-C or
// closes a window.
#ifndef KINEGRAPH_CORE_BASE_STOP_CHECK_H_
#define KINEGRAPH_CORE_BASE_STOP_CHECK_H_

#include <exception>
#include <functional>

namespace kinegraph {

// Throws (Stopped, or any other exception) when the work should end. Called
// often, from any working thread.
using StopCheck = std::function<void()>;

class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped"; }
};

// For its lifetime, the work of this thread, and the pieces that its calls of
// ParallelFor run on other threads, call `check` regularly: between people,
// between pieces of a recording, between iterations of a solver. An exception
// of `check` propagates out of the running call; objects that the call was
// changing are no longer usable. Only the innermost scope is active. `check`
// must outlive the scope.
class StopScope {
 public:
  explicit StopScope(const StopCheck* check);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  const StopCheck* before_;
};

// Calls the check of this thread's scope, if there is one.
void CheckStop();
// That scope's check, or nullptr.
const StopCheck* CurrentStopCheck();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_STOP_CHECK_H_
