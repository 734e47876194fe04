#include "core/io/files/input_files.h"

#include <atomic>
#include <map>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

// Properties of a file when it was first read.
struct State {
  std::string path;
  FileStatus status;
};

struct Inputs {
  std::atomic<bool> protect{false};
  std::mutex mutex;
  std::map<std::pair<uint64_t, uint64_t>, State> files;
};

Inputs& TheInputs() {
  static Inputs* const inputs = new Inputs;  // outlives every reader
  return *inputs;
}

std::atomic<int> stop_descriptor{-1};

}  // namespace

void InputFiles::Protect() { TheInputs().protect = true; }

void InputFiles::Note(int descriptor, const std::string& path) {
  Inputs& inputs = TheInputs();
  if (!inputs.protect) return;
  const auto status = StatusOf(descriptor);
  if (!status.has_value() || status->kind != FileType::kRegular) return;
  const State now = {path, *status};
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  const auto known = inputs.files.find(status->number);
  if (known == inputs.files.end()) {
    if (inputs.files.size() < kMaxFiles) {
      inputs.files.emplace(status->number, now);
    }
    return;
  }
  // A different path may be a new file that reuses the inode of a deleted one.
  if (known->second.path != path) {
    known->second = now;
  } else if (known->second.status.size != status->size ||
             known->second.status.changed != status->changed) {
    throw InputError(path, "", "has changed while it was being read");
  }
}

void InputFiles::Forget(const std::string& path) {
  Inputs& inputs = TheInputs();
  const auto status = StatusOf(path);
  if (!status.has_value()) return;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  inputs.files.erase(status->number);
}

bool InputFiles::Has(const std::string& path) {
  Inputs& inputs = TheInputs();
  const auto status = StatusOf(path);
  if (!status.has_value()) return false;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  return inputs.files.count(status->number) > 0;
}

void InputStop::ListenTo(int descriptor) { stop_descriptor = descriptor; }

bool InputStop::WaitForInput(int descriptor) {
  const int stop = stop_descriptor;
  return stop < 0 || kinegraph::WaitForInput(descriptor, stop);
}

bool InputStop::HasHappened() {
  const int stop = stop_descriptor;
  return stop >= 0 && HasInput(stop);
}

}  // namespace kinegraph
