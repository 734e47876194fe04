// Writing C3D, the format of motion capture laboratories, according to
// c3d.org's user guide. 512-byte blocks contain a header, the parameters, then
// for each frame and point x, y, z [mm] and a number for camera mask and
// residual, as Intel (little-endian) floats. C3D counts frames from 1: frame 0
// of the tracks is frame 1 of the file.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/binary/bytes.h"
#include "core/io/files/atomic_file.h"
#include "core/io/tracks/c3d_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

constexpr int64_t kMaxWord = 65535;
constexpr int kMaskBits = 7;  // of the camera mask; the sign bit stays 0

// The parameter section: groups with their parameters, in the order of
// insertion.
class C3dParameters {
 public:
  C3dParameters& Group(const std::string& name) {
    ++group_;
    return Record(name, -group_, "");
  }
  // Adds a parameter to the last group, stored as words or floats. An empty
  // shape means a scalar.
  C3dParameters& Words(const std::string& name,
                       const std::vector<size_t>& shape,
                       const std::vector<int64_t>& values) {
    return Numbers<uint16_t>(name, 2, shape, values);
  }
  C3dParameters& Word(const std::string& name, int64_t value) {
    return Words(name, {}, {value});
  }
  C3dParameters& Floats(const std::string& name,
                        const std::vector<size_t>& shape,
                        const std::vector<double>& values) {
    return Numbers<float>(name, 4, shape, values);
  }
  C3dParameters& Float(const std::string& name, double value) {
    return Floats(name, {}, {value});
  }
  // Adds texts, padded to the longest one. Beyond 255 texts they continue in
  // NAME2, NAME3, ...; a text is cut after 255 bytes.
  C3dParameters& Texts(const std::string& name,
                       const std::vector<std::string>& texts);

  // The section in whole blocks. Throws InputError above 255 blocks, the limit
  // of a file.
  std::string Section() const;

 private:
  template <typename Stored, typename Number>
  C3dParameters& Numbers(const std::string& name, int type,
                         const std::vector<size_t>& shape,
                         const std::vector<Number>& values) {
    std::string data;
    for (const Number value : values) {
      AppendNumbers(&data, static_cast<Stored>(value));
    }
    return Add(name, type, shape, data);
  }
  C3dParameters& Add(const std::string& name, int type,
                     const std::vector<size_t>& shape,
                     const std::string& data) {
    std::string content = {static_cast<char>(type),
                           static_cast<char>(shape.size())};
    for (const size_t side : shape) content += static_cast<char>(side);
    return Record(name, group_, content + data);
  }
  // Adds a record: length of the name, number of the group (negative: the group
  // itself), name, offset to the next record, content and an empty description.
  C3dParameters& Record(const std::string& name, int id,
                        const std::string& content) {
    records_ += static_cast<char>(name.size());
    records_ += static_cast<char>(id) + name;
    last_record_ = records_.size();
    AppendNumbers(&records_, static_cast<uint16_t>(content.size() + 3));
    records_ += content + '\0';
    return *this;
  }

  std::string records_;
  size_t last_record_ = 0;
  int group_ = 0;
};

C3dParameters& C3dParameters::Texts(const std::string& name,
                                    const std::vector<std::string>& texts) {
  constexpr size_t kMost = 255;  // the size of a dimension is a byte
  for (size_t begin = 0, part = 1; begin == 0 || begin < texts.size();
       begin += kMost, ++part) {
    const size_t end = std::min(begin + kMost, texts.size());
    size_t width = 1;
    for (size_t t = begin; t < end; ++t) {
      width = std::max(width, texts[t].size());
    }
    width = std::min(width, kMost);
    std::string data;
    for (size_t t = begin; t < end; ++t) {
      data += WholeLetters(texts[t], width);
      data.resize((t - begin + 1) * width, ' ');
    }
    Add(part == 1 ? name : name + std::to_string(part), -1,
        {width, end - begin}, data);
  }
  return *this;
}

