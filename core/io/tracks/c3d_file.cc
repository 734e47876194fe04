#include "core/io/tracks/c3d_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/limits.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr double kMostC3dFrames = 1e9;
constexpr int64_t kFull = 65535;   // maximum of a word (-1 if it is signed)
constexpr int64_t kWords = 65536;  // number of values of a word

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string WithoutFill(const std::string& text) {
  const size_t end = text.find_last_not_of(std::string(" \0", 2));
  return end == std::string::npos ? "" : text.substr(0, end + 1);
}

// Returns UTF-8 unchanged and converts other texts from Latin-1.
std::string AsUtf8(const std::string& text) {
  size_t at = 0;
  while (at < text.size()) {
    const Utf8Letter letter = LetterAt(text, at);
    if (!letter.point.has_value()) break;
    at += letter.size;
  }
  if (at >= text.size()) return text;
  std::string utf8;
  // Latin-1 is the first 256 code points of Unicode.
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80) utf8 += static_cast<char>(0xC0 | byte >> 6);
    utf8 += static_cast<char>(byte < 0x80 ? byte : 0x80 | (byte & 0x3F));
  }
  return utf8;
}

// Length in metres of the unit in POINT:UNITS, by default millimetres.
double MetresOf(const std::vector<std::string>& units) {
  const std::string unit = units.empty() ? "" : Upper(units.front());
  for (const auto& [name, metres] :
       {std::pair{"MM", 0.001}, {"", 0.001}, {"CM", 0.01}, {"M", 1.0}}) {
    if (unit == name) return metres;
  }
  throw InputError("POINT:UNITS: found '" + Printable(units.front()) +
                   "', expected mm, cm or m");
}

// The number in a word: unsigned, or in two's complement.
double Whole(double word, bool is_unsigned) {
  return is_unsigned || word < kWords / 2 ? word : word - kWords;
}

bool IsRate(double hz) { return hz > 0.0 && hz <= kMaxFrameRate_hz; }

// Offset of a block, counted from 1; 0 if the number is not valid.
size_t BlockBegin(double block) {
  return block >= 1.0 && block <= static_cast<double>(kFull)
             ? kC3dBlock * (static_cast<size_t>(block) - 1)
             : 0;
}

}  // namespace

// ---- Parameters ----

C3dValues::C3dValues(const C3dBytes& bytes, size_t begin) : bytes_(bytes) {
  const auto blocks = static_cast<size_t>(bytes.Byte(begin + 2));
  // Some writers leave the number of blocks at 0.
  const size_t end = blocks == 0
                         ? bytes.size()
                         : std::min(begin + kC3dBlock * blocks, bytes.size());
  std::map<int, std::string> groups;
  std::vector<std::pair<std::pair<int, std::string>, Place>> found;
  for (size_t at = begin + 4; at + 2 < end;) {
    const auto length =
        static_cast<size_t>(std::abs(static_cast<signed char>(bytes.Byte(at))));
    const int group = static_cast<signed char>(bytes.Byte(at + 1));
    if (length == 0 || group == 0) break;
    const std::string name = Upper(WithoutFill(bytes.Text(at + 2, length)));
    const size_t here = at + 2 + length;
    const auto step = static_cast<size_t>(bytes.Word(here));
    if (group < 0) {
      groups[-group] = name;
    } else if (const auto place = PlaceAt(here + 2)) {
      found.push_back({{group, name}, *place});
    }
    if (step == 0) break;
    at = here + step;
  }
  for (auto& [key, place] : found) {  // a group may follow its parameters
    places_[groups[key.first] + ":" + key.second] = std::move(place);
  }
}

std::optional<C3dValues::Place> C3dValues::PlaceAt(size_t at) const {
  constexpr size_t kMostSides = 7;
  Place place;
  place.type = static_cast<signed char>(bytes_.Byte(at));
  const auto sides = static_cast<size_t>(bytes_.Byte(at + 1));
  const auto width = static_cast<size_t>(std::abs(place.type));
  if (sides > kMostSides || width == 0 || width > 4) return std::nullopt;
  for (size_t s = 0; s < sides; ++s) {
    place.shape.push_back(static_cast<size_t>(bytes_.Byte(at + 2 + s)));
    place.count *= place.shape.back();
  }
  place.at = at + 2 + sides;
  if (!bytes_.Has(place.at, width * place.count)) return std::nullopt;
  return place;
}

std::optional<double> C3dValues::Number(const std::string& name,
                                        size_t index) const {
  const Place* place = Find(name);
  if (place == nullptr || index >= place->count) return std::nullopt;
  switch (place->type) {
    case 4:
      return bytes_.Float(place->at + 4 * index);
    case 2:
      return bytes_.Word(place->at + 2 * index);
    case 1:
      return bytes_.Byte(place->at + index);
    default:
      throw InputError(name + ": expected a number");
  }
}

