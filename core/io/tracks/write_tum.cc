// actorsGT.mat (TUM), a MATLAB 5 file: the cell `actor3D`, 1 x ACTORS, of cells
// FRAMES x 1, of JOINTS x 3 doubles [m] or nothing. Actor and frame are places
// in these cells.
//
// Written byte by byte, by MathWorks' "MAT-File Format", chapter 1 (level 5):
// matio takes a path, follows links and does not notice a full disk.
#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/export.h"
#include "core/io/tracks/lost_fields.h"

namespace kinegraph {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "numbers are written as this machine has them");

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

template <typename Value>
void AppendNumber(Value value, std::string* bytes) {
  static_assert(std::is_trivially_copyable_v<Value>);
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendTag(uint32_t type, uint64_t length, std::string* bytes) {
  AppendNumber(type, bytes);
  AppendNumber(static_cast<uint32_t>(length), bytes);
}

// An array up to its content: tag, flags, dimensions and name. Every element
// begins at a multiple of eight bytes.
std::string ArrayHeader(uint32_t array_class, uint64_t rows, uint64_t columns,
                        const std::string& name, uint64_t content_bytes) {
  std::string header;
  AppendTag(kUint32, 8, &header);
  AppendNumber(array_class, &header);
  AppendNumber(uint32_t{0}, &header);
  AppendTag(kInt32, 8, &header);
  AppendNumber(static_cast<int32_t>(rows), &header);
  AppendNumber(static_cast<int32_t>(columns), &header);
  AppendTag(kInt8, name.size(), &header);
  header += name;
  header.resize((header.size() + 7) / 8 * 8, '\0');
  std::string tag;
  AppendTag(kMatrix, header.size() + content_bytes, &tag);
  return tag + header;
}

// Column after column; NaN where a joint is missing. Nobody: an empty array.
std::string PoseArray(const Pose3d* pose) {
  std::string numbers;
  if (pose != nullptr) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const Joint3d& joint : *pose) {
        AppendNumber(joint.present() ? joint.position_m[axis]
                                     : std::numeric_limits<double>::quiet_NaN(),
                     &numbers);
      }
    }
  }
  std::string array =
      ArrayHeader(kDoubleClass, pose == nullptr ? 0 : pose->size(),
                  pose == nullptr ? 0 : 3, "", kTagBytes + numbers.size());
  AppendTag(kDouble, numbers.size(), &array);
  return array + numbers;
}

class ActorsFile {
 public:
  explicit ActorsFile(const TrackSequence& tracks) : tracks_(tracks) {
    const std::vector<int64_t> ids = IdsOf(tracks);
    if (ids.empty()) throw InputError("the tracks have nobody in them");
    frames_ = tracks.frames.back().frame + 1;
    if (ids.back() >= kMaxActors || frames_ > kMaxFrames) {
      throw InputError(
          "an actor's number is its place in actorsGT.mat, a frame's too: the "
          "largest id is " +
          std::to_string(ids.back()) +
          ", expected below 1000; the last frame " +
          std::to_string(frames_ - 1) + ", expected below 1000000");
    }
    poses_.resize(static_cast<size_t>(ids.back()) + 1, 0);
    for (const TrackFrame& frame : tracks.frames) {
      for (const PersonPose& person : frame.people) {
        ++poses_[static_cast<size_t>(person.id.value())];
      }
    }
    const auto joint_count =
        static_cast<size_t>(tracks.header.skeleton.joint_count());
    const Pose3d pose(joint_count);
    pose_bytes_ = PoseArray(&pose).size();
    nobody_ = PoseArray(nullptr);
  }

  void Write(const std::string& path) const {
    uint64_t bytes = 0;
    for (size_t a = 0; a < poses_.size(); ++a) {
      bytes += ActorHeader(a).size() + ActorBytes(a);
    }
    if (bytes > std::numeric_limits<uint32_t>::max() - 1000) {
      throw InputError(path, "",
                       "would have more than 4 GB, which this format does not "
                       "hold; take fewer frames");
    }
    AtomicFile file(path);
    file.Write(FileHeader());
    file.Write(ArrayHeader(kCellClass, 1, poses_.size(), "actor3D", bytes));
    for (size_t a = 0; a < poses_.size(); ++a) {
      file.Write(ActorHeader(a));
      WriteActor(TrackId(static_cast<int64_t>(a)), &file);
    }
    file.Commit();
  }

 private:
  // A text without the date: the same tracks shall give the same bytes. Then
  // version and byte order.
  static std::string FileHeader() {
    std::string header = "MATLAB 5.0 MAT-file, by kinegraph";
    header.resize(124, ' ');
    AppendNumber(uint16_t{0x0100}, &header);
    return header + "IM";
  }

  uint64_t ActorBytes(size_t actor) const {
    return poses_[actor] * pose_bytes_ +
           (static_cast<uint64_t>(frames_) - poses_[actor]) * nobody_.size();
  }

  std::string ActorHeader(size_t actor) const {
    return ArrayHeader(kCellClass, static_cast<uint64_t>(frames_), 1, "",
                       ActorBytes(actor));
  }

  void WriteActor(TrackId id, AtomicFile* file) const {
    int64_t next = 0;
    for (const TrackFrame& frame : tracks_.frames) {
      for (; next < frame.frame; ++next) file->Write(nobody_);
      ++next;
      const auto person =
          std::find_if(frame.people.begin(), frame.people.end(),
                       [id](const PersonPose& one) { return one.id == id; });
      file->Write(person == frame.people.end() ? nobody_
                                               : PoseArray(&person->joints));
    }
  }

  const TrackSequence& tracks_;
  int64_t frames_ = 0;
  std::vector<uint64_t> poses_;  // by actor
  uint64_t pose_bytes_ = 0;
  std::string nobody_;
};

}  // namespace

void WriteTracksTum(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& /*options*/,
                    LostFields* lost_fields) {
  ActorsFile(tracks).Write(path);
  NotePositionsOnly(tracks, lost_fields);
  NoteClock(tracks, lost_fields);
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
