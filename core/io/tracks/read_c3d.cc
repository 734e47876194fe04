// C3D as c3d.org's user guide has it, by whichever program: integers or floats,
// Intel, DEC or MIPS order, with analog samples (passed over) or without. A
// label "Anna:l_knee" is of person Anna; without such names all points are one
// person. C3D counts frames from 1, the tracks from 0.
#include "core/io/tracks/read_c3d.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/ids.h"
#include "core/io/tracks/c3d_parameters.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/person_files.h"

namespace kinegraph {
namespace {

constexpr int kIntel = 84;
constexpr int kDec = 85;
constexpr int kMips = 86;
constexpr double kMostFrames = 1e9;

// Bytes in one of the three orders; reading beyond the end throws InputError.
class Bytes {
 public:
  explicit Bytes(std::string text) : text_(std::move(text)) {}
  void set_order(int order) { order_ = order; }
  size_t size() const { return text_.size(); }

  int Byte(size_t at) const {
    Require(at, 1);
    return static_cast<unsigned char>(text_[at]);
  }
  int Word(size_t at) const {
    const int a = Byte(at);
    const int b = Byte(at + 1);
    return order_ == kMips ? a << 8 | b : b << 8 | a;
  }
  double Float(size_t at) const {
    const auto first = static_cast<uint32_t>(Word(at));
    const auto second = static_cast<uint32_t>(Word(at + 2));
    // DEC's and MIPS' more significant half comes first; DEC's exponent counts
    // two more.
    const uint32_t bits =
        order_ == kIntel ? second << 16 | first : first << 16 | second;
    float number = 0.0F;
    std::memcpy(&number, &bits, sizeof(number));
    return order_ == kDec ? number / 4.0 : number;
  }
  std::string Text(size_t at, size_t length) const {
    Require(at, length);
    return text_.substr(at, length);
  }
  void Require(size_t at, size_t length) const {
    if (at > text_.size() || length > text_.size() - at) {
      throw InputError("is cut off");
    }
  }

