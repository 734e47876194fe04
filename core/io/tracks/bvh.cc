// Biovision's BVH: a hierarchy with rest offsets, then one row per frame with a
// value for each channel, in centimetres and degrees. A file is one person.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/words.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"
#include "core/io/tracks/tree_motion.h"

namespace kinegraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kBvhExtension = ".bvh";

// ---- Reading: files of any program ----
//
// Channels may be in any order, and there may be several roots. Joint positions
// follow from offsets and channels. A joint with offset 0 and without position
// channels coincides with its parent: it is a pivot and is omitted. Frames
// count from 0.

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

size_t ReadChannels(Words* words, BvhNode* node) {
  constexpr double kMostChannels = 6.0;
  const double count = words->Number("a number of channels");
  if (!(count >= 0.0 && count <= kMostChannels) || !node->channels.empty()) {
    throw InputError("CHANNELS: expected 0 .. 6, once per joint");
  }
  for (int c = 0; c < static_cast<int>(count); ++c) {
    const std::string_view word = words->Need("a channel");
    const std::string_view kind = word.substr(1);
    if (word[0] < 'X' || word[0] > 'Z' ||
        (kind != "position" && kind != "rotation")) {
      Words::Fail(word, "Xposition .. Zrotation");
    }
    node->channels.push_back({kind == "position", word[0] - 'X'});
  }
  return node->channels.size();
}

// Reads up to and including the word MOTION.
Hierarchy ReadHierarchy(Words* words) {
  constexpr size_t kMostJoints = 10000;
  Hierarchy hierarchy;
  std::vector<int> open;  // from the root to the current joint
  const auto read_offset = [words] {
    Vector3d offset;
    for (double& number : offset) number = words->Number("an offset");
    return offset;
  };
  words->Expect("HIERARCHY");
  for (std::string_view word = words->Need("ROOT");
       !open.empty() || word != "MOTION";
       word = words->Need(open.empty() ? "MOTION" : "}")) {
    if (word == (open.empty() ? "ROOT" : "JOINT")) {
      BvhNode node;
      node.name = std::string(words->Need("the name of a joint"));
      node.parent = open.empty() ? -1 : open.back();
      words->Expect("{");
      if (hierarchy.nodes.size() >= kMostJoints) {
        throw InputError("has too many joints");
      }
      open.push_back(static_cast<int>(hierarchy.nodes.size()));
      hierarchy.nodes.push_back(std::move(node));
      continue;
    }
    if (open.empty()) Words::Fail(word, "ROOT or MOTION");
    BvhNode& node = hierarchy.nodes[static_cast<size_t>(open.back())];
    if (word == "}") {
      open.pop_back();
    } else if (word == "OFFSET") {
      node.offset = read_offset();
    } else if (word == "CHANNELS") {
      hierarchy.channel_count += ReadChannels(words, &node);
    } else if (word == "End") {
      for (const char* next : {"Site", "{", "OFFSET"}) words->Expect(next);
      read_offset();
      words->Expect("}");
    } else {
      Words::Fail(word, "OFFSET, CHANNELS, JOINT, End Site or }");
    }
  }
  return hierarchy;
}

// Positions of all nodes in a frame, in the file's unit and axes. Position
// channels replace the offset, as in MotionBuilder and Blender; rotations are
// multiplied in the order of their channels, the first outermost.
std::vector<Vector3d> PositionsOf(const Hierarchy& hierarchy,
                                  const std::vector<double>& values) {
  constexpr double kRadians = kPi / 180.0;
  std::vector<Vector3d> positions(hierarchy.nodes.size());
  std::vector<Matrix3d> rotations(hierarchy.nodes.size());
  size_t next = 0;
  for (size_t n = 0; n < hierarchy.nodes.size(); ++n) {
    const BvhNode& node = hierarchy.nodes[n];
    Vector3d local = node.offset;
    Matrix3d rotation = Matrix3d::Identity();
    for (const Channel& channel : node.channels) {
      const double value = values[next++];
      if (channel.is_position) {
        local[channel.axis] = value;
      } else {
        rotation *=
            Eigen::AngleAxisd(value * kRadians, Vector3d::Unit(channel.axis))
                .toRotationMatrix();
      }
    }
    if (node.parent < 0) {
      positions[n] = local;
      rotations[n] = rotation;
    } else {
      const auto parent = static_cast<size_t>(node.parent);
      positions[n] = positions[parent] + rotations[parent] * local;
      rotations[n] = rotations[parent] * rotation;
    }
  }
  return positions;
}

