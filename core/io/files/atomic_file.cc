#include "core/io/files/atomic_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/input_files.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// ---- What is being written and does not have its final name yet ----

enum class PartialKind { kFile, kFolder, kFolderToFill };

struct PartialList {
  // Recursive: memory may run out while it is held, and what is half-written is
  // removed there and then.
  std::recursive_mutex mutex;
  std::map<std::string, PartialKind> partial;            // by path
  std::set<std::string> looked_through;                  // folders
  std::map<std::string, std::vector<std::string>> left;  // by target
};

// Never destroyed: the thread that removes files may outlive main.
PartialList& ThePartialList() {
  static PartialList* const list = new PartialList;
  return *list;
}

// A folder's own files come after it in the order of paths, so whoever removes
// many goes from behind.
void RemovePath(const std::string& path, PartialKind kind) {
  std::error_code ignored;
  switch (kind) {
    case PartialKind::kFile:
      RemoveFile(path);
      return;
    case PartialKind::kFolder:
      // Another thread may be making folders in it at this very moment.
      for (int attempt = 0; attempt < 100; ++attempt) {
        fs::remove_all(path, ignored);
        if (!ignored) return;
      }
      return;
    case PartialKind::kFolderToFill:
      RemoveEmptyFolder(path);  // refuses a folder with anything in it
      return;
  }
}

// Removes what is on the list, with all that is in it, and takes it off.
void RemovePartial(const std::string& path) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const auto at = list.partial.find(path);
  if (at == list.partial.end()) return;
  RemovePath(at->first, at->second);
  list.partial.erase(at);
}

// The process in the name of what one left of `*target`; 0 for other names.
int64_t MakerOf(const std::string& path, std::string* target) {
  constexpr std::string_view kMark = ".partial-";
  const size_t mark = path.rfind(kMark);
  if (mark == std::string::npos) return 0;
  *target = path.substr(0, mark);
  const std::string made = path.substr(mark + kMark.size());
  const size_t hyphen = made.find('-', 1);
  if (hyphen == std::string::npos) return 0;
  return ParseNumber<int64_t>(made.substr(0, hyphen)).value_or(0);
}

void LookThrough(const std::string& folder, PartialList* list) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    std::string target;
    const std::string path = at->path().string();
    const int64_t process = MakerOf(path, &target);
    if (process > 0 && !IsRunning(process)) list->left[target].push_back(path);
  }
}

// Removes what runs that were killed have left of `target`,
// TARGET.partial-PROCESS-N, where that process is no more and nobody holds a
// lock on it. A folder is looked through once a process.
void SweepLeftovers(const std::string& target) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const fs::path path(target);
  const std::string folder =
      path.has_parent_path() ? path.parent_path().string() : ".";
  if (list.looked_through.insert(folder).second) LookThrough(folder, &list);
  const auto left =
      list.left.find((fs::path(folder) / path.filename()).string());
  if (left == list.left.end()) return;
  for (const std::string& one : left->second) {
    const Descriptor opened(OpenToRead(one));
    if (opened.get() < 0 || !LockFile(opened.get())) continue;
    std::error_code ignored;
    fs::remove_all(one, ignored);
  }
  list.left.erase(left);
}

// Makes a new file (open with O_EXCL, so a planted link is never followed) or a
// new folder, and puts it on the list. The file's descriptor, or 0; -1 and
// errno when the system refuses.
int MakePartial(const std::string& path, PartialKind kind) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const auto [at, is_new] = list.partial.emplace(path, kind);
  const int outcome =
      kind == PartialKind::kFile ? OpenNew(path) : MakeOneFolder(path);
  if (outcome < 0 && is_new) list.partial.erase(at);
  return outcome;
}

// The same beside `target`, under the name that `*temporary` gets.
int MakeBeside(const std::string& target, PartialKind kind,
               std::string* temporary) {
  SweepLeftovers(target);
  constexpr int kAttempts = 1000;  // leftovers that are still there
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    *temporary = target + ".partial-" + std::to_string(ProcessNumber()) + "-" +
                 std::to_string(attempt);
    const int outcome = MakePartial(*temporary, kind);
    if (outcome >= 0 || errno != EEXIST) return outcome;
  }
  return -1;
}

