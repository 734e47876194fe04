// One JSON file in COCO's manner, in metres: `images` are the frames (id is the
// frame's number), `annotations` the people, with `keypoints_3d` = x, y, z, v a
// joint (v as COCO's: 2 observed, 1 inferred, 0 without position) and
// `track_id`; the first of `categories` names joints and bones (from 1).
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/skeleton_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

int VisibilityOf(JointStatus status) {
  switch (status) {
    case JointStatus::kObserved:
      return 2;
    case JointStatus::kInferred:
      return 1;
    case JointStatus::kMissing:
      break;
  }
  return 0;
}

// ---- Writing ----

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

void WriteImage(const TrackFrame& frame, bool has_clock, JsonOutput* out) {
  out->Add("{\"id\": ", frame.frame);
  if (has_clock) {
    out->Text(", \"time_s\": ");
    out->Seconds(frame.time);
  }
  out->Text("}");
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
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
    if (joint.present()) at_m = joint.position_m;
    out->Numbers({at_m.x(), at_m.y(), at_m.z()});
    out->Add(", ", VisibilityOf(joint.status));
  });
  out->Text("]}");
}

void WriteTracksCoco3d(const std::string& path, const TrackSequence& tracks,
                       const TrackExportOptions& options,
                       LostFields* lost_fields) {
  const TrackContents contents = ContentsOf(tracks);
  AtomicFile file(path);
  file.Write("{\"info\": " + InfoText(tracks.header) + ",\n\"categories\": [" +
             CategoryText(tracks.header.skeleton) + "],\n\"images\": [");
  JsonOutput out;
  const char* separator = "\n";
  for (const TrackFrame& frame : tracks.frames) {
    out.Text(separator);
    separator = ",\n";
    WriteImage(frame, contents.has_clock, &out);
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
  NoteStatistics(contents, lost_fields);
  if (!contents.has_clock) lost_fields->push_back(kNoClock);
}

// ---- Reading ----

std::vector<std::string> Coco3dJoints(const JsonObject& category) {
  std::vector<std::string> joints;
  for (const JsonValue joint :
       AsArray(Required(category, "keypoints"), "keypoints")) {
    joints.emplace_back(AsText(joint, "keypoints"));
  }
  return joints;
}

Skeleton SkeletonOf(const JsonObject& category,
                    const TrackReadOptions& options) {
  const std::vector<std::string> joints = Coco3dJoints(category);
  std::vector<Bone> bones;
  JsonValue skeleton;
  if (category.at_key("skeleton").get(skeleton) == simdjson::SUCCESS) {
    bones = ReadBones(skeleton, "skeleton", 1, static_cast<int>(joints.size()));
  }
  return SkeletonOfNames(joints, options, bones);
}

TrackHeader Coco3dHeader(const JsonObject& root,
                         const TrackReadOptions& options) {
  TrackHeader header;
  header.mode = "coco3d";
  header.frame_rate_hz = options.frame_rate_hz;
  JsonValue info;
  JsonValue value;
  if (root.at_key("info").get(info) == simdjson::SUCCESS) {
    const JsonObject object = AsObject(info, "info");
    if (options.frame_rate_hz == 0.0 &&
        object.at_key("frame_rate").get(value) == simdjson::SUCCESS) {
      header.frame_rate_hz = AsFrameRate(value, "frame_rate");
    }
    if (object.at_key("unit").get(value) == simdjson::SUCCESS &&
        AsText(value, "unit") != "m") {
      throw InputError("unit: expected m");
    }
  }
  const JsonArray categories =
      AsArray(Required(root, "categories"), "categories");
  if (categories.size() == 0) throw InputError("categories: is empty");
  header.skeleton =
      SkeletonOf(AsObject(*categories.begin(), "categories"), options);
  return header;
}

void ReadAnnotation(const JsonObject& entry, TrackCollector* collector) {
  const int64_t frame = AsFrame(Required(entry, "image_id"), "image_id");
  const TrackId id(AsId(Required(entry, "track_id"), "track_id"));
  Pose3d& pose = collector->Add(frame, id)->joints;
  std::vector<double> numbers(4 * pose.size());
  AsNumbers(Required(entry, "keypoints_3d"), "keypoints_3d", numbers.size(),
            numbers.data());
  for (size_t j = 0; j < pose.size(); ++j) {
    const double* m = &numbers[4 * j];
    if (!(m[3] > 0.0)) continue;
    pose[j] = ObservedJoint(m[0], m[1], m[2]);
    if (pose[j].present() && m[3] <= 1.5) {
      pose[j].status = JointStatus::kInferred;
    }
  }
}

TrackSequence ReadCoco3dFile(const JsonObject& root,
                             const TrackReadOptions& options,
                             std::string* place) {
  TrackCollector collector(Coco3dHeader(root, options));
  size_t index = 0;
  for (const JsonValue value : AsArray(Required(root, "images"), "images")) {
    *place = "images[" + std::to_string(index++) + "]";
    const JsonObject image = AsObject(value, "images");
    TrackFrame* frame = collector.Touch(AsFrame(Required(image, "id"), "id"));
    JsonValue time;
    if (image.at_key("time_s").get(time) == simdjson::SUCCESS) {
      frame->time = AsTime(time, "time_s");
    }
  }
  index = 0;
  for (const JsonValue value :
       AsArray(Required(root, "annotations"), "annotations")) {
    *place = "annotations[" + std::to_string(index++) + "]";
    ReadAnnotation(AsObject(value, "annotations"), &collector);
  }
  return collector.Finish();
}

TrackSequence ReadTracksCoco3d(const std::string& path,
                               const TrackReadOptions& options) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] {
        return ReadCoco3dFile(AsObject(root, kOutermost), options, &place);
      });
}

PersonNames ReadCoco3dNames(const std::string& path) {
  PersonNames names;
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  return Located(path, [&] {
    for (const JsonValue value :
         AsArray(Required(AsObject(root, kOutermost), "annotations"),
                 "annotations")) {
      const JsonObject entry = AsObject(value, "annotations");
      JsonValue name;
      if (entry.at_key("name").get(name) != simdjson::SUCCESS) continue;
      names[TrackId(AsId(Required(entry, "track_id"), "track_id"))] =
          std::string(AsText(name, "name"));
    }
    return names;
  });
}

}  // namespace

TrackFormat Coco3dTrackFormat() {
  TrackFormat format;
  format.name = "coco3d";
  format.layout = "JSON as COCO's, keypoints_3d in m";
  format.has_marker_names = true;
  format.recognise = [](const TrackHead& head) {
    return head.HasKey("categories") && head.HasKey("images") &&
           head.beginning.find("keypoints_3d") != std::string::npos;
  };
  format.read = ReadTracksCoco3d;
  format.read_names = ReadCoco3dNames;
  format.keeps_names = true;
  format.write = WriteTracksCoco3d;
  format.kept = "frame, time, frame rate, identity, positions, status, bones";
  format.lost = "views, covariances, configuration";
  return format;
}

}  // namespace kinegraph
