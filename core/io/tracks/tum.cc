// TUM's actorsGT.mat of Campus and Shelf: a MATLAB 5 file with the cell
// `actor3D`, 1 x ACTORS; each entry a cell FRAMES x 1; each entry of that 14 x
// 3 doubles in metres, or empty where the actor is not annotated. The id of an
// actor is its place, the frame that of the entry, both from zero.
//
// MathWorks' "MAT-File Format", chapter 1 (level 5): an element is a tag (type
// and length in bytes) and data; an array is an element made of elements. No
// array is taken for as long as its dimensions say before its bytes are there.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/bytes.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr const char* kVariable = "actor3D";

// Data types and array classes (tables 1-1 and 1-3 of the description).
constexpr uint32_t kInt8 = 1;
constexpr uint32_t kInt32 = 5;
constexpr uint32_t kUint32 = 6;
constexpr uint32_t kDouble = 9;
constexpr uint32_t kMatrix = 14;
constexpr uint32_t kCompressed = 15;
constexpr uint32_t kCellClass = 1;
constexpr uint32_t kStructClass = 2;
constexpr uint32_t kCharClass = 4;
constexpr uint32_t kDoubleClass = 6;
constexpr uint32_t kLastNumberClass = 15;  // 64-bit integers; double is first
constexpr uint32_t kComplex = 0x800;       // a flag beside the class

constexpr size_t kMatHeaderBytes = 128;
constexpr size_t kTagBytes = 8;

// ---- Reading ----

struct MatElement {
  uint32_t type = 0;
  std::string_view data;
};

struct MatArray {
  uint32_t array_class = 0;  // 0: an element without bytes
  bool is_complex = false;
  size_t rank = 0;
  std::array<uint64_t, 2> sides = {};  // the first two
  uint64_t count = 0;
  std::string_view name;
  MatElement numbers;             // the real parts
  std::vector<MatArray> entries;  // of a cell or structure
};

// Bytes of a stored number, by data type; 0 where it is none.
size_t WidthOf(uint32_t type) {
  constexpr size_t kWidths[] = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};
  return type < std::size(kWidths) ? kWidths[type] : 0;
}

// MATLAB stores numbers in the smallest type that holds them.
double StoredNumber(const MatElement& numbers, size_t index) {
  const size_t at = index * WidthOf(numbers.type);
  switch (numbers.type) {
    case 1:
      return NumberAt<int8_t>(numbers.data, at);
    case 2:
      return NumberAt<uint8_t>(numbers.data, at);
    case 3:
      return NumberAt<int16_t>(numbers.data, at);
    case 4:
      return NumberAt<uint16_t>(numbers.data, at);
    case kInt32:
      return NumberAt<int32_t>(numbers.data, at);
    case kUint32:
      return NumberAt<uint32_t>(numbers.data, at);
    case 7:
      return NumberAt<float>(numbers.data, at);
    case 12:
      return static_cast<double>(NumberAt<int64_t>(numbers.data, at));
    case 13:
      return static_cast<double>(NumberAt<uint64_t>(numbers.data, at));
    default:
      return NumberAt<double>(numbers.data, at);
  }
}

// One array of a file, whose others are gone through as well: all that they
// declare must be there. Throws InputError without the file's name.
class MatReader {
 public:
  MatReader(const std::string& bytes, std::string_view name)
      : name_(name), left_bytes_(MostUnpackedBytes(bytes.size())) {
    if (bytes.size() < kMatHeaderBytes ||
        bytes.compare(0, 10, "MATLAB 5.0") != 0) {
      Refuse("is no MATLAB 5 file");
    }
    if (bytes.compare(126, 2, "IM") != 0) {
      Refuse("is not little-endian, expected that");
    }
    std::string_view rest = std::string_view(bytes).substr(kMatHeaderBytes);
    if (rest.empty()) Refuse("is truncated");
    while (!rest.empty()) {
      MatElement element = Take(&rest, /*padded=*/false);
      std::string unpacked;
      std::string_view behind;
      if (element.type == kCompressed) {
        unpacked = Unpack(element.data);
        behind = unpacked;
        element = Take(&behind, /*padded=*/false);
      }
      MatArray array = ReadArray(element, 0);
      if (!behind.empty()) Refuse("holds bytes behind an array");
      if (found_.has_value() || array.name != name_) continue;
      found_ = std::move(array);
      unpacked_.swap(unpacked);  // its bytes stay where they are
    }
  }

  const std::optional<MatArray>& found() const { return found_; }

 private:
  [[noreturn]] static void FailCount(uint64_t count) {
    Refuse("is truncated: an array declares {} entries, which are not there",
           count);
  }

