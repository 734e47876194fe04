// Tidy CSV of tracks, one row a joint (RFC 4180 quoting, lines end with \n).
#include <algorithm>

#include "core/io/files/atomic_file.h"
#include "core/io/text/csv_cell.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

constexpr const char* kCovarianceColumns =
    ",cov_xx_m2,cov_xy_m2,cov_xz_m2,cov_yy_m2,cov_yz_m2,cov_zz_m2";

class CsvWriter {
 public:
  CsvWriter(const std::string& path, const TrackSequence& tracks,
            const PersonNames& names)
      : contents_(ContentsOf(tracks)), file_(path) {
    for (const auto& [id, name] : names) names_[id] = CsvCell(name);
    for (const std::string& joint : tracks.header.skeleton.joints()) {
      joints_.push_back(CsvCell(joint));
    }
    out_.Text("frame,time_s,id,joint,x_m,y_m,z_m,status");
    if (contents_.has_views) out_.Text(",views");
    if (contents_.has_covariances) out_.Text(kCovarianceColumns);
    if (!names_.empty()) out_.Text(",name");
    out_.Text("\n");
  }

  void Write(const TrackFrame& frame) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        WriteRow(frame, person, j);
      }
    }
    out_.FlushTo(&file_);
  }

  void Commit() {
    out_.FlushTo(&file_);
    file_.Commit();
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
      out_.Text(",");
      if (name != names_.end()) out_.Text(name->second);
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

  const TrackContents contents_;
  AtomicFile file_;
  JsonOutput out_;
  std::vector<std::string> joints_;  // as cells
  PersonNames names_;                // as cells
};

}  // namespace

void WriteTracksCsv(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  CsvWriter writer(path, tracks, options.names);
  for (const TrackFrame& frame : tracks.frames) writer.Write(frame);
  writer.Commit();
  lost_fields->push_back("bones, frame rate and configuration are not kept");
  const TrackContents& contents = writer.contents();
  if (!contents.has_clock) lost_fields->push_back(kNoClock);
  if (contents.has_matches) lost_fields->push_back("matches are not kept");
  if (contents.empty_frames > 0) {
    lost_fields->push_back(std::to_string(contents.empty_frames) +
                           " frames with nobody in them are not kept");
  }
}

}  // namespace kinegraph
