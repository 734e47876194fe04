// Reading C3D files. The label "Anna:l_knee" is a joint of person Anna. Points
// without such prefixes are one person's, unless every label occurs the same
// number of times, twice or more: then the nth points of all labels are the nth
// person's. In a file without points the joints are the origins of segments.
#include "core/io/tracks/c3d.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/tracks/c3d_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {
namespace {

// A point or segment of the file, with its person and joint.
struct Point {
  size_t index = 0;  // in the file
  size_t person = 0;
  size_t joint = 0;
};

struct Contents {
  std::vector<std::string> joints;  // union over people
  std::vector<TrackId> ids;
  PersonNames names;
  std::vector<Point> points;
};

// Numbers distinct texts in order of appearance, from 0.
class Places {
 public:
  size_t Of(const std::string& text) {
    const auto [at, is_new] = places_.try_emplace(text, texts_.size());
    if (is_new) texts_.push_back(text);
    return at->second;
  }
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::map<std::string, size_t> places_;
  std::vector<std::string> texts_;
};

// The id in a prefix such as "person_3:".
std::optional<TrackId> IdOf(const std::string& prefix) {
  constexpr std::string_view kBegins = "person_";
  if (prefix.rfind(kBegins, 0) != 0 || prefix.back() != ':')
    return std::nullopt;
  return PersonIdOf(std::string_view(prefix).substr(
      kBegins.size(), prefix.size() - kBegins.size() - 1));
}

// False for empty labels, Vicon's unlabelled points and the laboratory segment.
bool IsJoint(const std::string& label) {
  return !label.empty() && label.front() != '*' && label != "worldbody";
}

// Interprets the labels of a file.
class Labels {
 public:
  Labels(const C3dValues& values, std::vector<std::string> labels)
      : labels_(std::move(labels)),
        prefixes_(values.Texts("SUBJECTS:LABEL_PREFIXES")),
        subject_names_(values.Texts("SUBJECTS:NAMES")),
        uses_prefixes_(values.Number("SUBJECTS:USES_PREFIXES") != 0.0) {}

  Contents Read() {
    std::map<std::string, size_t> counts;
    for (const std::string& label : labels_) {
      if (IsJoint(label)) ++counts[label];
    }
    // If all labels occur equally often, and more than once, each occurs once
    // per person.
    const size_t copies = counts.empty() ? 0 : counts.begin()->second;
    const bool is_one_set_each =
        copies > 1 &&
        std::all_of(counts.begin(), counts.end(),
                    [&](const auto& count) { return count.second == copies; });
    std::map<std::string, size_t> seen;
    Contents contents;
    Places subjects;
    Places joints;
    for (size_t i = 0; i < labels_.size(); ++i) {
      if (!IsJoint(labels_[i])) continue;
      auto [subject, joint] = Split(labels_[i]);
      const size_t copy = seen[labels_[i]]++;
      if (is_one_set_each && subject.empty()) {
        subject = copy < subject_names_.size()
                      ? subject_names_[copy] + ":"
                      : PersonLabel(static_cast<int64_t>(copy)) + ":";
      } else if (copy > 0) {
        joint = UniqueName(counts, subject, joint, copy + 1);
      }
      contents.points.push_back({i, subjects.Of(subject), joints.Of(joint)});
    }
    contents.joints = joints.texts();
    NamePeople(subjects.texts(), &contents);
    return contents;
  }

 private:
  // A unique name such as "C7_2" for the second point labelled C7.
  static std::string UniqueName(const std::map<std::string, size_t>& labels,
                                const std::string& subject,
                                const std::string& joint, size_t number) {
    std::string other;
    do {
      other = joint + "_" + std::to_string(number++);
    } while (labels.count(subject + other) > 0);
    return other;
  }

  // Splits a label into "Anna:" and "l_knee": after one of the file's prefixes,
  // otherwise at a colon, unless the file specifies that it has no prefixes and
  // the text before the colon is not a subject's name.
  std::pair<std::string, std::string> Split(const std::string& label) const {
    size_t size = 0;
    for (const std::string& prefix : prefixes_) {
      if (label.size() > prefix.size() && label.rfind(prefix, 0) == 0) {
        size = std::max(size, prefix.size());
      }
    }
    const size_t colon = label.find(':');
    if (size == 0 && colon != std::string::npos && colon > 0 &&
        colon + 1 < label.size() &&
        (uses_prefixes_ ||
         std::count(subject_names_.begin(), subject_names_.end(),
                    label.substr(0, colon)) > 0)) {
      size = colon + 1;
    }
    return {label.substr(0, size), label.substr(size)};
  }

