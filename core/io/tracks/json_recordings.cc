// Recordings as one JSON file:
// - poses, outputs of other programs: {"poses": [{"frame", "id", "joints":
//   [[x, y, z] or null, ...]}, ...]}, in metres. A joint may also be [null,
//   null, null]. 4D association's has its own skeleton as "joints19".
// - coco3d, in COCO's manner and metres: `images` are the frames (id is the
//   frame's number), `annotations` the people, with `keypoints_3d` = x, y, z, v
//   a joint (v as COCO's: 2 observed, 1 inferred, 0 without position) and
//   `track_id`; the first of `categories` names joints and bones (from 1).
// - longcw's annotation_3d.json and result_3d.json: [{"timestamp": s, "poses":
//   [{"id", "points_3d": [[x, y, z] cm, ...], "scores": [...]}]}, ...]. A joint
//   with score 0 is missing. Results have ids beyond 2^63.
#include <nlohmann/json.hpp>
#include <set>
#include <unordered_map>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/text/skeleton_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

using Eigen::Vector3d;

// What `read(root, &place)` makes of a file. Its errors get the file and
// `place`.
template <typename Read>
auto ReadJsonFile(const std::string& path, const Read& read) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; }, [&] { return read(root, &place); });
}

// Calls `read` with each of the objects of the array `key`.
template <typename Read>
void ForEachObject(const JsonArray& array, const std::string& key,
                   std::string* place, const Read& read) {
  size_t index = 0;
  for (const JsonValue value : array) {
    *place = key + "[" + std::to_string(index++) + "]";
    read(AsObject(value, key));
  }
}

Vector3d PositionOrZero(const Joint3d& joint) {
  return joint.present() ? joint.position_m : Vector3d(Vector3d::Zero());
}

void WritePoint(const Vector3d& at, JsonOutput* out) {
  out->Text("[");
  out->Numbers({at.x(), at.y(), at.z()});
  out->Text("]");
}

// ---- poses ----

// Skeleton that a file with so many joints is taken to have, or null.
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
    const Skeleton* told = SkeletonOfPoses(count);
    if (told == nullptr) {
      Refuse("joints: found {}, expected 17 (COCO), 14, 15, 19 or 25", count);
    }
    skeleton = *told;
  }
  TrackCollector collector("poses", skeleton, options);
  ForEachObject(poses, "poses", place, [&](const JsonObject& pose) {
    const int64_t frame = AsFrame(Required(pose, "frame"), "frame");
    const TrackId id(AsId(Required(pose, "id"), "id"));
    ReadJoints(AsArray(Required(pose, key), key), key,
               &collector.Add(frame, id)->joints);
  });
  return collector.Finish();
}

// ---- coco3d ----

std::string CategoryText(const Skeleton& skeleton) {
  Json bones = Json::array();
  for (const Bone& bone : skeleton.bones()) {
    bones.push_back({bone.a + 1, bone.b + 1});
  }
  const Json category = {{"id", 1},
                         {"name", "person"},
                         {"keypoints", skeleton.joints()},
                         {"skeleton", bones},
                         {"layout", skeleton.name()}};
  return DumpJson(category);
}

std::string InfoText(const TrackHeader& header) {
  Json info = {{"description", "keypoints_3d: x, y, z, v of each joint"},
               {"unit", "m"}};
  if (header.frame_rate_hz > 0.0) info["frame_rate"] = header.frame_rate_hz;
  return DumpJson(info);
}

void WriteAnnotation(const PersonPose& person, int64_t frame, int64_t number,
                     const PersonNames& names, JsonOutput* out) {
  out->Add("{\"id\": ", number, ", \"image_id\": ", frame,
           ", \"category_id\": 1, \"track_id\": ", person.id.value());
  const auto name = names.find(person.id);
  if (name != names.end()) out->Text(", \"name\": " + JsonText(name->second));
  out->Add(", \"num_keypoints\": ", CountPresent(person.joints),
           ", \"keypoints_3d\": [");
  out->Join(person.joints, [out](const Joint3d& joint) {
    const Vector3d at_m = PositionOrZero(joint);
    out->Numbers({at_m.x(), at_m.y(), at_m.z()});
    out->Add(", ", static_cast<int>(joint.status));  // as COCO counts
  });
  out->Text("]}");
}

