#include "core/io/files/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/input_files.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// ---- Files that do not have their final name yet ----

constexpr const char* kMark = ".partial-";

// Never destroyed: the thread that removes files may outlive main.
struct PartialList {
  std::mutex mutex;
  std::set<std::string> paths;
};
PartialList& ThePartialList() {
  static PartialList* const list = new PartialList;
  return *list;
}

void RemoveAll(const std::string& path) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

void RemovePartial(const std::string& path) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  if (list.paths.erase(path) > 0) RemoveAll(path);
}

enum class PartialKind { kFile, kFolder };

// Creates a file (open with O_EXCL, so a planted link is never followed) or a
// folder beside `target`, under the name returned in `*temporary`. Returns the
// file's descriptor, or 0 for a folder; on failure -1, and sets errno.
int MakeBeside(const std::string& target, PartialKind kind,
               std::string* temporary) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  // Names may be in use by other threads, or left by an earlier process with
  // the same number.
  constexpr int kAttempts = 1000;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    *temporary = target + kMark + std::to_string(ProcessNumber()) + "-" +
                 std::to_string(attempt);
    const int outcome = kind == PartialKind::kFile ? OpenNew(*temporary)
                                                   : MakeOneFolder(*temporary);
    if (outcome >= 0) list.paths.insert(*temporary);
    if (outcome >= 0 || errno != EEXIST) return outcome;
  }
  return -1;
}

// Renames a file or folder to its final name; returns 0, or -1 and sets errno.
int RenamePartial(const std::string& path, const std::string& final_name) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  const int outcome = std::rename(path.c_str(), final_name.c_str());
  if (outcome == 0) list.paths.erase(path);
  return outcome;
}

// Whether the path is in a temporary folder of AtomicFolder or AtomicFiles,
// whose Commit() flushes all files in it.
bool IsInsidePartialFolder(const std::string& path) {
  const size_t mark = path.rfind(kMark + std::to_string(ProcessNumber()) + "-");
  return mark != std::string::npos && path.find('/', mark) != std::string::npos;
}

// ---- The destination of a path ----

// The descriptor of the open file to which the path refers: /dev/stdout leads
// to /proc/self/fd/1. Opening such a path again would begin at offset 0, even
// after >> or earlier output.
std::optional<int> OpenFileNamed(const fs::path& path) {
  std::error_code error;
  const std::string folder =
      fs::canonical(path.parent_path(), error).string();  // /proc/PID/fd
  if (error || folder != FolderOfOpenFiles()) return std::nullopt;
  return ParseNumber<int>(path.filename().string());
}

[[noreturn]] void Refuse(const std::string& path, const char* what,
                         int reason) {
  throw InputError(path, "", std::string(what) + ": " + std::strerror(reason));
}

[[noreturn]] void Fail(const std::string& path, const char* what,
                       int reason = errno) {
  throw std::runtime_error(
      Printable(path + ": " + what + ": " + std::strerror(reason), 1000));
}

constexpr const char* kCannotWrite = "cannot be written";
constexpr const char* kCannotMake = "cannot be created";

struct Destination {
  // The final target, not a link; for an open file the path as given.
  std::string path;
  // Set if the path names an open file of this process.
  std::optional<int> open_file;
};

// Resolves links one by one, including links to a missing file.
Destination Follow(const std::string& path) {
  constexpr int kMaxLinks = 40;  // as in the kernel
  fs::path at = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    if (const auto open_file = OpenFileNamed(at)) return {path, open_file};
    std::error_code error;
    const fs::path next = fs::read_symlink(at, error);
    if (error) return {at.string(), std::nullopt};  // not a link
    at = next.is_absolute() ? next : at.parent_path() / next;
  }
  Refuse(path, kCannotWrite, ELOOP);
}

std::string WithoutTrailingSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

void RefuseInput(const std::string& path, const std::string& target) {
  if (!InputFiles::Has(target)) return;
  throw InputError(path, "",
                   "is an input of this command and would be overwritten; "
                   "give another file to write");
}

// Throws InputError unless a file can be written to `target`.
void CheckReplaceable(const std::string& path, const std::string& target,
                      const std::optional<FileStatus>& present) {
  if (!present.has_value()) return;
  if (present->kind == FileType::kFolder) {
    throw InputError(path, "", "is a folder, expected a file to write");
  }
  if (present->kind == FileType::kBlockDevice) {
    throw InputError(path, "", "is a block device, expected a file to write");
  }
  if (present->kind != FileType::kRegular) return;
  RefuseInput(path, target);
  if (!CanBeWritten(target)) Refuse(path, kCannotWrite, errno);
}

