#include "core/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace kinegraph {

void ParallelFor(int threads, int count, const std::function<void(int)>& work) {
  if (threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) work(i);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> errors(count);
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  const int extra = std::min(threads, count) - 1;
  others.reserve(extra);
  try {
    for (int i = 0; i < extra; ++i) others.emplace_back(run);
  } catch (const std::system_error&) {
    // The system gives no more threads: those there are do the work.
  }
  run();
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace kinegraph
