#include "core/io/files/atomic_file.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/io/files/commit_together.h"
#include "core/io/files/input_files.h"
#include "core/io/files/partial_files.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// Opens a new file beside `target`, with the permissions the user's umask
// gives (mkstemp would make it private).
int OpenBeside(const std::string& target, std::string* temporary) {
  PartialFiles::SweepLeftovers(target);
  constexpr int kAttempts = 1000;  // leftovers that are still there
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    *temporary = target + ".partial-" + std::to_string(ProcessNumber()) + "-" +
                 std::to_string(attempt);
    const int descriptor = PartialFiles::OpenNew(*temporary);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
  return -1;
}

// The number of an open file that the path stands for: /dev/stdout leads to
// /proc/self/fd/1. Opening such a path again would give a file of its own,
// which knows nothing of >> and of what was written before.
std::optional<int> OpenFileNamed(const fs::path& path) {
  std::error_code error;
  const std::string folder =
      fs::canonical(path.parent_path(), error).string();  // /proc/PID/fd
  if (error || folder != FolderOfOpenFiles()) return std::nullopt;
  const std::string name = path.filename().string();
  const char* const end = name.data() + name.size();
  int descriptor = -1;
  const auto [stop, status] = std::from_chars(name.data(), end, descriptor);
  if (status != std::errc() || stop != end) return std::nullopt;
  return descriptor;
}

// Where a path leads.
struct Destination {
  std::string path;              // the last one, no link itself
  std::optional<int> open_file;  // the path names an open file of this process
};

// Follows links one by one, so that one to nothing is followed too.
Destination Follow(const std::string& path) {
  constexpr int kMaxLinks = 40;  // as the kernel has it
  fs::path at = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    if (const auto open_file = OpenFileNamed(at)) return {path, open_file};
    std::error_code error;
    const fs::path next = fs::read_symlink(at, error);
    if (error) return {at.string(), std::nullopt};  // no link
    at = next.is_absolute() ? next : at.parent_path() / next;
  }
  throw InputError(path, "",
                   "cannot be written: " + std::string(strerror(ELOOP)));
}

[[noreturn]] void Refuse(const std::string& path, int reason) {
  throw InputError(path, "",
                   std::string("cannot be written: ") + std::strerror(reason));
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  if (path.empty()) throw InputError("an output file has an empty name");
  const Destination destination = Follow(path);
  target_ = destination.path;
  int descriptor = -1;
  const auto present = StatusOf(target_);
  if (destination.open_file.has_value()) {
    descriptor = Duplicate(*destination.open_file);
  } else if (!present.has_value() || present->kind == FileType::kRegular) {
    if (present.has_value()) RefuseInput();
    if (present.has_value() && !CanBeWritten(target_)) Refuse(path, errno);
    descriptor = OpenBeside(target_, &temporary_);
    if (descriptor >= 0) LockFile(descriptor);  // best effort, too
    // Best effort: some file systems have no permissions.
    if (present.has_value() && descriptor >= 0 &&
        !SetPermissions(descriptor, present->permissions)) {
      errno = 0;
    }
  } else if (present->kind == FileType::kFolder) {
    throw InputError(path, "", "is a folder, expected a file to write");
  } else if (present->kind == FileType::kBlockDevice) {
    throw InputError(path, "", "is a block device, expected a file to write");
  } else {
    descriptor = OpenToWrite(target_);
  }
  if (descriptor < 0) Refuse(path, errno);
  file_ = StreamOf(descriptor, "wb");
  if (file_ == nullptr) {
    const int reason = errno;
    CloseFile(descriptor);
    if (!temporary_.empty()) PartialFiles::Remove(temporary_);
    errno = reason;
    Fail();
  }
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  if (!temporary_.empty()) PartialFiles::Remove(temporary_);
}

void AtomicFile::Fail() const {
  throw std::runtime_error(
      Printable(path_ + ": cannot be written: " + std::strerror(errno), 1000));
}

void AtomicFile::RefuseInput() const {
  if (!InputFiles::Has(target_)) return;
  throw InputError(path_, "",
                   "is an input of this command and would be lost; name "
                   "another file to write");
}

void AtomicFile::Write(const char* data, size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) Fail();
}

void AtomicFile::Flush() {
  if (std::fflush(file_) != 0) Fail();
}

void AtomicFile::Commit() {
  Flush();  // where it fails, the destructor removes the rest
  if (!temporary_.empty()) {
    RefuseInput();  // files that were read since the beginning
    // After a power cut the name must not lead to a file whose bytes never
    // reached the disk. A folder that appears as a whole does this once.
    if (!PartialFiles::IsInsideFolder(temporary_) &&
        SyncFile(DescriptorOf(file_)) != 0) {
      Fail();
    }
  }
  std::FILE* const file = file_;
  file_ = nullptr;
  const bool closed = std::fclose(file) == 0;
  if (temporary_.empty()) {
    if (!closed) Fail();
    return;
  }
  const bool is_inside = PartialFiles::IsInsideFolder(target_);
  if (closed && !is_inside &&
      CommitTogether::Take(path_, temporary_, target_)) {
    return;
  }
  if (!closed || PartialFiles::Rename(temporary_, target_) != 0) {
    const int reason = errno;
    PartialFiles::Remove(temporary_);
    errno = reason;
    Fail();
  }
  if (!is_inside) SyncFolderOf(target_);
}

bool IsStandardOutput(const std::string& path) {
  const auto of_stdout = StatusOf(kStandardOutput);
  if (path.empty() || !of_stdout.has_value()) return false;
  const Destination destination = Follow(path);
  if (destination.open_file.has_value()) {
    return *destination.open_file == kStandardOutput;
  }
  // A pipe or terminal by another name. A regular file is replaced, and what is
  // printed goes to the old one.
  const auto of_path = StatusOf(path);
  return of_path.has_value() && of_path->kind != FileType::kRegular &&
         of_path->number == of_stdout->number;
}

bool IsStream(const std::string& path) {
  std::error_code error;
  return IsStandardOutput(path) || fs::is_other(path, error);
}

}  // namespace kinegraph
