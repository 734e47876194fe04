// TRC of OpenSim and Pose2Sim: tab-separated; the second and third line name
// and give the header's values, the fourth names a marker over each three
// columns, the fifth their coordinates; then a row a frame. Empty cells and NaN
// are markers without position. One file is one person: the number after
// "person_" (ours) or "_P" (Pose2Sim) in its name. Rows are frames, from the
// one on that the first row's time tells.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr std::string_view kTrcMark = "PathFileType";
constexpr const char* kTrcExtension = ".trc";

// Lines without what ends them, blank ones left out.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  bool Next(std::vector<std::string_view>* cells) {
    std::string_view line;
    while (line.find_first_not_of("\t\r ") == std::string_view::npos) {
      if (rest_.empty()) return false;
      const size_t end = std::min(rest_.find('\n'), rest_.size());
      line = rest_.substr(0, end);
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++number_;
    }
    if (line.back() == '\r') line.remove_suffix(1);
    cells->clear();
    for (size_t begin = 0; begin <= line.size();) {
      const size_t end = std::min(line.find('\t', begin), line.size());
      cells->push_back(line.substr(begin, end - begin));
      begin = end + 1;
    }
    return true;
  }

  std::string Place() const { return "line " + std::to_string(number_); }

 private:
  std::string_view rest_;
  int64_t number_ = 0;
};

// nullopt for an empty cell and NaN.
std::optional<double> NumberOf(std::string_view cell) {
  const std::optional<double> number = NumberOfCell(cell);
  if (number.has_value() && std::isinf(*number)) {
    throw InputError("found an infinite number");
  }
  return number;
}

struct Header {
  double frame_rate_hz = 0.0;
  double metres = 1.0;  // of a unit
  int64_t first_frame = 0;
  int64_t frames = 0;
  std::vector<std::string> markers;
};

std::vector<std::string_view> NextOf(Lines* lines) {
  std::vector<std::string_view> cells;
  if (!lines->Next(&cells)) throw InputError("ends in its header");
  return cells;
}

Header ReadHeader(Lines* lines) {
  constexpr int64_t kMaxRows = 10'000'000;
  Header header;
  const std::vector<std::string_view> first = NextOf(lines);
  if (first[0].substr(0, kTrcMark.size()) != kTrcMark) {
    throw InputError("does not begin with PathFileType");
  }
  if (first[0] != kTrcMark) {
    throw InputError("expected tabulators between cells, as TRC has them");
  }
  const std::vector<std::string_view> names = NextOf(lines);
  const std::vector<std::string_view> values = NextOf(lines);
  const auto value = [&](const char* name) -> std::string_view {
    for (size_t i = 0; i < names.size() && i < values.size(); ++i) {
      if (names[i] == name) return values[i];
    }
    throw InputError("has no '" + std::string(name) + "'");
  };
  const auto number = [&](const char* name, double high) {
    const double given = NumberOf(value(name)).value_or(-1.0);
    if (given < 0.0 || given > high) {
      throw InputError(std::string(name) + ": expected 0 .. " +
                       std::to_string(static_cast<int64_t>(high)));
    }
    return given;
  };
  header.frame_rate_hz = number("DataRate", 1e6);
  header.metres = ParseLengthUnit(std::string(value("Units")), "Units");
  header.frames = static_cast<int64_t>(number("NumFrames", kMaxRows));
  header.first_frame =
      static_cast<int64_t>(number("OrigDataStartFrame", kMaxFrame));
  const auto markers = static_cast<size_t>(number("NumMarkers", 10000.0));
  const std::vector<std::string_view> titles = NextOf(lines);
  for (size_t m = 0; m < markers; ++m) {
    if (2 + 3 * m >= titles.size()) {
      throw InputError("names fewer than " + std::to_string(markers) +
                       " markers");
    }
    header.markers.emplace_back(titles[2 + 3 * m]);
  }
  if (NextOf(lines).size() < 3) throw InputError("expected X1, Y1, Z1, ...");
  return header;
}

