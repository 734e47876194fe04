#include "core/io/files/input_stop.h"

#include <atomic>

#include "core/system/streams.h"

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
  return stop < 0 || kinegraph::WaitForInput(descriptor, stop);
}

bool InputStop::HasHappened() {
  const int stop = TheDescriptor();
  return stop >= 0 && HasInput(stop);
}

}  // namespace kinegraph
