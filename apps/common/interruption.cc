#include "apps/common/interruption.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
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

// The writing end of the pipe that InputStop reads, if the first signal should
// only end the input; -1: none.
std::atomic<int> end_of_input{-1};

void Say(const std::string& line) {
  // On a terminal, first clears a progress line.
  WriteAtOnce(kStandardError,
              (IsTerminal(kStandardError) ? "\r\033[K" : "") + line + "\n");
}

void WaitAndEnd(const std::string& program) {
  int number = NextSignal();
  if (number != 0 && end_of_input >= 0) {
    Say(program + ": " + SignalName(number) +
        ": input ended; a second signal discards the result");
    WriteAtOnce(end_of_input, std::string(1, '\0'));
    number = NextSignal();
  }
  if (number == 0) return;
  RemovePartialFilesForGood();
  Say(program + ": stopped by " + SignalName(number) +
      "; partial files were removed");
  EndBySignal(number);
}

char last_words[128] = "kinegraph: error: out of memory\n";

// std::bad_alloc also reaches the terminate handler: not all memory is
// allocated by operator new (Eigen's is not).
std::terminate_handler usual_terminate = nullptr;
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

// Runs before any other construction in the program's own files.
struct Handlers {
  Handlers() {
    usual_terminate = std::set_terminate(HandleTerminate);
    std::set_new_handler(EndOutOfMemory);
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
  if (!MakePipe(ends)) return;  // the first signal then ends the program
  InputStop::ListenTo(ends[0]);
  end_of_input = ends[1];
}

void NameProgram(const std::string& program) {
  std::snprintf(last_words, sizeof(last_words), "%.90s: error: out of memory\n",
                program.c_str());
}

void EndOutOfMemory() {
  static std::atomic<bool> is_ending{false};
  // Another thread is already ending the program.
  if (is_ending.exchange(true)) {
    while (true) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  std::fflush(stdout);  // keeps the order of output
  std::fputs(last_words, stderr);
  std::_Exit(kExitFailure);
}

}  // namespace kinegraph
