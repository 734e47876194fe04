#include "apps/common/out_of_memory.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <thread>

#include "apps/common/app.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {
namespace {

char last_words[128] = "kinegraph: error: out of memory\n";
std::atomic<bool> is_ending{false};
// Let go at the end, which needs a little itself.
std::atomic<void*> reserve{nullptr};
std::terminate_handler usual_terminate = nullptr;

// Of the thread that ends the program.
[[noreturn]] void End() {
  std::free(reserve.exchange(nullptr));
  try {
    std::cout.flush();  // what was printed before comes before
    std::fflush(stdout);
    RemovePartialFilesForGood();
  } catch (...) {
    // Not even that much: some of it stays.
  }
  std::fputs(last_words, stderr);
  std::_Exit(kExitFailure);
}

// In place of std::bad_alloc. The end itself, and threads that run out of
// memory meanwhile, get the exception: they may hold a lock that the end needs.
void HandleFailedNew() {
  if (is_ending.exchange(true)) throw std::bad_alloc();
  End();
}

// Not all memory comes by operator new (Eigen's).
[[noreturn]] void HandleTerminate() {
  try {
    if (std::current_exception())
      std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    EndOutOfMemory();
  } catch (...) {
  }
  usual_terminate();
  std::abort();
}

// Before whatever else the program's own files construct.
struct Handlers {
  Handlers() {
    constexpr size_t kReserveBytes = size_t{256} << 10;
    usual_terminate = std::set_terminate(HandleTerminate);
    std::set_new_handler(HandleFailedNew);
    reserve = std::malloc(kReserveBytes);
  }
};
[[gnu::init_priority(101)]] const Handlers handlers;

}  // namespace

void NameProgram(const std::string& program) {
  std::snprintf(last_words, sizeof(last_words), "%.90s: error: out of memory\n",
                program.c_str());
}

void EndOutOfMemory() {
  if (!is_ending.exchange(true)) End();
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

}  // namespace kinegraph
