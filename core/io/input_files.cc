#include "core/io/input_files.h"

#include <sys/stat.h>

#include <atomic>
#include <mutex>
#include <set>
#include <utility>

namespace kinegraph {
namespace {

struct Inputs {
  std::atomic<bool> protect{false};
  std::mutex mutex;
  std::set<std::pair<dev_t, ino_t>> files;
};

Inputs& TheInputs() {
  static Inputs* const inputs = new Inputs;  // outlives every reader
  return *inputs;
}

}  // namespace

void InputFiles::Protect() { TheInputs().protect = true; }

void InputFiles::Note(int descriptor) {
  constexpr size_t kMaxFiles = 1 << 16;
  Inputs& inputs = TheInputs();
  if (!inputs.protect) return;
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  if (inputs.files.size() < kMaxFiles) {
    inputs.files.emplace(status.st_dev, status.st_ino);
  }
}

bool InputFiles::Has(const std::string& path) {
  Inputs& inputs = TheInputs();
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return false;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  return inputs.files.count({status.st_dev, status.st_ino}) > 0;
}

}  // namespace kinegraph