size_t C3dValues::RowLength(const std::string& name) const {
  const Place* place = Find(name);
  return place == nullptr || place->shape.empty() ? 0 : place->shape.front();
}

std::vector<std::string> C3dValues::Texts(const std::string& name) const {
  std::vector<std::string> texts;
  for (int part = 1;; ++part) {
    const Place* place = Find(part == 1 ? name : name + std::to_string(part));
    if (place == nullptr || place->type != -1) return texts;
    const size_t width = place->shape.empty() ? 1 : place->shape[0];
    if (width == 0) continue;
    for (size_t i = 0; i + width <= place->count; i += width) {
      texts.push_back(AsUtf8(WithoutFill(bytes_.Text(place->at + i, width))));
    }
  }
}

// ---- The file ----

class C3dRange {
 public:
  // Collects the first frame, and the number of frames by each convention, the
  // most reliable first. A count of 0 means unspecified; a word of 65535 means
  // this many or more.
  C3dRange(const C3dBytes& bytes, const C3dValues& values)
      : bytes_(bytes), values_(values) {
    const auto state = [&](const char* where, int64_t count, bool is_word,
                           int64_t first = -1) {
      if (count > 0) stated_.push_back({where, count, is_word, first});
    };
    first_ = bytes_.Word(6);
    const std::string start = "TRIAL:ACTUAL_START_FIELD";
    const std::string stop = "TRIAL:ACTUAL_END_FIELD";
    if (values_.Number(start) && values_.Number(stop)) {
      const int64_t begin = FrameNumber(start);
      const int64_t end = FrameNumber(stop);
      if (end >= begin && end > 0) first_ = begin;
      if (end == kFull) {
        at_least_ = std::max(at_least_, end - begin + 1);
      } else {
        state("TRIAL", end - begin + 1, false, begin);
      }
    }
    for (const char* name : {"POINT:LONG_FRAMES", "POINT:FRAMES"}) {
      const double frames = values_.NumberOrZero(name);
      // A full count is 65535 or, stored as a float, also -1.
      if (frames > 0.0 && frames <= kMostC3dFrames && frames != kFull) {
        state(name, std::llround(frames), std::string(name) == "POINT:FRAMES");
      }
    }
    const int64_t last = bytes_.Word(8);
    const int64_t in_header = last - bytes_.Word(6) + 1;
    if (last == kFull) {
      at_least_ = std::max(at_least_, in_header);
    } else if (last > 0) {
      state("the header", (in_header + kWords) % kWords, true, bytes_.Word(6));
    }
  }

  // The first stated count for which the frames end less than a block before
  // `end`, the end of the data; otherwise the first that fits if a word is
  // assumed to have overflowed; nullopt if there is none.
  std::optional<int64_t> FittingCount(const C3dFrames& frames,
                                      size_t end) const {
    if (frames.frame_bytes == 0 || frames.begin > end) return std::nullopt;
    const auto room =
        static_cast<int64_t>((end - frames.begin) / frames.frame_bytes);
    const auto fits = [&](int64_t count) {
      return count <= room &&
             end - frames.begin -
                     static_cast<size_t>(count) * frames.frame_bytes <
                 kC3dBlock;
    };
    for (const Stated& stated : stated_) {
      if (fits(stated.count)) return stated.count;
    }
    for (const Stated& stated : stated_) {
      const int64_t over = (room - stated.count) / kWords * kWords;
      if (stated.is_word && over > 0 && fits(stated.count + over)) {
        return stated.count + over;
      }
    }
    return std::nullopt;
  }

  // The first frame, 0-based, from a source that also states `count`, since a
  // trimmed file may keep the old range in one place.
  int64_t FirstOf(int64_t count) const {
    int64_t first = first_;
    for (auto at = stated_.rbegin(); at != stated_.rend(); ++at) {
      if (at->first >= 0 && at->count == count) first = at->first;
    }
    return std::max<int64_t>(first, 1) - 1;
  }

