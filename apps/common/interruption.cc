#include "apps/common/interruption.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <mutex>
#include <system_error>
#include <thread>

#include "core/io/files/input_stop.h"
#include "core/io/files/partial_files.h"

namespace kinegraph {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

// The handler may do next to nothing, so it hands the signal's number to a
// thread that may do everything.
int signal_pipe[2] = {-1, -1};
// Read by InputStop where a signal shall end the input first.
std::atomic<int> end_of_input[2] = {{-1}, {-1}};

void PassOn(int signal_number) {
  const int reason = errno;
  const auto number = static_cast<unsigned char>(signal_number);
  // A full pipe means that a signal waits there already.
  [[maybe_unused]] const ssize_t written = write(signal_pipe[1], &number, 1);
  errno = reason;
}

const char* NameOf(int signal_number) {
  switch (signal_number) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    default:
      return "SIGHUP";
  }
}

// The next signal; 0 when there can be none.
int NextSignal() {
  unsigned char number = 0;
  while (read(signal_pipe[0], &number, 1) != 1) {
    if (errno != EINTR) return 0;
  }
  return number;
}

void Say(const std::string& line) {
  // A terminal may show progress on this line.
  const std::string text =
      (isatty(STDERR_FILENO) != 0 ? "\r\033[K" : "") + line + "\n";
  [[maybe_unused]] const ssize_t written =
      write(STDERR_FILENO, text.data(), text.size());
}

void WaitAndEnd(const std::string& program) {
  int number = NextSignal();
  if (number != 0 && end_of_input[1] >= 0) {
    Say(program + ": " + NameOf(number) +
        ": the input ends here; once more abandons the result");
    const char anything = 0;
    [[maybe_unused]] const ssize_t written =
        write(end_of_input[1], &anything, 1);
    number = NextSignal();
  }
  if (number == 0) return;
  PartialFiles::RemoveAllForGood();
  Say(program + ": stopped by " + NameOf(number) +
      "; what was half-written is removed");
  std::signal(number, SIG_DFL);
  // To the process, whose threads do not block it; then nothing goes on.
  kill(getpid(), number);
  while (true) pause();
}

void Install(const std::string& program) {
  std::signal(SIGXFSZ, SIG_IGN);
  if (pipe2(signal_pipe, O_CLOEXEC | O_NONBLOCK) != 0) return;
  fcntl(signal_pipe[0], F_SETFL, 0);  // the thread waits
  try {
    std::thread(WaitAndEnd, program).detach();
  } catch (const std::system_error&) {
    return;  // no thread to be had: the signals end the program as ever
  }
  for (const int number : kSignals) {
    struct sigaction present {};
    sigaction(number, nullptr, &present);
    if (present.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = PassOn;
    action.sa_flags = SA_RESTART;
    sigaction(number, &action, nullptr);
  }
}

}  // namespace

void HandleInterruptions(const std::string& program) {
  static std::once_flag once;
  std::call_once(once, [&program] { Install(program); });
}

void EndInputOnInterruption() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return;  // then the first signal abandons
  InputStop::ListenTo(ends[0]);
  end_of_input[0] = ends[0];
  end_of_input[1] = ends[1];
}

}  // namespace kinegraph