std::string C3dParameters::Section() const {
  constexpr size_t kMostBlocks = 255;
  std::string section(4, '\0');
  section += records_;
  // An offset of 0 marks the last record.
  section[4 + last_record_] = section[4 + last_record_ + 1] = '\0';
  const size_t blocks = (section.size() + 2 + kC3dBlock - 1) / kC3dBlock;
  if (blocks > kMostBlocks) {
    throw InputError(
        "the names of all joints of all people exceed the space in C3D "
        "(convert one person with --person=N)");
  }
  section.resize(blocks * kC3dBlock, '\0');
  section[0] = 1;
  section[1] = 0x50;
  section[2] = static_cast<char>(blocks);
  section[3] = 84;  // Intel
  return section;
}

// Expected RMS distance of the true joint from the estimate [mm]; 0 if unknown.
double UncertaintyMm(const PersonPose& person, size_t joint_idx) {
  if (person.covariances.empty() || !person.covariances[joint_idx]) return 0.0;
  const double variance_m2 = person.covariances[joint_idx]->trace();
  return kMillimetresPerMetre * std::sqrt(std::max(0.0, variance_m2));
}

// Unit of the stored residual [mm]. The file stores its negative, which marks
// float points. The guide requires that all coordinates divided by it fit 16
// bits.
double ScaleMm(const TrackSequence& tracks) {
  constexpr double kMaxInteger = 32000.0;
  constexpr double kMaxResidual = 255.0;
  double coordinate_mm = 1.0;
  double residual_mm = 0.0;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (!person.joints[j].present()) continue;
        coordinate_mm =
            std::max(coordinate_mm,
                     kMillimetresPerMetre *
                         person.joints[j].position_m.cwiseAbs().maxCoeff());
        residual_mm = std::max(residual_mm, UncertaintyMm(person, j));
      }
    }
  }
  return std::max(coordinate_mm / kMaxInteger, residual_mm / kMaxResidual);
}

// Bit v is set if view v, one of the first seven, observed the joint with a
// positive weight.
int CameraMask(const PersonPose& person, size_t joint_idx) {
  int mask = 0;
  for (const ViewMatch& match : person.matches) {
    if (match.view_idx >= kMaskBits || match.weights.empty()) continue;
    if (match.weights[joint_idx].value_or(0.0) > 0.0) {
      mask |= 1 << match.view_idx;
    }
  }
  return mask;
}

// The parts of a file.
class C3dRecording {
 public:
  C3dRecording(const TrackSequence& tracks, const TrackExportOptions& options)
      : tracks_(tracks),
        names_(options.names),
        axes_(options.axes.value_or(C3dAxes())),
        rate_hz_(RequireFrameRate(tracks, "C3D")),
        ids_(RequirePeople(tracks)),
        rows_(MakeTrackRows(tracks, "C3D")),
        joint_count_(tracks.header.skeleton.joints().size()),
        scale_mm_(ScaleMm(tracks)) {
    first_ = tracks.frames.front().frame + 1;
    last_ = tracks.frames.back().frame + 1;
    if (point_count() > kMaxWord) {
      Refuse(
          "{} people with {} joints are too many for C3D, which has at most {} "
          "points (convert one person with --person=N)",
          ids_.size(), joint_count_, kMaxWord);
    }
    constexpr int64_t kMaxFrameNumber = int64_t{1} << 31;
    if (last_ > kMaxFrameNumber) {
      Refuse("frame {} exceeds the frame numbers of C3D", last_ - 1);
    }
  }

  const std::vector<TrackRow>& rows() const { return rows_; }

  std::string Header(int data_block) const {
    std::string header = "\x02\x50";
    for (const int64_t word :
         {point_count(), int64_t{0}, std::min(first_, kMaxWord),
          std::min(last_, kMaxWord), int64_t{0}}) {
      AppendNumbers(&header, static_cast<uint16_t>(word));
    }
    AppendNumbers(&header, static_cast<float>(-scale_mm_),
                  static_cast<uint16_t>(data_block), uint16_t{0},
                  static_cast<float>(rate_hz_));
    header.resize(2 * 149, '\0');
    // A flag: event labels have four characters.
    AppendNumbers(&header, uint16_t{12345});
    header.resize(kC3dBlock, '\0');
    return header;
  }

