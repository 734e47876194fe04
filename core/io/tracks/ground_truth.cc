// Poses that data sets come with: 4D association's text, CMU Panoptic's JSON
// and TUM's actorsGT.mat.
#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/bytes.h"
#include "core/io/binary/mat_check.h"
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
// 4D association's gt.txt and skel.txt: "JOINTS FRAMES", then for each frame
// the number of people and for each person its id and four rows of JOINTS
// numbers: x, y, z [m] and weight.

Skeleton FourDAssociationSkeleton(int64_t joint_count,
                                  const TrackReadOptions& options) {
  if (options.skeleton && options.skeleton->joint_count() == joint_count) {
    return *options.skeleton;
  }
  if (joint_count == 15) return Tum15();
  if (joint_count == 19) return FourDA19();
  throw InputError("found " + std::to_string(joint_count) +
                   " joints, expected 15 (gt.txt) or 19 (skel.txt)");
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
  // Limits only keep a broken file from asking for all memory.
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
// CMU Panoptic's hdPose3d: one file a frame, body3DScene_FFFFFFFF.json:
// {"fpsType": "hd_29_97", "bodies": [{"id", "joints19": 19 x (x, y, z,
// confidence) in cm}]}. A joint with confidence 0 or less is missing, one of at
// most 0.1 is inferred: the field takes it as not seen.

constexpr double kInferredConfidence = 0.1;
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
    ReadWeighted(body, "joints19", kMetresPerCentimetre, kInferredConfidence,
                 &collector->Add(frame, id)->joints);
  }
}

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

// ---- TUM ----
//
// actorsGT.mat of Campus and Shelf (TUM): a MATLAB 5 file with the cell
// `actor3D`, 1 x ACTORS; each entry a cell FRAMES x 1; each entry of that 14 x
// 3 doubles in metres, or empty where the actor is not annotated. The id of an
// actor is its place, the frame that of the entry, both from zero.

constexpr const char* kVariable = "actor3D";

struct MatCloser {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct VariableFree {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

// matio prints its errors and aborts on some unless it is given another way.
void Quiet(int, char*) {}

// Number of entries by the declared dimensions; 0 for an empty cell, which has
// rank 0 and no dimensions.
size_t EntryCount(const matvar_t& variable) {
  if (variable.rank <= 0 || variable.dims == nullptr) return 0;
  size_t count = 1;
  for (int d = 0; d < variable.rank; ++d) count *= variable.dims[d];
  return count;
}

class TumReader {
 public:
  TumReader(const std::string& path, TrackCollector* collector)
      : path_(path), collector_(collector) {}

  void Read(const matvar_t& actors) {
    const size_t actor_count = CellSize(actors, kVariable);
    for (size_t a = 0; a < actor_count; ++a) {
      const std::string name =
          std::string(kVariable) + "{" + std::to_string(a + 1) + "}";
      const matvar_t& frames = Entry(actors, a, name);
      const size_t frame_count = CellSize(frames, name);
      if (a > 0 && frame_count != frame_count_) {
        throw InputError(
            path_, name,
            "found " + std::to_string(frame_count) + " frames, expected " +
                std::to_string(frame_count_) + " as of the first actor");
      }
      frame_count_ = frame_count;
      for (size_t f = 0; f < frame_count; ++f) {
        const std::string entry = name + "{" + std::to_string(f + 1) + "}";
        ReadEntry(Entry(frames, f, entry), entry, static_cast<int64_t>(f),
                  TrackId(static_cast<int64_t>(a)));
      }
    }
  }

 private:
  // The declared number of entries; the entries must all be there.
  size_t CellSize(const matvar_t& cell, const std::string& name) const {
    const size_t count = EntryCount(cell);
    if (cell.class_type != MAT_C_CELL || count == 0 || cell.data == nullptr) {
      throw InputError(path_, name, "is no cell array with entries");
    }
    if (cell.nbytes != count * sizeof(matvar_t*)) {
      throw InputError(path_, name, "has fewer entries than it declares");
    }
    return count;
  }

  const matvar_t& Entry(const matvar_t& cell, size_t index,
                        const std::string& name) const {
    const matvar_t* entry = static_cast<matvar_t* const*>(cell.data)[index];
    if (entry == nullptr) throw InputError(path_, name, "is missing");
    return *entry;
  }

