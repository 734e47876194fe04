// actorsGT.mat of Campus and Shelf (TUM): a MATLAB 5 file with the cell
// `actor3D`, 1 x ACTORS; each entry a cell FRAMES x 1; each entry of that 14 x
// 3 doubles in metres, or empty where the actor is not annotated. The id of an
// actor is its place, the frame that of the entry, both from zero.
#include <matio.h>

#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/mat_check.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

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

// ---- Writing ----

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
        AppendNumber(joint.present() ? joint.position_m[axis] : kNan, &numbers);
      }
    }
  }
  std::string array =
      ArrayHeader(kDoubleClass, pose == nullptr ? 0 : pose->size(),
                  pose == nullptr ? 0 : 3, "", kTagBytes + numbers.size());
  AppendTag(kDouble, numbers.size(), &array);
  return array + numbers;
}

// A text without the date: the same tracks shall give the same bytes. Then
// version and byte order.
std::string FileHeader() {
  std::string header = "MATLAB 5.0 MAT-file, by kinegraph";
  header.resize(124, ' ');
  AppendNumber(uint16_t{0x0100}, &header);
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
  const Pose3d pose(tracks.header.skeleton.joints().size());
  const uint64_t pose_bytes = PoseArray(&pose).size();
  const std::string nobody = PoseArray(nullptr);
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
      file.Write(person == nullptr ? nobody : PoseArray(&person->joints));
    }
  }
  file.Commit();
}

// TUM's actorsGT.mat; the id of a person is the place of the actor.
void WriteTracksTum(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& /*options*/,
                    LostFields* lost_fields) {
  WriteActors(path, tracks);
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteClock(contents, lost_fields);
  if (tracks.frames.front().frame > 0 ||
      tracks.frames.back().frame + 1 !=
          static_cast<int64_t>(tracks.frames.size())) {
    lost_fields->push_back(
        "frames that the input leaves out, from 0 on, are there without "
        "people");
  }
  if (tracks.header.skeleton != Tum14()) NoteSkeleton(tracks, lost_fields);
}

}  // namespace

TrackFormat TumTrackFormat() {
  TrackFormat format;
  format.name = "tum";
  format.layout = "actorsGT.mat";
  format.unit_m = 1.0;
  // "MATLAB 5.0 MAT-file".
  format.recognise = [](const TrackHead& head) { return head.kind == 'M'; };
  format.read = ReadTumTracks;
  format.write = WriteTracksTum;
  return format;
}

}  // namespace kinegraph