// Throws InputError unless `target` does not exist or is an empty folder.
void CheckNewFolder(const std::string& path, const std::string& target) {
  if (path.empty()) throw InputError("an output folder has an empty name");
  std::error_code error;
  const fs::file_status present = fs::symlink_status(target, error);
  if (!fs::exists(present)) return;
  if (fs::is_directory(present) && fs::is_empty(target, error) && !error) {
    return;
  }
  throw InputError(path, "",
                   "exists already, expected the name of a new folder");
}

// Flushes a file, or a folder with its contents, to disk.
int SyncPath(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return SyncTree(path);
  const Descriptor file(OpenToRead(path));
  return file.get() < 0 ? -1 : SyncFile(file.get());
}

}  // namespace

// ---- AtomicFile ----

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  if (path.empty()) throw InputError("an output file has an empty name");
  const Destination destination = Follow(path);
  target_ = destination.path;
  int descriptor = -1;
  const auto present = StatusOf(target_);
  if (destination.open_file.has_value()) {
    descriptor = Duplicate(*destination.open_file);
  } else if (CheckReplaceable(path, target_, present);
             !present.has_value() || present->kind == FileType::kRegular) {
    // Permissions follow the umask, unlike those of mkstemp, which makes files
    // private.
    descriptor = MakeBeside(target_, PartialKind::kFile, &temporary_);
    // Best effort: some file systems have no permissions.
    if (present.has_value() && descriptor >= 0) {
      SetPermissions(descriptor, present->permissions);
    }
  } else {
    descriptor = OpenToWrite(target_);
  }
  if (descriptor < 0) Refuse(path, kCannotWrite, errno);
  file_ = StreamOf(descriptor, "wb");
  if (file_ == nullptr) {
    const int reason = errno;
    CloseFile(descriptor);
    RemovePartial(temporary_);
    Fail(path, kCannotWrite, reason);
  }
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  RemovePartial(temporary_);
}

void AtomicFile::Write(const char* data, size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) Fail(path_, kCannotWrite);
}

void AtomicFile::Flush() {
  if (std::fflush(file_) != 0) Fail(path_, kCannotWrite);
}

void AtomicFile::Commit() {
  Flush();  // if it fails, the destructor removes the rest
  if (!temporary_.empty()) {
    RefuseInput(path_, target_);  // may have been read meanwhile
    // Without this, the name could refer to a file without its bytes after a
    // power failure.
    if (!IsInsidePartialFolder(target_) && SyncFile(DescriptorOf(file_)) != 0) {
      Fail(path_, kCannotWrite);
    }
  }
  std::FILE* const file = file_;
  file_ = nullptr;
  const bool closed = std::fclose(file) == 0;
  if (closed &&
      (temporary_.empty() || RenamePartial(temporary_, target_) == 0)) {
    if (!IsInsidePartialFolder(target_)) SyncFolderOf(target_);
    return;
  }
  const int reason = errno;
  RemovePartial(temporary_);
  Fail(path_, kCannotWrite, reason);
}

void WriteTextFile(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Write(text);
  file.Commit();
}

bool IsStandardOutput(const std::string& path) {
  const auto of_stdout = StatusOf(kStandardOutput);
  if (path.empty() || !of_stdout.has_value()) return false;
  const Destination destination = Follow(path);
  if (destination.open_file.has_value()) {
    return *destination.open_file == kStandardOutput;
  }
  // A pipe or terminal under another name. False for a regular file, since the
  // path gets a new file while printed output goes to the old one.
  const auto of_path = StatusOf(path);
  return of_path.has_value() && of_path->kind != FileType::kRegular &&
         of_path->number == of_stdout->number;
}

bool IsStream(const std::string& path) {
  std::error_code error;
  return IsStandardOutput(path) || fs::is_other(path, error);
}

// ---- Folders ----

AtomicFolder::AtomicFolder(const std::string& path)
    : target_(WithoutTrailingSlashes(path)) {
  CheckNewFolder(path, target_);
  if (MakeBeside(target_, PartialKind::kFolder, &temporary_) < 0) {
    Refuse(path, kCannotMake, errno);
  }
}

AtomicFolder::~AtomicFolder() {
  if (!committed_) RemovePartial(temporary_);
}