// kinegraph's names for joints of CMU's and Mixamo's skeletons, in which a
// joint has the name of the segment that begins there.
std::string BodyName(const std::string& label) {
  static const std::map<std::string, std::string> kNames = {
      {"Hips", "mid_hip"},          {"Neck", "neck"},
      {"Head", "head_base"},  // in other formats: the top of the head
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

// The nodes that are joints, with names and bones.
struct BvhJoints {
  std::vector<size_t> nodes;
  std::vector<std::string> names;
  std::vector<Bone> bones;
};

BvhJoints JointsOf(const Hierarchy& hierarchy) {
  BvhJoints joints;
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

// The frame rate [Hz] of a period in a file: the nearest whole rate if its
// period, rounded to the digits of the text, is the text's: 0.0333 s is 30 Hz.
double RateOf(double step_s, std::string_view text) {
  const double whole = std::round(1.0 / step_s);
  const size_t point = text.find('.');
  if (point == std::string_view::npos ||
      text.find_first_of("eE") != std::string_view::npos) {
    return 1.0 / step_s;
  }
  const auto digits = static_cast<double>(text.size() - point - 1);
  const double rounding_s = 0.5 * std::pow(10.0, -digits);
  // With fewer digits, the periods of several whole rates may round to the same
  // text.
  const bool is_precise = rounding_s < 0.01 * step_s;
  return is_precise && std::abs(1.0 / whole - step_s) <= rounding_s
             ? whole
             : 1.0 / step_s;
}

Motion ReadMotion(Words* words) {
  words->Expect("Frames:");
  const double frames = words->Number("a number of frames");
  words->Expect("Frame");
  words->Expect("Time:");
  const std::string_view text = Words(*words).Next();
  const double step_s = words->Number("seconds");
  if (!(frames >= 0.0 && frames <= kMaxRows)) {
    throw InputError("Frames: expected 0 .. 10000000");
  }
  if (!(step_s >= 1e-6 && step_s <= 1e6)) {
    throw InputError("Frame Time: expected 1e-6 .. 1e6 s");
  }
  return {static_cast<int64_t>(frames), RateOf(step_s, text)};
}

// The nearest whole rate [Hz] if it differs by less than 0.05 %: for periods
// that RateOf does not recognise as rounded, such as 0.033334 or 3.3333e-2 s.
double NearWhole(double rate_hz) {
  // Relative; NTSC rates such as 29.97 Hz differ by twice as much.
  constexpr double kNear = 5e-4;
  const double whole = std::round(rate_hz);
  return std::abs(rate_hz - whole) < kNear * whole ? whole : rate_hz;
}

void ReadBvhFrames(const Hierarchy& hierarchy,
                   const std::vector<size_t>& joints, int64_t frame_count,
                   const AxisMap& axes, TrackId id, Words* words,
                   TrackCollector* collector) {
  std::vector<double> values(hierarchy.channel_count);
  for (int64_t f = 0; f < frame_count; ++f) {
    for (double& value : values) value = words->Number("a channel's value");
    const std::vector<Vector3d> positions = PositionsOf(hierarchy, values);
    Pose3d& pose = collector->Add(f, id)->joints;
    for (size_t j = 0; j < joints.size(); ++j) {
      pose[j] = {axes.Invert(kMetresPerCentimetre * positions[joints[j]]),
                 JointStatus::kObserved};
      if (!pose[j].position_m.allFinite()) {
        throw InputError("the position of a joint is not a finite number");
      }
    }
  }
  const std::string_view rest = words->Next();
  if (!rest.empty()) Words::Fail(rest, "the end of the file");
}

// ---- Writing ----
//
// The root has a position and three angles, other joints have only angles, in
// the order Zrotation Xrotation Yrotation: a joint's rotation is Rz Rx Ry. Y is
// up.

// Angles about z, x and y [rad]. Of the two triples for a rotation, the one
// nearer to the previous row's angles, so that curves have no jumps.
Vector3d AnglesOf(const Eigen::Quaterniond& rotation, const Vector3d& last) {
  const Matrix3d r = rotation.toRotationMatrix();
  constexpr double kGimbalLock = 1.0 - 1e-12;
  const double x = std::asin(std::clamp(r(2, 1), -1.0, 1.0));
  double y = 0.0;
  double z = 0.0;
  if (std::abs(r(2, 1)) < kGimbalLock) {
    y = std::atan2(-r(2, 0), r(2, 2));
    z = std::atan2(-r(0, 1), r(1, 1));
  } else {  // only z + y or z - y is determined
    z = std::atan2(r(1, 0), r(0, 0));
  }
  // Equivalent angles nearest to the previous ones.
  const auto unwound = [&last](Vector3d angles) {
    for (int k = 0; k < 3; ++k) {
      angles[k] += 2.0 * kPi * std::round((last[k] - angles[k]) / (2.0 * kPi));
    }
    return angles;
  };
  const Vector3d a = unwound({z, x, y});
  const Vector3d b = unwound({z + kPi, kPi - x, y + kPi});
  const auto distance = [&last](const Vector3d& angles) {
    return std::abs(angles[0] - last[0]) + std::abs(angles[1] - last[1]) +
           std::abs(angles[2] - last[2]);
  };
  return distance(a) <= distance(b) ? a : b;
}

std::string Offset(const Vector3d& offset_m, const std::string& indent) {
  const Vector3d cm = kCentimetresPerMetre * offset_m;
  return fmt::format("{}OFFSET {:.6f} {:.6f} {:.6f}\n", indent, cm.x(), cm.y(),
                     cm.z());
}

// Adds the joint and its descendants to the text, and to the order of the
// angles in a row.
void AddBvhJoint(const JointTree& tree, const TreeMotion& motion, size_t joint,
                 const std::string& indent, std::string* text,
                 std::vector<size_t>* order) {
  const std::string inside = indent + "\t";
  const bool is_root = joint == 0;
  std::string name = tree[joint].name;
  for (char& c : name) {
    if (static_cast<unsigned char>(c) <= ' ') c = '_';
  }
  *text += fmt::format(
      "{0}{1} {2}\n{0}{{\n{3}{4}CHANNELS {5}Zrotation Xrotation Yrotation\n",
      indent, is_root ? "ROOT" : "JOINT", name,
      Offset(motion.offsets_m[joint], inside), inside,
      is_root ? "6 Xposition Yposition Zposition " : "3 ");
  order->push_back(joint);
  for (const size_t child : tree[joint].children) {
    AddBvhJoint(tree, motion, child, inside, text, order);
  }
  if (tree[joint].children.empty()) {
    // The end site extends the bone. A joint without a bone also gets one, to
    // be visible.
    constexpr double kShare = 0.3;
    const Vector3d end_m = motion.offsets_m[joint].isZero()
                               ? Vector3d(0.05 * Vector3d::UnitY())
                               : Vector3d(kShare * motion.offsets_m[joint]);
    *text += fmt::format("{0}End Site\n{0}{{\n{1}{0}}}\n", inside,
                         Offset(end_m, inside + "\t"));
  }
  *text += indent + "}\n";
}

class BvhWriter {
 public:
  BvhWriter(const TrackSequence& tracks, const std::vector<TrackRow>& rows,
            const TrackExportOptions& options)
      : tracks_(tracks),
        rows_(rows),
        axes_(options.axes.value_or(AnimationAxes())),
        tree_(MakeJointTree(tracks.header.skeleton, JointsSeen(tracks),
                            /*pivots=*/true)) {
    RequireBones();
    for (size_t r = 0; r < rows.size(); ++r) {
      if (rows[r].frame == nullptr) continue;
      for (const PersonPose& person : rows[r].frame->people) {
        const auto [at, is_new] = spans_.try_emplace(person.id.value());
        if (is_new) at->second.first = r;
        at->second.count = r + 1 - at->second.first;
      }
    }
    size_t there = 0;
    for (const auto& [id, span] : spans_) there += span.count;
    // Every file has all rows of the recording, unless the rows of all files
    // together then exceed both limits: with many people who are present only
    // briefly, files would consist mostly of repeated poses.
    constexpr size_t kMostRows = 200'000;
    constexpr size_t kMostTimes = 5;  // times the sum of the people's own spans
    const size_t all = rows.size() * spans_.size();
    on_one_clock_ = all <= std::max(kMostRows, kMostTimes * there);
  }

  void WritePerson(const std::string& path, TrackId id) {
    const Span span = spans_.at(id.value());
    std::vector<const PersonPose*> poses;
    for (size_t r = span.first; r < span.first + span.count; ++r) {
      poses.push_back(FindPerson(rows_[r].frame, id));
    }
    const TreeMotion motion = SolveTreeMotion(tree_, poses, axes_);
    losses_.See(tree_, motion, PersonLabel(id.value()));
    // Before the person's first row the first pose is repeated, and after the
    // last row the last pose.
    const size_t before = on_one_clock_ ? span.first : 0;
    const size_t after =
        on_one_clock_ ? rows_.size() - span.first - span.count : 0;
    AtomicFile file(path);
    std::string text = "HIERARCHY\n";
    std::vector<size_t> order;
    AddBvhJoint(tree_, motion, 0, "", &text, &order);
    file.Write(text + fmt::format("MOTION\nFrames: {}\nFrame Time: {}\n",
                                  before + span.count + after,
                                  1.0 / tracks_.header.frame_rate_hz));
    std::vector<Vector3d> last(tree_.size(), Vector3d::Zero());
    for (size_t r = 0; r < span.count; ++r) {
      const std::string line = Line(motion, order, r, &last);
      const size_t times =
          1 + (r == 0 ? before : 0) + (r + 1 == span.count ? after : 0);
      for (size_t i = 0; i < times; ++i) file.Write(line);
    }
    file.Commit();
  }

  void NoteLostFields(LostFields* lost_fields) const {
    lost_fields->push_back(
        "frame numbers, individual times and configuration are not kept");
    if (!on_one_clock_) {
      lost_fields->push_back(fmt::format(
          "with {} people and {} frames, files would mostly consist of "
          "repeated poses: each file begins and ends with its person "
          "(--person=N writes all frames for one person)",
          spans_.size(), rows_.size()));
    }
    const double rms_m =
        misfits_ > 0 ? std::sqrt(misfit_m2_ / static_cast<double>(misfits_))
                     : 0.0;
    lost_fields->push_back(
        fmt::format("bones have their median lengths: joints lie {:.1f} mm "
                    "(RMS) and at most {:.1f} mm from the tracks",
                    kMillimetresPerMetre * rms_m,
                    kMillimetresPerMetre * largest_misfit_m_));
    losses_.Note(tree_, lost_fields);
    NoteLosses(ContentsOf(tracks_),
               {Loss::kInferredAlike, Loss::kCovariances, Loss::kViews},
               lost_fields);
  }

 private:
  // A person's rows, from the first to the last with the person present.
  struct Span {
    size_t first = 0;
    size_t count = 0;
  };

  // Rotations require bones; several points without bones cannot be
  // represented.
  void RequireBones() const {
    const bool has_bones =
        std::any_of(tree_.begin() + 1, tree_.end(), [](const TreeJoint& joint) {
          return joint.is_held && !joint.is_pivot;
        });
    if (has_bones || tree_.size() == 1) return;
    Refuse(
        "BVH consists of bones, but the skeleton '{}' has none; C3D, TRC and "
        "glTF can store points",
        Printable(tracks_.header.skeleton.name()));
  }

  std::string Line(const TreeMotion& motion, const std::vector<size_t>& order,
                   size_t row, std::vector<Vector3d>* last) {
    const std::vector<Vector3d> rigid_m = motion.Rigid(tree_, row);
    for (size_t j = 0; j < tree_.size(); ++j) {
      if (!motion.rows[row].is_seen[j] || tree_[j].is_pivot) continue;
      const double m = (rigid_m[j] - motion.rows[row].positions_m[j]).norm();
      misfit_m2_ += m * m;
      largest_misfit_m_ = std::max(largest_misfit_m_, m);
      ++misfits_;
    }
    const Vector3d cm = kCentimetresPerMetre * rigid_m[0];
    std::string text =
        fmt::format("{:.6f} {:.6f} {:.6f}", cm.x(), cm.y(), cm.z());
    for (const size_t j : order) {
      Vector3d& angles = (*last)[j];
      angles = AnglesOf(motion.Local(tree_, row, j), angles);
      text += fmt::format(" {:.6f} {:.6f} {:.6f}", kDegPerRad * angles[0],
                          kDegPerRad * angles[1], kDegPerRad * angles[2]);
    }
    return text + "\n";
  }

  const TrackSequence& tracks_;
  const std::vector<TrackRow>& rows_;
  const AxisMap axes_;
  const JointTree tree_;
  std::map<int64_t, Span> spans_;  // by identity
  bool on_one_clock_ = true;       // every file has all rows of the recording
  // Distances of joints of the rigid skeleton from the joints seen in the
  // tracks.
  double misfit_m2_ = 0.0;
  double largest_misfit_m_ = 0.0;
  int64_t misfits_ = 0;
  TreeLosses losses_;
};

}  // namespace

bool RecogniseBvhTracks(const TrackHead& head) {
  return head.BeginsWith("HIERARCHY") || head.HasFile(kBvhExtension);
}

TrackSequence ReadBvhTracks(const std::string& path,
                            const TrackReadOptions& options) {
  std::optional<TrackCollector> collector;
  std::vector<std::string> names;  // joints of the first file
  for (const PersonFile& file : ListPersonFiles(path, kBvhExtension)) {
    ReadText<Words>(file.path, [&](Words* words) {
      const Hierarchy hierarchy = ReadHierarchy(words);
      const BvhJoints joints = JointsOf(hierarchy);
      const Motion motion = ReadMotion(words);
      if (!collector.has_value()) {
        names = joints.names;
        collector.emplace("bvh", SkeletonOfNames(names, options, joints.bones),
                          options, NearWhole(motion.rate_hz));
      } else if (joints.names != names) {
        throw InputError("has other joints than the first file");
      }
      ReadBvhFrames(hierarchy, joints.nodes, motion.frames,
                    options.axes.value_or(AnimationAxes()), file.id, words,
                    &*collector);
    });
  }
  return collector->Finish();
}

void WriteBvhTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& options,
                    LostFields* lost_fields) {
  RequireFrameRate(tracks, "BVH");
  RequirePeople(tracks);
  const std::vector<TrackRow> rows = MakeTrackRows(tracks, "BVH");
  BvhWriter writer(tracks, rows, options);
  WritePersonFiles(path, kBvhExtension, tracks, options.names,
                   [&writer](const std::string& file, TrackId id) {
                     writer.WritePerson(file, id);
                   });
  writer.NoteLostFields(lost_fields);
}

}  // namespace kinegraph