// Gives it its final name and takes it off the list; 0, or -1 and errno.
int RenamePartial(const std::string& path, const std::string& final_name) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const int outcome = std::rename(path.c_str(), final_name.c_str());
  if (outcome == 0) list.partial.erase(path);
  return outcome;
}

// Whether the path leads into a folder on the list, which becomes visible as a
// whole.
bool IsInsidePartialFolder(const std::string& path) {
  PartialList& list = ThePartialList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  return std::any_of(list.partial.begin(), list.partial.end(),
                     [&path](const auto& one) {
                       const std::string& folder = one.first;
                       return one.second == PartialKind::kFolder &&
                              path.size() > folder.size() &&
                              path.compare(0, folder.size(), folder) == 0 &&
                              path[folder.size()] == '/';
                     });
}

// ---- Where a path leads ----

// The number of an open file that the path stands for: /dev/stdout leads to
// /proc/self/fd/1. Opening such a path again would give a file of its own,
// which knows nothing of >> and of what was written before.
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

[[noreturn]] void Fail(const std::string& path, const char* what) {
  throw std::runtime_error(
      Printable(path + ": " + what + ": " + std::strerror(errno), 1000));
}

constexpr const char* kCannotWrite = "cannot be written";
constexpr const char* kCannotMake = "cannot be made";

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
  Refuse(path, kCannotWrite, ELOOP);
}

std::string WithoutTrailingSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

thread_local CommitTogether* current_together = nullptr;

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
  } else if (!present.has_value() || present->kind == FileType::kRegular) {
    if (present.has_value()) RefuseInput();
    if (present.has_value() && !CanBeWritten(target_)) {
      Refuse(path, kCannotWrite, errno);
    }
    // With the permissions that the user's umask gives (mkstemp would make it
    // private).
    descriptor = MakeBeside(target_, PartialKind::kFile, &temporary_);
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
  if (descriptor < 0) Refuse(path, kCannotWrite, errno);
  file_ = StreamOf(descriptor, "wb");
  if (file_ == nullptr) {
    const int reason = errno;
    CloseFile(descriptor);
    RemovePartial(temporary_);
    errno = reason;
    Fail(path, kCannotWrite);
  }
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  RemovePartial(temporary_);
}

void AtomicFile::RefuseInput() const {
  if (!InputFiles::Has(target_)) return;
  throw InputError(path_, "",
                   "is an input of this command and would be lost; name "
                   "another file to write");
}

void AtomicFile::Write(const char* data, size_t size) {
  if (std::fwrite(data, 1, size, file_) != size) Fail(path_, kCannotWrite);
}

void AtomicFile::Flush() {
  if (std::fflush(file_) != 0) Fail(path_, kCannotWrite);
}