void AtomicFolder::Commit() {
  if (SyncTree(temporary_) != 0 || RenamePartial(temporary_, target_) != 0) {
    Fail(target_, kCannotMake);
  }
  SyncFolderOf(target_);
  committed_ = true;
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  if (path.empty()) throw InputError("an output folder has an empty name");
  const std::string target = WithoutTrailingSlashes(path);
  for (size_t slash = target.find('/', 1);;
       slash = target.find('/', slash + 1)) {
    const std::string folder = target.substr(0, slash);
    if (MakeOneFolder(folder) == 0) {
      made_.push_back(folder);
    } else if (errno != EEXIST) {
      const int reason = errno;
      RemoveEmpty();
      Refuse(path, kCannotMake, reason);
    }
    if (slash == std::string::npos) break;
  }
  std::error_code error;
  if (!fs::is_directory(target, error)) {
    throw InputError(path, "", "is a file, expected a folder");
  }
}

OutputFolder::~OutputFolder() { RemoveEmpty(); }

void OutputFolder::RemoveEmpty() {
  std::for_each(made_.rbegin(), made_.rend(), RemoveEmptyFolder);
}

void CheckFileName(const std::string& name, const std::string& what) {
  constexpr size_t kLongest = 200;  // of at most 255, for suffixes
  const bool has_control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
  });
  if (name.empty() || name.front() == '.' || name.size() > kLongest ||
      has_control || name.find('/') != std::string::npos) {
    throw InputError("the " + what + " '" + Printable(name) +
                     "' cannot be the name of a file");
  }
}

// ---- AtomicFiles ----

AtomicFiles::~AtomicFiles() {
  for (const auto& [folder, aside] : aside_) RemovePartial(aside);
}

std::string AtomicFiles::AsideOf(const std::string& path,
                                 const std::string& target) {
  const fs::path name(target);
  std::string& aside = aside_[name.parent_path().string()];
  if (aside.empty() && MakeBeside(target, PartialKind::kFolder, &aside) < 0) {
    aside.clear();
    Refuse(path, kCannotWrite, errno);
  }
  const std::string temporary = aside + "/" + name.filename().string();
  waiting_.push_back({path, temporary, target});
  return temporary;
}

std::string AtomicFiles::Aside(const std::string& path) {
  for (const Waiting& one : waiting_) {
    if (one.path == path) return one.temporary;
  }
  if (path.empty()) throw InputError("an output file has an empty name");
  if (IsStream(path)) return path;
  const Destination destination = Follow(path);
  if (destination.open_file.has_value()) return path;
  CheckReplaceable(path, destination.path, StatusOf(destination.path));
  return AsideOf(path, destination.path);
}

std::string AtomicFiles::FolderAside(const std::string& path) {
  for (const Waiting& one : waiting_) {
    if (one.path == path) return one.temporary;
  }
  const std::string target = WithoutTrailingSlashes(path);
  CheckNewFolder(path, target);
  return AsideOf(path, target);
}

void AtomicFiles::RemoveOld(const std::string& path) {
  old_.push_back(Follow(path).path);
}

void AtomicFiles::Commit() {
  std::error_code ignored;
  const auto is_unwritten = [&](const Waiting& one) {
    return !fs::exists(one.temporary, ignored);
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), is_unwritten),
                 waiting_.end());
  for (const Waiting& one : waiting_) {
    RefuseInput(one.path, one.target);  // may have been read meanwhile
    const fs::file_status present = fs::status(one.target, ignored);
    if (fs::is_regular_file(present)) {
      fs::permissions(one.temporary, present.permissions(), ignored);
    }
    if (SyncPath(one.temporary) != 0) Fail(one.path, kCannotWrite);
  }
  // RemovePartialFilesForGood waits until all files have their final names.
  PartialList& list = ThePartialList();
  const std::lock_guard<std::mutex> lock(list.mutex);
  for (const std::string& path : old_) RemoveFile(path);
  for (auto one = waiting_.rbegin(); one != waiting_.rend(); ++one) {
    if (std::rename(one->temporary.c_str(), one->target.c_str()) != 0) {
      Fail(one->path, kCannotWrite);
    }
    SyncFolderOf(one->target);
  }
  for (const auto& [folder, aside] : aside_) {
    RemoveEmptyFolder(aside);
    list.paths.erase(aside);
  }
  aside_.clear();
  waiting_.clear();
}

void RemovePartialFilesForGood() {
  PartialList& list = ThePartialList();
  list.mutex.lock();  // never unlocked
  for (const std::string& path : list.paths) RemoveAll(path);
}

}  // namespace kinegraph