  // The number of frames; throws InputError if what the file states contradicts
  // itself or the size of the data.
  int64_t CountOf(const C3dFrames& frames, size_t end) const {
    if (const auto count = FittingCount(frames, end)) return *count;
    const int64_t room =
        frames.begin > end
            ? 0
            : static_cast<int64_t>((end - frames.begin) / frames.frame_bytes);
    if (!stated_.empty()) {
      const Stated& most_trusted = stated_.front();
      for (const Stated& stated : stated_) {
        if (stated.count == most_trusted.count) continue;
        Refuse("specifies {} ({}) and {} ({}), but has space for {}",
               Counted(most_trusted.count, "frame", "frames"),
               most_trusted.where, Counted(stated.count, "frame", "frames"),
               stated.where, room);
      }
      const bool may_have_run_over =
          most_trusted.is_word && room >= most_trusted.count + kWords;
      if (most_trusted.count > room || most_trusted.count < at_least_ ||
          may_have_run_over) {
        Refuse(
            "is cut off or miscounted: {} specifies {}, but there is space for "
            "{}",
            most_trusted.where, Counted(most_trusted.count, "frame", "frames"),
            room);
      }
      return most_trusted.count;
    }
    if (room < at_least_) throw InputError("is cut off");
    // Only the file's size determines the count. Frames of zeros in the last
    // block are padding.
    int64_t count = room;
    const auto begin_of = [&](int64_t frame) {
      return frames.begin + static_cast<size_t>(frame) * frames.frame_bytes;
    };
    while (count > at_least_ && end - begin_of(count - 1) < kC3dBlock &&
           bytes_.AllZero(begin_of(count - 1), end)) {
      --count;
    }
    return count;
  }

  bool is_stated() const { return !stated_.empty(); }

 private:
  struct Stated {
    std::string where;
    int64_t count = 0;
    bool is_word = false;  // modulo 65536
    int64_t first = -1;    // 1-based; -1: unspecified
  };

  // Reads a frame number: two words, or one number of another type.
  int64_t FrameNumber(const std::string& name) const {
    const double low = values_.NumberOrZero(name);
    const double high = values_.NumberOrZero(name, 1);
    if (!(low >= 0.0 && low <= kMostC3dFrames && high >= 0.0 &&
          high < kWords)) {
      throw InputError(name + ": expected the number of a frame");
    }
    return static_cast<int64_t>(low) + kWords * static_cast<int64_t>(high);
  }

  const C3dBytes& bytes_;
  const C3dValues& values_;
  int64_t first_ = 0;  // 1-based; used if no statement fits
  std::vector<Stated> stated_;
  int64_t at_least_ = 0;  // lower bound of the count, if a word is full
};

C3dFile::C3dFile(std::string content)
    : bytes_(std::move(content)), values_(bytes_, OpenParameters()) {
  rate_hz_ = values_.NumberOrZero("POINT:RATE");
  if (!IsRate(rate_hz_)) rate_hz_ = bytes_.Float(20);
  unit_m_ = MetresOf(values_.Texts("POINT:UNITS"));
  const C3dRange range(bytes_, values_);
  FindSegments(range);
  FindPoints(range);
  FindAnalog();
  if (points_.width + segments_.width == 0) {
    throw InputError("has no points (POINT:USED is 0)");
  }
}

// Sets the byte order; returns the offset of the parameters.
size_t C3dFile::OpenParameters() {
  if (!bytes_.Has(0, kC3dBlock)) throw InputError("is cut off");
  if (bytes_.Byte(1) != 0x50) throw InputError("is not a C3D file");
  const size_t begin = BlockBegin(bytes_.Byte(0));
  const int order = bytes_.Byte(begin + 3);
  if (order < C3dBytes::kIntel || order > C3dBytes::kMips) {
    throw InputError("has an unknown byte order, expected Intel, DEC or MIPS");
  }
  bytes_.set_order(order);
  return begin;
}

void C3dFile::FindSegments(const C3dRange& range) {
  constexpr size_t kMatrixBytes = 17 * 4;
  const double used = values_.NumberOrZero("ROTATION:USED");
  const size_t begin = BlockBegin(values_.NumberOrZero("ROTATION:DATA_START"));
  if (!(used >= 1.0 && used <= static_cast<double>(kFull)) || begin == 0) {
    return;
  }
  const double rate_hz = values_.NumberOrZero("ROTATION:RATE");
  double ratio = values_.NumberOrZero("ROTATION:RATIO");
  if (!(ratio >= 1.0)) ratio = IsRate(rate_hz_) ? rate_hz / rate_hz_ : 1.0;
  const int64_t each =
      ratio >= 1.0 && ratio <= 1000.0 ? std::llround(ratio) : 1;
  segments_.width = static_cast<size_t>(used);
  segments_.begin = begin;
  segments_.frame_bytes =
      kMatrixBytes * segments_.width * static_cast<size_t>(each);
  if (bytes_.Word(2) > 0 && range.is_stated() &&
      !range.FittingCount(segments_, bytes_.size())) {
    segments_ = {};  // DATA_START is invalid, or exceeds the range of a word
    return;
  }
  const int64_t count = range.CountOf(segments_, bytes_.size());
  segments_.count = each * count;
  segments_.frame_bytes /= static_cast<size_t>(each);
  segments_.first = each * range.FirstOf(count);
  segments_.rate_hz = IsRate(rate_hz_)  ? static_cast<double>(each) * rate_hz_
                      : IsRate(rate_hz) ? rate_hz
                                        : 0.0;
}

