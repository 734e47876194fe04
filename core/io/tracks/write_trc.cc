// TRC, the marker format of OpenSim and Pose2Sim: tab-separated, five header
// lines, then a row a frame. The layout is that of the files Pose2Sim writes,
// but each row ends with a tabulator, as in OpenSim's: its reader counts what
// follows the last one only where it is not empty, and refuses rows that lack a
// cell.
#include <fmt/format.h>

#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"
#include "core/io/tracks/person_files.h"
#include "core/io/tracks/rows.h"

namespace kinegraph {
namespace {

constexpr const char* kTrcExtension = ".trc";

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
  const auto joint_count =
      static_cast<size_t>(tracks.header.skeleton.joint_count());
  JsonOutput out;
  for (size_t r = 0; r < rows.size(); ++r) {
    out.Add(r + 1, "\t", rows[r].time_s);
    WriteMarkers(FindPerson(rows[r].frame, id), joint_count, axes, &out);
    out.Text("\t\n");
    out.FlushTo(&file);
  }
  file.Commit();
}

void NoteTrcLosses(const TrackSequence& tracks, size_t row_count,
                   LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  lost_fields->push_back("bones and configuration are not kept");
  NotePlainPositions(contents, lost_fields);
  NoteAddedRows(tracks, row_count, "have empty rows", lost_fields);
}

}  // namespace

void WriteTracksTrc(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  RequireFrameRate(tracks, "TRC");
  CheckMarkerNames(tracks.header.skeleton);
  const std::vector<int64_t> ids = PeopleToWrite(path, kTrcExtension, tracks);
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "TRC");
  WritePersonFiles(path, kTrcExtension, ids, options.names,
                   [&](const std::string& file, TrackId id) {
                     WriteTrcPerson(file, id, tracks, rows,
                                    options.axes.value_or(AxisMap()));
                   });
  NoteTrcLosses(tracks, rows.size(), lost_fields);
  constexpr int64_t kKeptIds = 1'000'000'000'000'000'000;  // 18 digits
  NoteRenumbering(tracks, kKeptIds, lost_fields);
}

}  // namespace kinegraph
