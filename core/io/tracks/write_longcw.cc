// longcw's annotation_3d.json: [{"timestamp": s, "poses": [{"id", "points_3d":
// [[x, y, z] cm], "scores": [1 or 0]}]}].
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

void WritePose(const PersonPose& person, JsonOutput* out) {
  out->Add("{\"id\": ", person.id.value(), ", \"points_3d\": [");
  out->Join(person.joints, [out](const Joint3d& joint) {
    Eigen::Vector3d at_cm = Eigen::Vector3d::Zero();
    if (joint.present()) at_cm = kCentimetresPerMetre * joint.position_m;
    out->Text("[");
    out->Numbers({at_cm.x(), at_cm.y(), at_cm.z()});
    out->Text("]");
  });
  out->Text("], \"scores\": [");
  out->Join(person.joints, [out](const Joint3d& joint) {
    out->Text(joint.present() ? "1" : "0");
  });
  out->Text("]}");
}

}  // namespace

void WriteTracksLongcw(const std::string& path, const TrackSequence& tracks,
                       const TrackExportOptions& /*options*/,
                       LostFields* lost_fields) {
  const double rate = tracks.header.frame_rate_hz;
  RequireLongcwRate(rate);
  AtomicFile file(path);
  JsonOutput out;
  out.Text("[");
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    RequireLongcwTime(frame.frame, frame.time, rate);
    out.Text(separator);
    separator = ",\n";
    out.Text("{\"timestamp\": ");
    out.Seconds(frame.time);
    out.Text(", \"poses\": [");
    out.Join(frame.people,
             [&](const PersonPose& person) { WritePose(person, &out); });
    out.Text("]}");
    out.FlushTo(&file);
  }
  file.Write(tracks.frames.empty() ? "[]\n" : "\n]\n");
  file.Commit();
  NotePositionsOnly(tracks, lost_fields);
  constexpr int64_t kKeptIds = int64_t{1} << 31;  // by its reader
  NoteRenumbering(tracks, kKeptIds, lost_fields);
  if (rate != kLongcwFrameRateHz) {
    lost_fields->push_back("the frame rate is not kept: name it when reading");
  }
  const Skeleton& skeleton = tracks.header.skeleton;
  if (skeleton != Tum14() && skeleton != Coco17())
    NoteSkeleton(tracks, lost_fields);
}

}  // namespace kinegraph
