#include "core/io/files/partial_files.h"

#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <system_error>

#include "core/system/file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

enum class PartialKind { kFile, kFolder, kFolderToFill };

struct List {
  // Recursive: memory may run out while it is held, and what is half-written is
  // removed there and then.
  std::recursive_mutex mutex;
  std::map<std::string, PartialKind> partial;  // by path
};

// Never destroyed: the thread that removes files may outlive main.
List& TheList() {
  static List* const list = new List;
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

int MakeListedFolder(const std::string& path, PartialKind kind) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const auto [at, is_new] = list.partial.emplace(path, kind);
  const int outcome = MakeOneFolder(path);
  if (outcome != 0 && is_new) list.partial.erase(at);
  return outcome;
}

}  // namespace

int PartialFiles::OpenNew(const std::string& path) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const auto [at, is_new] = list.partial.emplace(path, PartialKind::kFile);
  const int descriptor = kinegraph::OpenNew(path);
  if (descriptor < 0 && is_new) list.partial.erase(at);
  return descriptor;
}

int PartialFiles::MakeFolder(const std::string& path) {
  return MakeListedFolder(path, PartialKind::kFolder);
}

int PartialFiles::MakeFolderToFill(const std::string& path) {
  return MakeListedFolder(path, PartialKind::kFolderToFill);
}

int PartialFiles::Rename(const std::string& path,
                         const std::string& final_name) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const int outcome = std::rename(path.c_str(), final_name.c_str());
  if (outcome == 0) list.partial.erase(path);
  return outcome;
}

void PartialFiles::Keep(const std::string& path) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  list.partial.erase(path);
}

void PartialFiles::Remove(const std::string& path) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  const auto at = list.partial.find(path);
  if (at == list.partial.end()) return;
  RemovePath(at->first, at->second);
  list.partial.erase(at);
}

bool PartialFiles::IsInsideFolder(const std::string& path) {
  List& list = TheList();
  const std::lock_guard<std::recursive_mutex> lock(list.mutex);
  for (const auto& [folder, kind] : list.partial) {
    if (kind == PartialKind::kFolder && path.size() > folder.size() &&
        path.compare(0, folder.size(), folder) == 0 &&
        path[folder.size()] == '/') {
      return true;
    }
  }
  return false;
}

void PartialFiles::RemoveAllForGood() {
  List& list = TheList();
  list.mutex.lock();  // and never unlocked
  for (auto at = list.partial.rbegin(); at != list.partial.rend(); ++at) {
    RemovePath(at->first, at->second);
  }
  list.partial.clear();
}

}  // namespace kinegraph
