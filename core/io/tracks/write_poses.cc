// {"unit": "m", "poses": [{"frame", "id", "joints": [[x, y, z] or null]}]}.
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

void WriteJoints(const Pose3d& joints, JsonOutput* out) {
  const char* separator = "";
  for (const Joint3d& joint : joints) {
    out->Text(separator);
    separator = ", ";
    if (!joint.present()) {
      out->Text("null");
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      out->Text(axis == 0 ? "[" : ", ");
      out->Number(joint.position_m[axis]);
    }
    out->Text("]");
  }
}

void NotePosesLosses(const TrackSequence& tracks, LostFields* lost_fields) {
  NotePositionsOnly(tracks, lost_fields);
  NoteClock(tracks, lost_fields);
  const int64_t empty_frames = ContentsOf(tracks).empty_frames;
  if (empty_frames > 0) {
    lost_fields->push_back(std::to_string(empty_frames) +
                           " frames with nobody in them are not kept");
  }
  const Skeleton* told = SkeletonOfPoses(
      static_cast<size_t>(tracks.header.skeleton.joint_count()));
  if (told == nullptr || *told != tracks.header.skeleton) {
    NoteSkeleton(tracks, lost_fields);
  }
}

}  // namespace

void WriteTracksPoses(const std::string& path, const TrackSequence& tracks,
                      LostFields* lost_fields) {
  AtomicFile file(path);
  file.Write("{\"unit\": \"m\", \"poses\": [");
  JsonOutput out;
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      out.Text(separator);
      separator = ",\n";
      out.Text("{\"frame\": ");
      out.Integer(frame.frame);
      out.Text(", \"id\": ");
      out.Integer(person.id.value());
      out.Text(", \"joints\": [");
      WriteJoints(person.joints, &out);
      out.Text("]}");
    }
    file.Write(out.text().data(), out.text().size());
    out.Clear();
  }
  file.Write("\n]}\n");
  file.Commit();
  NotePosesLosses(tracks, lost_fields);
}

}  // namespace kinegraph
