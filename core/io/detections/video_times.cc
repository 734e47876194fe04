#include "core/io/detections/video_times.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

// A day at 240 Hz has fewer; a broken file could claim any number.
constexpr uint64_t kMaxPictures = 30'000'000;
// The least that a picture takes: its length in the file's list.
constexpr uint64_t kMinPictureBytes = 4;
// The list of that many pictures.
constexpr uint64_t kMaxListBytes = uint64_t{1} << 29;

std::string LowerEnding(const std::string& path) {
  const size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] == '/') return "";
  std::string ending = path.substr(dot + 1);
  for (char& c : ending) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return ending;
}

uint64_t BigEndian(std::string_view bytes) {
  uint64_t value = 0;
  for (const char byte : bytes) {
    value = value << 8 | static_cast<unsigned char>(byte);
  }
  return value;
}

// A file of which parts are read, wherever they are.
class Parts {
 public:
  explicit Parts(const std::string& path)
      : path_(path), file_(path, std::ios::binary) {
    if (!file_) throw InputError(path, "", "cannot be read");
    file_.seekg(0, std::ios::end);
    size_ = static_cast<uint64_t>(std::max<std::streamoff>(file_.tellg(), 0));
  }

  uint64_t size() const { return size_; }
  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(path_, "", message);
  }
  // Fewer at the end of the file.
  std::string Peek(uint64_t at, uint64_t count) {
    if (at >= size_) return "";
    std::string bytes(std::min(count, size_ - at), '\0');
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(at));
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
      Fail("cannot be read");
    }
    return bytes;
  }
  std::string Read(uint64_t at, uint64_t count) {
    if (at > size_ || count > size_ - at) Fail("ends in the middle");
    return Peek(at, count);
  }

 private:
  std::string path_;
  std::ifstream file_;
  uint64_t size_ = 0;
};

// ---- MP4 and QuickTime (ISO 14496-12): boxes of size, name and content ----

// How many bytes the head of a box has, and all of it, which stands where
// `left` bytes are left.
std::pair<size_t, uint64_t> SizeOfBox(std::string_view head, uint64_t left) {
  uint64_t size = BigEndian(head.substr(0, 4));
  const bool is_wide = size == 1 && head.size() >= 16;
  if (is_wide) size = BigEndian(head.substr(8, 8));
  return {is_wide ? 16 : 8, size == 0 ? left : size};
}

class Boxes {
 public:
  Boxes(const Parts& file, std::string_view bytes)
      : file_(file), bytes_(bytes) {}

  // The contents of the boxes of that name, of so many at the most.
  std::vector<std::string_view> All(std::string_view name,
                                    size_t most = SIZE_MAX) const {
    std::vector<std::string_view> found;
    for (std::string_view rest = bytes_;
         rest.size() >= 8 && found.size() < most;) {
      const std::string_view content = ContentOf(rest);
      if (rest.substr(4, 4) == name) found.push_back(content);
      rest.remove_prefix(
          static_cast<size_t>(content.data() - rest.data() + content.size()));
    }
    return found;
  }
  // The content of the first; nullopt: there is none.
  std::optional<std::string_view> Find(std::string_view name) const {
    const std::vector<std::string_view> found = All(name, 1);
    return found.empty() ? std::nullopt : std::optional(found.front());
  }
  Boxes In(std::string_view name) const {
    return Boxes(file_, Find(name).value_or(std::string_view()));
  }

 private:
  std::string_view ContentOf(std::string_view box) const {
    const auto [header, size] = SizeOfBox(box, box.size());
    if (size < header || size > box.size()) file_.Fail("holds a broken box");
    return box.substr(header, size - header);
  }

  const Parts& file_;
  std::string_view bytes_;
};

// The table of a full box: rows of `columns` numbers of four bytes each.
class Table {
 public:
  Table(const Parts& file, std::optional<std::string_view> box, size_t columns)
      : columns_(columns) {
    if (!box.has_value()) return;
    if (box->size() < 8) file.Fail("holds a broken box");
    rows_ = BigEndian(box->substr(4, 4));
    bytes_ = box->substr(8);
    if (rows_ > bytes_.size() / (4 * columns)) file.Fail("ends in the middle");
  }
  size_t rows() const { return rows_; }
  uint32_t At(size_t row, size_t column) const {
    return static_cast<uint32_t>(
        BigEndian(bytes_.substr(4 * (row * columns_ + column), 4)));
  }

 private:
  size_t columns_;
  size_t rows_ = 0;
  std::string_view bytes_;
};

// Ticks a second, of `mvhd` and `mdhd`, which begin alike.
double TicksPerSecond(const Parts& file, std::optional<std::string_view> box) {
  if (!box.has_value() || box->size() < 24) file.Fail("states no time scale");
  const size_t at = (*box)[0] == 1 ? 20 : 12;
  const uint64_t ticks = BigEndian(box->substr(at, 4));
  if (ticks == 0) file.Fail("states no time scale");
  return static_cast<double>(ticks);
}

