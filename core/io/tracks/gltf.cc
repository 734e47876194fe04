// glTF 2.0 (Khronos' specification, sections 3 and 4): all people of the
// recording as animated skeletons with a simple body of bones, in metres, Y up
// unless other axes are requested. A path with the extension .glb gets the
// binary container, any other JSON with an embedded buffer.
//
// Each joint has a rotation, determined by the directions of its bones, and a
// position in its parent's frame, so that joint positions equal those of the
// tracks to float precision. An absent person has scale 0.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/binary/bytes.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"
#include "core/io/tracks/tree_motion.h"

namespace kinegraph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Constants of the specification.
enum ComponentType {
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};
enum BufferTarget { kNoTarget = 0, kVertices = 34962, kIndices = 34963 };

void PadTo4(char with, std::string* bytes) {
  while (bytes->size() % 4 != 0) *bytes += with;
}

// A JSON array that is stored as text while it grows: a tree of JSON values for
// thousands of people would take a hundred times the memory of its text.
class JsonList {
 public:
  // Returns the index of the item.
  size_t Add(const std::string& item) {
    text_ += (count_ == 0 ? "" : ",") + item;
    return count_++;
  }
  size_t size() const { return count_; }
  std::string Text() const { return "[" + text_ + "]"; }

 private:
  std::string text_;
  size_t count_ = 0;
};

// The one buffer, with the views and accessors into it.
class Buffer {
 public:
  // Adds vectors of `width` numbers each; returns the index of the accessor.
  template <typename Number>
  size_t Add(const std::vector<Number>& values, size_t width,
             BufferTarget target = kNoTarget, const std::string& bounds = "") {
    constexpr ComponentType kType = std::is_same_v<Number, float> ? kFloat
                                    : sizeof(Number) == 2 ? kUnsignedShort
                                                          : kUnsignedInt;
    PadTo4('\0', &bytes_);
    const size_t size = values.size() * sizeof(Number);
    const size_t view = views_.Add(fmt::format(
        R"({{"buffer":0,"byteOffset":{},"byteLength":{}{}}})", bytes_.size(),
        size,
        target == kNoTarget ? "" : fmt::format(R"(,"target":{})", +target)));
    if (size > 0) {
      bytes_.append(reinterpret_cast<const char*>(values.data()), size);
    }
    const char* type = width == 1   ? "SCALAR"
                       : width == 3 ? "VEC3"
                       : width == 4 ? "VEC4"
                                    : "MAT4";
    return accessors_.Add(fmt::format(
        R"({{"bufferView":{},"componentType":{},"count":{},"type":"{}"{}}})",
        view, +kType, values.size() / width, type, bounds));
  }
  // The same, with minimum and maximum values.
  size_t AddBounded(const std::vector<float>& values, size_t width,
                    BufferTarget target = kNoTarget) {
    std::vector<float> low(values.begin(),
                           values.begin() + static_cast<long>(width));
    std::vector<float> high = low;
    for (size_t i = width; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
    return Add(values, width, target,
               fmt::format(R"(,"min":[{}],"max":[{}])", fmt::join(low, ","),
                           fmt::join(high, ",")));
  }

  const std::string& bytes() const { return bytes_; }
  std::string views() const { return views_.Text(); }
  std::string accessors() const { return accessors_.Text(); }

 private:
  std::string bytes_;
  JsonList views_;
  JsonList accessors_;
};

template <typename Vector>
void AppendFloats(const Vector& numbers, std::vector<float>* values) {
  for (const double number : numbers) {
    values->push_back(static_cast<float>(number));
    if (!std::isfinite(values->back())) {
      throw InputError(
          "the position of a joint exceeds the range of 32-bit floats");
    }
  }
}

// The body: a spindle along each bone and a small octahedron at each joint, in
// the rest pose, with the joints that move each vertex.
class Body {
 public:
  Body(const JointTree& tree, const std::vector<Vector3d>& rest_m) {
    // Radius of the octahedra: a twentieth of the longest bone, but at most
    // kBall_m.
    double ball_m = 0.0;
    for (size_t j = 1; j < tree.size(); ++j) {
      const Vector3d bone_m = rest_m[j] - rest_m[tree[j].parent];
      ball_m = std::max(ball_m, 0.05 * bone_m.norm());
    }
    constexpr double kBall_m = 0.02;
    ball_m = ball_m > 0.0 ? std::min(ball_m, kBall_m) : kBall_m;
    for (size_t j = 0; j < tree.size(); ++j) {
      AddSpindle(rest_m[j] - ball_m * Vector3d::UnitY(), j,
                 rest_m[j] + ball_m * Vector3d::UnitY(), j, rest_m[j], ball_m);
      if (j == 0 || !tree[j].is_held) continue;
      const size_t parent = tree[j].parent;
      const Vector3d bone_m = rest_m[j] - rest_m[parent];
      if (bone_m.norm() < ball_m) continue;
      // Position of the largest width as a fraction of the bone.
      constexpr double kThickest = 0.15;
      AddSpindle(rest_m[parent], parent, rest_m[j], j,
                 rest_m[parent] + kThickest * bone_m,
                 std::min(0.1 * bone_m.norm(), 1.5 * ball_m));
    }
  }

