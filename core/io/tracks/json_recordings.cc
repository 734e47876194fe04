// Recordings in one JSON file:
// - poses, output of other programs: {"poses": [{"frame", "id", "joints":
//   [[x, y, z] or null, ...]}, ...]}, in metres. A joint may also be [null,
//   null, null]. Files of 4D association also have "joints19", its own
//   skeleton.
// - longcw's annotation_3d.json and result_3d.json: [{"timestamp": s, "poses":
//   [{"id", "points_3d": [[x, y, z] cm, ...], "scores": [...]}]}, ...]. A joint
//   with score 0 or less is missing. Ids of results may exceed 2^63.
#include <set>
#include <unordered_map>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// Returns read(root, &place) for the outermost value of a file. Errors name the
// file and `place`, which `read` sets to the entry that it reads.
template <typename Read>
auto ReadJsonFile(const std::string& path, const Read& read) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; }, [&] { return read(root, &place); });
}

// ---- poses ----

// The skeleton assumed for this number of joints, or null.
const Skeleton* SkeletonOfPoses(size_t joint_count) {
  for (const Skeleton* skeleton :
       {&Coco17(), &Tum14(), &Tum15(), &FourDA19(), &Body25()}) {
    if (joint_count == skeleton->joints().size()) return skeleton;
  }
  return nullptr;
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
  CheckCount(key, joints.size(), pose->size(), "");
  size_t j = 0;
  for (const JsonValue joint : joints) {
    if (!IsMissing(joint)) {
      Vector3d at_m;
      AsNumbers(joint, key, 3, at_m.data());
      (*pose)[j] = ObservedJoint(at_m);
    }
    ++j;
  }
}

TrackSequence ReadPoses(JsonValue outermost, const TrackReadOptions& options,
                        std::string* place) {
  const JsonObject root = AsObject(outermost, kOutermost);
  JsonValue unit;
  if (Get(root, "unit", &unit) && AsText(unit, "unit") != "m") {
    Refuse("unit: found '{}', expected m",
           Printable(std::string(AsText(unit, "unit"))));
  }
  const JsonArray poses = AsArray(Required(root, "poses"), "poses");
  const bool own_joints = options.skeleton && *options.skeleton == FourDA19();
  const char* const key = own_joints ? "joints19" : "joints";
  Skeleton skeleton = options.skeleton.value_or(Coco17());
  if (!options.skeleton && poses.begin() != poses.end()) {
    const JsonObject first = AsObject(*poses.begin(), "poses");
    const size_t count = AsArray(Required(first, key), key).size();
    const Skeleton* known = SkeletonOfPoses(count);
    if (known == nullptr) {
      Refuse("joints: found {}, expected 17 (COCO), 14, 15, 19 or 25", count);
    }
    skeleton = *known;
  }
  TrackCollector collector("poses", skeleton, options);
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

// ---- longcw ----

uint64_t ReadLongcwId(const JsonObject& pose) {
  uint64_t id = 0;
  if (Required(pose, "id").get_uint64().get(id)) {
    throw InputError("id: expected an integer of 0 .. 2^64 - 1");
  }
  return id;
}

const Skeleton& LongcwSkeleton(size_t joint_count) {
  if (joint_count == 14) return Tum14();
  if (joint_count == 17) return Coco17();
  Refuse("points_3d: found {} joints, expected 14 (TUM) or 17 (COCO)",
         joint_count);
}

void ReadLongcwPose(const JsonObject& object, Pose3d* pose) {
  std::vector<double> scores(pose->size());
  AsNumbers(Required(object, "scores"), "scores", scores.size(), scores.data());
  const JsonArray points = AsArray(Required(object, "points_3d"), "points_3d");
  CheckCount("points_3d", points.size(), pose->size(), " joints");
  size_t j = 0;
  for (const JsonValue point : points) {
    Vector3d cm;
    AsNumbers(point, "points_3d", 3, cm.data());
    if (scores[j] > 0.0) (*pose)[j] = ObservedJoint(kMetresPerCentimetre * cm);
    ++j;
  }
}

TrackSequence ReadLongcw(JsonValue outermost, const TrackReadOptions& options,
                         std::string* place) {
  const JsonArray frames = AsArray(outermost, kOutermost);
  // Calls `visit(frame, poses)` for each entry; errors name the entry.
  const auto for_each_frame = [&](const auto& visit) {
    size_t index = 0;
    for (const JsonValue value : frames) {
      *place = "entry " + std::to_string(index++);
      const JsonObject frame = AsObject(value, "a frame");
      visit(frame, AsArray(Required(frame, "poses"), "poses"));
    }
  };
  // Collect all ids and the skeleton first. If all ids are below 2^31, they are
  // kept: in annotations they are the actors' numbers. Otherwise they are
  // replaced by 0, 1, 2 in order of appearance.
  bool all_small = true;
  std::unordered_map<uint64_t, int64_t> order;
  std::optional<Skeleton> skeleton = options.skeleton;
  for_each_frame([&](const JsonObject&, const JsonArray& poses) {
    for (const JsonValue value : poses) {
      const JsonObject pose = AsObject(value, "poses");
      const uint64_t id = ReadLongcwId(pose);
      all_small = all_small && id < uint64_t{1} << 31;
      order.emplace(id, static_cast<int64_t>(order.size()));
      if (skeleton.has_value()) continue;
      skeleton = LongcwSkeleton(
          AsArray(Required(pose, "points_3d"), "points_3d").size());
    }
  });
  const double rate_hz =
      options.frame_rate_hz > 0.0 ? options.frame_rate_hz : kLongcwFrameRateHz;
  TrackCollector collector("longcw", skeleton.value_or(Tum14()), options,
                           rate_hz);
  std::set<int64_t> seen;
  for_each_frame([&](const JsonObject& frame, const JsonArray& poses) {
    const LongcwTime time =
        ReadLongcwTime(Required(frame, "timestamp"), rate_hz);
    if (!seen.insert(time.frame).second) {
      Refuse("frame {} appears twice", time.frame);
    }
    collector.Touch(time.frame)->time = time.time;
    for (const JsonValue value : poses) {
      const JsonObject pose = AsObject(value, "poses");
      const uint64_t id = ReadLongcwId(pose);
      const TrackId kept(all_small ? static_cast<int64_t>(id) : order.at(id));
      ReadLongcwPose(pose, &collector.Add(time.frame, kept)->joints);
    }
  });
  return collector.Finish();
}

}  // namespace