void ReadMarkers(const std::vector<std::string_view>& cells, double metres,
                 const AxisMap& axes, Pose3d* joints) {
  for (size_t m = 0; m < joints->size(); ++m) {
    Eigen::Vector3d in_file;
    int found = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto number =
          NumberOf(cells[2 + 3 * m + static_cast<size_t>(axis)]);
      found += number.has_value() ? 1 : 0;
      in_file[axis] = number.value_or(0.0) * metres;
    }
    if (found == 0) continue;
    if (found < 3) throw InputError("a marker has only some coordinates");
    (*joints)[m] = {axes.Invert(in_file), JointStatus::kObserved};
  }
}

// The frame of the first row. Its time tells it: programs that trim a recording
// keep the times, and number rows and OrigDataStartFrame anew, from 0 or from
// 1. A quarter of a frame is what rounding of times and rates may cost. Times
// that begin anew themselves, or lie between frames, tell nothing; then the
// header does, which counts from 0 here and in Pose2Sim, whose rows and times
// count from 1, and from 1 in laboratories' files.
int64_t FirstFrame(const Header& header, double time_s, double row_number) {
  const double by_time = time_s * header.frame_rate_hz;
  const double nearest = std::round(by_time);
  const auto start = static_cast<double>(header.first_frame);
  if (std::abs(by_time - start) < 0.75) return header.first_frame;
  if (std::abs(by_time - nearest) > 0.25 || nearest < 0.0 ||
      nearest > static_cast<double>(kMaxFrame)) {
    return header.first_frame;
  }
  const bool begins_anew =
      nearest == 0.0 || (nearest == 1.0 && row_number == 1.0);
  if (begins_anew && start != 1.0) return header.first_frame;
  return static_cast<int64_t>(nearest);
}

void ReadRows(const Header& header, TrackId id, const AxisMap& axes,
              Lines* lines, TrackCollector* collector) {
  std::vector<std::string_view> cells;
  int64_t first_frame = 0;
  int64_t row = 0;
  while (lines->Next(&cells)) {
    if (cells.size() < 2 + 3 * header.markers.size()) {
      throw InputError("found " + std::to_string(cells.size()) +
                       " cells, expected " +
                       std::to_string(2 + 3 * header.markers.size()));
    }
    const std::optional<double> time_s = NumberOf(cells[1]);
    if (!time_s.has_value() || std::abs(*time_s) > 1e9) {
      throw InputError("Time: expected seconds");
    }
    if (row == 0) {
      first_frame =
          FirstFrame(header, *time_s, NumberOf(cells[0]).value_or(-1.0));
    }
    const int64_t number = first_frame + row++;
    collector->Touch(number)->time = FromSeconds(*time_s);
    Pose3d joints(header.markers.size());
    ReadMarkers(cells, header.metres, axes, &joints);
    collector->AddIfSeen(number, id, std::move(joints));
  }
  if (row != header.frames) {
    throw InputError("found " + std::to_string(row) + " rows, NumFrames says " +
                     std::to_string(header.frames));
  }
}

TrackSequence ReadTracksTrc(const std::string& path,
                            const TrackReadOptions& options) {
  std::optional<TrackCollector> collector;
  std::vector<std::string> markers;  // of the first file
  for (const PersonFile& file : ListPersonFiles(path, kTrcExtension)) {
    const std::string text = ReadTextFile(file.path);
    Lines lines(text);
    Located(
        file.path, [&] { return lines.Place(); },
        [&] {
          const Header header = ReadHeader(&lines);
          if (!collector.has_value()) {
            markers = header.markers;
            collector.emplace("trc", SkeletonOfNames(markers, options), options,
                              header.frame_rate_hz);
          } else if (markers != header.markers) {
            throw InputError("has other markers than the first file");
          }
          ReadRows(header, file.id, options.axes.value_or(AxisMap()), &lines,
                   &*collector);
        });
  }
  return collector->Finish();
}

// ---- Writing ----

// The layout is that of the files Pose2Sim writes, but each row ends with a
// tabulator, as in OpenSim's: its reader counts what follows the last one only
// where it is not empty, and refuses rows that lack a cell.

void CheckMarkerNames(const Skeleton& skeleton) {
  for (const std::string& joint : skeleton.joints()) {
    if (joint.find_first_of("\t\r\n") != std::string::npos) {
      throw InputError("the joint '" + Printable(joint) +
                       "' cannot be the name of a TRC marker");
    }
  }
}

