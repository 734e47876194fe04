// Joints of BVH files by whichever program: channels in any order, several
// roots, a file or a folder with a file a person, in centimetres. Places of
// joints follow from offsets and angles; a joint that lies on its parent in
// every frame is a pivot and left out. Frames count from 0.
#include "core/io/tracks/read_bvh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/words.h"
#include "core/io/tracks/formats.h"
#include "core/io/tracks/person_files.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr size_t kMostJoints = 10000;

struct Channel {
  bool is_position = false;
  int axis = 0;
};

struct BvhNode {
  std::string name;
  int parent = -1;
  Vector3d offset = Vector3d::Zero();
  std::vector<Channel> channels;
};

struct Hierarchy {
  std::vector<BvhNode> nodes;
  size_t channel_count = 0;
};

std::optional<Channel> ChannelOf(std::string_view word) {
  if (word.size() < 9 || word[0] < 'X' || word[0] > 'Z') return std::nullopt;
  const std::string_view kind = word.substr(1);
  if (kind != "position" && kind != "rotation") return std::nullopt;
  return Channel{kind == "position", word[0] - 'X'};
}

// Channels, joints and end sites up to the closing brackets.
class HierarchyReader {
 public:
  explicit HierarchyReader(Words* words) : words_(*words) {}

  // "MOTION" is the word after the hierarchy.
  Hierarchy Read() {
    words_.Expect("HIERARCHY");
    std::string_view word = words_.Need("ROOT");
    while (word == "ROOT") {
      Open();
      while (!open_.empty()) Inside();
      word = words_.Need("MOTION");
    }
    if (word != "MOTION") Words::Fail(word, "ROOT or MOTION");
    return std::move(hierarchy_);
  }

 private:
  void Open() {
    BvhNode node;
    node.name = std::string(words_.Need("the name of a joint"));
    node.parent = open_.empty() ? -1 : open_.back();
    words_.Expect("{");
    if (hierarchy_.nodes.size() >= kMostJoints) {
      throw InputError("has too many joints");
    }
    open_.push_back(static_cast<int>(hierarchy_.nodes.size()));
    hierarchy_.nodes.push_back(std::move(node));
  }

  void Inside() {
    BvhNode& node = hierarchy_.nodes[static_cast<size_t>(open_.back())];
    const std::string_view word = words_.Need("}");
    if (word == "}") {
      open_.pop_back();
    } else if (word == "OFFSET") {
      for (int axis = 0; axis < 3; ++axis) {
        node.offset[axis] = words_.Number("an offset");
      }
    } else if (word == "CHANNELS") {
      ReadChannels(&node);
    } else if (word == "JOINT") {
      Open();
    } else if (word == "End") {
      words_.Expect("Site");
      words_.Expect("{");
      words_.Expect("OFFSET");
      for (int axis = 0; axis < 3; ++axis) words_.Number("an offset");
      words_.Expect("}");
    } else {
      Words::Fail(word, "OFFSET, CHANNELS, JOINT, End Site or }");
    }
  }

  void ReadChannels(BvhNode* node) {
    constexpr double kMostChannels = 6.0;
    const double count = words_.Number("a number of channels");
    if (!(count >= 0.0 && count <= kMostChannels) || !node->channels.empty()) {
      throw InputError("CHANNELS: expected 0 .. 6, once a joint");
    }
    for (int c = 0; c < static_cast<int>(count); ++c) {
      const std::string_view word = words_.Need("a channel");
      const auto channel = ChannelOf(word);
      if (!channel) Words::Fail(word, "Xposition .. Zrotation");
      node->channels.push_back(*channel);
      ++hierarchy_.channel_count;
    }
  }

  Words& words_;
  Hierarchy hierarchy_;
  std::vector<int> open_;
};

// Places of all nodes in a frame. A channel of position takes the offset's
// place, as MotionBuilder and Blender have it; rotations apply in the order of
// their channels, the first outermost.
std::vector<Vector3d> PlacesOf(const Hierarchy& hierarchy,
                               const std::vector<double>& values) {
  constexpr double kRadians = 3.14159265358979323846 / 180.0;
  std::vector<Vector3d> places(hierarchy.nodes.size());
  std::vector<Matrix3d> turns(hierarchy.nodes.size());
  size_t next = 0;
  for (size_t n = 0; n < hierarchy.nodes.size(); ++n) {
    const BvhNode& node = hierarchy.nodes[n];
    Vector3d local = node.offset;
    Matrix3d turn = Matrix3d::Identity();
    for (const Channel& channel : node.channels) {
      const double value = values[next++];
      if (channel.is_position) {
        local[channel.axis] = value;
      } else {
        turn *=
            Eigen::AngleAxisd(value * kRadians, Vector3d::Unit(channel.axis))
                .toRotationMatrix();
      }
    }
    if (node.parent < 0) {
      places[n] = local;
      turns[n] = turn;
    } else {
      const auto parent = static_cast<size_t>(node.parent);
      places[n] = places[parent] + turns[parent] * local;
      turns[n] = turns[parent] * turn;
    }
  }
  return places;
}

