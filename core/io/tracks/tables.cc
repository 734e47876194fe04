// Tables: kinegraph's own, FreeMoCap's and Anipose's.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/checks.h"
#include "core/data/limits.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

// ---- kinegraph's own ----
//
// CSV of tracks, one row per joint. Columns are identified by their names;
// other columns are ignored, except `name` by ReadCsvNames. Frames may be in
// any order, but the rows of one person in one frame must be contiguous.

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
    Refuse("found '{}', expected a number", Printable(cell));
  });
}

int64_t Whole(const std::string& cell, size_t column, int64_t high) {
  const auto number = ParseNumber<int64_t>(cell);
  if (!number) {
    Refuse("{}: found '{}', expected a whole number", kColumns[column],
           Printable(cell));
  }
  if (*number < 0 || *number > high) {
    Refuse("{}: found {}, expected 0 .. {}", kColumns[column], cell, high);
  }
  return *number;
}

// Index of the column in the first row; the number of columns if it is absent.
size_t ColumnOf(const std::string& title,
                const std::vector<std::string>& titles) {
  return static_cast<size_t>(std::find(titles.begin(), titles.end(), title) -
                             titles.begin());
}

class CsvTrackReader {
 public:
  explicit CsvTrackReader(std::string_view text) : text_(text), rows_(text) {}

  std::string Place() const { return rows_.Place(); }

  TrackSequence Read(const TrackReadOptions& options) {
    const std::vector<std::string> labels = JointNames();
    for (size_t j = 0; j < labels.size(); ++j) place_.emplace(labels[j], j);
    TrackCollector collector("csv", SkeletonOfNames(labels, options), options);
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

  void FindColumns(const std::vector<std::string>& titles) {
    for (size_t c = 0; c < kColumns.size(); ++c) {
      column_[c] = ColumnOf(kColumns[c], titles);
      if (column_[c] < titles.size()) continue;
      column_[c].reset();
      if (c < kRequired) FailMissingColumn(c);
    }
  }

  [[noreturn]] static void FailMissingColumn(size_t column) {
    Refuse("has no column '{}'", kColumns[column]);
  }

  // Names of the joints in order of appearance. Throws InputError for more than
  // kMaxJoints, for which the search for a skeleton would take too long.
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
        collector->Touch(frame)->time =
            CheckedTime(Finite(cell(kTime), kTime), "time_s");
      }
    }
    // By label: the skeleton has the joints in the order of the labels, but may
    // have other names for them.
    const size_t joint = place_.at(PlainCell(cell(kJoint)));
    if (seen_[joint]) {
      Refuse("joint '{}' appears twice", Printable(cell(kJoint)));
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
        if (!column_[at]) FailMissingColumn(at);
        covariance(row, column) = covariance(column, row) =
            Finite(cell(at), at);
      }
    }
    person_->covariances[j] = covariance;
  }

  const std::string_view text_;
  CsvRows rows_;
  std::array<std::optional<size_t>, kColumns.size()> column_;
  std::unordered_map<std::string, size_t> place_;  // of labels
  PersonPose* person_ = nullptr;                   // of the last row
  int64_t frame_ = 0;
  std::vector<bool> seen_;
};

// Writes the columns frame,time_s,id,joint,x_m,y_m,z_m,status, followed by
// `views`, the six columns cov_xx_m2 .. cov_zz_m2 and `name` if the tracks have
// these. Cells of missing values are empty, and so are times if all are
// unknown.
class CsvWriter {
 public:
  CsvWriter(const TrackSequence& tracks, const TrackContents& contents,
            const PersonNames& names)
      : tracks_(tracks), contents_(contents) {
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
    out_.FlushTo(&file);
    for (const TrackFrame& frame : tracks_.frames) {
      for (const PersonPose& person : frame.people) {
        for (size_t j = 0; j < person.joints.size(); ++j) {
          WriteRow(frame, person, j);
        }
      }
      out_.FlushTo(&file);
    }
    file.Commit();
  }

 private:
  void WriteRow(const TrackFrame& frame, const PersonPose& person, size_t j) {
    const Joint3d& joint = person.joints[j];
    out_.Add(frame.frame, ",");
    if (contents_.has_clock) out_.Seconds(frame.time);
    out_.Add(",", person.id.value(), ",", joints_[j]);
    for (const double metres : joint.position_m) {
      out_.Text(",");
      if (joint.present()) out_.Number(metres);
    }
    out_.Add(",", ToString(joint.status));
    if (contents_.has_views) {
      out_.Text(",");
      if (!person.inlier_views.empty()) out_.Integer(person.inlier_views[j]);
    }
    const bool has_covariance =
        !person.covariances.empty() && person.covariances[j].has_value();
    for (int r = 0; contents_.has_covariances && r < 3; ++r) {
      for (int c = r; c < 3; ++c) {
        out_.Text(",");
        if (has_covariance) out_.Number((*person.covariances[j])(r, c));
      }
    }
    if (!names_.empty()) {
      const auto name = names_.find(person.id);
      out_.Add(",", name == names_.end() ? "" : name->second);
    }
    out_.Text("\n");
  }

