#include "core/system/signals.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>
#include <thread>

namespace kinegraph {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};

// The handler may do next to nothing, so it hands the signal's number on.
int signal_pipe[2] = {-1, -1};

void PassOn(int signal_number) {
  const int reason = errno;
  const auto number = static_cast<unsigned char>(signal_number);
  // A full pipe means that a signal waits there already.
  [[maybe_unused]] const ssize_t written = write(signal_pipe[1], &number, 1);
  errno = reason;
}

}  // namespace

void CatchSignals(const std::function<void()>& thread) {
  std::signal(SIGXFSZ, SIG_IGN);
  if (pipe2(signal_pipe, O_CLOEXEC | O_NONBLOCK) != 0) return;
  fcntl(signal_pipe[0], F_SETFL, 0);  // the thread waits
  try {
    std::thread(thread).detach();
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

int NextSignal() {
  unsigned char number = 0;
  while (read(signal_pipe[0], &number, 1) != 1) {
    if (errno != EINTR) return 0;
  }
  return number;
}

const char* SignalName(int number) {
  switch (number) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    default:
      return "SIGHUP";
  }
}

void EndBySignal(int number) {
  std::signal(number, SIG_DFL);
  // To the process, whose threads do not block it; then nothing goes on.
  kill(getpid(), number);
  while (true) pause();
}

}  // namespace kinegraph