  std::string Parameters() const {
    // The parameters contain the block at which the data begin, which depends
    // on their own size, so make them twice.
    const size_t blocks = MakeParameters(0).size() / kC3dBlock;
    return MakeParameters(static_cast<int>(blocks) + 2);
  }

  std::string Points(const TrackRow& row) const {
    std::string bytes;
    for (const int64_t id : ids_) {
      const PersonPose* person = FindPerson(row.frame, TrackId(id));
      for (size_t j = 0; j < joint_count_; ++j) {
        Eigen::Vector4d point(0.0, 0.0, 0.0, -1.0);
        if (person != nullptr && person->joints[j].present()) {
          point.head<3>() =
              kMillimetresPerMetre * axes_.Apply(person->joints[j].position_m);
          // Readers treat a point at exactly 0, 0, 0 as missing, C3dFile only
          // if the residual is also 0.
          if (point.head<3>().isZero(0.0)) {
            point.x() = std::numeric_limits<float>::min();
          }
          point.w() = FourthWord(*person, j);
        }
        for (const double number : point) {
          AppendNumbers(&bytes, static_cast<float>(number));
        }
      }
    }
    return bytes;
  }

 private:
  int64_t point_count() const {
    return static_cast<int64_t>(ids_.size() * joint_count_);
  }

  // The camera mask is the high byte, the residual the low byte.
  double FourthWord(const PersonPose& person, size_t joint_idx) const {
    const double uncertainty_mm = UncertaintyMm(person, joint_idx);
    int residual = 0;
    if (uncertainty_mm > 0.0) {
      residual = std::clamp(
          static_cast<int>(std::lround(uncertainty_mm / scale_mm_)), 1, 255);
    }
    const bool is_measured =
        person.joints[joint_idx].status == JointStatus::kObserved;
    const int mask = is_measured ? CameraMask(person, joint_idx) : 0;
    return (mask << 8) + residual;
  }

  std::string MakeParameters(int data_block) const {
    C3dParameters parameters;
    AddPoints(data_block, &parameters);
    parameters.Group("ANALOG").Word("USED", 0).Float("GEN_SCALE", 1.0);
    parameters.Float("RATE", rate_hz_);
    parameters.Group("FORCE_PLATFORM").Word("USED", 0);
    parameters.Group("TRIAL")
        .Words("ACTUAL_START_FIELD", {2}, {first_ % 65536, first_ / 65536})
        .Words("ACTUAL_END_FIELD", {2}, {last_ % 65536, last_ / 65536})
        .Float("CAMERA_RATE", rate_hz_);
    AddSubjectsAndEvents(&parameters);
    parameters.Group("MANUFACTURER").Texts("COMPANY", {"kinegraph"});
    parameters.Texts("SOFTWARE", {"kinegraph"});
    return parameters.Section();
  }

  void AddPoints(int data_block, C3dParameters* parameters) const {
    const auto frames = static_cast<int64_t>(rows_.size());
    std::vector<std::string> labels;
    for (const int64_t id : ids_) {
      const std::string prefix = ids_.size() > 1 ? PersonLabel(id) + ":" : "";
      for (const std::string& joint : tracks_.header.skeleton.joints()) {
        labels.push_back(prefix + joint);
      }
    }
    // The direction of a world axis in the file, such as "+Z".
    const auto axis_of = [this](int of_world) {
      const size_t i = axes_.FileAxisOf(of_world);
      return std::string(axes_.sign[i] < 0.0 ? "-" : "+") +
             static_cast<char>('X' + i);
    };
    parameters->Group("POINT").Word("USED", point_count());
    parameters->Float("SCALE", -scale_mm_).Float("RATE", rate_hz_);
    parameters->Word("DATA_START", data_block);
    parameters->Word("FRAMES", std::min(frames, kMaxWord));
    if (frames >= kMaxWord) {  // a word then means "or more"
      parameters->Float("LONG_FRAMES", static_cast<double>(frames));
    }
    parameters->Texts("LABELS", labels).Texts("UNITS", {"mm"});
    parameters->Texts("X_SCREEN", {axis_of(0)}).Texts("Y_SCREEN", {axis_of(2)});
  }