  const TrackSequence& tracks_;
  const TrackContents& contents_;
  JsonOutput out_;
  std::vector<std::string> joints_;  // as cells
  PersonNames names_;                // as cells
};

// ---- FreeMoCap's ----
//
// 3D points of one person, in millimetres: a table NAME_x, NAME_y, NAME_z, ...
// with one row per frame and no frame number (mediapipe_body_3d_xyz.csv), or an
// array [frames, points, 3] (mediapipe_body_3d_xyz.npy,
// mediapipe_skeleton_3d.npy), NaN where a point is missing. Frames count from
// 0, the person's id is 0.

constexpr const char* kFreeMoCap = "freemocap";

void AddRow(int64_t frame, const double* numbers, TrackCollector* collector) {
  Pose3d joints(collector->joint_count());
  for (size_t j = 0; j < joints.size(); ++j) {
    joints[j] =
        ObservedJoint(Eigen::Vector3d(numbers + 3 * j) / kMillimetresPerMetre);
  }
  collector->AddIfSeen(frame, TrackId(0), std::move(joints));
}

// Names of the points; empty unless the columns are NAME_x, NAME_y, NAME_z in
// this order.
std::vector<std::string> PointsOf(const std::vector<std::string>& cells) {
  std::vector<std::string> names;
  for (size_t c = 0; c + 2 < cells.size(); c += 3) {
    const std::string& first = cells[c];
    if (first.size() < 3) return {};
    const std::string name = first.substr(0, first.size() - 2);
    if (first != name + "_x" || cells[c + 1] != name + "_y" ||
        cells[c + 2] != name + "_z") {
      return {};
    }
    names.push_back(name);
  }
  return cells.size() % 3 == 0 ? names : std::vector<std::string>();
}

TrackSequence ReadTable(CsvRows* rows, const TrackReadOptions& options) {
  std::vector<std::string> cells;
  std::vector<std::string> names;
  if (rows->Next(&cells)) names = PointsOf(cells);
  if (names.empty()) {
    throw InputError("expected columns NAME_x, NAME_y, NAME_z, ...");
  }
  TrackCollector collector(kFreeMoCap, SkeletonOfNames(names, options),
                           options);
  std::vector<double> numbers(cells.size());
  for (int64_t frame = 0; rows->Next(&cells, numbers.size()); ++frame) {
    std::transform(cells.begin(), cells.end(), numbers.begin(),
                   [](const std::string& cell) {
                     return NumberOfCell(cell).value_or(kNan);
                   });
    AddRow(frame, numbers.data(), &collector);
  }
  return collector.Finish();
}

TrackSequence ReadArray(const std::string& path,
                        const TrackReadOptions& options) {
  const NpzReader reader(path);
  const std::vector<size_t> shape = reader.At("", 3).shape;
  const std::vector<double> numbers = reader.Numbers("", 3);
  if (shape[2] != 3) reader.Fail("", "expected the shape [frames, points, 3]");
  const Skeleton skeleton = options.skeleton.value_or(MediaPipe33());
  const size_t points = shape[1];
  if (points < skeleton.joints().size()) {
    reader.Fail("", "has " + std::to_string(points) +
                        " points, expected at least the " +
                        std::to_string(skeleton.joints().size()) + " of '" +
                        skeleton.name() + "'");
  }
  TrackCollector collector(kFreeMoCap, skeleton, options);
  for (size_t f = 0; f < shape[0]; ++f) {
    AddRow(static_cast<int64_t>(f), &numbers[f * points * 3], &collector);
  }
  return collector.Finish();
}

// Whether the file is an array of the shape [frames, points, 3].
bool IsArrayOfPoints(const std::string& beginning) {
  const size_t shape = beginning.find("'shape': (");
  if (beginning.compare(0, kNpyMagic.size(), kNpyMagic) != 0 ||
      shape == std::string::npos) {
    return false;
  }
  int end = 0;
  std::sscanf(beginning.c_str() + shape, "'shape': (%*u, %*u, 3)%n", &end);
  return end > 0;
}

// ---- Anipose's ----
//
// The table that Anipose's `triangulate` writes (pose-3d), one row per frame:
// NAME_x, NAME_y, NAME_z [mm], NAME_error, NAME_ncams and NAME_score of each
// joint, then the rotation M_00 .. M_22 and the centre by which Anipose
// transformed the points (here the identity and zero), and the frame number. A
// file is one person.