// What an edit list adds to the times of the media [s]: it begins where the
// list says, after as long a wait as it says.
double Shift(const Parts& file, const Boxes& track, double movie_hz,
             double media_hz) {
  const auto list = track.In("edts").Find("elst");
  if (!list.has_value() || list->size() < 8) return 0.0;
  const bool wide = (*list)[0] == 1;
  const size_t number = wide ? 8 : 4;
  const size_t row = 2 * number + 4;
  const uint64_t rows = BigEndian(list->substr(4, 4));
  double wait_s = 0.0;
  for (uint64_t i = 0; i < rows; ++i) {
    const size_t at = 8 + static_cast<size_t>(i) * row;
    if (at + row > list->size()) file.Fail("ends in the middle");
    const uint64_t bits = BigEndian(list->substr(at + number, number));
    const int64_t start =
        wide ? static_cast<int64_t>(bits) : static_cast<int32_t>(bits);
    if (start >= 0) return wait_s - static_cast<double>(start) / media_hz;
    wait_s +=
        static_cast<double>(BigEndian(list->substr(at, number))) / movie_hz;
  }
  return 0.0;
}

std::vector<double> TimesOfTrack(const Parts& file, const Boxes& track,
                                 double movie_hz) {
  const Boxes media = track.In("mdia");
  const double media_hz = TicksPerSecond(file, media.Find("mdhd"));
  const double shift_s = Shift(file, track, movie_hz, media_hz);
  const Boxes list = media.In("minf").In("stbl");
  const Table durations(file, list.Find("stts"), 2);
  const Table offsets(file, list.Find("ctts"), 2);
  std::vector<double> times_s;
  const uint64_t most = std::min(kMaxPictures, file.size() / kMinPictureBytes);
  int64_t ticks = 0;
  size_t offset_row = 0;
  uint32_t used = 0;  // of that row
  for (size_t row = 0; row < durations.rows(); ++row) {
    const uint32_t count = durations.At(row, 0);
    if (times_s.size() + count > most) {
      file.Fail("declares more than " + std::to_string(most) +
                " frames, more than it holds");
    }
    for (uint32_t i = 0; i < count; ++i) {
      int64_t shown = ticks;
      while (offset_row < offsets.rows() && used >= offsets.At(offset_row, 0)) {
        ++offset_row;
        used = 0;
      }
      if (offset_row < offsets.rows()) {
        // Version 0 says unsigned, and yet programs write negative ones.
        shown += static_cast<int32_t>(offsets.At(offset_row, 1));
        ++used;
      }
      times_s.push_back(static_cast<double>(shown) / media_hz + shift_s);
      ticks += durations.At(row, 1);
    }
  }
  return times_s;
}

std::vector<double> Mp4Times(Parts* file) {
  for (uint64_t at = 0; at + 8 <= file->size();) {
    const std::string head = file->Peek(at, 16);
    const uint64_t size = SizeOfBox(head, file->size() - at).second;
    if (size < 8) file->Fail("holds a broken box");
    if (head.substr(4, 4) != "moov") {
      if (size > file->size() - at) break;
      at += size;
      continue;
    }
    if (size > kMaxListBytes) file->Fail("has too many frames");
    const std::string bytes = file->Read(at, size);
    const Boxes movie = Boxes(*file, bytes).In("moov");
    const double movie_hz = TicksPerSecond(*file, movie.Find("mvhd"));
    for (const std::string_view content : movie.All("trak")) {
      const Boxes track(*file, content);
      const auto handler = track.In("mdia").Find("hdlr");
      if (handler.has_value() && handler->size() >= 12 &&
          handler->substr(8, 4) == "vide") {
        return TimesOfTrack(*file, track, movie_hz);
      }
    }
    file->Fail("has no video track");
  }
  file->Fail("ends in the middle: its list of frames (moov) is missing");
}

// ---- WebM and Matroska (RFC 9559): elements of id, size and content ----

constexpr uint64_t kSegment = 0x18538067;
constexpr uint64_t kInfo = 0x1549A966;
constexpr uint64_t kTimestampScale = 0x2AD7B1;
constexpr uint64_t kMatroskaTracks = 0x1654AE6B;
constexpr uint64_t kTrackEntry = 0xAE;
constexpr uint64_t kTrackNumber = 0xD7;
constexpr uint64_t kTrackType = 0x83;
constexpr uint64_t kCluster = 0x1F43B675;
constexpr uint64_t kTimestamp = 0xE7;
constexpr uint64_t kSimpleBlock = 0xA3;
constexpr uint64_t kBlockGroup = 0xA0;
constexpr uint64_t kBlock = 0xA1;