  // Adds the names of all people and, for the first 127 people, events at the
  // first and the last frame in which they are present.
  void AddSubjectsAndEvents(C3dParameters* parameters) const {
    constexpr size_t kMostEvents = 254;  // a dimension is at most 255
    constexpr double kMinute = 60.0;
    std::map<int64_t, std::pair<int64_t, int64_t>> presence;
    for (const TrackFrame& frame : tracks_.frames) {
      for (const PersonPose& person : frame.people) {
        const auto first = std::pair(frame.frame, frame.frame);
        presence.try_emplace(person.id.value(), first).first->second.second =
            frame.frame;
      }
    }
    std::vector<std::string> prefixes;
    std::vector<std::string> subject_names;
    std::vector<std::string> subjects;
    std::vector<std::string> labels;
    std::vector<double> times;
    for (const int64_t id : ids_) {
      prefixes.push_back(PersonLabel(id) + ":");
      const auto name = names_.find(TrackId(id));
      subject_names.push_back(name != names_.end() ? name->second
                                                   : PersonLabel(id));
      if (labels.size() + 2 > kMostEvents) continue;
      const auto [begin, end] = presence.at(id);
      for (const auto& [label, frame] :
           {std::pair{"begin", begin}, {"end", end}}) {
        const double time_s = static_cast<double>(frame) / rate_hz_;
        times.push_back(std::floor(time_s / kMinute));
        times.push_back(time_s - kMinute * times.back());
        labels.push_back(label);
        subjects.push_back(subject_names.back());
      }
    }
    parameters->Group("SUBJECTS").Word("IS_STATIC", 0);
    parameters->Word("USES_PREFIXES", ids_.size() > 1 ? 1 : 0);
    parameters->Word("USED", static_cast<int64_t>(ids_.size()));
    parameters->Texts("NAMES", subject_names).Texts("LABEL_PREFIXES", prefixes);
    const size_t count = labels.size();
    parameters->Group("EVENT").Word("USED", static_cast<int64_t>(count));
    parameters->Texts("CONTEXTS", std::vector<std::string>(count, "General"));
    parameters->Texts("LABELS", labels).Texts("SUBJECTS", subjects);
    parameters->Floats("TIMES", {2, count}, times);
    parameters->Words("ICON_IDS", {count}, std::vector<int64_t>(count, 0));
  }

  const TrackSequence& tracks_;
  const PersonNames& names_;
  const AxisMap axes_;
  const double rate_hz_;
  const std::vector<int64_t> ids_;
  const std::vector<TrackRow> rows_;
  const size_t joint_count_;
  const double scale_mm_;
  int64_t first_ = 1;  // 1-based
  int64_t last_ = 1;
};

}  // namespace

void WriteC3dTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  const C3dRecording recording(tracks, options);
  const std::string parameters = recording.Parameters();
  AtomicFile file(path);
  file.Write(
      recording.Header(static_cast<int>(parameters.size() / kC3dBlock) + 2));
  file.Write(parameters);
  size_t bytes = 0;
  for (const TrackRow& row : recording.rows()) {
    const std::string points = recording.Points(row);
    file.Write(points);
    bytes += points.size();
  }
  file.Write(std::string((kC3dBlock - bytes % kC3dBlock) % kC3dBlock, '\0'));
  file.Commit();
  const TrackContents contents = ContentsOf(tracks);
  lost_fields->push_back(
      "bones, configuration and individual times are not kept");
  if (contents.has_covariances) {
    lost_fields->push_back(
        "of covariances only the root of the trace is kept, as the residual");
  }
  NoteLosses(contents, {Loss::kInferredObserved}, lost_fields);
  if (contents.has_views && !contents.has_matches) {
    lost_fields->push_back(
        "the camera mask is empty: the tracks have no matches");
  }
  if (tracks.header.view_names.size() > kMaskBits) {
    lost_fields->push_back(
        "the camera mask contains only the first seven views");
  }
  NoteAddedRows(tracks, recording.rows().size(), "have points without position",
                lost_fields);
}

}  // namespace kinegraph
