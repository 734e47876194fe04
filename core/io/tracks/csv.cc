// Our CSV of tracks, one row a joint: columns are found by their names and
// others passed over, rows may come in any order of frames, those of one person
// in one frame together.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <unordered_set>
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

constexpr std::array<const char*, 15> kColumns = {
    "frame",     "time_s",    "id",        "joint",     "x_m",
    "y_m",       "z_m",       "status",    "views",     "cov_xx_m2",
    "cov_xy_m2", "cov_xz_m2", "cov_yy_m2", "cov_yz_m2", "cov_zz_m2"};
enum Column : size_t {
  kFrame,
  kTime,
  kId,
  kJoint,
  kX,
  kStatus = 7,
  kViews,
  kCovariance
};
constexpr size_t kRequired = 8;

double Finite(const std::string& cell, size_t column) {
  return Located(kColumns[column], [&] {
    const std::optional<double> number = NumberOfCell(cell);
    if (number.has_value() && std::isfinite(*number)) return *number;
    throw InputError("found '" + Printable(cell) + "', expected a number");
  });
}

int64_t Whole(const std::string& cell, size_t column, int64_t high) {
  int64_t number = -1;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, number);
  if (error != std::errc() || stop != end) {
    throw InputError(std::string(kColumns[column]) + ": found '" +
                     Printable(cell) + "', expected a whole number");
  }
  if (number < 0 || number > high) {
    throw InputError(std::string(kColumns[column]) + ": found " + cell +
                     ", expected 0 .. " + std::to_string(high));
  }
  return number;
}

class CsvTrackReader {
 public:
  CsvTrackReader(std::string_view text, const TrackReadOptions& options)
      : text_(text), options_(options), rows_(text) {}

  std::string Place() const { return rows_.Place(); }

  TrackSequence Read() {
    TrackCollector collector("csv", SkeletonOfNames(JointNames(), options_),
                             options_);
    ForEachRow([&](const std::vector<std::string>& cells) {
      ReadRow(cells, &collector);
    });
    return collector.Finish();
  }

 private:
  template <typename Visit>
  void ForEachRow(const Visit& visit) {
    rows_ = CsvRows(text_);
    std::vector<std::string> cells;
    if (!rows_.Next(&cells)) throw InputError("is empty");
    const size_t width = cells.size();
    FindColumns(cells);
    while (rows_.Next(&cells, width)) visit(cells);
  }

  void FindColumns(const std::vector<std::string>& names) {
    for (size_t c = 0; c < kColumns.size(); ++c) {
      const auto at = std::find(names.begin(), names.end(), kColumns[c]);
      column_[c].reset();
      if (at != names.end()) {
        column_[c] = static_cast<size_t>(at - names.begin());
      } else if (c < kRequired) {
        throw InputError("has no column '" + std::string(kColumns[c]) + "'");
      }
    }
  }

  // In the order in which they come. A skeleton is searched name by name, so
  // one too large is refused here, before that takes long.
  std::vector<std::string> JointNames() {
    constexpr size_t kMaxJoints = 10000;
    std::vector<std::string> names;
    std::unordered_set<std::string> known;
    ForEachRow([&](const std::vector<std::string>& cells) {
      const std::string name = PlainCell(cells[*column_[kJoint]]);
      if (!known.insert(name).second) return;
      names.push_back(name);
      if (names.size() > kMaxJoints) throw InputError("has too many joints");
    });
    return names;
  }

  void ReadRow(const std::vector<std::string>& cells,
               TrackCollector* collector) {
    const auto cell = [&](size_t column) -> const std::string& {
      return cells[*column_[column]];
    };
    const int64_t frame = Whole(cell(kFrame), kFrame, kMaxFrame);
    const TrackId id(Whole(cell(kId), kId, kMaxId));
    if (person_ == nullptr || frame != frame_ || id != person_->id) {
      person_ = collector->Add(frame, id);
      frame_ = frame;
      seen_.assign(person_->joints.size(), false);
      if (column_[kViews]) person_->inlier_views.resize(seen_.size());
      if (column_[kCovariance]) person_->covariances.resize(seen_.size());
      if (!cell(kTime).empty()) {
        const double time_s = Finite(cell(kTime), kTime);
        constexpr double kMaxSeconds = 1e9;
        if (std::abs(time_s) > kMaxSeconds) {
          throw InputError("time_s: is beyond 1e9 s");
        }
        collector->Touch(frame)->time = FromSeconds(time_s);
      }
    }
    const int index =
        collector->header().skeleton.IndexOf(PlainCell(cell(kJoint)));
    if (index < 0) {
      throw InputError("joint '" + Printable(cell(kJoint)) +
                       "' is not of the skeleton");
    }
    const auto joint = static_cast<size_t>(index);
    if (seen_[joint]) {
      throw InputError("joint '" + Printable(cell(kJoint)) +
                       "' stands there twice");
    }
    seen_[joint] = true;
    ReadJoint(cell, joint);
  }