// A number whose first byte tells its length; 0: broken.
size_t VintLength(std::string_view bytes) {
  if (bytes.empty() || bytes[0] == 0) return 0;
  size_t length = 1;
  for (unsigned char first = static_cast<unsigned char>(bytes[0]);
       (first & 0x80) == 0; first = static_cast<unsigned char>(first << 1)) {
    ++length;
  }
  return length <= bytes.size() ? length : 0;
}

uint64_t WithoutMarker(std::string_view vint) {
  return BigEndian(vint) & ~(uint64_t{1} << (7 * vint.size()));
}

// Goes through the elements in their order. Those that only hold others are
// entered, so that a live recording, whose sizes are not known, reads as well.
class MatroskaReader {
 public:
  explicit MatroskaReader(Parts* file) : file_(*file) {}

  std::vector<double> Times() {
    for (uint64_t at = 0; at < file_.size();) at = Element(at);
    if (video_ == 0) file_.Fail("has no video track");
    return std::move(times_s_);
  }

 private:
  // Returns where the next one begins.
  uint64_t Element(uint64_t at) {
    const std::string head = file_.Peek(at, 12);
    const std::string_view view(head);
    const size_t id_length = VintLength(view);
    const size_t size_length =
        id_length == 0 ? 0 : VintLength(view.substr(id_length));
    // A recording that was cut off ends like this.
    if (size_length == 0) return file_.size();
    const uint64_t id = BigEndian(view.substr(0, id_length));
    const uint64_t size = WithoutMarker(view.substr(id_length, size_length));
    const uint64_t content = at + id_length + size_length;
    switch (id) {
      case kSegment:
      case kInfo:
      case kMatroskaTracks:
      case kCluster:
      case kBlockGroup:
        return content;
      case kTrackEntry:
        number_ = type_ = 0;
        return content;
      case kTrackNumber:
        number_ = Unsigned(content, size);
        break;
      case kTrackType:
        type_ = Unsigned(content, size);
        break;
      case kTimestampScale:
        scale_s_ = 1e-9 * static_cast<double>(Unsigned(content, size));
        break;
      case kTimestamp:
        cluster_ = static_cast<int64_t>(Unsigned(content, size));
        break;
      case kSimpleBlock:
      case kBlock:
        AddBlock(content);
        break;
      default:
        break;
    }
    // Number and type of a track come in any order.
    if (video_ == 0 && type_ == 1) video_ = number_;
    return size > file_.size() - std::min(content, file_.size())
               ? file_.size()
               : content + size;
  }

  uint64_t Unsigned(uint64_t at, uint64_t size) {
    if (size > 8) file_.Fail("holds a broken number");
    return BigEndian(file_.Read(at, size));
  }

  void AddBlock(uint64_t at) {
    const std::string head = file_.Peek(at, 10);
    const std::string_view view(head);
    const size_t length = VintLength(view);
    if (length == 0 || length + 2 > view.size()) return;
    if (WithoutMarker(view.substr(0, length)) != video_) return;
    if (times_s_.size() >= kMaxPictures) file_.Fail("has too many frames");
    const auto relative =
        static_cast<int16_t>(BigEndian(view.substr(length, 2)));
    times_s_.push_back(scale_s_ * static_cast<double>(cluster_ + relative));
  }

  Parts& file_;
  uint64_t number_ = 0;  // of the track that is described
  uint64_t type_ = 0;    // 1: video
  uint64_t video_ = 0;   // number of the first video track
  double scale_s_ = 1e-3;
  int64_t cluster_ = 0;
  std::vector<double> times_s_;
};

}  // namespace

bool IsVideoName(const std::string& path) { return !VideoType(path).empty(); }

std::string VideoType(const std::string& path) {
  static const std::map<std::string, std::string> kTypes = {
      {"mp4", "video/mp4"},
      {"m4v", "video/mp4"},
      {"mov", "video/quicktime"},
      {"webm", "video/webm"},
      {"mkv", "video/x-matroska"}};
  const auto type = kTypes.find(LowerEnding(path));
  return type == kTypes.end() ? "" : type->second;
}

std::vector<double> ReadVideoTimes(const std::string& path) {
  Parts file(path);
  const std::string head = file.Peek(0, 12);
  std::vector<double> times_s;
  if (head.substr(0, 4) == "\x1A\x45\xDF\xA3") {
    times_s = MatroskaReader(&file).Times();
  } else if (head.size() >= 8 &&
             (head.substr(4, 4) == "ftyp" || head.substr(4, 4) == "moov" ||
              head.substr(4, 4) == "wide" || head.substr(4, 4) == "mdat")) {
    times_s = Mp4Times(&file);
  } else {
    file.Fail("is no video that is read here, expected MP4 or WebM");
  }
  std::sort(times_s.begin(), times_s.end());
  // Rounding aside, what an edit list cuts off is never shown.
  times_s.erase(times_s.begin(),
                std::lower_bound(times_s.begin(), times_s.end(), -1e-6));
  return times_s;
}

}  // namespace kinegraph
