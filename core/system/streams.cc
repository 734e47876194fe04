#include "core/system/streams.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace kinegraph {

bool IsTerminal(int descriptor) { return isatty(descriptor) != 0; }

void PrepareStandardStreams() {
  std::signal(SIGPIPE, SIG_IGN);
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (fcntl(fd, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one. Opened the wrong way round, so that
    // using it still fails.
    const int mode = fd == STDIN_FILENO ? O_WRONLY : O_RDONLY;
    if (open("/dev/null", mode) < 0) return;
  }
}

bool ReaderIsGone(int descriptor) {
  pollfd stream = {descriptor, POLLOUT, 0};
  return poll(&stream, 1, 0) == 1 && (stream.revents & POLLERR) != 0;
}

bool WaitForInput(int descriptor, int stop) {
  while (true) {
    pollfd both[2] = {{stop, POLLIN, 0}, {descriptor, POLLIN, 0}};
    const int ready = poll(both, 2, -1);
    if (ready < 0 && errno == EINTR) continue;
    return ready < 0 || both[0].revents == 0;
  }
}

bool HasInput(int descriptor) {
  pollfd one = {descriptor, POLLIN, 0};
  return poll(&one, 1, 0) > 0;
}

bool MakePipe(int ends[2]) { return pipe2(ends, O_CLOEXEC) == 0; }

void WriteAtOnce(int descriptor, const std::string& text) {
  [[maybe_unused]] const ssize_t written =
      write(descriptor, text.data(), text.size());
}

}  // namespace kinegraph
