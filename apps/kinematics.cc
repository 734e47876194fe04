// kinegraph-kinematics: computes joint angles, speeds and distances from
// tracks.
#include "core/kinematics/kinematics.h"

#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/table.h"
#include "apps/common/track_files.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/configuration/config.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/reading_notes.h"
#include "core/io/tracks/tracks.h"
#include "core/kinematics/ground.h"

DEFINE_string(tracks, "", "3D tracks in any supported format");
DEFINE_string(out, "", "NAME.csv to write, one row per person and frame");
DEFINE_string(up, "auto",
              "axis of the world that points upwards: x, -x, y, -y, z, -z; "
              "auto: from the file's format, the floor and the people");
DEFINE_bool(observed, false,
            "joints that fewer than two views support in a frame count as "
            "missing");
DEFINE_string(skeleton, "", "skeleton of the tracks if they do not specify it");
DEFINE_double(frame_rate, 0.0,
              "frame rate [Hz] if the tracks do not specify it");
DEFINE_string(unit, "",
              "unit of tracks whose format does not specify it (such as BVH): "
              "m, cm or mm");

namespace kinegraph {
namespace {

Skeleton SkeletonFlag() {
  try {
    return ResolveSkeleton(FLAGS_skeleton, {});
  } catch (const InputError& error) {
    throw InputError("--skeleton: " + std::string(error.what()));
  }
}

TrackSequence ReadInput() {
  TrackReadOptions read;
  if (!FLAGS_skeleton.empty()) read.skeleton = SkeletonFlag();
  if (FLAGS_frame_rate < 0.0 || !std::isfinite(FLAGS_frame_rate)) {
    throw InputError("--frame_rate: expected a rate in Hz above 0");
  }
  read.frame_rate_hz = FLAGS_frame_rate;
  if (!FLAGS_unit.empty()) read.unit_m = ParseLengthUnit(FLAGS_unit);
  TrackSequence tracks = ReadTracks(FLAGS_tracks, read);
  PrintUnitNote("kinematics", FLAGS_tracks, read, tracks);
  // Angles are defined by kinegraph's joint names; "RHip" and "right_hip"
  // become r_hip.
  tracks.header.skeleton = WithOurNames(tracks.header.skeleton);
  return tracks;
}

void RequireCsv() {
  if (EndsInAnyCase(FLAGS_out, ".csv") || IsStream(FLAGS_out)) return;
  FailFlag("out", FLAGS_out, "NAME.csv or /dev/stdout");
}

void WriteCsv(const KinematicsTable& table, const PersonNames& names) {
  AtomicFile file(WithFolders(FLAGS_out));
  JsonOutput out;
  out.Text("frame,time_s,id");
  if (!names.empty()) out.Text(",name");
  for (const std::string& column : table.columns) {
    out.Add(",", CsvCell(column));
  }
  out.Text("\n");
  for (const KinematicsRow& row : table.rows) {
    out.Add(row.frame, ",");
    if (table.has_times) out.Seconds(row.time);
    out.Add(",", row.id.value());
    if (!names.empty()) {
      const auto name = names.find(row.id);
      out.Text(",");
      if (name != names.end()) out.Text(CsvCell(name->second));
    }
    for (const double value : row.values) {
      out.Text(",");
      if (std::isfinite(value)) out.Number(value);
    }
    out.Text("\n");
    out.FlushTo(&file);
  }
  out.FlushTo(&file);
  file.Commit();
}

// ---- Output -----------------------------------------------------------------

// Finite values of a column, by person.
using Values = std::map<TrackId, std::vector<double>>;

Values ValuesOf(const KinematicsTable& table, const std::string& column) {
  Values values;
  const int at = table.IndexOf(column);
  for (const KinematicsRow& row : table.rows) {
    std::vector<double>& mine = values[row.id];
    if (at < 0) continue;
    const double value = row.values[static_cast<size_t>(at)];
    if (std::isfinite(value)) mine.push_back(value);
  }
  return values;
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return kNan;
  const auto last = static_cast<double>(values.size() - 1);
  const auto at = values.begin() + std::lround(share * last);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string Range(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return Fixed(Quantile(values, 0.05), 0) + " .. " +
         Fixed(Quantile(values, 0.5), 0) + " .. " +
         Fixed(Quantile(values, 0.95), 0);
}

std::string Digest(const KinematicsTable& table, const PersonNames& names) {
  constexpr size_t kMostPeople = 6;
  std::vector<TrackId> shown;
  for (const auto& [id, values] : ValuesOf(table, "")) shown.push_back(id);
  const size_t people = shown.size();
  shown.resize(std::min(people, kMostPeople));
  const auto title_of = [&names](TrackId id) {
    const auto name = names.find(id);
    return name != names.end() ? Printable(name->second, 20)
                               : "person " + std::to_string(id.value());
  };
  Table text(RowOf("5 % .. median .. 95 %", CellsOf(shown, title_of)));
  const auto add = [&](const std::string& title, const std::string& column,
                       const auto& cell) {
    if (table.IndexOf(column) < 0) return;
    const Values values = ValuesOf(table, column);
    const auto cell_of = [&](TrackId id) { return cell(values.at(id)); };
    text.AddRow(RowOf(title, CellsOf(shown, cell_of)));
  };
  for (const std::string& angle : table.angles) {
    add(angle + ", deg", angle + "_deg", Range);
  }
  add("pelvis along the floor: median, m/s", "pelvis_speed_m_s",
      [](const auto& values) { return Fixed(Quantile(values, 0.5), 2); });
  add("pelvis along the floor: path, m", "pelvis_path_m",
      [](const auto& values) {
        return Fixed(values.empty() ? kNan : values.back(), 2);
      });
  std::string result = text.ToString();
  if (people > shown.size()) {
    result += "and " + std::to_string(people - shown.size()) + " more people\n";
  }
  return result;
}

std::string UpText(const std::optional<Eigen::Vector3d>& up) {
  if (!up.has_value()) return "not known";
  // Avoids -0.
  return fmt::format("({:g}, {:g}, {:g})", up->x() + 0.0, up->y() + 0.0,
                     up->z() + 0.0);
}

void RunKinematics() {
  UseAdapterFlag();
  RequireFlag("tracks", FLAGS_tracks);
  RequireFlag("out", FLAGS_out);
  RequireCsv();
  KinematicsOptions options;
  options.up = ParseUp(FLAGS_up);
  options.known.stated = StatedUp(FLAGS_tracks);
  options.observed_only = FLAGS_observed;
  const TrackSequence tracks = ReadInput();
  const PersonNames names = ReadPersonNames(FLAGS_tracks);
  const KinematicsTable table = MeasureKinematics(tracks, options);
  if (table.rows.empty()) throw InputError(FLAGS_tracks + ": has no people");
  if (table.columns.empty()) {
    throw InputError(FLAGS_tracks + ": the skeleton " +
                     Printable(tracks.header.skeleton.name()) +
                     " has none of the joints that angles need (--skeleton), "
                     "and there are no speeds");
  }
  WriteCsv(table, names);
  SayNotes(table.notes, "kinegraph-kinematics: ");
  std::FILE* summary = SummaryStream(FLAGS_out);
  if (!table.angles.empty()) std::fputs(Digest(table, names).c_str(), summary);
  std::fprintf(summary, "up is %s; %zu rows of %zu columns -> %s\n",
               UpText(table.up).c_str(), table.rows.size(),
               table.columns.size() + (names.empty() ? 3 : 4),
               FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"kinematics",
       "joint angles, speeds and distances of tracks, as CSV",
       "--tracks=F --out=NAME.csv [--up=AXIS] [--observed]",
       {"--tracks=take.jsonl --out=angles.csv",
        "--tracks=take.jsonl --up=z --observed --out=angles.csv"}},
      kinegraph::RunKinematics);
}