  template <typename Cell>
  void ReadJoint(const Cell& cell, size_t j) {
    Joint3d& joint = person_->joints[j];
    joint.status = ParseJointStatus(cell(kStatus));
    for (size_t axis = 0; axis < 3 && joint.present(); ++axis) {
      joint.position_m[static_cast<Eigen::Index>(axis)] =
          Finite(cell(kX + axis), kX + axis);
    }
    if (column_[kViews] && !cell(kViews).empty()) {
      constexpr int64_t kMaxViews = 100000;
      person_->inlier_views[j] =
          static_cast<int>(Whole(cell(kViews), kViews, kMaxViews));
    }
    if (!column_[kCovariance] || cell(kCovariance).empty()) return;
    Eigen::Matrix3d covariance;
    size_t at = kCovariance;
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column, ++at) {
        if (!column_[at]) {
          throw InputError("has no column '" + std::string(kColumns[at]) + "'");
        }
        covariance(row, column) = covariance(column, row) =
            Finite(cell(at), at);
      }
    }
    person_->covariances[j] = covariance;
  }

  const std::string_view text_;
  const TrackReadOptions& options_;
  CsvRows rows_;
  std::array<std::optional<size_t>, kColumns.size()> column_;
  PersonPose* person_ = nullptr;  // of the last row
  int64_t frame_ = 0;
  std::vector<bool> seen_;
};

PersonNames ReadCsvNames(const std::string& path) {
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
    const std::optional<TrackId> id = PersonIdOf(cells[of_id]);
    if (id.has_value()) names.emplace(*id, PlainCell(cells[of_name]));
  }
  return names;
}

TrackSequence ReadTracksCsv(const std::string& path,
                            const TrackReadOptions& options) {
  const std::string text = ReadTextFile(path);
  CsvTrackReader reader(text, options);
  return Located(
      path, [&] { return reader.Place(); }, [&] { return reader.Read(); });
}

// ---- Writing ----

// Tidy CSV, one row a joint: frame,time_s,id,joint,x_m,y_m,z_m,status; `views`,
// the six columns cov_xx_m2 .. cov_zz_m2 and `name` follow when anybody has
// them. The cells of what is missing are empty, those of times when none is
// known.
class CsvWriter {
 public:
  CsvWriter(const TrackSequence& tracks, const PersonNames& names)
      : tracks_(tracks), contents_(ContentsOf(tracks)) {
    for (const auto& [id, name] : names) names_[id] = CsvCell(name);
    for (const std::string& joint : tracks.header.skeleton.joints()) {
      joints_.push_back(CsvCell(joint));
    }
  }

  void Write(const std::string& path) {
    AtomicFile file(path);
    for (size_t c = 0; c < kColumns.size(); ++c) {
      if (c == kViews && !contents_.has_views) continue;
      if (c >= kCovariance && !contents_.has_covariances) continue;
      out_.Add(c == 0 ? "" : ",", kColumns[c]);
    }
    out_.Text(names_.empty() ? "\n" : ",name\n");
    for (const TrackFrame& frame : tracks_.frames) {
      for (const PersonPose& person : frame.people) {
        for (size_t j = 0; j < person.joints.size(); ++j) {
          WriteRow(frame, person, j);
        }
      }
      out_.FlushTo(&file);
    }
    out_.FlushTo(&file);
    file.Commit();
  }

  const TrackContents& contents() const { return contents_; }

 private:
  void WriteRow(const TrackFrame& frame, const PersonPose& person, size_t j) {
    const Joint3d& joint = person.joints[j];
    out_.Add(frame.frame, ",");
    if (contents_.has_clock) out_.Seconds(frame.time);
    out_.Add(",", person.id.value(), ",", joints_[j]);
    for (int axis = 0; axis < 3; ++axis) {
      out_.Text(",");
      if (joint.present()) out_.Number(joint.position_m[axis]);
    }
    out_.Add(",", ToString(joint.status));
    if (contents_.has_views) {
      out_.Text(",");
      if (!person.inlier_views.empty()) out_.Integer(person.inlier_views[j]);
    }
    if (contents_.has_covariances) WriteCovariance(person, j);
    if (!names_.empty()) {
      const auto name = names_.find(person.id);
      out_.Add(",", name == names_.end() ? "" : name->second);
    }
    out_.Text("\n");
  }

  void WriteCovariance(const PersonPose& person, size_t j) {
    const bool known =
        !person.covariances.empty() && person.covariances[j].has_value();
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        out_.Text(",");
        if (known) out_.Number((*person.covariances[j])(row, column));
      }
    }
  }

  const TrackSequence& tracks_;
  const TrackContents contents_;
  JsonOutput out_;
  std::vector<std::string> joints_;  // as cells
  PersonNames names_;                // as cells
};

void WriteTracksCsv(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  CsvWriter writer(tracks, options.names);
  writer.Write(path);
  lost_fields->push_back("bones, frame rate and configuration are not kept");
  const TrackContents& contents = writer.contents();
  if (!contents.has_clock) lost_fields->push_back(kNoClock);
  if (contents.has_matches) lost_fields->push_back("matches are not kept");
  NoteEmptyFrames(contents, lost_fields);
}

}  // namespace

TrackFormat CsvTrackFormat() {
  TrackFormat format;
  format.name = "csv";
  format.layout = "one row a joint";
  format.extensions = {".csv"};
  format.has_marker_names = true;
  format.recognise = [](const TrackHead& head) {
    const std::vector<std::string> row = head.FirstRow();
    return row.size() > kJoint &&
           std::equal(row.begin(), row.begin() + kJoint + 1, kColumns.begin());
  };
  format.read = ReadTracksCsv;
  format.read_names = ReadCsvNames;
  format.keeps_names = true;
  format.write = WriteTracksCsv;
  return format;
}

}  // namespace kinegraph