void C3dFile::FindPoints(const C3dRange& range) {
  const int in_header = bytes_.Word(2);
  const double used = values_.Number("POINT:USED").value_or(in_header);
  points_.width = used >= 1.0 && used <= static_cast<double>(kFull)
                      ? static_cast<size_t>(used)
                      : static_cast<size_t>(in_header);
  if (points_.width == 0) return;
  double scale = values_.NumberOrZero("POINT:SCALE");
  if (!std::isfinite(scale) || scale == 0.0) scale = bytes_.Float(12);
  if (!std::isfinite(scale) || scale == 0.0) {
    throw InputError("POINT:SCALE: expected a number other than 0");
  }
  is_float_ = scale < 0.0;
  points_.begin = BlockBegin(bytes_.Word(16));
  if (points_.begin == 0) {
    points_.begin = BlockBegin(values_.NumberOrZero("POINT:DATA_START"));
  }
  if (points_.begin == 0) {
    throw InputError("POINT:DATA_START: expected a block");
  }
  const size_t end = segments_.begin > points_.begin
                         ? std::min(segments_.begin, bytes_.size())
                         : bytes_.size();
  const auto set_bytes = [&] {
    points_.frame_bytes =
        (is_float_ ? 4 : 2) *
        (4 * points_.width + static_cast<size_t>(bytes_.Word(4)));
    return range.FittingCount(points_, end).has_value();
  };
  const size_t width = points_.width;
  if (!set_bytes()) {
    // Header and parameters disagree, or floats have the scale of integers: use
    // the alternative that fits the file's size.
    points_.width = static_cast<size_t>(in_header);
    if (in_header == 0 || !set_bytes()) {
      points_.width = width;
      const bool was_float = is_float_;
      is_float_ = true;
      if (!set_bytes()) is_float_ = was_float;
      set_bytes();
    }
  }
  step_m_ = is_float_ ? unit_m_ : unit_m_ * scale;
  points_.count = range.CountOf(points_, end);
  points_.first = range.FirstOf(points_.count);
  points_.rate_hz = IsRate(rate_hz_) ? rate_hz_ : 0.0;
}

// The header specifies the numbers of analog values and of samples per frame.
void C3dFile::FindAnalog() {
  const auto values = static_cast<size_t>(bytes_.Word(4));
  const auto per_frame = static_cast<size_t>(bytes_.Word(18));
  if (points_.width == 0 || values == 0) return;
  analog_.per_frame = std::max<size_t>(1, per_frame);
  analog_.channels = values / analog_.per_frame;
}

C3dChannel C3dFile::Channel(size_t index) const {
  const auto formats = values_.Texts("ANALOG:FORMAT");
  C3dChannel channel;
  channel.index = index;
  channel.is_unsigned =
      !formats.empty() && Upper(formats.front()) == "UNSIGNED";
  channel.offset =
      Whole(values_.NumberOrZero("ANALOG:OFFSET", index), channel.is_unsigned);
  channel.scale = values_.Number("ANALOG:SCALE", index).value_or(1.0);
  channel.general_scale = values_.Number("ANALOG:GEN_SCALE").value_or(1.0);
  return channel;
}

double C3dFile::Analog(int64_t frame, size_t sample,
                       const C3dChannel& channel) const {
  const size_t width = is_float_ ? 4 : 2;
  const size_t at =
      points_.begin + points_.frame_bytes * static_cast<size_t>(frame) +
      width * (4 * points_.width + sample * analog_.channels + channel.index);
  const double raw = is_float_ ? bytes_.Float(at)
                               : Whole(bytes_.Word(at), channel.is_unsigned);
  return (raw - channel.offset) * channel.scale * channel.general_scale;
}

std::optional<Eigen::Isometry3d> C3dFile::Segment(int64_t frame,
                                                  size_t segment) const {
  constexpr size_t kNumbers = 17;  // a matrix by columns, and its reliability
  const size_t at = segments_.begin +
                    segments_.frame_bytes * static_cast<size_t>(frame) +
                    4 * kNumbers * segment;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      pose(row, column) =
          bytes_.Float(at + 4 * static_cast<size_t>(4 * column + row));
    }
  }
  const double reliability = bytes_.Float(at + 4 * (kNumbers - 1));
  // Missing segments have NaN, zeros or a negative reliability.
  if (!(reliability >= 0.0) || !pose.matrix().allFinite() ||
      !(pose.linear().determinant() > 0.5)) {
    return std::nullopt;
  }
  pose.translation() *= unit_m_;
  return pose;
}

}  // namespace kinegraph
