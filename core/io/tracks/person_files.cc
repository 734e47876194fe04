#include "core/io/tracks/person_files.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <set>

#include "core/base/error.h"
#include "core/base/split.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/names.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBegin = "person_";

// The number after the last "person_" or "_P" in a file's name.
std::optional<int64_t> PersonOf(const std::string& name) {
  for (const std::string mark : {"person_", "_P"}) {
    for (size_t at = name.rfind(mark); at != std::string::npos;
         at = at == 0 ? std::string::npos : name.rfind(mark, at - 1)) {
      const size_t begin = at + mark.size();
      size_t end = begin;
      while (end < name.size() && name[end] >= '0' && name[end] <= '9') ++end;
      if (end > begin) return LastInteger(name.substr(begin, end - begin));
    }
  }
  return std::nullopt;
}

std::vector<std::string> FilesOf(const std::string& folder,
                                 const std::string& extension) {
  std::vector<std::string> names;
  for (const std::string& name : ListFolder(folder)) {
    if (name.front() != '.' && fs::path(name).extension() == extension) {
      names.push_back(name);
    }
  }
  return names;
}

}  // namespace

std::optional<TrackId> PersonIdOf(std::string_view text) {
  int64_t id = -1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc() || stop != end || id < 0) return std::nullopt;
  return TrackId(id);
}

std::string PersonLabel(int64_t id, const PersonNames& names) {
  std::string label = std::string(kBegin) + std::to_string(id);
  const auto name = names.find(TrackId(id));
  if (name == names.end()) return label;
  constexpr size_t kMaxBytes = 100;
  std::string letters = name->second.substr(0, kMaxBytes);
  // Not in the middle of a letter of UTF-8.
  if (name->second.size() > kMaxBytes) {
    while (!letters.empty() && (letters.back() & 0x80) != 0) {
      letters.pop_back();
    }
  }
  for (char& c : letters) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte) == 0) c = '-';
  }
  return label + "_" + letters;
}

std::vector<std::string> PersonTitles(const std::vector<int64_t>& ids,
                                      const PersonNames& names) {
  std::vector<std::string> titles;
  for (const int64_t id : ids) {
    const std::string label = std::string(kBegin) + std::to_string(id);
    const auto name = names.find(TrackId(id));
    if (name == names.end()) {
      titles.push_back(label);
      continue;
    }
    const auto count = std::count_if(
        names.begin(), names.end(),
        [&](const auto& other) { return other.second == name->second; });
    titles.push_back(count > 1 ? name->second + "_" + label : name->second);
  }
  return titles;
}

std::vector<PersonFile> ListPersonFiles(const std::string& path,
                                        const std::string& extension) {
  if (!IsFolder(path)) {
    const std::string name = fs::path(path).filename().string();
    return {{path, TrackId(PersonOf(name).value_or(0))}};
  }
  const std::vector<std::string> names = FilesOf(path, extension);
  if (names.empty()) {
    throw InputError(path, "", "has no " + extension + " files");
  }
  std::vector<PersonFile> files;
  std::set<int64_t> ids;
  for (const std::string& name : names) {
    const std::optional<int64_t> id = PersonOf(name);
    if (id.has_value()) ids.insert(*id);
    files.push_back({path + "/" + name, TrackId(id.value_or(0))});
  }
  if (ids.size() == files.size()) return files;
  for (size_t i = 0; i < files.size(); ++i) {
    files[i].id = TrackId(static_cast<int64_t>(i));
  }
  return files;
}

PersonNames NamesOfPersonFiles(const std::string& path,
                               const std::string& extension) {
  PersonNames names;
  const std::vector<std::string> files = IsFolder(path)
                                             ? FilesOf(path, extension)
                                             : std::vector<std::string>{path};
  for (const std::string& file : files) {
    const std::string stem = fs::path(file).stem().string();
    const size_t end = stem.find('_', kBegin.size());
    if (stem.compare(0, kBegin.size(), kBegin) != 0 ||
        end == std::string::npos || end + 1 == stem.size()) {
      continue;
    }
    const std::optional<TrackId> id = PersonIdOf(
        std::string_view(stem).substr(kBegin.size(), end - kBegin.size()));
    if (id.has_value()) names[*id] = stem.substr(end + 1);
  }
  return names;
}

std::vector<int64_t> PeopleToWrite(const std::string& path,
                                   const std::string& extension,
                                   const TrackSequence& tracks) {
  std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty()) {
    throw InputError("the tracks have nobody in them, nothing to write");
  }
  if (EndsIn(path, extension) && ids.size() > 1) {
    throw InputError("a " + extension + " file holds one person, the tracks " +
                     "have " + std::to_string(ids.size()));
  }
  return ids;
}

void WritePersonFiles(const std::string& path, const std::string& extension,
                      const std::vector<int64_t>& ids, const PersonNames& names,
                      const std::function<void(const std::string& file,
                                               TrackId id)>& write_file) {
  if (EndsIn(path, extension)) return write_file(path, TrackId(ids.front()));
  AtomicFolder folder(path);
  for (const int64_t id : ids) {
    write_file(folder.PathOf(PersonLabel(id, names) + extension), TrackId(id));
  }
  folder.Commit();
}

}  // namespace kinegraph