 private:
  std::string text_;
  int order_ = kIntel;
};

std::string Upper(std::string text) {
  for (char& c : text) {
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return text;
}

std::string Trimmed(const std::string& text) {
  const size_t end = text.find_last_not_of(std::string(" \0", 2));
  return end == std::string::npos ? "" : text.substr(0, end + 1);
}

// Where a parameter's values stand.
struct Parameter {
  int type = 0;  // -1 characters, 1 bytes, 2 words, 4 floats
  std::vector<size_t> shape;
  size_t at = 0;

  size_t count() const {
    size_t count = 1;
    for (const size_t side : shape) count *= side;
    return count;
  }
};

// Parameters by "GROUP:NAME".
class Parameters {
 public:
  Parameters(const Bytes& bytes, size_t begin) : bytes_(bytes) {
    const size_t end =
        std::min(begin + kC3dBlock * static_cast<size_t>(bytes.Byte(begin + 2)),
                 bytes.size());
    std::map<int, std::string> groups;
    std::vector<std::pair<std::pair<int, std::string>, Parameter>> found;
    for (size_t at = begin + 4; at + 2 < end;) {
      const auto length = static_cast<size_t>(
          std::abs(static_cast<signed char>(bytes.Byte(at))));
      const int group = static_cast<signed char>(bytes.Byte(at + 1));
      if (length == 0 || group == 0) break;
      const std::string name = Upper(bytes.Text(at + 2, length));
      const size_t here = at + 2 + length;
      const auto step = static_cast<size_t>(bytes.Word(here));
      if (group < 0) {
        groups[-group] = name;
      } else {
        found.push_back({{group, name}, ReadParameter(here + 2)});
      }
      if (step == 0) break;
      at = here + step;
    }
    for (auto& [key, parameter] : found) {
      parameters_[groups[key.first] + ":" + key.second] = std::move(parameter);
    }
  }

  bool Has(const std::string& name) const {
    return parameters_.count(name) > 0;
  }
  // The value at `index`; `otherwise` when it is not there.
  double Number(const std::string& name, double otherwise,
                size_t index = 0) const {
    const auto found = parameters_.find(name);
    if (found == parameters_.end() || index >= found->second.count()) {
      return otherwise;
    }
    const Parameter& parameter = found->second;
    if (parameter.type == 4) return bytes_.Float(parameter.at + 4 * index);
    if (parameter.type == 2) return bytes_.Word(parameter.at + 2 * index);
    if (parameter.type == 1) return bytes_.Byte(parameter.at + index);
    throw InputError(name + ": expected a number");
  }
  // With those of NAME2, NAME3, ...
  std::vector<std::string> Texts(const std::string& name) const {
    std::vector<std::string> texts;
    for (int part = 1;; ++part) {
      const auto found =
          parameters_.find(part == 1 ? name : name + std::to_string(part));
      if (found == parameters_.end()) return texts;
      const Parameter& parameter = found->second;
      if (parameter.type != -1) throw InputError(name + ": expected texts");
      const size_t width = parameter.shape.empty() ? 1 : parameter.shape[0];
      if (width == 0) continue;
      for (size_t i = 0; i + width <= parameter.count(); i += width) {
        texts.push_back(Trimmed(bytes_.Text(parameter.at + i, width)));
      }
    }
  }

 private:
  Parameter ReadParameter(size_t at) const {
    Parameter parameter;
    parameter.type = static_cast<signed char>(bytes_.Byte(at));
    const auto sides = static_cast<size_t>(bytes_.Byte(at + 1));
    constexpr size_t kMostSides = 7;
    if (sides > kMostSides) throw InputError("a parameter has too many sides");
    for (size_t s = 0; s < sides; ++s) {
      parameter.shape.push_back(static_cast<size_t>(bytes_.Byte(at + 2 + s)));
    }
    parameter.at = at + 2 + sides;
    const auto width = static_cast<size_t>(std::abs(parameter.type));
    if (width == 0 || width > 4) throw InputError("a parameter has no type");
    // Seven sides of 255 at most: no overflow.
    bytes_.Require(parameter.at, width * parameter.count());
    return parameter;
  }

  const Bytes& bytes_;
  std::map<std::string, Parameter> parameters_;
};

// A point of the file: whose it is and which joint.
struct Point {
  size_t index = 0;  // in the file
  size_t person = 0;
  size_t joint = 0;
};

struct Contents {
  std::vector<std::string> joints;  // of all people together
  std::vector<TrackId> ids;
  PersonNames names;
  std::vector<Point> points;
};

class Reader {
 public:
  explicit Reader(const std::string& path) : bytes_(ReadTextFile(path)) {}

  Contents ReadContents() {
    const Parameters& parameters = Open();
    const std::vector<std::string> labels = parameters.Texts("POINT:LABELS");
    Contents contents;
    std::vector<std::string> subjects;
    std::set<std::pair<size_t, size_t>> taken;
    for (size_t i = 0; i < labels.size() && i < point_count_; ++i) {
      // Points without a name, and Vicon's that nobody named.
      if (labels[i].empty() || labels[i].front() == '*') continue;
      const size_t colon = labels[i].find(':');
      const bool has_subject = colon != std::string::npos && colon > 0 &&
                               colon + 1 < labels[i].size();
      const std::string subject = has_subject ? labels[i].substr(0, colon) : "";
      const std::string joint =
          has_subject ? labels[i].substr(colon + 1) : labels[i];
      const Point point = {i, PlaceIn(subject, &subjects),
                           PlaceIn(joint, &contents.joints)};
      if (!taken.insert({point.person, point.joint}).second) {
        throw InputError("the point '" + Printable(labels[i]) +
                         "' stands there twice");
      }
      contents.points.push_back(point);
    }
    if (contents.points.empty()) throw InputError("has no points with labels");
    NamePeople(subjects, &contents);
    return contents;
  }

  TrackSequence Read(const TrackReadOptions& options) {
    const Contents contents = ReadContents();
    TrackHeader header;
    header.mode = "c3d";
    header.frame_rate_hz =
        options.frame_rate_hz > 0.0 ? options.frame_rate_hz : rate_hz_;
    header.skeleton = SkeletonOfNames(contents.joints, options);
    TrackCollector collector(std::move(header));
    const AxisMap axes = options.axes.value_or(C3dAxes());
    for (int64_t f = 0; f < frame_count_; ++f) {
      const int64_t number = first_frame_ - 1 + f;
      collector.Touch(number);
      std::vector<Pose3d> poses(contents.ids.size(),
                                Pose3d(contents.joints.size()));
      for (const Point& point : contents.points) {
        const auto at_m = PointAt(f, point.index);
        if (!at_m) continue;
        poses[point.person][point.joint] = {axes.Invert(*at_m),
                                            JointStatus::kObserved};
      }
      for (size_t p = 0; p < poses.size(); ++p) {
        if (CountPresent(poses[p]) == 0) continue;
        collector.Add(number, contents.ids[p])->joints = std::move(poses[p]);
      }
    }
    return collector.Finish();
  }

 private:
  static size_t PlaceIn(const std::string& name,
                        std::vector<std::string>* names) {
    const auto found = std::find(names->begin(), names->end(), name);
    if (found == names->end()) {
      names->push_back(name);
      return names->size() - 1;
    }
    return static_cast<size_t>(found - names->begin());
  }

  // Header and parameters; where the points are.
  const Parameters& Open() {
    bytes_.Require(0, kC3dBlock);
    if (bytes_.Byte(1) != 0x50) throw InputError("is no C3D file");
    const auto begin =
        kC3dBlock * static_cast<size_t>(std::max(bytes_.Byte(0) - 1, 0));
    const int order = bytes_.Byte(begin + 3);
    if (order < kIntel || order > kMips) {
      throw InputError("names no byte order (Intel, DEC or MIPS)");
    }
    bytes_.set_order(order);
    parameters_.emplace(bytes_, begin);
    point_count_ = static_cast<size_t>(bytes_.Word(2));
    scale_ = bytes_.Float(12);
    rate_hz_ = bytes_.Float(20);
    if (!(rate_hz_ > 0.0 && rate_hz_ <= 1e6)) {
      throw InputError("expected a frame rate above 0 .. 1e6 Hz");
    }
    if (!std::isfinite(scale_) || scale_ == 0.0) {
      throw InputError("POINT:SCALE: expected a number other than 0");
    }
    FindFrames();
    metres_ = MetresOf(parameters_->Texts("POINT:UNITS"));
    return *parameters_;
  }

  void FindFrames() {
    // Two words, or a number of another type.
    const auto field = [&](const char* name, int header) {
      const double low = parameters_->Number(name, header);
      const double high = parameters_->Number(name, 0.0, 1);
      if (!(low >= 0.0 && low <= kMostFrames && high >= 0.0 &&
            high < 65536.0)) {
        throw InputError(std::string(name) +
                         ": expected the number of a frame");
      }
      return static_cast<int64_t>(low) + 65536 * static_cast<int64_t>(high);
    };
    first_frame_ = field("TRIAL:ACTUAL_START_FIELD", bytes_.Word(6));
    int64_t last = field("TRIAL:ACTUAL_END_FIELD", bytes_.Word(8));
    // A word holds no more; without TRIAL the points' own count may.
    constexpr int64_t kFull = 65535;
    if (last == kFull) {
      const double count = parameters_->Number(
          "POINT:LONG_FRAMES", parameters_->Number("POINT:FRAMES", 0.0));
      if (count > 0.0 && count <= kMostFrames) {
        last = std::max(last, first_frame_ - 1 + static_cast<int64_t>(count));
      }
    }
    frame_count_ = last - first_frame_ + 1;
    if (first_frame_ < 1 || frame_count_ < 0) {
      throw InputError("expected frames from 1 on, found " +
                       std::to_string(first_frame_) + " .. " +
                       std::to_string(last));
    }
    const size_t width = scale_ < 0.0 ? 4 : 2;
    frame_bytes_ =
        width * (4 * point_count_ + static_cast<size_t>(bytes_.Word(4)));
    data_ = kC3dBlock * static_cast<size_t>(std::max(bytes_.Word(16) - 1, 0));
    bytes_.Require(data_, frame_bytes_ * static_cast<size_t>(frame_count_));
  }

  static double MetresOf(const std::vector<std::string>& units) {
    const std::string unit = units.empty() ? "mm" : units.front();
    for (const auto& [name, metres] :
         {std::pair{"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}}) {
      if (unit == name) return metres;
    }
    throw InputError("POINT:UNITS: found '" + Printable(unit) +
                     "', expected mm, cm or m");
  }

  // nullopt for a point that is not valid.
  std::optional<Eigen::Vector3d> PointAt(int64_t frame, size_t point) const {
    const bool is_float = scale_ < 0.0;
    const size_t width = is_float ? 4 : 2;
    const size_t at =
        data_ + frame_bytes_ * static_cast<size_t>(frame) + 4 * width * point;
    double values[4];
    for (size_t k = 0; k < 4; ++k) {
      values[k] = is_float ? bytes_.Float(at + 4 * k)
                           : static_cast<int16_t>(bytes_.Word(at + 2 * k));
    }
    if (values[3] < 0.0) return std::nullopt;
    const double unit = is_float ? metres_ : metres_ * scale_;
    const Eigen::Vector3d at_m(unit * values[0], unit * values[1],
                               unit * values[2]);
    if (!at_m.allFinite()) return std::nullopt;
    return at_m;
  }

  // "person_3" is identity 3, others count 0, 1, 2 in order; SUBJECTS:NAMES
  // says what people are called.
  void NamePeople(const std::vector<std::string>& subjects,
                  Contents* contents) const {
    const auto prefixes = parameters_->Texts("SUBJECTS:LABEL_PREFIXES");
    const auto called = parameters_->Texts("SUBJECTS:NAMES");
    std::set<TrackId> taken;
    std::vector<std::string> names(subjects.size());
    for (size_t s = 0; s < subjects.size(); ++s) {
      std::string prefix = subjects[s] + ":";
      if (subjects.size() == 1 && subjects[s].empty() && !prefixes.empty()) {
        prefix = prefixes.front();
      }
      contents->ids.push_back(IdOf(prefix).value_or(TrackId(-1)));
      taken.insert(contents->ids.back());
      const auto place = std::find(prefixes.begin(), prefixes.end(), prefix);
      const auto index = static_cast<size_t>(place - prefixes.begin());
      std::string name = prefix.substr(0, prefix.size() - 1);
      if (index < called.size()) name = called[index];
      if (!IdOf(name + ":")) names[s] = name;
    }
    const bool all_numbered =
        taken.size() == subjects.size() && taken.count(TrackId(-1)) == 0;
    for (size_t s = 0; s < subjects.size(); ++s) {
      if (!all_numbered) contents->ids[s] = TrackId(static_cast<int64_t>(s));
      if (!names[s].empty()) contents->names[contents->ids[s]] = names[s];
    }
  }

  static std::optional<TrackId> IdOf(const std::string& prefix) {
    const std::string begin = "person_";
    if (prefix.rfind(begin, 0) != 0 || prefix.back() != ':') {
      return std::nullopt;
    }
    const auto id = PersonIdOf(std::string_view(prefix).substr(
        begin.size(), prefix.size() - begin.size() - 1));
    if (!id.has_value() || id->value() > kMaxId) return std::nullopt;
    return id;
  }

  Bytes bytes_;
  std::optional<Parameters> parameters_;
  size_t point_count_ = 0;
  double scale_ = 0.0;
  double rate_hz_ = 0.0;
  double metres_ = 0.001;
  int64_t first_frame_ = 1;
  int64_t frame_count_ = 0;
  size_t frame_bytes_ = 0;
  size_t data_ = 0;
};

TrackSequence ReadTracksC3d(const std::string& path,
                            const TrackReadOptions& options) {
  return Located(path, [&] { return Reader(path).Read(options); });
}

PersonNames ReadNames(const std::string& path) {
  return Located(path, [&] { return Reader(path).ReadContents().names; });
}

}  // namespace

TrackFormat C3dTrackFormat() {
  TrackFormat format;
  format.name = "c3d";
  format.layout = "points of motion capture, mm";
  format.extensions = {kC3dExtension};
  format.axes = C3dAxes();
  format.has_marker_names = true;
  // The first byte says where the parameters begin.
  format.recognise = [](const TrackHead& head) {
    return head.beginning.size() >= kC3dBlock && head.beginning[1] == 0x50 &&
           !head.BeginsWith("PK") && head.beginning[0] > 0 &&
           head.beginning[0] < ' ';
  };
  format.read = ReadTracksC3d;
  format.read_names = ReadNames;
  format.keeps_names = true;
  format.write = WriteTracksC3d;
  format.read_note = "integers and floats of all byte orders; m, cm, mm";
  format.kept =
      "frame, frame rate, identity, positions (32 bit); written also the size "
      "of the covariance (residual) and which of the first seven views "
      "measured a joint (camera mask)";
  format.lost =
      "times of their own, status, views, bones of own skeletons; read, analog "
      "samples and points without labels; refused: above 65535 points";
  return format;
}

}  // namespace kinegraph
