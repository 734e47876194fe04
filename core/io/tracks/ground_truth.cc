// Ground truth of data sets: 4D association's text and CMU Panoptic's JSON.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/text/words.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// ---- 4D association ----
//
// gt.txt and skel.txt: "JOINTS FRAMES", then for each frame the number of
// people and for each person the id and four rows of JOINTS numbers: x, y, z
// [m] and weight.

Skeleton FourDAssociationSkeleton(int64_t joint_count,
                                  const TrackReadOptions& options) {
  if (options.skeleton && options.skeleton->joint_count() == joint_count) {
    return *options.skeleton;
  }
  if (joint_count == 15) return Tum15();
  if (joint_count == 19) return FourDA19();
  Refuse("found {} joints, expected 15 (gt.txt) or 19 (skel.txt)", joint_count);
}

void ReadPose(Words* words, StoredZeros stored_zeros, Pose3d* pose) {
  std::vector<double> numbers(4 * pose->size());
  for (double& number : numbers) {
    number = words->Number("a number: x, y, z or weight");
  }
  const size_t count = pose->size();
  for (size_t j = 0; j < count; ++j) {
    if (numbers[3 * count + j] > 0.0 || stored_zeros == StoredZeros::kKeep) {
      (*pose)[j] = ObservedJoint(
          {numbers[j], numbers[count + j], numbers[2 * count + j]});
    }
  }
}

TrackSequence ReadPeople(Words* words, const TrackReadOptions& options) {
  // Limits keep a corrupt file from allocating all memory.
  constexpr int64_t kMaxJoints = 1000;
  constexpr int64_t kMaxFrames = 1 << 30;
  TrackCollector collector(
      "4d_association",
      FourDAssociationSkeleton(
          words->Integer("the number of joints", 1, kMaxJoints), options),
      options);
  const int64_t frame_count =
      words->Integer("the number of frames", 0, kMaxFrames);
  for (int64_t i = 0; i < frame_count; ++i) {
    const int64_t frame = options.first_frame + i;
    collector.Touch(frame);
    const int64_t people =
        words->Integer("the number of people", 0, kMaxFrames);
    for (int64_t p = 0; p < people; ++p) {
      const TrackId id(words->Integer("the id of a person", 0, kMaxId));
      ReadPose(words, options.stored_zeros, &collector.Add(frame, id)->joints);
    }
  }
  if (!words->Next().empty()) throw InputError("text after the last frame");
  return collector.Finish();
}

void WritePerson(const PersonPose& person, JsonOutput* out) {
  out->Add(person.id.value(), "\n");
  for (int row = 0; row < 4; ++row) {
    const auto write = [&](const Joint3d& joint) {
      const double weight = joint.present() ? 1.0 : 0.0;
      out->Number(row == 3 || weight == 0.0 ? weight : joint.position_m[row]);
    };
    out->Join(person.joints, write, " ");
    out->Text("\n");
  }
}

// ---- Panoptic ----
//
// CMU Panoptic's hdPose3d: one file per frame, body3DScene_FFFFFFFF.json:
// {"fpsType": "hd_29_97", "bodies": [{"id", "joints19": 19 x (x, y, z,
// confidence) in cm}]}. A joint without a position or with confidence 0 or less
// is missing. A joint with confidence up to 0.1 is inferred, since evaluations
// treat it as not seen.

constexpr double kInferredConfidence = 0.1;
constexpr double kHdFrameRateHz = 29.97;  // of the high-definition cameras

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

void ReadBody(const JsonObject& body, Pose3d* pose) {
  constexpr std::string_view kKey = "joints19";
  std::vector<double> numbers(4 * pose->size());
  AsNumbers(Required(body, kKey), kKey, numbers.size(), numbers.data());
  for (size_t j = 0; j < pose->size(); ++j) {
    const double* at_cm = &numbers[4 * j];
    const double confidence = at_cm[3];
    if (!(confidence > 0.0)) continue;
    Joint3d& joint = (*pose)[j];
    joint = ObservedJoint(kMetresPerCentimetre * Eigen::Vector3d(at_cm));
    if (joint.present() && confidence <= kInferredConfidence) {
      joint.status = JointStatus::kInferred;
    }
  }
}

void ReadPanopticFrame(JsonValue root, int64_t frame,
                       TrackCollector* collector) {
  if (!collector->Touch(frame)->people.empty()) {
    Refuse("frame {} appears twice", frame);
  }
  const JsonArray bodies =
      AsArray(Required(AsObject(root, kOutermost), "bodies"), "bodies");
  for (const JsonValue value : bodies) {
    const JsonObject body = AsObject(value, "bodies");
    const TrackId id(AsId(Required(body, "id"), "id"));
    ReadBody(body, &collector->Add(frame, id)->joints);
  }
}