  void ReadEntry(const matvar_t& entry, const std::string& name, int64_t frame,
                 TrackId id) {
    collector_->Touch(frame);
    const size_t count = EntryCount(entry);
    if (count == 0) return;  // not annotated
    const size_t joints = collector_->joint_count();
    const bool fits = entry.rank == 2 && entry.dims[0] == joints &&
                      entry.dims[1] == 3 && entry.class_type == MAT_C_DOUBLE &&
                      entry.isComplex == 0 && entry.data != nullptr &&
                      entry.nbytes == count * sizeof(double);
    if (!fits) {
      throw InputError(path_, name,
                       "expected " + std::to_string(joints) +
                           " x 3 doubles or an empty entry");
    }
    Pose3d& pose = collector_->Add(frame, id)->joints;
    const auto* m = static_cast<const double*>(entry.data);
    for (size_t j = 0; j < joints; ++j) {
      // Columns follow one another; NaN is MATLAB's way to say "none".
      const Eigen::Vector3d at_m(m[j], m[joints + j], m[2 * joints + j]);
      if (at_m.array().isInf().any()) {
        throw InputError(path_, name, "holds an infinite number");
      }
      pose[j] = ObservedJoint(at_m);
    }
  }

  const std::string path_;
  TrackCollector* const collector_;
  size_t frame_count_ = 0;
};

// Byte by byte, by MathWorks' "MAT-File Format", chapter 1 (level 5): matio
// takes a path, follows links and does not notice a full disk.

// The official file's shape; also keeps a stray id from filling the disk.
constexpr int64_t kMaxActors = 1000;
constexpr int64_t kMaxFrames = 1'000'000;

// Data types (tables 1-1 and 1-3 of the description).
constexpr uint32_t kInt8 = 1;
constexpr uint32_t kInt32 = 5;
constexpr uint32_t kUint32 = 6;
constexpr uint32_t kDouble = 9;
constexpr uint32_t kMatrix = 14;
constexpr uint32_t kCellClass = 1;
constexpr uint32_t kDoubleClass = 6;

constexpr uint64_t kTagBytes = 8;

std::string Tag(uint32_t type, uint64_t length) {
  std::string tag;
  AppendNumbers(&tag, type, static_cast<uint32_t>(length));
  return tag;
}

// An array up to its content: tag, flags, dimensions and name. Every element
// begins at a multiple of eight bytes.
std::string ArrayHeader(uint32_t array_class, uint64_t rows, uint64_t columns,
                        const std::string& name, uint64_t content_bytes) {
  std::string header = Tag(kUint32, 8);
  AppendNumbers(&header, array_class, uint32_t{0});
  header += Tag(kInt32, 8);
  AppendNumbers(&header, static_cast<int32_t>(rows),
                static_cast<int32_t>(columns));
  header += Tag(kInt8, name.size()) + name;
  header.resize((header.size() + 7) / 8 * 8, '\0');
  return Tag(kMatrix, header.size() + content_bytes) + header;
}

// Column after column; NaN where a joint is missing. Nobody: an empty array.
std::string PoseArray(const Pose3d& pose) {
  std::string numbers;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Joint3d& joint : pose) {
      AppendNumbers(&numbers, joint.present() ? joint.position_m[axis] : kNan);
    }
  }
  return ArrayHeader(kDoubleClass, pose.size(), pose.empty() ? 0 : 3, "",
                     kTagBytes + numbers.size()) +
         Tag(kDouble, numbers.size()) + numbers;
}

// A text without the date: the same tracks shall give the same bytes. Then
// version and byte order.
std::string FileHeader() {
  std::string header = "MATLAB 5.0 MAT-file, by kinegraph";
  header.resize(124, ' ');
  AppendNumbers(&header, uint16_t{0x0100});
  return header + "IM";
}