  std::string Mesh(const std::string& name, size_t material,
                   Buffer* buffer) const {
    const size_t positions = buffer->AddBounded(positions_, 3, kVertices);
    const size_t joints = buffer->Add(joints_, 4, kVertices);
    const size_t weights = buffer->Add(weights_, 4, kVertices);
    return fmt::format(
        R"({{"name":{},"primitives":[{{"attributes":{{"POSITION":{},)"
        R"("JOINTS_0":{},"WEIGHTS_0":{}}},"indices":{},"material":{}}}]}})",
        JsonText(name), positions, joints, weights,
        buffer->Add(indices_, 1, kIndices), material);
  }

 private:
  void AddSpindle(const Vector3d& head, size_t head_joint, const Vector3d& tip,
                  size_t tip_joint, const Vector3d& middle, double radius_m) {
    const auto first = static_cast<uint32_t>(positions_.size() / 3);
    const Vector3d along = (tip - head).normalized();
    const Vector3d side = along.unitOrthogonal();
    const Vector3d across = along.cross(side);
    AddCorner(head, head_joint);
    for (const Vector3d& out :
         {side, across, Vector3d(-side), Vector3d(-across)}) {
      AddCorner(middle + radius_m * out, head_joint);
    }
    AddCorner(tip, tip_joint);
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t a = first + 1 + k;
      const uint32_t b = first + 1 + (k + 1) % 4;
      // Counter-clockwise seen from outside.
      for (const uint32_t corner : {first, b, a, first + 5, a, b}) {
        indices_.push_back(corner);
      }
    }
  }

  void AddCorner(const Vector3d& at, size_t joint) {
    AppendFloats(at, &positions_);
    joints_.insert(joints_.end(), {static_cast<uint16_t>(joint), 0, 0, 0});
    weights_.insert(weights_.end(), {1.0F, 0.0F, 0.0F, 0.0F});
  }

  std::vector<float> positions_;
  std::vector<uint16_t> joints_;
  std::vector<float> weights_;
  std::vector<uint32_t> indices_;
};

// A person to be animated. The nodes of the joints follow the person's `node`.
// `rows` are the rows of the recording with the person; rows[i] is row
// of_motion[i] of `motion`, which begins with the person's first row and
// includes gaps.
struct AnimatedPerson {
  std::string name;
  size_t node = 0;
  std::vector<size_t> rows;
  std::vector<size_t> of_motion;
  TreeMotion motion;
};

// Okabe and Ito's palette, distinguishable with colour blindness.
constexpr std::array<const char*, 7> kColours = {
    "0.9,0.6,0",  "0.34,0.71,0.91", "0,0.62,0.45",  "0.94,0.89,0.26",
    "0,0.45,0.7", "0.84,0.37,0",    "0.8,0.47,0.65"};

