#include "core/io/files/commit_together.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "core/base/error.h"
#include "core/io/files/partial_files.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

thread_local CommitTogether* current = nullptr;

}  // namespace

CommitTogether::CommitTogether() : outer_(current) { current = this; }

CommitTogether::~CommitTogether() {
  current = outer_;
  for (const Waiting& one : waiting_) PartialFiles::Remove(one.temporary);
}

std::string CommitTogether::WaitingAt(const std::string& path) const {
  for (const Waiting& one : waiting_) {
    if (one.path == path) return one.temporary;
  }
  return path;
}

bool CommitTogether::Take(const std::string& path, const std::string& temporary,
                          const std::string& target) {
  if (current == nullptr) return false;
  // The first waits at the end, which is renamed last.
  std::vector<Waiting>& waiting = current->waiting_;
  const auto place = waiting.empty() ? waiting.end() : waiting.end() - 1;
  waiting.insert(place, {path, temporary, target});
  return true;
}

// A name of which the rest did not come leads to nothing.
void CommitTogether::TakeBack(size_t renamed) {
  std::error_code ignored;
  for (size_t i = 0; i < renamed; ++i) {
    std::filesystem::remove_all(waiting_[i].target, ignored);
  }
}

void CommitTogether::Commit() {
  for (const std::string& path : old_) RemoveFile(path);
  for (size_t i = 0; i < waiting_.size(); ++i) {
    const Waiting& one = waiting_[i];
    if (PartialFiles::Rename(one.temporary, one.target) == 0) continue;
    const int reason = errno;
    TakeBack(i);
    throw std::runtime_error(Printable(
        one.path + ": cannot be written: " + std::strerror(reason), 1000));
  }
  for (const Waiting& one : waiting_) SyncFolderOf(one.target);
  waiting_.clear();
}

}  // namespace kinegraph