  // Sets ids and names. If all prefixes are like "person_3:", with different
  // numbers, these are the ids, otherwise ids are 0, 1, 2 in order of
  // appearance. Names are those of SUBJECTS:NAMES, otherwise the prefixes;
  // "person_3" is no name.
  void NamePeople(const std::vector<std::string>& subjects,
                  Contents* contents) const {
    std::set<TrackId> taken;
    std::vector<std::string> names(subjects.size());
    for (size_t s = 0; s < subjects.size(); ++s) {
      std::string prefix = subjects[s];
      if (subjects.size() == 1 && prefix.empty() && !prefixes_.empty()) {
        prefix = prefixes_.front();
      }
      contents->ids.push_back(IdOf(prefix).value_or(TrackId(-1)));
      taken.insert(contents->ids.back());
      std::string name = prefix;
      if (!name.empty() && name.back() == ':') name.pop_back();
      const auto place = std::find(prefixes_.begin(), prefixes_.end(), prefix);
      const auto index = static_cast<size_t>(place - prefixes_.begin());
      const bool is_listed = index < prefixes_.size() ||
                             (subjects.size() == 1 && prefixes_.empty());
      if (is_listed && index < subject_names_.size()) {
        name = subject_names_[index];
      }
      if (!IdOf(name + ":")) names[s] = name;
    }
    const bool all_numbered =
        taken.size() == subjects.size() && taken.count(TrackId(-1)) == 0;
    for (size_t s = 0; s < subjects.size(); ++s) {
      if (!all_numbered) contents->ids[s] = TrackId(static_cast<int64_t>(s));
      if (!names[s].empty()) contents->names[contents->ids[s]] = names[s];
    }
  }