void WriteActors(const std::string& path, const TrackSequence& tracks) {
  const std::vector<int64_t> ids = IdsOf(tracks);
  if (ids.empty()) throw InputError("the tracks have nobody in them");
  const int64_t last = tracks.frames.back().frame;
  if (ids.back() >= kMaxActors || last >= kMaxFrames) {
    throw InputError(
        "an actor's number is its place in actorsGT.mat, a frame's too: the "
        "largest id is " +
        std::to_string(ids.back()) + ", expected below 1000; the last frame " +
        std::to_string(last) + ", expected below 1000000");
  }
  const auto frames = static_cast<uint64_t>(last) + 1;
  std::vector<uint64_t> poses(static_cast<size_t>(ids.back()) + 1, 0);
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      ++poses[static_cast<size_t>(person.id.value())];
    }
  }
  const uint64_t pose_bytes =
      PoseArray(Pose3d(tracks.header.skeleton.joints().size())).size();
  const std::string nobody = PoseArray({});
  std::vector<std::string> headers;  // by actor
  uint64_t bytes = 0;
  for (const uint64_t count : poses) {
    const uint64_t content =
        count * pose_bytes + (frames - count) * nobody.size();
    headers.push_back(ArrayHeader(kCellClass, frames, 1, "", content));
    bytes += headers.back().size() + content;
  }
  if (bytes > std::numeric_limits<uint32_t>::max() - 1000) {
    throw InputError(path, "",
                     "would have more than 4 GB, which this format does not "
                     "hold; take fewer frames");
  }
  AtomicFile file(path);
  file.Write(FileHeader());
  file.Write(ArrayHeader(kCellClass, 1, headers.size(), kVariable, bytes));
  for (size_t a = 0; a < headers.size(); ++a) {
    file.Write(headers[a]);
    int64_t next = 0;
    for (const TrackFrame& frame : tracks.frames) {
      for (; next < frame.frame; ++next) file.Write(nobody);
      ++next;
      const PersonPose* person =
          FindPerson(&frame, TrackId(static_cast<int64_t>(a)));
      file.Write(person == nullptr ? nobody : PoseArray(person->joints));
    }
  }
  file.Commit();
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

// 4D association's gt.txt or skel.txt, an entry for every frame from the first
// to the last; a missing joint has weight 0.
void WriteFourDAssociationTracks(const std::string& path,
                                 const TrackSequence& tracks,
                                 const TrackExportOptions& /*options*/,
                                 LostFields* lost_fields) {
  constexpr int64_t kMaxFrames = 10'000'000;
  const int64_t first = tracks.frames.empty() ? 0 : tracks.frames[0].frame;
  const int64_t count =
      tracks.frames.empty() ? 0 : tracks.frames.back().frame - first + 1;
  if (count > kMaxFrames) {
    throw InputError("the tracks span " + std::to_string(count) +
                     " frames, this format has one entry for each");
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
      "the first frame is not kept: name it when reading "
      "(--set=tracks.first_frame=" +
      std::to_string(first) + ")");
  const auto missing = count - static_cast<int64_t>(tracks.frames.size());
  if (missing > 0) {
    lost_fields->push_back(
        std::to_string(missing) +
        " frames that the input leaves out have entries without "
        "people");
  }
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

// CMU Panoptic's hdPose3d, a folder with a file a frame, in centimetres; joints
// are taken over by name.
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

// "MATLAB 5.0 MAT-file".
bool RecogniseTumTracks(const TrackHead& head) { return head.kind == 'M'; }

TrackSequence ReadTumTracks(const std::string& path,
                            const TrackReadOptions& options) {
  CheckMatFile(ReadBytes(path), path);
  static std::once_flag quiet;
  std::call_once(quiet, [] { Mat_LogInitFunc("kinegraph", Quiet); });
  const std::unique_ptr<mat_t, MatCloser> file(
      Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (file == nullptr) throw InputError(path, "", "is no MATLAB 5 file");
  const std::unique_ptr<matvar_t, VariableFree> actors(
      Mat_VarRead(file.get(), kVariable));
  if (actors == nullptr) {
    throw InputError(path, kVariable, "is missing or damaged");
  }
  TrackCollector collector("tum", options.skeleton.value_or(Tum14()), options);
  TumReader(path, &collector).Read(*actors);
  return collector.Finish();
}

// TUM's actorsGT.mat; the id of a person is the place of the actor.
void WriteTumTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& /*options*/,
                    LostFields* lost_fields) {
  WriteActors(path, tracks);
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteLosses(contents, {Loss::kClock}, lost_fields);
  if (tracks.frames.front().frame > 0 ||
      tracks.frames.back().frame + 1 !=
          static_cast<int64_t>(tracks.frames.size())) {
    lost_fields->push_back(
        "frames that the input leaves out, from 0 on, are there without "
        "people");
  }
  if (tracks.header.skeleton != Tum14()) NoteSkeleton(tracks, lost_fields);
}

}  // namespace kinegraph
