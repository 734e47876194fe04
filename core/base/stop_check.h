// Long work that somebody may want no longer: a user who presses Ctrl-C, a
// window that is closed.
#ifndef KINEGRAPH_CORE_BASE_STOP_CHECK_H_
#define KINEGRAPH_CORE_BASE_STOP_CHECK_H_

#include <exception>
#include <functional>

namespace kinegraph {

// Throws (Stopped, or what it likes) when the work shall end. It is called
// often, and on any thread that works.
using StopCheck = std::function<void()>;

class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped"; }
};

// While it lives, what this thread does, and what ParallelFor does for it on
// others, asks `check` now and then: between people, between pieces of a
// recording, between iterations of a solver. What is thrown comes out of the
// call that was at work; the objects that it was working on are of no use any
// more. One scope inside another counts alone. `check` must outlive the scope.
class StopScope {
 public:
  explicit StopScope(const StopCheck* check);
  ~StopScope();
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

 private:
  const StopCheck* before_;
};

// Asks the scope of this thread, if there is one.
void CheckStop();
// That scope's check, or nullptr.
const StopCheck* CurrentStopCheck();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_STOP_CHECK_H_