std::string HeaderText(const std::string& file_name,
                       const TrackSequence& tracks, size_t row_count) {
  const std::vector<std::string>& joints = tracks.header.skeleton.joints();
  const double rate = tracks.header.frame_rate_hz;
  const int64_t start = tracks.frames.empty() ? 0 : tracks.frames.front().frame;
  std::string text =
      "PathFileType\t4\t(X/Y/Z)\t" + file_name +
      "\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
      "OrigDataStartFrame\tOrigNumFrames\n";
  text += fmt::format("{}\t{}\t{}\t{}\tm\t{}\t{}\t{}\n", rate, rate, row_count,
                      joints.size(), rate, start, row_count);
  text += "Frame#\tTime";
  for (size_t j = 0; j < joints.size(); ++j) {
    text += (j == 0 ? "\t" : "\t\t\t") + joints[j];
  }
  text += "\t\t\n\t";
  for (size_t j = 1; j <= joints.size(); ++j) {
    text += fmt::format("\tX{}\tY{}\tZ{}", j, j, j);
  }
  return text + "\t\n";
}

void WriteMarkers(const PersonPose* person, size_t joint_count,
                  const AxisMap& axes, JsonOutput* out) {
  for (size_t j = 0; j < joint_count; ++j) {
    if (person == nullptr || !person->joints[j].present()) {
      out->Text("\t\t\t");
      continue;
    }
    const Eigen::Vector3d marker = axes.Apply(person->joints[j].position_m);
    for (int axis = 0; axis < 3; ++axis) out->Add("\t", marker[axis]);
  }
}

void WriteTrcPerson(const std::string& path, TrackId id,
                    const TrackSequence& tracks,
                    const std::vector<TrackRow>& rows, const AxisMap& axes) {
  AtomicFile file(path);
  const size_t slash = path.find_last_of('/');
  const std::string name =
      path.substr(slash == std::string::npos ? 0 : slash + 1);
  file.Write(HeaderText(name, tracks, rows.size()));
  const size_t joint_count = tracks.header.skeleton.joints().size();
  JsonOutput out;
  for (size_t r = 0; r < rows.size(); ++r) {
    out.Add(r + 1, "\t", rows[r].time_s);
    WriteMarkers(FindPerson(rows[r].frame, id), joint_count, axes, &out);
    out.Text("\t\n");
    out.FlushTo(&file);
  }
  file.Commit();
}

// TRC as OpenSim and Pose2Sim read it, a file a person: PATH/person_ID.trc, or
// PATH/person_ID_NAME.trc of those who have a name; NAME.trc is the file of the
// one person that the tracks have. All files have a row for every frame of the
// recording, Frame# from 1 and the time of the tracks; the header's
// OrigDataStartFrame is the first frame's number. A marker without position has
// empty cells. Needs a frame rate.
void WriteTracksTrc(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  RequireFrameRate(tracks, "TRC");
  CheckMarkerNames(tracks.header.skeleton);
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "TRC");
  WritePersonFiles(path, kTrcExtension, tracks, options.names,
                   [&](const std::string& file, TrackId id) {
                     WriteTrcPerson(file, id, tracks, rows,
                                    options.axes.value_or(AxisMap()));
                   });
  lost_fields->push_back("bones and configuration are not kept");
  NotePlainPositions(ContentsOf(tracks), lost_fields);
  NoteAddedRows(tracks, rows.size(), "have empty rows", lost_fields);
  constexpr int64_t kKeptIds = 1'000'000'000'000'000'000;  // 18 digits
  NoteRenumbering(tracks, kKeptIds, lost_fields);
}

}  // namespace

TrackFormat TrcTrackFormat() {
  TrackFormat format;
  format.name = "trc";
  format.layout = "a folder, a file a person";
  format.extensions = {kTrcExtension};
  format.files = TrackFormat::Files::kFileAPerson;
  format.person_extension = kTrcExtension;
  format.axes = AxisMap();
  format.has_marker_names = true;
  format.recognise = [](const TrackHead& head) {
    return head.BeginsWith(std::string(kTrcMark)) ||
           head.HasFile(kTrcExtension);
  };
  format.read = ReadTracksTrc;
  format.read_names = [](const std::string& path) {
    return NamesOfPersonFiles(path, kTrcExtension);
  };
  format.keeps_names = true;
  format.write = WriteTracksTrc;
  return format;
}

}  // namespace kinegraph
