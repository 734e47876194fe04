#include "core/base/stop_check.h"

namespace kinegraph {
namespace {

thread_local const StopCheck* current = nullptr;

}  // namespace

StopScope::StopScope(const StopCheck* check) : before_(current) {
  current = check;
}

StopScope::~StopScope() { current = before_; }

void CheckStop() {
  if (current != nullptr) (*current)();
}

const StopCheck* CurrentStopCheck() { return current; }

}  // namespace kinegraph
