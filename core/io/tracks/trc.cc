// TRC of OpenSim and Pose2Sim, tab-separated: the second and third line are the
// names and values of the header, the fourth names a marker over every three
// columns, the fifth their coordinates; then one row per frame. Empty cells and
// NaN mean that a marker has no position. One file is one person, whose id
// comes from the file name (ListPersonFiles).
// Rows are consecutive frames; FirstFrame determines the number of the first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/limits.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr std::string_view kTrcMark = "PathFileType";
constexpr const char* kTrcExtension = ".trc";

// Splits a text into lines, without blank lines, and these into cells.
class TrcLines {
 public:
  explicit TrcLines(std::string_view text) : rest_(text) {}

  bool Next(std::vector<std::string_view>* cells) {
    std::string_view line;
    while (line.find_first_not_of("\t\r ") == std::string_view::npos) {
      if (rest_.empty()) return false;
      line = CutAt('\n', &rest_);
      ++number_;
    }
    if (line.back() == '\r') line.remove_suffix(1);
    const auto tabulators = std::count(line.begin(), line.end(), '\t');
    cells->resize(static_cast<size_t>(tabulators) + 1);
    for (std::string_view& cell : *cells) cell = CutAt('\t', &line);
    return true;
  }

  // A line of the header.
  std::vector<std::string_view> Need() {
    std::vector<std::string_view> cells;
    if (!Next(&cells)) throw InputError("ends in its header");
    return cells;
  }

  std::string Place() const { return "line " + std::to_string(number_); }