Skeleton SkeletonOf(const JsonObject& category,
                    const TrackReadOptions& options) {
  std::vector<std::string> joints;
  for (const JsonValue joint :
       AsArray(Required(category, "keypoints"), "keypoints")) {
    joints.emplace_back(AsText(joint, "keypoints"));
  }
  std::vector<Bone> bones;
  JsonValue skeleton;
  if (Get(category, "skeleton", &skeleton)) {
    bones = ReadBones(skeleton, "skeleton", 1, static_cast<int>(joints.size()));
  }
  return SkeletonOfNames(joints, options, bones);
}

// The frame rate that the file tells, where the options do not; 0: it does not.
double ReadInfo(const JsonObject& root, const TrackReadOptions& options) {
  JsonValue info;
  JsonValue value;
  double rate_hz = 0.0;
  if (!Get(root, "info", &info)) return rate_hz;
  const JsonObject object = AsObject(info, "info");
  if (options.frame_rate_hz == 0.0 && Get(object, "frame_rate", &value)) {
    rate_hz = AsFrameRate(value, "frame_rate");
  }
  if (Get(object, "unit", &value) && AsText(value, "unit") != "m") {
    throw InputError("unit: expected m");
  }
  return rate_hz;
}

void ReadAnnotation(const JsonObject& entry, TrackCollector* collector) {
  const int64_t frame = AsFrame(Required(entry, "image_id"), "image_id");
  const TrackId id(AsId(Required(entry, "track_id"), "track_id"));
  constexpr double kInferred = 1.5;  // between COCO's 1 and 2
  ReadWeighted(entry, "keypoints_3d", 1.0, kInferred,
               &collector->Add(frame, id)->joints);
}