class Scene {
 public:
  Scene(const TrackSequence& tracks, const TrackExportOptions& options)
      : tracks_(tracks),
        axes_(options.axes.value_or(AnimationAxes())),
        rows_(MakeTrackRows(tracks, "glTF")),
        tree_(MakeJointTree(tracks.header.skeleton, JointsSeen(tracks),
                            /*pivots=*/false)) {
    rate_hz_ = RequireFrameRate(tracks, "glTF");
    const std::vector<int64_t> ids = RequirePeople(tracks);
    const std::vector<std::string> titles = PersonTitles(ids, options.names);
    for (size_t p = 0; p < ids.size(); ++p) {
      const AnimatedPerson person = Solve(TrackId(ids[p]), titles[p]);
      scene_nodes_.Add(std::to_string(person.node));
      nodes_.Add(
          fmt::format(R"({{"name":{},"children":[{}],"extras":{{"id":{}}}}})",
                      JsonText(person.name), person.node + 1, ids[p]));
      // Readers expect unique node names.
      AddJoints(person, ids.size() > 1 ? person.name + "_" : "");
      AddSkin(person, kColours[p % kColours.size()]);
      AddMotion(person);
    }
  }

  // The document up to the buffer's length: without its URI and the closing
  // brackets.
  std::string Document() const {
    const TrackFrame& first = tracks_.frames.front();
    return fmt::format(
        R"({{"asset":{{"version":"2.0","generator":"kinegraph"}},"scene":0,)"
        R"("scenes":[{{"name":"kinegraph","nodes":{},"extras":{{)"
        R"("frame_rate_hz":{},"first_frame":{},"start_s":{}}}}}],"nodes":{},)"
        R"("meshes":{},"materials":{},"skins":{},"animations":[{{)"
        R"("name":"take","channels":{},"samplers":{}}}],"accessors":{},)"
        R"("bufferViews":{},"buffers":[{{"byteLength":{})",
        scene_nodes_.Text(), rate_hz_, first.frame, ToSeconds(first.time),
        nodes_.Text(), meshes_.Text(), materials_.Text(), skins_.Text(),
        channels_.Text(), samplers_.Text(), buffer_.accessors(),
        buffer_.views(), buffer_.bytes().size());
  }
  const std::string& bytes() const { return buffer_.bytes(); }

  void NoteLostFields(LostFields* lost_fields) const {
    lost_fields->push_back(
        "the configuration is not kept; positions are 32-bit floats");
    losses_.Note(tree_, lost_fields);
    NoteLosses(ContentsOf(tracks_),
               {Loss::kInferredAlike, Loss::kCovariances, Loss::kViews},
               lost_fields);
    NoteAddedRows(tracks_, rows_.size(), "show no person", lost_fields);
  }

 private:
  // Seconds since the first frame, as absolute times may exceed float
  // precision.
  float SecondsOf(size_t row) const {
    return static_cast<float>(rows_[row].time_s - rows_.front().time_s);
  }

  AnimatedPerson Solve(TrackId id, const std::string& name) {
    AnimatedPerson person;
    person.name = name;
    person.node = nodes_.size();
    std::vector<const PersonPose*> poses;  // from the person's first row on
    for (size_t r = 0; r < rows_.size(); ++r) {
      const PersonPose* pose = FindPerson(rows_[r].frame, id);
      if (pose != nullptr) {
        person.rows.push_back(r);
        person.of_motion.push_back(poses.size());
      }
      if (!person.rows.empty()) poses.push_back(pose);
    }
    poses.resize(person.of_motion.back() + 1);
    person.motion = SolveTreeMotion(tree_, poses, axes_);
    losses_.See(tree_, person.motion, name);
    return person;
  }

