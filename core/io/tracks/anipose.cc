// The table that Anipose's `triangulate` writes (pose-3d): a row a frame;
// NAME_x, NAME_y, NAME_z [mm], NAME_error, NAME_ncams and NAME_score of each
// joint, then the rotation M_00 .. M_22 and the centre by which Anipose turned
// the points (none here), and the frame's number. A file is one person.
#include "core/base/constants.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr const char* kAniposeExtension = ".csv";

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

// Empty cells are NaN for those who read them.
void WriteAniposeJoint(const PersonPose* person, size_t joint_idx,
                       JsonOutput* out) {
  if (person == nullptr || !person->joints[joint_idx].present()) {
    out->Text(",,,,,,");
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    out->Add(kMillimetresPerMetre * person->joints[joint_idx].position_m[axis],
             ",");
  }
  out->Text(",");  // the reprojection error is not in the tracks
  if (!person->inlier_views.empty()) {
    out->Integer(person->inlier_views[joint_idx]);
  }
  out->Text(",,");
}

void WriteAniposePerson(const std::string& path, TrackId id,
                        const TrackSequence& tracks,
                        const std::vector<TrackRow>& rows) {
  AtomicFile file(path);
  file.Write(TitleRow(tracks.header.skeleton));
  const size_t joint_count = tracks.header.skeleton.joints().size();
  int64_t number = tracks.frames.front().frame;
  JsonOutput out;
  for (const TrackRow& row : rows) {
    const PersonPose* person = FindPerson(row.frame, id);
    for (size_t j = 0; j < joint_count; ++j) WriteAniposeJoint(person, j, &out);
    out.Add("1,0,0,0,1,0,0,0,1,0,0,0,", number++, "\n");
    out.FlushTo(&file);
  }
  file.Commit();
}

void WriteTracksAnipose(const std::string& path, const TrackSequence& tracks,
                        const TrackExportOptions& options,
                        LostFields* lost_fields) {
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "Anipose");
  WritePersonFiles(path, kAniposeExtension, tracks, options.names,
                   [&](const std::string& file, TrackId id) {
                     WriteAniposePerson(file, id, tracks, rows);
                   });
  const TrackContents contents = ContentsOf(tracks);
  lost_fields->push_back(
      "bones, times, frame rate and configuration are not kept; errors and "
      "scores are empty");
  if (contents.has_inferred) {
    lost_fields->push_back("inferred joints are written like observed ones");
  }
  if (contents.has_covariances) {
    lost_fields->push_back("covariances are not kept");
  }
  NoteAddedRows(tracks, rows.size(), "have empty cells", lost_fields);
}

}  // namespace

TrackFormat AniposeTrackFormat() {
  TrackFormat format;
  format.name = "anipose";
  format.layout = "Anipose's table of 3D points, mm, a file a person";
  format.files = TrackFormat::Files::kFileAPerson;
  format.person_extension = kAniposeExtension;
  format.has_marker_names = true;
  format.keeps_names = true;
  format.write = WriteTracksAnipose;
  return format;
}

}  // namespace kinegraph