void WriteBody(const PersonPose& person, const std::vector<int>& map,
               JsonOutput* out) {
  out->Add("{ \"id\": ", person.id.value(), ",\n\"joints19\": [");
  out->Join(map, [&](int j) {
    const Joint3d joint =
        j >= 0 ? person.joints[static_cast<size_t>(j)] : Joint3d();
    const Eigen::Vector3d at_cm = CentimetresOf(joint);
    out->Numbers({at_cm.x(), at_cm.y(), at_cm.z()});
    out->Text(joint.present() ? ", 1" : ", -1");
  });
  out->Text("]\n}");
}

}  // namespace

bool RecogniseFourDAssociationTracks(const TrackHead& head) {
  return head.kind >= '0' && head.kind <= '9';
}

TrackSequence ReadFourDAssociationTracks(const std::string& path,
                                         const TrackReadOptions& options) {
  return ReadText<Words>(
      path, [&](Words* words) { return ReadPeople(words, options); });
}

// Writes gt.txt or skel.txt with an entry for every frame from the first to the
// last; a missing joint has weight 0.
void WriteFourDAssociationTracks(const std::string& path,
                                 const TrackSequence& tracks,
                                 const TrackExportOptions& /*options*/,
                                 LostFields* lost_fields) {
  const int64_t first = tracks.frames.empty() ? 0 : tracks.frames[0].frame;
  const int64_t count =
      tracks.frames.empty() ? 0 : tracks.frames.back().frame - first + 1;
  if (count > kMaxRows) {
    Refuse(
        "the tracks span {} frames, which is too many for this format: it has "
        "an entry for each",
        count);
  }
  AtomicFile file(path);
  JsonOutput out;
  out.Add(tracks.header.skeleton.joint_count(), " ", count, "\n");
  int64_t next = first;
  for (const TrackFrame& frame : tracks.frames) {
    for (; next < frame.frame; ++next) out.Text("0\n");
    ++next;
    out.Add(frame.people.size(), "\n");
    for (const PersonPose& person : frame.people) WritePerson(person, &out);
    out.FlushTo(&file);
  }
  out.FlushTo(&file);
  file.Commit();
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteLosses(contents, {Loss::kClock}, lost_fields);
  lost_fields->push_back(
      "the first frame is not kept: specify it when reading "
      "(--set=tracks.first_frame=" +
      std::to_string(first) + ")");
  NoteAddedRows(tracks, static_cast<size_t>(count),
                "have entries without people", lost_fields);
  const Skeleton& skeleton = tracks.header.skeleton;
  if (skeleton != Tum15() && skeleton != FourDA19()) {
    NoteSkeleton(tracks, lost_fields);
  }
}

bool RecognisePanopticTracks(const TrackHead& head) {
  return head.HasKey("bodies") ||
         std::any_of(head.names.begin(), head.names.end(), IsSceneFile);
}

TrackSequence ReadPanopticTracks(const std::string& path,
                                 const TrackReadOptions& options) {
  const double rate_hz =
      options.frame_rate_hz > 0.0 ? options.frame_rate_hz : kHdFrameRateHz;
  TrackCollector collector("panoptic", Panoptic19(), options, rate_hz);
  JsonFileParser parser;
  for (const std::string& file : ListScenes(path)) {
    const std::optional<int64_t> frame =
        FrameOfFileName(fs::path(file).filename().string());
    if (!frame || *frame > kMaxFrame) {
      throw InputError(file, "", "the file name contains no frame number");
    }
    const JsonValue root = parser.Parse(file);
    Located(file, [&] { ReadPanopticFrame(root, *frame, &collector); });
  }
  return collector.Finish();
}

// Writes hdPose3d, a folder with one file per frame, in centimetres; joints are
// mapped by name.
void WritePanopticTracks(const std::string& path, const TrackSequence& tracks,
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
        "times and frame rate are not kept: specify the rate when reading, "
        "otherwise 29.97 Hz is assumed");
  }
  const auto kept = static_cast<size_t>(
      std::count_if(map.begin(), map.end(), [](int j) { return j >= 0; }));
  const size_t joints = tracks.header.skeleton.joints().size();
  if (kept < map.size() || kept < joints) {
    lost_fields->push_back(
        "joints are mapped by name to Panoptic's nineteen: " +
        std::to_string(kept) + " of the input's " + std::to_string(joints) +
        " are kept, the others of the nineteen are missing");
  }
}

}  // namespace kinegraph