  // Adds the joints in the pose of the person's first frame.
  void AddJoints(const AnimatedPerson& person, const std::string& prefix) {
    for (size_t j = 0; j < tree_.size(); ++j) {
      const Vector3d at = LocalPosition(person.motion, 0, j);
      // Rounding may move components of a unit quaternion beyond 1, which glTF
      // forbids.
      const Eigen::Vector4d rotation = person.motion.Local(tree_, 0, j)
                                           .coeffs()
                                           .cwiseMax(-1.0)
                                           .cwiseMin(1.0);
      std::vector<size_t> children = tree_[j].children;
      for (size_t& child : children) child += person.node + 1;
      nodes_.Add(fmt::format(
          R"({{"name":{},"translation":[{},{},{}],"rotation":[{},{},{},{}]{}}})",
          JsonText(prefix + tree_[j].name), at.x(), at.y(), at.z(),
          rotation.x(), rotation.y(), rotation.z(), rotation.w(),
          children.empty()
              ? ""
              : fmt::format(",\"children\":[{}]", fmt::join(children, ","))));
    }
  }

  void AddSkin(const AnimatedPerson& person, const std::string& colour) {
    std::vector<Vector3d> rest_m(tree_.size(), Vector3d::Zero());
    std::vector<float> inverses;
    std::vector<size_t> joints;
    for (size_t j = 0; j < tree_.size(); ++j) {
      rest_m[j] = rest_m[tree_[j].parent] + person.motion.offsets_m[j];
      Eigen::Matrix4d inverse = Eigen::Matrix4d::Identity();
      inverse.topRightCorner<3, 1>() = -rest_m[j];
      AppendFloats(inverse.reshaped(), &inverses);
      joints.push_back(person.node + 1 + j);
    }
    const std::string name = JsonText(person.name);
    const size_t index = skins_.Add(fmt::format(
        R"({{"name":{},"inverseBindMatrices":{},"skeleton":{},"joints":[{}]}})",
        name, buffer_.Add(inverses, 16), joints.front(),
        fmt::join(joints, ",")));
    materials_.Add(fmt::format(
        R"({{"name":{},"pbrMetallicRoughness":{{"baseColorFactor":[{},1],)"
        R"("metallicFactor":0,"roughnessFactor":0.8}}}})",
        name, colour));
    meshes_.Add(Body(tree_, rest_m).Mesh(person.name, index, &buffer_));
    scene_nodes_.Add(std::to_string(nodes_.size()));
    nodes_.Add(fmt::format(R"({{"name":{},"mesh":{},"skin":{}}})",
                           JsonText(person.name + "_body"), index, index));
  }

  Vector3d LocalPosition(const TreeMotion& motion, size_t row,
                         size_t joint) const {
    const TreeMotion::Row& pose = motion.rows[row];
    if (joint == 0) return pose.positions_m[joint];
    const size_t parent = tree_[joint].parent;
    return pose.global[parent].conjugate() *
           (pose.positions_m[joint] - pose.positions_m[parent]);
  }

  void AddMotion(const AnimatedPerson& person) {
    std::vector<float> times_s;
    for (const size_t row : person.rows) times_s.push_back(SecondsOf(row));
    const size_t input = buffer_.AddBounded(times_s, 1);
    for (size_t j = 0; j < tree_.size(); ++j) {
      std::vector<float> translations;
      std::vector<float> rotations;
      Quaterniond last = Quaterniond::Identity();
      for (const size_t row : person.of_motion) {
        AppendFloats(LocalPosition(person.motion, row, j), &translations);
        Quaterniond rotation = person.motion.Local(tree_, row, j);
        // Of the quaternion's two signs, the one nearer to the previous row,
        // for interpolation.
        if (rotation.dot(last) < 0.0) rotation.coeffs() *= -1.0;
        last = rotation;
        AppendFloats(rotation.coeffs(), &rotations);  // x, y, z, w
      }
      const size_t node = person.node + 1 + j;
      AddChannel(node, "translation", "LINEAR", input,
                 buffer_.Add(translations, 3));
      AddChannel(node, "rotation", "LINEAR", input, buffer_.Add(rotations, 4));
    }
    if (person.rows.size() < rows_.size()) AddVisibility(person);
  }