void AtomicFile::Commit() {
  Flush();  // where it fails, the destructor removes the rest
  if (!temporary_.empty()) {
    RefuseInput();  // files that were read since the beginning
    // After a power cut the name must not lead to a file whose bytes never
    // reached the disk. A folder that appears as a whole does this once.
    if (!IsInsidePartialFolder(target_) && SyncFile(DescriptorOf(file_)) != 0) {
      Fail(path_, kCannotWrite);
    }
  }
  std::FILE* const file = file_;
  file_ = nullptr;
  const bool closed = std::fclose(file) == 0;
  if (closed && (temporary_.empty() ||
                 CommitTogether::Appear(path_, temporary_, target_) == 0)) {
    return;
  }
  const int reason = errno;
  RemovePartial(temporary_);
  errno = reason;
  Fail(path_, kCannotWrite);
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

// ---- Folders ----

AtomicFolder::AtomicFolder(const std::string& path)
    : target_(WithoutTrailingSlashes(path)) {
  if (path.empty()) throw InputError("an output folder has an empty name");
  std::error_code error;
  if (fs::exists(fs::symlink_status(target_, error)) &&
      !(fs::is_directory(fs::symlink_status(target_, error)) &&
        fs::is_empty(target_, error) && !error)) {
    throw InputError(path, "",
                     "is there already, expected the name of a new folder");
  }
  if (MakeBeside(target_, PartialKind::kFolder, &temporary_) < 0) {
    Refuse(path, kCannotMake, errno);
  }
  lock_ = std::make_unique<Descriptor>(OpenToRead(temporary_));
  LockFile(lock_->get());  // best effort: against being swept
}

AtomicFolder::~AtomicFolder() {
  if (!committed_) RemovePartial(temporary_);
}

void AtomicFolder::Commit() {
  if (SyncTree(temporary_) != 0 ||
      CommitTogether::Appear(target_, temporary_, target_) != 0) {
    Fail(target_, kCannotMake);
  }
  committed_ = true;
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  if (path.empty()) throw InputError("an output folder has an empty name");
  const std::string target = WithoutTrailingSlashes(path);
  for (size_t slash = target.find('/', 1);;
       slash = target.find('/', slash + 1)) {
    const std::string folder = target.substr(0, slash);
    if (MakePartial(folder, PartialKind::kFolderToFill) == 0) {
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
  std::for_each(made_.rbegin(), made_.rend(), RemovePartial);
}

void CheckFileName(const std::string& name, const std::string& what) {
  constexpr size_t kLongest = 200;  // of 255, so that endings have room
  const bool has_control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
  });
  if (name.empty() || name.front() == '.' || name.size() > kLongest ||
      has_control || name.find('/') != std::string::npos) {
    throw InputError("the " + what + " '" + Printable(name) +
                     "' cannot be the name of a file");
  }
}

// ---- CommitTogether ----

CommitTogether::CommitTogether() : outer_(current_together) {
  current_together = this;
}

CommitTogether::~CommitTogether() {
  current_together = outer_;
  for (const Waiting& one : waiting_) RemovePartial(one.temporary);
}

std::string CommitTogether::WaitingAt(const std::string& path) const {
  for (const Waiting& one : waiting_) {
    if (one.path == path) return one.temporary;
  }
  return path;
}

int CommitTogether::Appear(const std::string& path,
                           const std::string& temporary,
                           const std::string& target) {
  const bool is_inside = IsInsidePartialFolder(target);
  if (current_together != nullptr && !is_inside) {
    // The first waits at the end, which is renamed last.
    std::vector<Waiting>& waiting = current_together->waiting_;
    const auto place = waiting.empty() ? waiting.end() : waiting.end() - 1;
    waiting.insert(place, {path, temporary, target});
    return 0;
  }
  if (RenamePartial(temporary, target) != 0) return -1;
  if (!is_inside) SyncFolderOf(target);
  return 0;
}

// A name of which the rest did not come leads to nothing.
void CommitTogether::TakeBack(size_t renamed) {
  std::error_code ignored;
  for (size_t i = 0; i < renamed; ++i) {
    fs::remove_all(waiting_[i].target, ignored);
  }
}

void CommitTogether::Commit() {
  for (const std::string& path : old_) RemoveFile(path);
  for (size_t i = 0; i < waiting_.size(); ++i) {
    const Waiting& one = waiting_[i];
    if (RenamePartial(one.temporary, one.target) == 0) continue;
    const int reason = errno;
    TakeBack(i);
    errno = reason;
    Fail(one.path, kCannotWrite);
  }
  for (const Waiting& one : waiting_) SyncFolderOf(one.target);
  waiting_.clear();
}

void RemovePartialFilesForGood() {
  PartialList& list = ThePartialList();
  list.mutex.lock();  // and never unlocked
  for (auto at = list.partial.rbegin(); at != list.partial.rend(); ++at) {
    RemovePath(at->first, at->second);
  }
  list.partial.clear();
}

}  // namespace kinegraph
