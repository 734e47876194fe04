#include "core/io/person_names.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/io/csv_cell.h"
#include "core/io/csv_rows.h"
#include "core/io/json.h"
#include "core/io/npz_reader.h"
#include "core/io/text_file.h"
#include "core/io/track_formats.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

std::optional<TrackId> IdOf(std::string_view text) {
  int64_t id = -1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, id);
  if (error != std::errc() || stop != end || id < 0) return std::nullopt;
  return TrackId(id);
}

PersonNames OfHeader(const std::string& path) {
  PersonNames names;
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return names;
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || json.count("kinegraph") == 0) return names;
  const auto entries = json.find("names");
  if (entries == json.end()) return names;
  for (const auto& [key, name] : entries->items()) {
    const std::optional<TrackId> id = IdOf(key);
    if (!entries->is_object() || !id.has_value() || !name.is_string()) {
      throw InputError(path, "names",
                       "found '" + Printable(key) + ": " +
                           Printable(name.dump()) +
                           "', expected {\"identity\": \"name\"}");
    }
    names[*id] = name.get<std::string>();
  }
  return names;
}

PersonNames OfCsv(const std::string& path) {
  PersonNames names;
  const std::string text = ReadTextFile(path);
  CsvRows rows(text);
  std::vector<std::string> cells;
  if (!rows.Next(&cells)) return names;
  const auto column = [&](const char* title) {
    return static_cast<size_t>(std::find(cells.begin(), cells.end(), title) -
                               cells.begin());
  };
  const size_t of_id = column("id");
  const size_t of_name = column("name");
  const size_t width = cells.size();
  if (of_name == width || of_id == width) return names;
  while (rows.Next(&cells)) {
    if (cells.size() != width || cells[of_name].empty()) continue;
    const std::optional<TrackId> id = IdOf(cells[of_id]);
    if (id.has_value()) names.emplace(*id, PlainCell(cells[of_name]));
  }
  return names;
}

PersonNames OfNpz(const std::string& path) {
  PersonNames names;
  const NpzReader file(path);
  if (!file.Has("names") || !file.Has("ids")) return names;
  const std::vector<std::string> of_ids = file.Texts("names", 1);
  const std::vector<int64_t> ids = file.Integers("ids", 1);
  if (of_ids.size() != ids.size()) file.Fail("names", "does not fit the ids");
  for (size_t p = 0; p < ids.size(); ++p) {
    if (!of_ids[p].empty()) names[TrackId(ids[p])] = of_ids[p];
  }
  return names;
}

// "person_3_Anna.trc" is Anna's.
PersonNames OfTrc(const std::vector<std::string>& files) {
  constexpr std::string_view kBegin = "person_";
  PersonNames names;
  for (const std::string& file : files) {
    const std::string stem = fs::path(file).stem().string();
    const size_t end = stem.find('_', kBegin.size());
    if (stem.compare(0, kBegin.size(), kBegin) != 0 ||
        end == std::string::npos || end + 1 == stem.size()) {
      continue;
    }
    const std::optional<TrackId> id =
        IdOf(std::string_view(stem).substr(kBegin.size(), end - kBegin.size()));
    if (id.has_value()) names[*id] = stem.substr(end + 1);
  }
  return names;
}

}  // namespace

PersonNames ReadPersonNames(const std::string& path) {
  if (IsPipe(path)) return {};
  if (IsFolder(path)) return OfTrc(ListTrcFiles(path));
  if (!IsFile(path)) return {};
  const std::string beginning = BeginningOf(path, 64);
  const auto begins = [&](const char* word) {
    return beginning.rfind(word, 0) == 0;
  };
  if (begins("frame,time_s,id,joint,")) return OfCsv(path);
  if (begins("PK\x03\x04")) return OfNpz(path);
  if (begins("PathFileType")) return OfTrc({path});
  return begins("{") ? OfHeader(path) : PersonNames();
}

}  // namespace kinegraph