TrackSequence ReadCoco3d(JsonValue outermost, const TrackReadOptions& options,
                         std::string* place) {
  const JsonObject root = AsObject(outermost, kOutermost);
  const double rate_hz = ReadInfo(root, options);
  const JsonArray categories =
      AsArray(Required(root, "categories"), "categories");
  if (categories.size() == 0) throw InputError("categories: is empty");
  TrackCollector collector(
      "coco3d",
      SkeletonOf(AsObject(*categories.begin(), "categories"), options), options,
      rate_hz);
  ForEachObject(AsArray(Required(root, "images"), "images"), "images", place,
                [&](const JsonObject& image) {
                  TrackFrame* frame =
                      collector.Touch(AsFrame(Required(image, "id"), "id"));
                  JsonValue time;
                  if (Get(image, "time_s", &time)) {
                    frame->time = AsTime(time, "time_s");
                  }
                });
  ForEachObject(AsArray(Required(root, "annotations"), "annotations"),
                "annotations", place, [&](const JsonObject& entry) {
                  ReadAnnotation(entry, &collector);
                });
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
  // Runs `visit(frame, poses)` on each entry, which errors name.
  const auto for_each_frame = [&](const auto& visit) {
    size_t index = 0;
    for (const JsonValue value : frames) {
      *place = "entry " + std::to_string(index++);
      const JsonObject frame = AsObject(value, "a frame");
      visit(frame, AsArray(Required(frame, "poses"), "poses"));
    }
  };
  // All ids and the skeleton, before anything is made of them. Small ids are
  // kept: those of an annotation are the actors' numbers. Where one is not
  // small, all count 0, 1, 2 in order of appearance.
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
  TrackCollector collector("longcw", skeleton.value_or(Tum14()), options,
                           kLongcwFrameRateHz);
  std::set<int64_t> seen;
  for_each_frame([&](const JsonObject& frame, const JsonArray& poses) {
    const LongcwTime time = ReadLongcwTime(Required(frame, "timestamp"),
                                           collector.header().frame_rate_hz);
    if (!seen.insert(time.frame).second) {
      Refuse("frame {} stands there twice", time.frame);
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

void WritePosesTracks(const std::string& path, const TrackSequence& tracks,
                      const TrackExportOptions& /*options*/,
                      LostFields* lost_fields) {
  AtomicFile file(path);
  file.Write("{\"unit\": \"m\", \"poses\": [");
  JsonOutput out;
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      out.Add(separator, "{\"frame\": ", frame.frame,
              ", \"id\": ", person.id.value(), ", \"joints\": [");
      separator = ",\n";
      out.Join(person.joints, [&](const Joint3d& joint) {
        joint.present() ? WritePoint(joint.position_m, &out) : out.Text("null");
      });
      out.Text("]}");
    }
    out.FlushTo(&file);
  }
  file.Write("\n]}\n");
  file.Commit();
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteLosses(contents, {Loss::kClock, Loss::kEmptyFrames}, lost_fields);
  const Skeleton& skeleton = tracks.header.skeleton;
  const Skeleton* told = SkeletonOfPoses(skeleton.joints().size());
  if (told == nullptr || *told != skeleton) NoteSkeleton(tracks, lost_fields);
}

bool RecogniseCoco3dTracks(const TrackHead& head) {
  return head.HasKey("categories") && head.HasKey("images") &&
         head.beginning.find("keypoints_3d") != std::string::npos;
}

TrackSequence ReadCoco3dTracks(const std::string& path,
                               const TrackReadOptions& options) {
  return ReadJsonFile(path, [&](JsonValue root, std::string* place) {
    return ReadCoco3d(root, options, place);
  });
}

PersonNames ReadCoco3dNames(const std::string& path) {
  return ReadJsonFile(path, [](JsonValue root, std::string*) {
    PersonNames names;
    for (const JsonValue value :
         AsArray(Required(AsObject(root, kOutermost), "annotations"),
                 "annotations")) {
      const JsonObject entry = AsObject(value, "annotations");
      JsonValue name;
      if (!Get(entry, "name", &name)) continue;
      names[TrackId(AsId(Required(entry, "track_id"), "track_id"))] =
          std::string(AsText(name, "name"));
    }
    return names;
  });
}

void WriteCoco3dTracks(const std::string& path, const TrackSequence& tracks,
                       const TrackExportOptions& options,
                       LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  AtomicFile file(path);
  file.Write("{\"info\": " + InfoText(tracks.header) + ",\n\"categories\": [" +
             CategoryText(tracks.header.skeleton) + "],\n\"images\": [");
  JsonOutput out;
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    out.Add(separator, "{\"id\": ", frame.frame);
    separator = ",\n";
    if (contents.has_clock) out.Add(", \"time_s\": ", ToSeconds(frame.time));
    out.Text("}");
    out.FlushTo(&file);
  }
  out.Text("],\n\"annotations\": [");
  separator = "\n";
  int64_t number = 0;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      out.Text(separator);
      separator = ",\n";
      WriteAnnotation(person, frame.frame, ++number, options.names, &out);
    }
    out.FlushTo(&file);
  }
  out.Text("]}\n");
  out.FlushTo(&file);
  file.Commit();
  lost_fields->push_back("the configuration is not kept");
  NoteLosses(contents, {Loss::kCovariances, Loss::kViews, Loss::kUnknownClock},
             lost_fields);
}

bool RecogniseLongcwTracks(const TrackHead& head) { return head.kind == '['; }

TrackSequence ReadLongcwTracks(const std::string& path,
                               const TrackReadOptions& options) {
  return ReadJsonFile(path, [&](JsonValue root, std::string* place) {
    return ReadLongcw(root, options, place);
  });
}

// Frames are told by their times alone, so it needs a frame rate.
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
        WritePoint(kCentimetresPerMetre * PositionOrZero(joint), &out);
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
  constexpr int64_t kKeptIds = int64_t{1} << 31;  // by its reader
  NoteRenumbering(tracks, kKeptIds, lost_fields);
  if (rate != kLongcwFrameRateHz) {
    lost_fields->push_back("the frame rate is not kept: name it when reading");
  }
  const Skeleton& skeleton = tracks.header.skeleton;
  if (skeleton != Tum14() && skeleton != Coco17()) {
    NoteSkeleton(tracks, lost_fields);
  }
}

}  // namespace kinegraph
