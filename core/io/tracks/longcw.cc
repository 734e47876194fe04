// annotation_3d.json and result_3d.json of longcw: [{"timestamp": s, "poses":
// [{"id", "points_3d": [[x, y, z] cm, ...], "scores": [...]}]}, ...]. A joint
// with score 0 is missing. Results have ids beyond 2^63.
#include "core/io/text/longcw.h"

#include <unordered_map>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

uint64_t AsUnsignedId(JsonValue value) {
  uint64_t id = 0;
  if (value.get_uint64().get(id)) {
    throw InputError("id: expected an integer of 0 .. 2^64 - 1");
  }
  return id;
}

// Small ids are kept: those of an annotation are the actors' numbers. Where one
// is not small, all count 0, 1, 2 in order of appearance.
class IdMap {
 public:
  void Learn(uint64_t id) {
    all_small_ = all_small_ && id < kSmall;
    order_.emplace(id, static_cast<int64_t>(order_.size()));
  }
  TrackId Find(uint64_t id) const {
    return TrackId(all_small_ ? static_cast<int64_t>(id) : order_.at(id));
  }

 private:
  static constexpr uint64_t kSmall = uint64_t{1} << 31;
  bool all_small_ = true;
  std::unordered_map<uint64_t, int64_t> order_;
};

const Skeleton& LongcwSkeleton(size_t joint_count) {
  if (joint_count == 14) return Tum14();
  if (joint_count == 17) return Coco17();
  throw InputError("points_3d: found " + std::to_string(joint_count) +
                   " joints, expected 14 (TUM) or 17 (COCO)");
}

class LongcwReader {
 public:
  LongcwReader(const std::string& path, const TrackReadOptions& options)
      : path_(path), options_(options) {}

  TrackSequence Read(JsonValue root) {
    Scan(root);
    TrackHeader header;
    header.mode = "longcw";
    header.skeleton = skeleton_;
    header.frame_rate_hz = options_.frame_rate_hz > 0.0 ? options_.frame_rate_hz
                                                        : kLongcwFrameRateHz;
    TrackCollector collector(std::move(header));
    ForEachFrame(root, [&](const JsonObject& frame, const JsonArray& poses) {
      const LongcwTime time = ReadLongcwTime(Required(frame, "timestamp"),
                                             collector.header().frame_rate_hz);
      if (!seen_.emplace(time.frame, true).second) {
        throw InputError("frame " + std::to_string(time.frame) +
                         " stands there twice");
      }
      collector.Touch(time.frame)->time = time.time;
      for (const JsonValue value : poses) {
        const JsonObject pose = AsObject(value, "poses");
        const uint64_t id = AsUnsignedId(Required(pose, "id"));
        ReadPose(pose, &collector.Add(time.frame, ids_.Find(id))->joints);
      }
    });
    return collector.Finish();
  }

 private:
  // Runs `visit(frame, poses)` on each entry; errors name the entry.
  template <typename Visit>
  void ForEachFrame(JsonValue root, const Visit& visit) const {
    const JsonArray frames =
        Located(path_, [&] { return AsArray(root, kOutermost); });
    size_t index = 0;
    Located(
        path_, [&] { return "entry " + std::to_string(index); },
        [&] {
          for (const JsonValue value : frames) {
            const JsonObject frame = AsObject(value, "a frame");
            visit(frame, AsArray(Required(frame, "poses"), "poses"));
            ++index;
          }
        });
  }

  // Learns all ids and the skeleton before anything is made of them.
  void Scan(JsonValue root) {
    bool has_skeleton = options_.skeleton.has_value();
    skeleton_ = options_.skeleton.value_or(Tum14());
    ForEachFrame(root, [&](const JsonObject&, const JsonArray& poses) {
      for (const JsonValue value : poses) {
        const JsonObject pose = AsObject(value, "poses");
        ids_.Learn(AsUnsignedId(Required(pose, "id")));
        if (has_skeleton) continue;
        skeleton_ = LongcwSkeleton(
            AsArray(Required(pose, "points_3d"), "points_3d").size());
        has_skeleton = true;
      }
    });
  }

  static void ReadPose(const JsonObject& object, Pose3d* pose) {
    std::vector<double> scores(pose->size());
    AsNumbers(Required(object, "scores"), "scores", scores.size(),
              scores.data());
    const JsonArray points =
        AsArray(Required(object, "points_3d"), "points_3d");
    if (points.size() != pose->size()) {
      throw InputError("points_3d: found " + std::to_string(points.size()) +
                       " joints, expected " + std::to_string(pose->size()));
    }
    size_t j = 0;
    for (const JsonValue point : points) {
      double cm[3];
      AsNumbers(point, "points_3d", 3, cm);
      if (scores[j] > 0.0) {
        (*pose)[j] = ObservedJoint(cm[0] * kMetresPerCentimetre,
                                   cm[1] * kMetresPerCentimetre,
                                   cm[2] * kMetresPerCentimetre);
      }
      ++j;
    }
  }

  const std::string path_;
  const TrackReadOptions options_;
  Skeleton skeleton_;
  IdMap ids_;
  std::unordered_map<int64_t, bool> seen_;
};

TrackSequence ReadLongcwTracks(const std::string& path,
                               const TrackReadOptions& options) {
  JsonFileParser parser;
  return LongcwReader(path, options).Read(parser.Parse(path));
}

// ---- Writing ----

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

// longcw's annotation_3d.json, in centimetres. Frames are told by their times
// alone, so it needs a frame rate.
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

}  // namespace

TrackFormat LongcwTrackFormat() {
  TrackFormat format;
  format.name = "longcw";
  format.layout = "annotation_3d.json, result_3d.json";
  format.unit_m = 0.01;
  format.is_unmistakable = false;
  format.recognise = [](const TrackHead& head) { return head.kind == '['; };
  format.read = ReadLongcwTracks;
  format.write = WriteTracksLongcw;
  format.kept = "frame, time, identity, positions";
  format.lost =
      "status, covariances; frame rates other than 25 Hz must be named; a time "
      "that would be read as another frame is refused";
  return format;
}

}  // namespace kinegraph