 private:
  // The text before `mark`, or all of it; removes it and the mark from the
  // text.
  static std::string_view CutAt(char mark, std::string_view* text) {
    const size_t end = std::min(text->find(mark), text->size());
    const std::string_view before = text->substr(0, end);
    text->remove_prefix(std::min(end + 1, text->size()));
    return before;
  }

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

struct TrcHeader {
  double frame_rate_hz = 0.0;
  double metres = 1.0;  // length of the unit
  int64_t first_frame = 0;
  int64_t frames = 0;
  std::vector<std::string> markers;
};

TrcHeader ReadTrcHeader(TrcLines* lines) {
  TrcHeader header;
  const std::vector<std::string_view> first = lines->Need();
  if (first[0].substr(0, kTrcMark.size()) != kTrcMark) {
    throw InputError("does not begin with PathFileType");
  }
  if (first[0] != kTrcMark) {
    throw InputError("expected tabs between cells");
  }
  const std::vector<std::string_view> names = lines->Need();
  const std::vector<std::string_view> values = lines->Need();
  const auto value = [&](const char* name) -> std::string_view {
    for (size_t i = 0; i < names.size() && i < values.size(); ++i) {
      if (names[i] == name) return values[i];
    }
    Refuse("has no '{}'", name);
  };
  const auto number = [&](const char* name, double high) {
    const double given = NumberOf(value(name)).value_or(-1.0);
    if (given < 0.0 || given > high) {
      Refuse("{}: expected 0 .. {}", name, static_cast<int64_t>(high));
    }
    return given;
  };
  header.frame_rate_hz = number("DataRate", kMaxFrameRate_hz);
  header.metres = ParseLengthUnit(std::string(value("Units")), "Units");
  header.frames = static_cast<int64_t>(number("NumFrames", kMaxRows));
  header.first_frame =
      static_cast<int64_t>(number("OrigDataStartFrame", kMaxFrame));
  const auto markers = static_cast<size_t>(number("NumMarkers", 10000.0));
  const std::vector<std::string_view> titles = lines->Need();
  for (size_t m = 0; m < markers; ++m) {
    if (2 + 3 * m >= titles.size()) {
      Refuse("names fewer than {} markers", markers);
    }
    header.markers.emplace_back(titles[2 + 3 * m]);
  }
  if (lines->Need().size() < 3) throw InputError("expected X1, Y1, Z1, ...");
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

// The frame of the first row: the header's OrigDataStartFrame if the row's time
// is less than 0.75 frames from it, otherwise the frame at that time. Programs
// that trim a recording keep the times, but renumber rows and
// OrigDataStartFrame from 0 or 1. A tolerance of a quarter of a frame permits
// rounded times and rates; a time less than 0.75 frames from OrigDataStartFrame
// is outside the tolerance of all other frames. If the times restart as well,
// at 0 or, as in Pose2Sim, after one frame, or are negative, between frames or
// since 1970, the frame is OrigDataStartFrame. This number is 0-based in files
// of kinegraph and Pose2Sim, but 1-based in laboratories' files, so that a
// start of 1 with a time of 0 is frame 0.
int64_t FirstFrame(const TrcHeader& header, double time_s, double row_number) {
  const double by_time = time_s * header.frame_rate_hz;
  const double nearest = std::round(by_time);
  const auto start = static_cast<double>(header.first_frame);
  if (std::abs(by_time - start) < 0.75) return header.first_frame;
  constexpr double kMostSinceStartS = 1e9;  // more: seconds since 1970
  if (std::abs(by_time - nearest) > 0.25 || nearest < 0.0 ||
      time_s > kMostSinceStartS || nearest > static_cast<double>(kMaxFrame)) {
    return header.first_frame;
  }
  const bool begins_anew =
      nearest == 0.0 || (nearest == 1.0 && row_number == 1.0);
  if (begins_anew && start != 1.0) return header.first_frame;
  return static_cast<int64_t>(nearest);
}

void ReadRows(const TrcHeader& header, TrackId id, const AxisMap& axes,
              TrcLines* lines, TrackCollector* collector) {
  std::vector<std::string_view> cells;
  int64_t first_frame = 0;
  int64_t row = 0;
  while (lines->Next(&cells)) {
    if (cells.size() < 2 + 3 * header.markers.size()) {
      Refuse("found {} cells, expected {}", cells.size(),
             2 + 3 * header.markers.size());
    }
    const std::optional<double> time_s = NumberOf(cells[1]);
    if (!time_s.has_value() || std::abs(*time_s) > kMaxTime_s) {
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
    Refuse("found {}, but NumFrames is {}", Counted(row, "row", "rows"),
           header.frames);
  }
}

// ---- Writing ----

// The layout of Pose2Sim's files, except that each row ends with a tab as in
// OpenSim's files: OpenSim's reader counts the cell after the last tab only if
// it is not empty, and rejects rows that lack a cell.

std::string TrcHeaderText(const std::string& file_name,
                          const TrackSequence& tracks, size_t row_count) {
  const std::vector<std::string>& joints = tracks.header.skeleton.joints();
  const double rate = tracks.header.frame_rate_hz;
  std::string text =
      "PathFileType\t4\t(X/Y/Z)\t" + file_name +
      "\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
      "OrigDataStartFrame\tOrigNumFrames\n";
  text +=
      fmt::format("{}\t{}\t{}\t{}\tm\t{}\t{}\t{}\n", rate, rate, row_count,
                  joints.size(), rate, tracks.frames.front().frame, row_count);
  text += fmt::format("Frame#\tTime\t{}\t\t\n\t", fmt::join(joints, "\t\t\t"));
  for (size_t j = 1; j <= joints.size(); ++j) {
    text += fmt::format("\tX{}\tY{}\tZ{}", j, j, j);
  }
  return text + "\t\n";
}

}  // namespace

bool RecogniseTrcTracks(const TrackHead& head) {
  return head.BeginsWith(kTrcMark) || head.HasFile(kTrcExtension);
}

TrackSequence ReadTrcTracks(const std::string& path,
                            const TrackReadOptions& options) {
  std::optional<TrackCollector> collector;
  std::vector<std::string> markers;  // of the first file
  for (const PersonFile& file : ListPersonFiles(path, kTrcExtension)) {
    ReadText<TrcLines>(file.path, [&](TrcLines* lines) {
      const TrcHeader header = ReadTrcHeader(lines);
      if (!collector.has_value()) {
        markers = header.markers;
        collector.emplace("trc", SkeletonOfNames(markers, options), options,
                          header.frame_rate_hz);
      } else if (markers != header.markers) {
        throw InputError("has other markers than the first file");
      }
      ReadRows(header, file.id, options.axes.value_or(AxisMap()), lines,
               &*collector);
    });
  }
  return collector->Finish();
}

// TRC for OpenSim and Pose2Sim, one file per person: PATH/person_ID.trc, or
// PATH/person_ID_NAME.trc for people with names; if PATH has the extension
// .trc, it is the file of the only person in the tracks. All files have a row
// for every frame of the recording, with Frame# from 1 and the time of the
// tracks; the header's OrigDataStartFrame is the number of the first frame. A
// marker without position has empty cells. Requires a frame rate.
void WriteTrcTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  RequireFrameRate(tracks, "TRC");
  const std::vector<std::string>& joints = tracks.header.skeleton.joints();
  for (const std::string& joint : joints) {
    if (joint.find_first_of("\t\r\n") != std::string::npos) {
      Refuse("the joint '{}' cannot be the name of a TRC marker",
             Printable(joint));
    }
  }
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "TRC");
  const AxisMap axes = options.axes.value_or(AxisMap());
  WritePersonTables(
      path, kTrcExtension, tracks, options.names, rows,
      [&](const std::string& file) {
        // npos + 1 is 0
        return TrcHeaderText(file.substr(file.find_last_of('/') + 1), tracks,
                             rows.size());
      },
      [&](size_t row, const PersonPose* person, JsonOutput* out) {
        out->Add(row + 1, "\t", rows[row].time_s);
        for (size_t j = 0; j < joints.size(); ++j) {
          if (person == nullptr || !person->joints[j].present()) {
            out->Text("\t\t\t");
            continue;
          }
          const Eigen::Vector3d at = axes.Apply(person->joints[j].position_m);
          for (const double number : at) out->Add("\t", number);
        }
        out->Text("\t\n");
      });
  lost_fields->push_back("bones and configuration are not kept");
  NoteLosses(ContentsOf(tracks),
             {Loss::kInferredAlike, Loss::kCovariances, Loss::kViews},
             lost_fields);
  NoteAddedRows(tracks, rows.size(), "have empty rows", lost_fields);
  // Ids in file names are read if they have at most 18 digits.
  constexpr int64_t kKeptIds = 1'000'000'000'000'000'000;
  NoteRenumbering(tracks, kKeptIds, lost_fields);
}

}  // namespace kinegraph