  // Scale 1 while the person is present, else 0.
  void AddVisibility(const AnimatedPerson& person) {
    std::vector<float> times_s;
    std::vector<float> scales;
    size_t next = 0;
    for (size_t r = 0; r < rows_.size(); ++r) {
      const bool is_there = next < person.rows.size() && person.rows[next] == r;
      next += is_there ? 1 : 0;
      const float scale = is_there ? 1.0F : 0.0F;
      if (!scales.empty() && scales.back() == scale) continue;
      times_s.push_back(SecondsOf(r));
      scales.insert(scales.end(), 3, scale);
    }
    const size_t input = buffer_.AddBounded(times_s, 1);
    AddChannel(person.node, "scale", "STEP", input, buffer_.Add(scales, 3));
  }

  void AddChannel(size_t node, const char* path, const char* interpolation,
                  size_t input, size_t output) {
    const size_t sampler = samplers_.Add(
        fmt::format(R"({{"input":{},"interpolation":"{}","output":{}}})", input,
                    interpolation, output));
    channels_.Add(
        fmt::format(R"({{"sampler":{},"target":{{"node":{},"path":"{}"}}}})",
                    sampler, node, path));
  }

  const TrackSequence& tracks_;
  const AxisMap axes_;
  const std::vector<TrackRow> rows_;
  const JointTree tree_;
  double rate_hz_ = 0.0;
  TreeLosses losses_;
  Buffer buffer_;
  JsonList nodes_;
  JsonList scene_nodes_;
  JsonList meshes_;
  JsonList materials_;
  JsonList skins_;
  JsonList channels_;
  JsonList samplers_;
};

// Writes header, a JSON chunk and a binary chunk (section 4.4 of the
// specification).
void WriteBinary(const Scene& scene, AtomicFile* file) {
  std::string text = scene.Document() + "}]}";
  PadTo4(' ', &text);
  const std::string padding((4 - scene.bytes().size() % 4) % 4, '\0');
  const size_t buffer_size = scene.bytes().size() + padding.size();
  constexpr size_t kHeaders = 12 + 2 * 8;
  const size_t size = kHeaders + text.size() + buffer_size;
  if (size > std::numeric_limits<uint32_t>::max()) {
    throw InputError("the recording is larger than the 4 GB of a .glb file");
  }
  std::string header = "glTF";
  AppendNumbers(&header, uint32_t{2}, static_cast<uint32_t>(size),
                static_cast<uint32_t>(text.size()));
  file->Write(header + "JSON");
  file->Write(text);
  std::string chunk;
  AppendNumbers(&chunk, static_cast<uint32_t>(buffer_size));
  file->Write(chunk + std::string("BIN\0", 4));
  file->Write(scene.bytes());
  file->Write(padding);
}

void WriteText(const Scene& scene, AtomicFile* file) {
  file->Write(scene.Document());
  file->Write(",\"uri\":\"data:application/octet-stream;base64,");
  constexpr size_t kPiece = 3 << 18;  // three bytes make four base64 digits
  const std::string_view bytes = scene.bytes();
  for (size_t at = 0; at < bytes.size(); at += kPiece) {
    file->Write(Base64(bytes.substr(at, kPiece)));
  }
  file->Write("\"}]}\n");
}

}  // namespace

void WriteGltfTracks(const std::string& path, const TrackSequence& tracks,
                     const TrackExportOptions& options,
                     LostFields* lost_fields) {
  const Scene scene(tracks, options);
  AtomicFile file(path);
  EndsInAnyCase(path, ".glb") ? WriteBinary(scene, &file)
                              : WriteText(scene, &file);
  file.Commit();
  scene.NoteLostFields(lost_fields);
}

}  // namespace kinegraph
