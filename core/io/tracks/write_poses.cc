// {"unit": "m", "poses": [{"frame", "id", "joints": [[x, y, z] or null]}]}.
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

void WriteJoint(const Joint3d& joint, JsonOutput* out) {
  if (!joint.present()) return out->Text("null");
  const Eigen::Vector3d& at_m = joint.position_m;
  out->Text("[");
  out->Numbers({at_m.x(), at_m.y(), at_m.z()});
  out->Text("]");
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
                      const TrackExportOptions& /*options*/,
                      LostFields* lost_fields) {
  AtomicFile file(path);
  file.Write("{\"unit\": \"m\", \"poses\": [");
  JsonOutput out;
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      out.Text(separator);
      separator = ",\n";
      out.Add("{\"frame\": ", frame.frame, ", \"id\": ", person.id.value(),
              ", \"joints\": [");
      out.Join(person.joints,
               [&](const Joint3d& joint) { WriteJoint(joint, &out); });
      out.Text("]}");
    }
    out.FlushTo(&file);
  }
  file.Write("\n]}\n");
  file.Commit();
  NotePosesLosses(tracks, lost_fields);
}

}  // namespace kinegraph
