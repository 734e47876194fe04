// A data set of poses as the Python package `movement` keeps them, for
// xarray: netCDF with the dimensions time, space, keypoints and individuals.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/constants.h"
#include "core/geometry/ball_probability.h"
#include "core/io/binary/netcdf_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr double kWithin_m = 0.05;

class MovementRecording {
 public:
  MovementRecording(const TrackSequence& tracks, const PersonNames& names)
      : tracks_(tracks),
        contents_(ContentsOf(tracks)),
        ids_(RequirePeople(tracks)),
        joint_count_(tracks.header.skeleton.joints().size()),
        individuals_(PersonTitles(ids_, names)) {
    people_.resize(tracks.frames.size() * ids_.size(), nullptr);
    for (size_t f = 0; f < tracks.frames.size(); ++f) {
      for (const PersonPose& person : tracks.frames[f].people) {
        const auto at =
            std::lower_bound(ids_.begin(), ids_.end(), person.id.value());
        people_[f * ids_.size() + static_cast<size_t>(at - ids_.begin())] =
            &person;
      }
    }
  }

  void Write(const std::string& path) const {
    NetcdfFile file;
    const int time = file.Dimension("time", tracks_.frames.size());
    const int space = file.Dimension("space", 3);
    const int keypoints = file.Dimension("keypoints", joint_count_);
    const int individuals = file.Dimension("individuals", ids_.size());
    AddAttributes(&file);
    file.Doubles("time", {time}, {}, [this](size_t f) {
      const TrackFrame& frame = tracks_.frames[f];
      return contents_.has_clock ? ToSeconds(frame.time)
                                 : static_cast<double>(frame.frame);
    });
    file.Texts("space", space, {"x", "y", "z"});
    file.Texts("keypoints", keypoints, tracks_.header.skeleton.joints());
    file.Texts("individuals", individuals, individuals_);
    file.Doubles("frame", {time}, {}, [this](size_t f) {
      return static_cast<double>(tracks_.frames[f].frame);
    });
    file.Doubles("identity", {individuals}, {},
                 [this](size_t p) { return static_cast<double>(ids_[p]); });
    const NetcdfFile::Attributes more = {{"coordinates", "frame identity"}};
    NetcdfFile::Attributes metres = more;
    metres.emplace_back("units", "m");
    const std::vector<int> dense = {time, space, keypoints, individuals};
    const std::vector<int> a_joint = {time, keypoints, individuals};
    file.Doubles("position", dense, metres,
                 [this](size_t i) { return Position(i); });
    NetcdfFile::Attributes confidence = more;
    confidence.emplace_back("long_name",
                            "probability that the joint lies within 50 mm");
    file.Doubles("confidence", a_joint, confidence,
                 [this](size_t i) { return Confidence(i); });
    NetcdfFile::Attributes status = more;
    status.emplace_back("long_name", "2 observed, 1 inferred, 0 missing");
    file.Bytes("status", a_joint, status,
               [this](size_t i) { return Status(i); });
    if (contents_.has_covariances) {
      metres.emplace_back("long_name", "standard deviation of the position");
      file.Doubles("position_sigma", dense, metres,
                   [this](size_t i) { return Sigma(i); });
    }
    file.Write(path);
  }

  const TrackContents& contents() const { return contents_; }

 private:
  void AddAttributes(NetcdfFile* file) const {
    file->Attribute("ds_type", "poses");
    file->Attribute("source_software", "kinegraph");
    file->Attribute("time_unit", contents_.has_clock ? "seconds" : "frames");
    if (tracks_.header.frame_rate_hz > 0.0) {
      file->Attribute("fps", tracks_.header.frame_rate_hz);
    }
  }

  // A joint in a frame: the place in [time, keypoints, individuals].
  struct Cell {
    const PersonPose* person;
    size_t joint_idx;
  };
  Cell CellOf(size_t i) const {
    const size_t p = i % ids_.size();
    const size_t rest = i / ids_.size();
    return {people_[rest / joint_count_ * ids_.size() + p],
            rest % joint_count_};
  }
  // The same in [time, space, keypoints, individuals].
  Cell CellOf(size_t i, int* axis) const {
    const size_t plane = joint_count_ * ids_.size();
    *axis = static_cast<int>(i / plane % 3);
    return CellOf(i / (3 * plane) * plane + i % plane);
  }

  static bool IsPresent(const Cell& cell) {
    return cell.person != nullptr &&
           cell.person->joints[cell.joint_idx].present();
  }
  static const Eigen::Matrix3d* CovarianceOf(const Cell& cell) {
    if (!IsPresent(cell) || cell.person->covariances.empty()) return nullptr;
    const auto& covariance = cell.person->covariances[cell.joint_idx];
    return covariance ? &*covariance : nullptr;
  }

  double Position(size_t i) const {
    int axis = 0;
    const Cell cell = CellOf(i, &axis);
    if (!IsPresent(cell)) return kNan;
    return cell.person->joints[cell.joint_idx].position_m[axis];
  }
  double Sigma(size_t i) const {
    int axis = 0;
    const Eigen::Matrix3d* covariance = CovarianceOf(CellOf(i, &axis));
    return covariance == nullptr ? kNan : std::sqrt((*covariance)(axis, axis));
  }
  double Confidence(size_t i) const {
    const Eigen::Matrix3d* covariance = CovarianceOf(CellOf(i));
    return covariance == nullptr ? kNan
                                 : ProbabilityWithin(kWithin_m, *covariance);
  }
  int8_t Status(size_t i) const {
    const Cell cell = CellOf(i);
    if (cell.person == nullptr) return 0;
    return static_cast<int8_t>(cell.person->joints[cell.joint_idx].status);
  }

  const TrackSequence& tracks_;
  const TrackContents contents_;
  const std::vector<int64_t> ids_;
  const size_t joint_count_;
  const std::vector<std::string> individuals_;
  std::vector<const PersonPose*> people_;  // [time, individuals]
};

void WriteTracksMovement(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& options,
                         LostFields* lost_fields) {
  const MovementRecording recording(tracks, options.names);
  recording.Write(path);
  lost_fields->push_back("bones, views and configuration are not kept");
  if (recording.contents().has_covariances) {
    lost_fields->push_back(
        "of a covariance the standard deviation of each axis is kept");
  } else {
    lost_fields->push_back("confidence is NaN: the tracks have no covariances");
  }
  if (!recording.contents().has_clock) {
    lost_fields->push_back("times are frame numbers (--frame_rate=HZ)");
  }
}

}  // namespace

TrackFormat MovementTrackFormat() {
  TrackFormat format;
  format.name = "movement";
  format.layout = "netCDF for movement and xarray, m";
  format.extensions = {".nc"};
  format.has_marker_names = true;
  format.keeps_names = true;
  format.write = WriteTracksMovement;
  return format;
}

}  // namespace kinegraph