  // The next element of `rest`. Within an array each begins at a multiple of
  // eight bytes; one of up to four bytes may stand in its own tag.
  static MatElement Take(std::string_view* rest, bool padded = true) {
    if (rest->size() < kTagBytes) Refuse("is truncated");
    const auto type = NumberAt<uint32_t>(*rest, 0);
    size_t length = type >> 16U;
    if (length != 0) {
      if (length > 4) Refuse("is damaged: a small element is too long");
      const MatElement element = {type & 0xFFFFU, rest->substr(4, length)};
      rest->remove_prefix(kTagBytes);
      return element;
    }
    length = NumberAt<uint32_t>(*rest, 4);
    rest->remove_prefix(kTagBytes);
    if (length > rest->size()) {
      Refuse("is truncated: an element of {} bytes has only {}", length,
             rest->size());
    }
    const MatElement element = {type, rest->substr(0, length)};
    const size_t step = padded ? (length + 7) / 8 * 8 : length;
    rest->remove_prefix(std::min(step, rest->size()));
    return element;
  }

  MatArray ReadArray(const MatElement& element, int depth) {
    constexpr int kMaxDepth = 16;
    if (element.type != kMatrix) Refuse("holds something that is no array");
    MatArray array;
    if (element.data.empty()) return array;
    if (depth > kMaxDepth) Refuse("is nested too deeply");
    std::string_view rest = element.data;
    const MatElement flags = Take(&rest);
    if (flags.type != kUint32 || flags.data.size() != 8) {
      Refuse("has an array without flags");
    }
    array.array_class = NumberAt<uint32_t>(flags.data, 0) & 0xFFU;
    array.is_complex = (NumberAt<uint32_t>(flags.data, 0) & kComplex) != 0;
    ReadDimensions(Take(&rest), &array);
    array.name = Take(&rest).data;
    if (depth == 0) keeps_entries_ = array.name == name_;
    if (array.array_class == kCellClass) {
      ReadEntries(array.count, rest, depth, &array);
    } else if (array.array_class == kStructClass) {
      const uint64_t fields = FieldsOf(&rest);
      if (fields > 0 && array.count > rest.size() / fields) {
        FailCount(array.count);
      }
      ReadEntries(array.count * fields, rest, depth, &array);
    } else {
      ReadNumbers(rest, &array);
    }
    return array;
  }

  static void ReadNumbers(std::string_view rest, MatArray* array) {
    const bool is_text = array->array_class == kCharClass;
    if (!is_text && (array->array_class < kDoubleClass ||
                     array->array_class > kLastNumberClass)) {
      Refuse(
          "holds an array of class {}, expected numbers, texts, cells or "
          "structures",
          array->array_class);
    }
    if (array->count == 0) {
      if (!rest.empty()) Take(&rest);
      return;
    }
    array->numbers = Take(&rest);
    const size_t bytes = array->numbers.data.size();
    const size_t width = is_text ? 1 : WidthOf(array->numbers.type);
    const bool fits = is_text ? bytes >= array->count
                              : width > 0 && bytes / width == array->count &&
                                    bytes % width == 0;
    if (!fits) FailCount(array->count);
    if (array->is_complex) Take(&rest);
  }

  static void ReadDimensions(const MatElement& dimensions, MatArray* array) {
    array->rank = dimensions.data.size() / 4;
    if (dimensions.type != kInt32 || array->rank < 2 || array->rank > 32 ||
        dimensions.data.size() % 4 != 0) {
      Refuse("has an array without dimensions");
    }
    array->count = 1;
    for (size_t d = 0; d < array->rank; ++d) {
      const uint64_t side = NumberAt<uint32_t>(dimensions.data, 4 * d);
      if (side > 0x7FFFFFFFU) Refuse("has an array of a negative size");
      if (d < array->sides.size()) array->sides[d] = side;
      // Beyond 2^32 no file of this kind holds it.
      array->count =
          std::min<uint64_t>(array->count * side, uint64_t{1} << 32U);
    }
  }

  // A structure names the bytes of a field's name, then the names.
  static uint64_t FieldsOf(std::string_view* rest) {
    const MatElement length = Take(rest);
    if (length.type != kInt32 || length.data.size() != 4 ||
        NumberAt<uint32_t>(length.data, 0) == 0) {
      Refuse("has a structure without names");
    }
    return Take(rest).data.size() / NumberAt<uint32_t>(length.data, 0);
  }

  void ReadEntries(uint64_t count, std::string_view rest, int depth,
                   MatArray* array) {
    if (count > rest.size() / kTagBytes) FailCount(count);
    for (uint64_t i = 0; i < count; ++i) {
      MatArray entry = ReadArray(Take(&rest), depth + 1);
      if (keeps_entries_) array->entries.push_back(std::move(entry));
    }
  }