std::string TitleRow(const Skeleton& skeleton) {
  std::string text;
  for (const std::string& joint : skeleton.joints()) {
    for (const char* column :
         {"_x", "_y", "_z", "_error", "_ncams", "_score"}) {
      text += CsvCell(joint + column) + ",";
    }
  }
  return text +
         "M_00,M_01,M_02,M_10,M_11,M_12,M_20,M_21,M_22,"
         "center_0,center_1,center_2,fnum\n";
}

// Readers treat empty cells as NaN.
void WriteAniposeJoint(const PersonPose* person, size_t joint_idx,
                       JsonOutput* out) {
  if (person == nullptr || !person->joints[joint_idx].present()) {
    out->Text(",,,,,,");
    return;
  }
  for (const double metres : person->joints[joint_idx].position_m) {
    out->Add(kMillimetresPerMetre * metres, ",");
  }
  out->Text(",");  // the reprojection error is not in the tracks
  if (!person->inlier_views.empty()) {
    out->Integer(person->inlier_views[joint_idx]);
  }
  out->Text(",,");
}

}  // namespace

bool RecogniseCsvTracks(const TrackHead& head) {
  const std::vector<std::string> row = FirstCsvRow(head.beginning);
  return row.size() > kJoint &&
         std::equal(row.begin(), row.begin() + kJoint + 1, kColumns.begin());
}

TrackSequence ReadCsvTracks(const std::string& path,
                            const TrackReadOptions& options) {
  return ReadText<CsvTrackReader>(
      path, [&](CsvTrackReader* reader) { return reader->Read(options); });
}

PersonNames ReadCsvNames(const std::string& path) {
  return ReadText<CsvRows>(path, [](CsvRows* rows) {
    PersonNames names;
    std::vector<std::string> cells;
    if (!rows->Next(&cells)) return names;
    const size_t width = cells.size();
    const size_t of_id = ColumnOf("id", cells);
    const size_t of_name = ColumnOf("name", cells);
    if (of_name == width || of_id == width) return names;
    while (rows->Next(&cells)) {
      if (cells.size() != width || cells[of_name].empty()) continue;
      const std::optional<TrackId> id = PersonIdOf(cells[of_id]);
      if (id.has_value()) names.emplace(*id, PlainCell(cells[of_name]));
    }
    return names;
  });
}

void WriteCsvTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  CsvWriter(tracks, contents, options.names).Write(path);
  lost_fields->push_back("bones, frame rate and configuration are not kept");
  if (IdsOf(tracks).empty()) {
    lost_fields->push_back(
        "the tracks contain no people: the table names no joints and cannot be "
        "read back");
  }
  NoteLosses(contents,
             {Loss::kUnknownClock, Loss::kMatches, Loss::kEmptyFrames},
             lost_fields);
}

bool RecogniseFreeMoCapTracks(const TrackHead& head) {
  const std::string& text = head.beginning;  // empty for a folder
  return IsArrayOfPoints(text) ||
         (text.find('\n') != std::string::npos &&
          !PointsOf(FirstCsvRow(head.beginning)).empty());
}

TrackSequence ReadFreeMoCapTracks(const std::string& path,
                                  const TrackReadOptions& options) {
  if (BeginningOf(path, kNpyMagic.size()) == kNpyMagic) {
    return ReadArray(path, options);
  }
  return ReadText<CsvRows>(
      path, [&](CsvRows* rows) { return ReadTable(rows, options); });
}

void WriteAniposeTracks(const std::string& path, const TrackSequence& tracks,
                        const TrackExportOptions& options,
                        LostFields* lost_fields) {
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "Anipose");
  const Skeleton& skeleton = tracks.header.skeleton;
  WritePersonTables(
      path, ".csv", tracks, options.names, rows,
      [&](const std::string&) { return TitleRow(skeleton); },
      [&](size_t row, const PersonPose* person, JsonOutput* out) {
        for (size_t j = 0; j < skeleton.joints().size(); ++j) {
          WriteAniposeJoint(person, j, out);
        }
        out->Add("1,0,0,0,1,0,0,0,1,0,0,0,",
                 tracks.frames.front().frame + static_cast<int64_t>(row), "\n");
      });
  lost_fields->push_back(
      "bones, times, frame rate and configuration are not kept; errors and "
      "scores are empty");
  NoteLosses(ContentsOf(tracks), {Loss::kInferredAlike, Loss::kCovariances},
             lost_fields);
  NoteAddedRows(tracks, rows.size(), "have empty cells", lost_fields);
}

}  // namespace kinegraph
