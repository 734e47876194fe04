// The content of a C3D file of any program, according to c3d.org's user guide:
// integers or floats, Intel, DEC or MIPS order, analog samples; and C-Motion's
// ROTATION group, a 4x4 matrix per segment and frame. For core/io only.
#ifndef KINEGRAPH_CORE_IO_TRACKS_C3D_FILE_H_
#define KINEGRAPH_CORE_IO_TRACKS_C3D_FILE_H_

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {

inline constexpr size_t kC3dBlock = 512;  // bytes

// The bytes of a file, with numbers in one of three byte orders. Reading beyond
// the end throws InputError.
class C3dBytes {
 public:
  // Codes of the parameter section.
  enum Order { kIntel = 84, kDec = 85, kMips = 86 };

  explicit C3dBytes(std::string text) : text_(std::move(text)) {}
  void set_order(int order) { order_ = order; }
  size_t size() const { return text_.size(); }

  int Byte(size_t at) const { return ByteThere(Require(at, 1)); }
  int Word(size_t at) const { return WordThere(Require(at, 2)); }
  double Float(size_t at) const {
    Require(at, 4);
    const auto first = static_cast<uint32_t>(WordThere(at));
    const auto second = static_cast<uint32_t>(WordThere(at + 2));
    // In DEC and MIPS order the more significant half comes first; DEC's
    // exponent is larger by two.
    const uint32_t bits =
        order_ == kIntel ? second << 16 | first : first << 16 | second;
    float number = 0.0F;
    std::memcpy(&number, &bits, sizeof(number));
    return order_ == kDec ? number / 4.0 : number;
  }
  std::string Text(size_t at, size_t length) const {
    return text_.substr(Require(at, length), length);
  }
  bool Has(size_t at, size_t length) const {
    return at <= text_.size() && length <= text_.size() - at;
  }
  bool AllZero(size_t begin, size_t end) const {
    return text_.find_first_not_of('\0', begin) >= end;
  }

 private:
  int ByteThere(size_t at) const {
    return static_cast<unsigned char>(text_[at]);
  }
  int WordThere(size_t at) const {
    return order_ == kMips ? ByteThere(at) << 8 | ByteThere(at + 1)
                           : ByteThere(at + 1) << 8 | ByteThere(at);
  }
  size_t Require(size_t at, size_t length) const {
    if (!Has(at, length)) throw InputError("is cut off");
    return at;
  }

  std::string text_;
  int order_ = kIntel;
};

// The parameters of a file by "GROUP:NAME". Malformed parameters count as
// absent.
class C3dValues {
 public:
  C3dValues(const C3dBytes& bytes, size_t begin);

  // The value at `index`, nullopt if absent; bytes and words count as unsigned.
  // Throws InputError for a text.
  std::optional<double> Number(const std::string& name, size_t index = 0) const;
  // 0 if absent.
  double NumberOrZero(const std::string& name, size_t index = 0) const {
    return Number(name, index).value_or(0.0);
  }
  // Size of the first dimension, which varies fastest; 0 if absent.
  size_t RowLength(const std::string& name) const;
  // The texts, including those of NAME2, NAME3, ..., without trailing spaces
  // and NULs; empty for numbers. Texts that are not UTF-8 are read as Latin-1.
  std::vector<std::string> Texts(const std::string& name) const;

 private:
  // Type, shape and position in the file of a parameter's values.
  struct Place {
    int type = 0;  // -1 characters, 1 bytes, 2 words, 4 floats
    std::vector<size_t> shape;
    size_t count = 1;  // at most seven dimensions of 255: no overflow
    size_t at = 0;     // offset of the first value
  };

  // Reads the type and shape at an offset; nullopt if they are malformed.
  std::optional<Place> PlaceAt(size_t at) const;
  const Place* Find(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? nullptr : &found->second;
  }

  const C3dBytes& bytes_;
  std::map<std::string, Place> places_;
};

// Frames of points or of segments' matrices.
struct C3dFrames {
  size_t width = 0;  // points or segments per frame
  int64_t count = 0;
  int64_t first = 0;     // 0-based, whereas C3D counts from 1
  double rate_hz = 0.0;  // 0: unknown
  size_t begin = 0;      // offset of the first frame in the file
  size_t frame_bytes = 0;
};

// Analog samples, which follow the points of each frame.
struct C3dAnalog {
  size_t channels = 0;
  size_t per_frame = 0;  // samples of each channel
};

// How the samples of an analog channel are stored.
struct C3dChannel {
  size_t index = 0;
  bool is_unsigned = false;
  double offset = 0.0;  // subtracted before scaling
  double scale = 1.0;
  double general_scale = 1.0;
};

class C3dRange;  // what the file specifies about its range of frames

class C3dFile {
 public:
  // Throws InputError, which does not name the file, if it is not C3D, is
  // truncated, contradicts itself about its length, has neither points nor
  // segments, or has an unknown byte order or unit, no scale or no position of
  // the points.
  explicit C3dFile(std::string content);
  C3dFile(const C3dFile&) = delete;
  C3dFile& operator=(const C3dFile&) = delete;

  const C3dValues& values() const { return values_; }
  const C3dFrames& points() const { return points_; }
  const C3dFrames& segments() const { return segments_; }
  const C3dAnalog& analog() const { return analog_; }
  double unit_m() const { return unit_m_; }

  // In Point, Analog and Segment, `frame` is 0 for the first frame of the file.

  // Position in metres, in the axes of the file. nullopt for a missing point:
  // one with a negative residual or a number that is not finite, or at 0, 0, 0
  // with residual 0, as many programs write it.
  std::optional<Eigen::Vector3d> Point(int64_t frame, size_t point) const;
  C3dChannel Channel(size_t index) const;
  // A sample in the unit of the channel.
  double Analog(int64_t frame, size_t sample, const C3dChannel& channel) const;
  // Transform from the segment's axes to the file's; nullopt if the segment is
  // missing.
  std::optional<Eigen::Isometry3d> Segment(int64_t frame, size_t segment) const;

 private:
  size_t OpenParameters();
  void FindPoints(const C3dRange& range);
  void FindSegments(const C3dRange& range);
  void FindAnalog();

  C3dBytes bytes_;
  const C3dValues values_;
  bool is_float_ = true;
  double unit_m_ = 0.001;
  double step_m_ = 0.001;  // unit of a stored coordinate
  double rate_hz_ = 0.0;
  C3dFrames points_;
  C3dFrames segments_;
  C3dAnalog analog_;
};

// Inline, because it is called for each point of each frame.
inline std::optional<Eigen::Vector3d> C3dFile::Point(int64_t frame,
                                                     size_t point) const {
  const size_t width = is_float_ ? 4 : 2;
  const size_t at = points_.begin +
                    points_.frame_bytes * static_cast<size_t>(frame) +
                    4 * width * point;
  double values[4];
  for (size_t k = 0; k < 4; ++k) {
    values[k] = is_float_ ? bytes_.Float(at + 4 * k)
                          : static_cast<int16_t>(bytes_.Word(at + 2 * k));
  }
  constexpr double kLeast = std::numeric_limits<float>::min();
  if (is_float_ && values[3] != 0.0 && std::abs(values[3]) < kLeast) {
    // Some programs write the residual as a word even in float files.
    values[3] = static_cast<int16_t>(bytes_.Word(at + 12));
  }
  if (!(values[3] >= 0.0)) return std::nullopt;
  const Eigen::Vector3d at_m(step_m_ * values[0], step_m_ * values[1],
                             step_m_ * values[2]);
  const bool is_zero = values[0] == 0.0 && values[1] == 0.0 && values[2] == 0.0;
  if (!at_m.allFinite() || (is_zero && values[3] == 0.0)) return std::nullopt;
  return at_m;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_C3D_FILE_H_