  // An element with its tag, which says first how long it is.
  std::string Unpack(std::string_view packed) {
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) Refuse("cannot be unpacked");
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
    std::string unpacked(kTagBytes, '\0');
    const auto inflate_at = [&](size_t at) {
      stream.next_out = reinterpret_cast<Bytef*>(unpacked.data() + at);
      stream.avail_out = static_cast<uInt>(unpacked.size() - at);
      return inflate(&stream, Z_NO_FLUSH);
    };
    int state = inflate_at(0);
    const size_t length = NumberAt<uint32_t>(unpacked, 4);
    const bool fits = length <= left_bytes_;
    if (fits && state == Z_OK) {
      left_bytes_ -= length;
      unpacked.resize(kTagBytes + length + 1);  // one more shows the end
      state = inflate_at(kTagBytes);
    }
    inflateEnd(&stream);
    if (!fits) {
      Refuse("would unpack to {} bytes, too many for what is stored", length);
    }
    if (state != Z_STREAM_END) Refuse("is truncated or damaged");
    unpacked.resize(unpacked.size() - stream.avail_out);
    return unpacked;
  }

  const std::string_view name_;
  bool keeps_entries_ = false;  // of the array that is being read
  size_t left_bytes_;           // that may be unpacked
  std::string unpacked_;        // in which the array lies
  std::optional<MatArray> found_;
};

const std::vector<MatArray>& EntriesOf(const MatArray& cell) {
  if (cell.array_class != kCellClass || cell.count == 0) {
    Refuse("is no cell array with entries");
  }
  return cell.entries;
}

void ReadActorPose(const MatArray& entry, Pose3d* pose) {
  const size_t joints = pose->size();
  if (entry.rank != 2 || entry.sides[0] != joints || entry.sides[1] != 3 ||
      entry.array_class != kDoubleClass || entry.is_complex) {
    Refuse("expected {} x 3 doubles or an empty entry", joints);
  }
  for (size_t j = 0; j < joints; ++j) {
    Eigen::Vector3d at_m;
    for (size_t axis = 0; axis < 3; ++axis) {
      // Columns follow one another; NaN is MATLAB's way to say "none".
      at_m[static_cast<Eigen::Index>(axis)] =
          StoredNumber(entry.numbers, axis * joints + j);
    }
    if (at_m.array().isInf().any()) {
      Refuse("holds an infinite number");
    }
    (*pose)[j] = ObservedJoint(at_m);
  }
}

// `*place` is the entry that is being read.
TrackSequence ReadActors(const MatArray& variable,
                         const TrackReadOptions& options, std::string* place) {
  TrackCollector collector("tum", options.skeleton.value_or(Tum14()), options);
  *place = kVariable;
  const std::vector<MatArray>& actors = EntriesOf(variable);
  size_t frame_count = 0;
  for (size_t a = 0; a < actors.size(); ++a) {
    const std::string actor = kVariable + ("{" + std::to_string(a + 1) + "}");
    *place = actor;
    const std::vector<MatArray>& frames = EntriesOf(actors[a]);
    if (a > 0 && frames.size() != frame_count) {
      Refuse("found {} frames, expected {} as of the first actor",
             frames.size(), frame_count);
    }
    frame_count = frames.size();
    for (size_t f = 0; f < frame_count; ++f) {
      *place = actor + "{" + std::to_string(f + 1) + "}";
      const auto frame = static_cast<int64_t>(f);
      collector.Touch(frame);
      if (frames[f].count == 0) continue;  // not annotated
      const TrackId id(static_cast<int64_t>(a));
      ReadActorPose(frames[f], &collector.Add(frame, id)->joints);
    }
  }
  return collector.Finish();
}

// ---- Writing ----

// The official file's shape; also keeps a stray id from filling the disk.
constexpr int64_t kMaxActors = 1000;
constexpr int64_t kMaxMatFrames = 1'000'000;

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
  if (ids.empty()) Refuse("the tracks have nobody in them");
  const int64_t last = tracks.frames.back().frame;
  if (ids.back() >= kMaxActors || last >= kMaxMatFrames) {
    Refuse(
        "an actor's number is its place in actorsGT.mat, a frame's too: the "
        "largest id is {}, expected below {}; the last frame {}, expected "
        "below {}",
        ids.back(), kMaxActors, last, kMaxMatFrames);
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

// "MATLAB 5.0 MAT-file".
bool RecogniseTumTracks(const TrackHead& head) { return head.kind == 'M'; }

TrackSequence ReadTumTracks(const std::string& path,
                            const TrackReadOptions& options) {
  const std::string bytes = ReadBytes(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] {
        const MatReader reader(bytes, kVariable);
        place = kVariable;
        if (!reader.found()) Refuse("is missing or damaged");
        return ReadActors(*reader.found(), options, &place);
      });
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
