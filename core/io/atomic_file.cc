#include "core/io/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// Opens a new file beside `target`, with the permissions the user's umask
// gives (mkstemp would make it private).
int OpenBeside(const std::string& target, std::string* temporary) {
  constexpr int kAttempts = 1000;  // leftovers of killed programs are skipped
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    *temporary = target + ".partial-" + std::to_string(getpid()) + "-" +
                 std::to_string(attempt);
    const int descriptor =
        open(temporary->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
  return -1;
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path), target_(path) {
  if (path.empty()) throw InputError("an output file has an empty name");
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) {
    throw InputError(path, "", "is a folder, expected a file to write");
  }
  if (fs::is_regular_file(status)) {
    const fs::path resolved = fs::canonical(path, error);
    if (!error) target_ = resolved.string();
  }
  int descriptor = -1;
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    descriptor = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    descriptor = OpenBeside(target_, &temporary_);
  }
  if (descriptor < 0) {
    throw InputError(path, "",
                     std::string("cannot be written: ") + std::strerror(errno));
  }
  file_ = fdopen(descriptor, "wb");
  if (file_ == nullptr) {
    close(descriptor);
    if (!temporary_.empty()) unlink(temporary_.c_str());
    Fail();
  }
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void AtomicFile::Fail() const {
  throw std::runtime_error(
      Printable(path_ + ": cannot be written: " + std::strerror(errno), 1000));
}

void AtomicFile::Write(const char* data, size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) Fail();
}

void AtomicFile::Commit() {
  if (std::fflush(file_) != 0) Fail();  // the destructor removes the rest
  std::FILE* const file = file_;
  file_ = nullptr;
  const bool closed = std::fclose(file) == 0;
  if (temporary_.empty()) {
    if (!closed) Fail();
    return;
  }
  if (!closed || std::rename(temporary_.c_str(), target_.c_str()) != 0) {
    const int reason = errno;
    unlink(temporary_.c_str());
    errno = reason;
    Fail();
  }
}

}  // namespace kinegraph