// The names that CMU's and Mixamo's skeletons give to our joints: a segment is
// called there, which begins at the joint.
std::string BodyName(const std::string& label) {
  static const std::map<std::string, std::string> kNames = {
      {"Hips", "mid_hip"},          {"Neck", "neck"},
      {"Head", "head_base"},  // not its top, as other files have it
      {"LeftUpLeg", "l_hip"},       {"RightUpLeg", "r_hip"},
      {"LeftLeg", "l_knee"},        {"RightLeg", "r_knee"},
      {"LeftFoot", "l_ankle"},      {"RightFoot", "r_ankle"},
      {"LeftToeBase", "l_big_toe"}, {"RightToeBase", "r_big_toe"},
      {"LeftArm", "l_shoulder"},    {"RightArm", "r_shoulder"},
      {"LeftForeArm", "l_elbow"},   {"RightForeArm", "r_elbow"},
      {"LeftHand", "l_wrist"},      {"RightHand", "r_wrist"}};
  const size_t colon = label.find_last_of(':');  // "mixamorig:Hips"
  const auto found =
      kNames.find(colon == std::string::npos ? label : label.substr(colon + 1));
  return found == kNames.end() ? label : found->second;
}

// The nodes that are joints, with their names and bones.
struct Joints {
  std::vector<size_t> nodes;
  std::vector<std::string> names;
  std::vector<Bone> bones;
};

Joints BvhJoints(const Hierarchy& hierarchy) {
  Joints joints;
  std::vector<int> joint_of(hierarchy.nodes.size(), -1);
  std::map<std::string, int> counts;
  for (const BvhNode& node : hierarchy.nodes) ++counts[BodyName(node.name)];
  for (size_t n = 0; n < hierarchy.nodes.size(); ++n) {
    const BvhNode& node = hierarchy.nodes[n];
    const int above =
        node.parent < 0 ? -1 : joint_of[static_cast<size_t>(node.parent)];
    const bool moves =
        std::any_of(node.channels.begin(), node.channels.end(),
                    [](const Channel& channel) { return channel.is_position; });
    if (above >= 0 && node.offset.isZero() && !moves) {
      joint_of[n] = above;  // a pivot
      continue;
    }
    joint_of[n] = static_cast<int>(joints.nodes.size());
    if (above >= 0) joints.bones.push_back({above, joint_of[n]});
    joints.nodes.push_back(n);
    const std::string name = BodyName(node.name);
    joints.names.push_back(counts[name] == 1 ? name : node.name);
  }
  return joints;
}

struct Motion {
  int64_t frames = 0;
  double rate_hz = 0.0;
};

Motion ReadMotion(Words* words) {
  constexpr double kMostBvhFrames = 1e7;
  words->Expect("Frames:");
  const double frames = words->Number("a number of frames");
  words->Expect("Frame");
  words->Expect("Time:");
  const double step_s = words->Number("seconds");
  if (!(frames >= 0.0 && frames <= kMostBvhFrames)) {
    throw InputError("Frames: expected 0 .. 10000000");
  }
  if (!(step_s >= 1e-6 && step_s <= 1e6)) {
    throw InputError("Frame Time: expected 1e-6 .. 1e6 s");
  }
  return {static_cast<int64_t>(frames), 1.0 / step_s};
}

// The rate that a rounded time means: 0.033333 s are 30 Hz.
double NearWhole(double rate_hz) {
  constexpr double kNear = 5e-4;  // a thousandth away is the next NTSC rate
  const double whole = std::round(rate_hz);
  return std::abs(rate_hz - whole) < kNear * whole ? whole : rate_hz;
}

class BvhReader {
 public:
  explicit BvhReader(const TrackReadOptions& options) : options_(options) {}

  void Read(Words* words, TrackId id) {
    const Hierarchy hierarchy = HierarchyReader(words).Read();
    const Joints joints = BvhJoints(hierarchy);
    const Motion motion = ReadMotion(words);
    Prepare(joints, motion);
    const AxisMap axes = options_.axes.value_or(BvhAxes());
    std::vector<double> values(hierarchy.channel_count);
    for (int64_t f = 0; f < motion.frames; ++f) {
      for (double& value : values) value = words->Number("a channel's value");
      const std::vector<Vector3d> places = PlacesOf(hierarchy, values);
      Pose3d& pose = collector_->Add(f, id)->joints;
      for (size_t j = 0; j < joints.nodes.size(); ++j) {
        pose[j] = {axes.Invert(kBvhCentimetre_m * places[joints.nodes[j]]),
                   JointStatus::kObserved};
        if (!pose[j].position_m.allFinite()) {
          throw InputError("a joint is beyond all numbers");
        }
      }
    }
    const std::string_view rest = words->Next();
    if (!rest.empty()) Words::Fail(rest, "the end of the file");
  }

  TrackSequence Finish() { return collector_->Finish(); }

 private:
  void Prepare(const Joints& joints, const Motion& motion) {
    if (collector_.has_value()) {
      if (joints.names != names_) {
        throw InputError("has other joints than the first file");
      }
      return;
    }
    names_ = joints.names;
    TrackHeader header;
    header.mode = "bvh";
    header.frame_rate_hz = options_.frame_rate_hz > 0.0
                               ? options_.frame_rate_hz
                               : NearWhole(motion.rate_hz);
    header.skeleton = SkeletonOfNames(joints.names, options_, joints.bones);
    collector_.emplace(std::move(header));
  }

  const TrackReadOptions& options_;
  std::optional<TrackCollector> collector_;
  std::vector<std::string> names_;
};

}  // namespace

TrackSequence ReadTracksBvh(const std::string& path,
                            const TrackReadOptions& options) {
  BvhReader reader(options);
  for (const PersonFile& file : ListPersonFiles(path, kBvhExtension)) {
    const std::string text = ReadTextFile(file.path);
    Words words(text);
    Located(
        file.path, [&] { return words.Place(); },
        [&] { reader.Read(&words, file.id); });
  }
  return reader.Finish();
}

}  // namespace kinegraph
