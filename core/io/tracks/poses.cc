// {"poses": [{"frame", "id", "joints": [[x, y, z] or null, ...]}, ...]}, in
// metres: outputs of other programs in the data folder. A joint may also be
// [null, null, null]. 4D association's has its own skeleton as "joints19".
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

const Skeleton& PosesSkeleton(size_t joint_count) {
  if (const Skeleton* skeleton = SkeletonOfPoses(joint_count)) return *skeleton;
  throw InputError("joints: found " + std::to_string(joint_count) +
                   ", expected 17 (COCO), 14, 15, 19 or 25");
}

bool IsMissing(JsonValue joint) {
  if (joint.is_null()) return true;
  JsonArray array;
  if (joint.get_array().get(array)) return false;
  for (const JsonValue number : array) {
    if (!number.is_null()) return false;
  }
  return array.size() == 3;
}

void ReadJoints(const JsonArray& joints, std::string_view key, Pose3d* pose) {
  if (joints.size() != pose->size()) {
    throw InputError(std::string(key) + ": found " +
                     std::to_string(joints.size()) + ", expected " +
                     std::to_string(pose->size()));
  }
  size_t j = 0;
  for (const JsonValue joint : joints) {
    if (!IsMissing(joint)) {
      double m[3];
      AsNumbers(joint, key, 3, m);
      (*pose)[j] = ObservedJoint(m[0], m[1], m[2]);
    }
    ++j;
  }
}

void CheckUnit(const JsonObject& root) {
  JsonValue unit;
  if (root.at_key("unit").get(unit)) return;
  if (AsText(unit, "unit") != "m") {
    throw InputError("unit: found '" +
                     Printable(std::string(AsText(unit, "unit"))) +
                     "', expected m");
  }
}

TrackSequence ReadPosesFile(const JsonObject& root,
                            const TrackReadOptions& options,
                            std::string* place) {
  CheckUnit(root);
  const JsonArray poses = AsArray(Required(root, "poses"), "poses");
  const bool own_joints = options.skeleton && *options.skeleton == FourDA19();
  const char* const key = own_joints ? "joints19" : "joints";
  TrackHeader header;
  header.mode = "poses";
  header.frame_rate_hz = options.frame_rate_hz;
  header.skeleton = options.skeleton.value_or(Coco17());
  if (!options.skeleton && poses.begin() != poses.end()) {
    const JsonObject first = AsObject(*poses.begin(), "poses");
    header.skeleton = PosesSkeleton(AsArray(Required(first, key), key).size());
  }
  TrackCollector collector(std::move(header));
  size_t index = 0;
  for (const JsonValue value : poses) {
    *place = "poses[" + std::to_string(index++) + "]";
    const JsonObject pose = AsObject(value, "poses");
    const int64_t frame = AsFrame(Required(pose, "frame"), "frame");
    const TrackId id(AsId(Required(pose, "id"), "id"));
    ReadJoints(AsArray(Required(pose, key), key), key,
               &collector.Add(frame, id)->joints);
  }
  return collector.Finish();
}

TrackSequence ReadPoses(const std::string& path,
                        const TrackReadOptions& options) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] {
        return ReadPosesFile(AsObject(root, kOutermost), options, &place);
      });
}

// ---- Writing ----

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

// {"unit": "m", "poses": [{"frame", "id", "joints": [[x, y, z] or null]}]}.
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

}  // namespace

const Skeleton* SkeletonOfPoses(size_t joint_count) {
  for (const Skeleton* skeleton :
       {&Coco17(), &Tum14(), &Tum15(), &FourDA19(), &Body25()}) {
    if (joint_count == skeleton->joints().size()) return skeleton;
  }
  return nullptr;
}

TrackFormat PosesTrackFormat() {
  TrackFormat format;
  format.name = "poses";
  format.layout = "JSON: {\"poses\": [...]}";
  format.recognise = [](const TrackHead& head) { return head.HasKey("poses"); };
  format.read = ReadPoses;
  format.write = WriteTracksPoses;
  format.kept = "frame, identity, positions";
  format.lost = "times, status, covariances, frames with nobody";
  return format;
}

}  // namespace kinegraph
