#include "core/io/files/atomic_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/io/files/commit_together.h"
#include "core/io/files/partial_files.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

std::string WithoutTrailingSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

}  // namespace

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
  PartialFiles::SweepLeftovers(target_);
  constexpr int kAttempts = 1000;  // leftovers that are still there
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    temporary_ = target_ + ".partial-" + std::to_string(ProcessNumber()) + "-" +
                 std::to_string(attempt);
    if (PartialFiles::MakeFolder(temporary_) == 0) {
      lock_ = std::make_unique<Descriptor>(OpenToRead(temporary_));
      LockFile(lock_->get());  // best effort: against being swept
      return;
    }
    if (errno != EEXIST) break;
  }
  throw InputError(path, "",
                   std::string("cannot be made: ") + std::strerror(errno));
}

AtomicFolder::~AtomicFolder() {
  if (!committed_) PartialFiles::Remove(temporary_);
}

void AtomicFolder::Commit() {
  const bool is_whole = SyncTree(temporary_) == 0;
  if (is_whole && CommitTogether::Take(target_, temporary_, target_)) {
    committed_ = true;
    return;
  }
  if (!is_whole || PartialFiles::Rename(temporary_, target_) != 0) {
    throw std::runtime_error(
        Printable(target_ + ": cannot be made: " + std::strerror(errno), 1000));
  }
  committed_ = true;
  SyncFolderOf(target_);
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  if (path.empty()) throw InputError("an output folder has an empty name");
  const std::string target = WithoutTrailingSlashes(path);
  for (size_t slash = target.find('/', 1);;
       slash = target.find('/', slash + 1)) {
    const std::string folder = target.substr(0, slash);
    if (PartialFiles::MakeFolderToFill(folder) == 0) {
      made_.push_back(folder);
    } else if (errno != EEXIST) {
      const int reason = errno;
      RemoveEmpty();
      throw InputError(path, "",
                       std::string("cannot be made: ") + std::strerror(reason));
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
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) {
    PartialFiles::Remove(*folder);
  }
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

}  // namespace kinegraph