  const std::vector<std::string> labels_;
  const std::vector<std::string> prefixes_;
  const std::vector<std::string> subject_names_;
  const bool uses_prefixes_;
};

// C-Motion and Theia label the matrix of the pelvis "pelvis_4X4".
std::string SegmentName(const std::string& label) {
  for (const std::string_view end : {"_4X4", "_4x4"}) {
    if (EndsIn(label, end)) {
      return label.substr(0, label.size() - end.size());
    }
  }
  return label;
}

// Empties the labels of quantities that Vicon's models compute and store as
// points, such as angles [degrees] and forces. POINT:ANGLES, POINT:FORCES, ...
// list these labels.
void DropModelled(const C3dValues& values, std::vector<std::string>* labels) {
  std::set<std::string> modelled;
  for (const char* kind :
       {"ANGLES", "FORCES", "MOMENTS", "POWERS", "REACTIONS", "SCALARS"}) {
    for (const std::string& label :
         values.Texts(std::string("POINT:") + kind)) {
      if (IsJoint(label)) modelled.insert(label);
    }
  }
  if (modelled.empty()) return;
  for (std::string& label : *labels) {
    if (modelled.count(label) > 0) label.clear();
  }
  if (std::none_of(labels->begin(), labels->end(), IsJoint)) {
    throw InputError("has angles or other results of a model, but no points");
  }
}

Contents ContentsOf(const C3dFile& file) {
  // Limits memory: every person gets an entry for every joint, at most this
  // many for each point of the file.
  constexpr size_t kMostPlaces = 64;
  const bool has_points = file.points().width > 0;
  std::vector<std::string> labels =
      file.values().Texts(has_points ? "POINT:LABELS" : "ROTATION:LABELS");
  labels.resize(has_points ? file.points().width : file.segments().width);
  if (!has_points) {
    std::transform(labels.begin(), labels.end(), labels.begin(), SegmentName);
  }
  DropModelled(file.values(), &labels);
  if (std::none_of(labels.begin(), labels.end(), IsJoint)) {
    for (size_t i = 0; i < labels.size(); ++i) {
      labels[i] = "point_" + std::to_string(i + 1);
    }
  }
  Contents contents = Labels(file.values(), labels).Read();
  if (contents.ids.size() * contents.joints.size() >
      kMostPlaces * contents.points.size()) {
    Refuse(
        "has {} people and {} joints in all, but people have different joints",
        contents.ids.size(), contents.joints.size());
  }
  return contents;
}

TrackSequence TracksOf(const C3dFile& file, const TrackReadOptions& options) {
  const Contents contents = ContentsOf(file);
  const bool has_points = file.points().width > 0;
  const C3dFrames& frames = has_points ? file.points() : file.segments();
  // SkeletonOfNames would translate the names of segments into those of joints,
  // but the origin of the head, for example, is not the joint at its top.
  TrackCollector collector("c3d",
                           has_points || options.skeleton.has_value()
                               ? SkeletonOfNames(contents.joints, options)
                               : Skeleton("custom", contents.joints, {}),
                           options, frames.rate_hz);
  const AxisMap axes = options.axes.value_or(C3dAxes());
  const auto at_m = [&](int64_t f, size_t i) -> std::optional<Eigen::Vector3d> {
    if (has_points) return file.Point(f, i);
    const auto pose = file.Segment(f, i);
    if (!pose.has_value()) return std::nullopt;
    return pose->translation();
  };
  for (int64_t f = 0; f < frames.count; ++f) {
    std::vector<Pose3d> poses(contents.ids.size(),
                              Pose3d(contents.joints.size()));
    for (const Point& point : contents.points) {
      const auto position_m = at_m(f, point.index);
      if (!position_m) continue;
      poses[point.person][point.joint] = {axes.Invert(*position_m),
                                          JointStatus::kObserved};
    }
    collector.Touch(frames.first + f);
    for (size_t p = 0; p < poses.size(); ++p) {
      collector.AddIfSeen(frames.first + f, contents.ids[p],
                          std::move(poses[p]));
    }
  }
  return collector.Finish();
}

SegmentSequence SegmentsOf(const C3dFile& file, const AxisMap& axes) {
  const C3dFrames& frames = file.segments();
  std::vector<std::string> labels = file.values().Texts("ROTATION:LABELS");
  labels.resize(frames.width);
  SegmentSequence sequence;
  sequence.frame_rate_hz = frames.rate_hz;
  for (const std::string& label : labels) {
    sequence.names.push_back(SegmentName(label));
  }
  for (int64_t f = 0; f < frames.count; ++f) {
    SegmentFrame& frame = sequence.frames.emplace_back();
    frame.frame = frames.first + f;
    for (size_t s = 0; s < frames.width; ++s) {
      auto pose = file.Segment(f, s);
      if (pose.has_value()) {
        for (int column = 0; column < 4; ++column) {
          pose->matrix().col(column).head<3>() =
              axes.Invert(pose->matrix().col(column).head<3>());
        }
      }
      frame.world_from_segment.push_back(pose);
    }
  }
  return sequence;
}

// ---- Force plates ----

double PlateNumber(const C3dValues& values, const std::string& name,
                   size_t index, double otherwise = 0.0) {
  return values.Number("FORCE_PLATFORM:" + name, index).value_or(otherwise);
}

// The weights with which the plate's channels add up to its vertical load;
// empty for types other than 1 to 4.
std::vector<double> LoadWeights(const C3dValues& values, size_t plate) {
  switch (static_cast<int>(PlateNumber(values, "TYPE", plate))) {
    case 1:
    case 2:
      return {0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    case 3:  // channels 5 to 8: vertical forces at the four corners
      return {0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0};
    case 4: {  // row of the calibration matrix for Fz; stored by columns
      std::vector<double> weights;
      for (size_t c = 0; c < 6; ++c) {
        weights.push_back(PlateNumber(
            values, "CAL_MATRIX", 36 * plate + 6 * c + 2, c == 2 ? 1.0 : 0.0));
      }
      return weights;
    }
    default:
      return {};
  }
}

ForcePlate ReadPlate(const C3dFile& file, size_t plate, size_t row_length,
                     const std::vector<double>& weights) {
  const C3dValues& values = file.values();
  ForcePlate result;
  for (size_t corner = 0; corner < 4; ++corner) {
    for (size_t axis = 0; axis < 3; ++axis) {
      result.centre_m[static_cast<Eigen::Index>(axis)] +=
          0.25 * file.unit_m() *
          PlateNumber(values, "CORNERS", 12 * plate + 3 * corner + axis);
    }
  }
  result.centre_m = C3dAxes().Invert(result.centre_m);
  const C3dAnalog& analog = file.analog();
  // The plate's channels and their weights, without those of weight 0.
  std::vector<std::pair<C3dChannel, double>> channels;
  for (size_t c = 0; c < weights.size(); ++c) {
    const double channel =
        PlateNumber(values, "CHANNEL", row_length * plate + c);
    if (!(channel >= 1.0 && channel <= static_cast<double>(analog.channels))) {
      Refuse(
          "FORCE_PLATFORM:CHANNEL: plate {}: entry {} is {:g}, expected an "
          "analog channel from 1 to {}",
          plate + 1, c + 1, channel, analog.channels);
    }
    if (weights[c] == 0.0) continue;
    channels.emplace_back(file.Channel(static_cast<size_t>(channel) - 1),
                          weights[c]);
  }
  const C3dFrames& points = file.points();
  result.rate_hz = points.rate_hz * static_cast<double>(analog.per_frame);
  result.first_s = static_cast<double>(points.first) / points.rate_hz;
  double sum_n = 0.0;
  for (int64_t frame = 0; frame < points.count; ++frame) {
    for (size_t sample = 0; sample < analog.per_frame; ++sample) {
      double load_n = 0.0;
      for (const auto& [channel, weight] : channels) {
        load_n += weight * file.Analog(frame, sample, channel);
      }
      result.load_n.push_back(load_n);
      sum_n += load_n;
    }
  }
  // The sign depends on conventions: the plate's axis may point up or down, and
  // the file may contain the force on the plate or its reaction.
  if (sum_n < 0.0) {
    for (double& load_n : result.load_n) load_n = -load_n;
  }
  return result;
}

// Calls `read` with the content of a file; errors name the path.
template <typename Read>
auto ReadC3d(const std::string& path, const Read& read) {
  std::string content = ReadBytes(path);  // names the path itself
  return Located(path, [&] { return read(C3dFile(std::move(content))); });
}

}  // namespace

SegmentSequence ReadSegments(const std::string& path,
                             const std::optional<AxisMap>& axes) {
  return ReadC3d(path, [&](const C3dFile& file) {
    return SegmentsOf(file, axes.value_or(C3dAxes()));
  });
}

std::vector<ForcePlate> ReadForcePlates(const std::string& path) {
  return ReadC3d(path, [&](const C3dFile& file) {
    const double used = PlateNumber(file.values(), "USED", 0);
    std::vector<std::vector<double>> weights;
    for (size_t plate = 0; static_cast<double>(plate) < used; ++plate) {
      weights.push_back(LoadWeights(file.values(), plate));
    }
    // One row per plate, each as long as for the plate with most channels.
    const size_t row_length = file.values().RowLength("FORCE_PLATFORM:CHANNEL");
    std::vector<ForcePlate> plates;
    for (size_t plate = 0; plate < weights.size(); ++plate) {
      if (weights[plate].empty()) continue;
      plates.push_back(ReadPlate(file, plate, row_length, weights[plate]));
    }
    if (plates.empty() || file.analog().per_frame == 0) {
      throw InputError("has no force plates of types 1 to 4 with samples");
    }
    if (!(file.points().rate_hz > 0.0)) {
      throw InputError("POINT:RATE: not given, expected the frame rate in Hz");
    }
    return plates;
  });
}

// The first byte of a C3D file is the block at which the parameters begin.
bool RecogniseC3dTracks(const TrackHead& head) {
  return head.beginning.size() >= kC3dBlock && head.beginning[1] == 0x50 &&
         !head.BeginsWith("PK") && head.beginning[0] > 0 &&
         head.beginning[0] < ' ';
}

TrackSequence ReadC3dTracks(const std::string& path,
                            const TrackReadOptions& options) {
  return ReadC3d(path,
                 [&](const C3dFile& file) { return TracksOf(file, options); });
}

PersonNames ReadC3dNames(const std::string& path) {
  return ReadC3d(path,
                 [](const C3dFile& file) { return ContentsOf(file).names; });
}

}  // namespace kinegraph
