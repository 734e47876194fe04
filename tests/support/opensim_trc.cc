#include "tests/support/opensim_trc.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

#include "core/io/files/text_file.h"

namespace kinegraph::testing {
namespace {

using ::testing::AssertionFailure;
using ::testing::AssertionResult;
using ::testing::AssertionSuccess;
using Cells = std::vector<std::string>;

Cells CellsOf(const std::string& line) {
  Cells cells;
  size_t begin = 0;
  for (size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = line.find_first_of("\t\r", begin);
    cells.push_back(line.substr(begin, end - begin));
  }
  if (cells.back().empty()) cells.pop_back();
  return cells;
}

Cells WithoutEmpty(Cells cells) {
  cells.erase(std::remove(cells.begin(), cells.end(), ""), cells.end());
  return cells;
}

AssertionResult HeaderIsRead(const std::vector<Cells>& lines, size_t* markers) {
  const Cells keys = {"DataRate",           "CameraRate",   "NumFrames",
                      "NumMarkers",         "Units",        "OrigDataRate",
                      "OrigDataStartFrame", "OrigNumFrames"};
  if (lines.size() < 5 || lines[0].empty() || lines[0][0] != "PathFileType") {
    return AssertionFailure() << "no header that begins with PathFileType";
  }
  const Cells values = WithoutEmpty(lines[2]);
  if (WithoutEmpty(lines[1]) != keys || values.size() != keys.size()) {
    return AssertionFailure() << "the header has other keys than expected, or "
                                 "not one value for each";
  }
  *markers = std::stoul(values[3]);
  const Cells names = WithoutEmpty(lines[3]);
  if (names.size() != 2 + *markers || names[0] != "Frame#" ||
      names[1] != "Time") {
    return AssertionFailure() << "line 4 does not name Frame#, Time and "
                              << *markers << " markers";
  }
  Cells axes;
  for (size_t m = 1; m <= *markers; ++m) {
    for (const char* axis : {"X", "Y", "Z"}) {
      axes.push_back(axis + std::to_string(m));
    }
  }
  if (WithoutEmpty(lines[4]) != axes) {
    return AssertionFailure() << "line 5 does not name X1, Y1, Z1, X2, ...";
  }
  return AssertionSuccess();
}

AssertionResult FileIsRead(const std::string& path) {
  std::istringstream text(ReadBytes(path));
  std::vector<Cells> lines;
  for (std::string line; std::getline(text, line);) {
    lines.push_back(CellsOf(line));
  }
  size_t markers = 0;
  const AssertionResult header = HeaderIsRead(lines, &markers);
  if (!header) return AssertionFailure() << path << ": " << header.message();
  size_t rows = 0;
  for (size_t i = 5; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    ++rows;
    if (lines[i].size() == 2 + 3 * markers) continue;
    return AssertionFailure()
           << path << ": line " << i + 1 << " has " << lines[i].size()
           << " cells, expected " << 2 + 3 * markers;
  }
  if (rows == std::stoul(WithoutEmpty(lines[2])[2])) return AssertionSuccess();
  return AssertionFailure() << path << ": NumFrames is not " << rows;
}

}  // namespace

AssertionResult OpenSimReads(const std::string& path) {
  if (!IsFolder(path)) return FileIsRead(path);
  size_t files = 0;
  for (const std::string& name : ListFolder(path)) {
    if (std::filesystem::path(name).extension() != ".trc") continue;
    ++files;
    AssertionResult read = FileIsRead(path + "/" + name);
    if (!read) return read;
  }
  if (files > 0) return AssertionSuccess();
  return AssertionFailure() << path << " holds no .trc";
}

}  // namespace kinegraph::testing
