#include "core/io/files/input_files.h"

#include <sys/stat.h>

#include <atomic>
#include <map>
#include <mutex>
#include <utility>

#include "core/base/error.h"

namespace kinegraph {
namespace {

// What a file was like when it was read first.
struct State {
  std::string path;
  off_t size = 0;
  timespec changed{};

  bool operator==(const State& other) const {
    return size == other.size && changed.tv_sec == other.changed.tv_sec &&
           changed.tv_nsec == other.changed.tv_nsec;
  }
};

struct Inputs {
  std::atomic<bool> protect{false};
  std::mutex mutex;
  std::map<std::pair<dev_t, ino_t>, State> files;
};

Inputs& TheInputs() {
  static Inputs* const inputs = new Inputs;  // outlives every reader
  return *inputs;
}

}  // namespace

void InputFiles::Protect() { TheInputs().protect = true; }

void InputFiles::Note(int descriptor, const std::string& path) {
  constexpr size_t kMaxFiles = 1 << 16;
  Inputs& inputs = TheInputs();
  if (!inputs.protect) return;
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return;
  const State now = {path, status.st_size, status.st_mtim};
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  const auto known = inputs.files.find({status.st_dev, status.st_ino});
  if (known == inputs.files.end()) {
    if (inputs.files.size() < kMaxFiles) {
      inputs.files.emplace(std::make_pair(status.st_dev, status.st_ino), now);
    }
    return;
  }
  // Under another name it may be another file with the number of one that is
  // gone.
  if (known->second.path != path) {
    known->second = now;
  } else if (!(known->second == now)) {
    throw InputError(path, "", "has changed while it was being read");
  }
}

void InputFiles::Forget(const std::string& path) {
  Inputs& inputs = TheInputs();
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  inputs.files.erase({status.st_dev, status.st_ino});
}

bool InputFiles::Has(const std::string& path) {
  Inputs& inputs = TheInputs();
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return false;
  const std::lock_guard<std::mutex> lock(inputs.mutex);
  return inputs.files.count({status.st_dev, status.st_ino}) > 0;
}

}  // namespace kinegraph
