// CMU Panoptic's hdPose3d: one file a frame, body3DScene_FFFFFFFF.json:
// {"fpsType": "hd_29_97", "bodies": [{"id", "joints19": 19 x (x, y, z,
// confidence) in cm}]}. A joint with confidence 0 or less is missing, one of at
// most 0.1 is inferred: the field takes it as not seen.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr double kSeenConfidence = 0.1;
// Of its high-definition cameras.
constexpr double kHdFrameRateHz = 29.97;

bool IsSceneFile(const std::string& name) {
  return name.rfind("body3DScene_", 0) == 0;
}

std::vector<std::string> ListScenes(const std::string& path) {
  if (!IsFolder(path)) return {path};
  std::vector<std::string> files;
  for (const std::string& name : ListFolder(path)) {
    if (IsSceneFile(name) && fs::path(name).extension() == ".json") {
      files.push_back((fs::path(path) / name).string());
    }
  }
  if (files.empty()) {
    throw InputError(path, "", "holds no body3DScene_*.json files");
  }
  return files;
}

void ReadPanopticFrame(JsonValue root, int64_t frame,
                       TrackCollector* collector) {
  if (!collector->Touch(frame)->people.empty()) {
    throw InputError("frame " + std::to_string(frame) + " stands there twice");
  }
  const JsonArray bodies =
      AsArray(Required(AsObject(root, kOutermost), "bodies"), "bodies");
  for (const JsonValue value : bodies) {
    const JsonObject body = AsObject(value, "bodies");
    const TrackId id(AsId(Required(body, "id"), "id"));
    Pose3d& pose = collector->Add(frame, id)->joints;
    std::vector<double> numbers(4 * pose.size());
    AsNumbers(Required(body, "joints19"), "joints19", numbers.size(),
              numbers.data());
    for (size_t j = 0; j < pose.size(); ++j) {
      const double* cm = &numbers[4 * j];
      if (!(cm[3] > 0.0)) continue;
      pose[j] = ObservedJoint(kMetresPerCentimetre * Eigen::Vector3d(cm));
      if (cm[3] <= kSeenConfidence) pose[j].status = JointStatus::kInferred;
    }
  }
}

TrackSequence ReadPanoptic(const std::string& path,
                           const TrackReadOptions& options) {
  TrackCollector collector("panoptic", Panoptic19(), options, kHdFrameRateHz);
  JsonFileParser parser;
  for (const std::string& file : ListScenes(path)) {
    const std::optional<int64_t> frame =
        FrameOfFileName(fs::path(file).filename().string());
    if (!frame || *frame > kMaxFrame) {
      throw InputError(file, "", "the file name holds no frame number");
    }
    const JsonValue root = parser.Parse(file);
    Located(file, [&] { ReadPanopticFrame(root, *frame, &collector); });
  }
  return collector.Finish();
}

// ---- Writing ----

void WriteBody(const PersonPose& person, const std::vector<int>& map,
               JsonOutput* out) {
  out->Add("{ \"id\": ", person.id.value(), ",\n\"joints19\": [");
  out->Join(map, [&](int j) {
    const Joint3d joint =
        j >= 0 ? person.joints[static_cast<size_t>(j)] : Joint3d();
    Eigen::Vector3d at_cm = Eigen::Vector3d::Zero();
    if (joint.present()) at_cm = kCentimetresPerMetre * joint.position_m;
    out->Numbers({at_cm.x(), at_cm.y(), at_cm.z()});
    out->Text(joint.present() ? ", 1" : ", -1");
  });
  out->Text("]\n}");
}

// CMU Panoptic's hdPose3d, a folder with a file a frame, in centimetres; joints
// are taken over by name.
void WriteTracksPanoptic(const std::string& path, const TrackSequence& tracks,
                         const TrackExportOptions& /*options*/,
                         LostFields* lost_fields) {
  const std::vector<int> map = MapByName(tracks.header.skeleton, Panoptic19());
  AtomicFolder folder(path);
  JsonOutput out;
  for (const TrackFrame& frame : tracks.frames) {
    out.Text("{ \"version\": 0.7,\n\"fpsType\": \"hd_29_97\",\n\"bodies\": [");
    if (!frame.people.empty()) out.Text("\n");
    out.Join(
        frame.people,
        [&](const PersonPose& person) { WriteBody(person, map, &out); }, ",\n");
    out.Text("\n] }\n");
    AtomicFile file(
        folder.PathOf(fmt::format("body3DScene_{:08d}.json", frame.frame)));
    out.FlushTo(&file);
    file.Commit();
  }
  folder.Commit();
  NotePositionsOnly(ContentsOf(tracks), lost_fields);
  if (tracks.header.frame_rate_hz != kHdFrameRateHz) {
    lost_fields->push_back(
        "times and frame rate are not kept: name the rate when reading, it is "
        "taken for 29.97 Hz");
  }
  const auto kept = static_cast<size_t>(
      std::count_if(map.begin(), map.end(), [](int j) { return j >= 0; }));
  const size_t joints = tracks.header.skeleton.joints().size();
  if (kept < map.size() || kept < joints) {
    lost_fields->push_back(
        "joints are Panoptic's nineteen by name: " + std::to_string(kept) +
        " of the input's " + std::to_string(joints) +
        " are kept, the others of the nineteen are missing");
  }
}

}  // namespace

TrackFormat PanopticTrackFormat() {
  TrackFormat format;
  format.name = "panoptic";
  format.layout = "body3DScene_*.json";
  format.unit_m = 0.01;
  format.files = TrackFormat::Files::kFileAFrame;
  format.recognise = [](const TrackHead& head) {
    return head.HasKey("bodies") ||
           std::any_of(head.names.begin(), head.names.end(), IsSceneFile);
  };
  format.read = ReadPanoptic;
  format.write = WriteTracksPanoptic;
  return format;
}

}  // namespace kinegraph