bool RecognisePosesTracks(const TrackHead& head) {
  return head.HasKey("poses");
}

TrackSequence ReadPosesTracks(const std::string& path,
                              const TrackReadOptions& options) {
  return ReadJsonFile(path, [&](JsonValue root, std::string* place) {
    return ReadPoses(root, options, place);
  });
}

bool RecogniseLongcwTracks(const TrackHead& head) { return head.kind == '['; }

TrackSequence ReadLongcwTracks(const std::string& path,
                               const TrackReadOptions& options) {
  return ReadJsonFile(path, [&](JsonValue root, std::string* place) {
    return ReadLongcw(root, options, place);
  });
}

// The format identifies frames by their times, which requires a frame rate.
void WriteLongcwTracks(const std::string& path, const TrackSequence& tracks,
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
    out.Add(separator, "{\"timestamp\": ", ToSeconds(frame.time),
            ", \"poses\": [");
    separator = ",\n";
    out.Join(frame.people, [&](const PersonPose& person) {
      out.Add("{\"id\": ", person.id.value(), ", \"points_3d\": [");
      out.Join(person.joints, [&](const Joint3d& joint) {
        const Vector3d at_cm = CentimetresOf(joint);
        out.Text("[");
        out.Numbers({at_cm.x(), at_cm.y(), at_cm.z()});
        out.Text("]");
      });
      out.Text("], \"scores\": [");
      out.Join(person.joints, [&](const Joint3d& joint) {
        out.Text(joint.present() ? "1" : "0");
      });
      out.Text("]}");
    });
    out.Text("]}");
    out.FlushTo(&file);
  }
  file.Write(tracks.frames.empty() ? "[]\n" : "\n]\n");
  file.Commit();
  NotePositionsOnly(ContentsOf(tracks), lost_fields);
  constexpr int64_t kKeptIds = int64_t{1} << 31;  // kept by the reader
  NoteRenumbering(tracks, kKeptIds, lost_fields);
  if (rate != kLongcwFrameRateHz) {
    lost_fields->push_back(
        "the frame rate is not kept: specify it when reading");
  }
  const Skeleton& skeleton = tracks.header.skeleton;
  if (skeleton != Tum14() && skeleton != Coco17()) {
    NoteSkeleton(tracks, lost_fields);
  }
}

}  // namespace kinegraph
