#include "core/io/files/partial_files.h"

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <vector>

#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

enum class PartialKind { kFile, kFolder, kFolderToFill };

struct List {
  // Recursive: memory may run out while it is held, and what is half-written is
  // removed there and then.
  std::recursive_mutex mutex;
  std::map<std::string, PartialKind> partial;            // by path
  std::set<std::string> looked_through;                  // folders
  std::map<std::string, std::vector<std::string>> left;  // by target
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

// The process in the name of what one left of `*target`; 0 for other names.
int64_t MakerOf(const std::string& path, std::string* target) {
  constexpr std::string_view kMark = ".partial-";
  const size_t mark = path.rfind(kMark);
  if (mark == std::string::npos) return 0;
  *target = path.substr(0, mark);
  int64_t process = 0;
  const char* const end = path.data() + path.size();
  const char* const begin = path.data() + mark + kMark.size();
  const auto [stop, error] = std::from_chars(begin, end, process);
  return error == std::errc() && stop != end && *stop == '-' ? process : 0;
}

void LookThrough(const std::string& folder, List* list) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    std::string target;
    const std::string path = at->path().string();
    const int64_t process = MakerOf(path, &target);
    if (process > 0 && !IsRunning(process)) list->left[target].push_back(path);
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

void PartialFiles::SweepLeftovers(const std::string& target) {
  List& list = TheList();
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
