#include "apps/common/interruption.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <mutex>
#include <new>
#include <thread>

#include "apps/common/app.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

// Read by InputStop where a signal shall end the input first.
std::atomic<int> end_of_input[2] = {{-1}, {-1}};

void Say(const std::string& line) {
  // A terminal may show progress on this line.
  WriteAtOnce(kStandardError,
              (IsTerminal(kStandardError) ? "\r\033[K" : "") + line + "\n");
}

void WaitAndEnd(const std::string& program) {
  int number = NextSignal();
  if (number != 0 && end_of_input[1] >= 0) {
    Say(program + ": " + SignalName(number) +
        ": the input ends here; once more abandons the result");
    WriteAtOnce(end_of_input[1], std::string(1, '\0'));
    number = NextSignal();
  }
  if (number == 0) return;
  RemovePartialFilesForGood();
  Say(program + ": stopped by " + SignalName(number) +
      "; what was half-written is removed");
  EndBySignal(number);
}

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
[[gnu::init_priority(101)]] const Handlers kHandlers;

}  // namespace

void HandleInterruptions(const std::string& program) {
  static std::once_flag once;
  std::call_once(
      once, [&program] { CatchSignals([program] { WaitAndEnd(program); }); });
}

void EndInputOnInterruption() {
  int ends[2];
  if (!MakePipe(ends)) return;  // then the first signal abandons
  InputStop::ListenTo(ends[0]);
  end_of_input[0] = ends[0];
  end_of_input[1] = ends[1];
}

void NameProgram(const std::string& program) {
  std::snprintf(last_words, sizeof(last_words), "%.90s: error: out of memory\n",
                program.c_str());
}

void EndOutOfMemory() {
  if (!is_ending.exchange(true)) End();
  while (true) std::this_thread::sleep_for(std::chrono::hours(1));
}

}  // namespace kinegraph
