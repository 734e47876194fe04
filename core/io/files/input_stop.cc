#include "core/io/files/input_stop.h"

#include <poll.h>

#include <atomic>
#include <cerrno>

namespace kinegraph {
namespace {

std::atomic<int>& TheDescriptor() {
  static std::atomic<int> descriptor{-1};
  return descriptor;
}

}  // namespace

void InputStop::ListenTo(int descriptor) { TheDescriptor() = descriptor; }

bool InputStop::WaitForInput(int descriptor) {
  const int stop = TheDescriptor();
  if (stop < 0) return true;
  while (true) {
    pollfd both[2] = {{stop, POLLIN, 0}, {descriptor, POLLIN, 0}};
    const int ready = poll(both, 2, -1);
    if (ready < 0 && errno == EINTR) continue;
    return ready < 0 || both[0].revents == 0;
  }
}

bool InputStop::HasHappened() {
  const int stop = TheDescriptor();
  if (stop < 0) return false;
  pollfd one = {stop, POLLIN, 0};
  return poll(&one, 1, 0) > 0;
}

}  // namespace kinegraph
