// glTF 2.0 (Khronos' specification, sections 3 and 4): everybody of the take as
// an animated skeleton with a simple body of bones, in metres, Y up. A path
// that ends in .glb gets the binary container, any other JSON with the buffer
// inside.
//
// Each joint has its rotation, by the directions of its bones, and its place in
// its parent's frame, so that joints stand where the tracks have them, to the
// last bit of a float. A person who is not there has scale 0.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/joint_tree.h"
#include "core/io/tracks/losses.h"
#include "core/io/tracks/person_files.h"
#include "core/io/tracks/rows.h"
#include "core/io/tracks/tree_motion.h"

namespace kinegraph {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// As for BVH: Blender then shows our world.
AxisMap GltfAxes() { return AxisMap::Parse("x,z,-y"); }

// Numbers of the specification.
enum ComponentType {
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};
enum BufferTarget { kNoTarget = 0, kVertices = 34962, kIndices = 34963 };

void PadTo4(char with, std::string* bytes) {
  while (bytes->size() % 4 != 0) *bytes += with;
}

void AddWord(uint32_t value, std::string* bytes) {
  char word[4];
  std::memcpy(word, &value, sizeof(word));  // little-endian, as this machine
  bytes->append(word, sizeof(word));
}

std::string Base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) {
      const auto byte =
          i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0;
      group = group << 8 | byte;
    }
    for (size_t k = 0; k < 4; ++k) {
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

// The one buffer, with the views and accessors into it.
class Buffer {
 public:
  // Arrays of `width` numbers each; the index of the accessor.
  int Floats(const std::vector<float>& values, size_t width,
             bool with_bounds = false, BufferTarget target = kNoTarget) {
    Json accessor = Add(values.data(), values.size(), width, kFloat, target);
    if (with_bounds) {
      for (const char* bound : {"min", "max"}) {
        Json numbers = Json::array();
        for (size_t k = 0; k < width; ++k) {
          float found = values[k];
          for (size_t i = k; i < values.size(); i += width) {
            found = bound[1] == 'i' ? std::min(found, values[i])
                                    : std::max(found, values[i]);
          }
          numbers.push_back(found);
        }
        accessor[bound] = numbers;
      }
    }
    return Push(accessor);
  }
  int Shorts(const std::vector<uint16_t>& values, size_t width) {
    return Push(
        Add(values.data(), values.size(), width, kUnsignedShort, kVertices));
  }
  int Indices(const std::vector<uint32_t>& values) {
    return Push(Add(values.data(), values.size(), 1, kUnsignedInt, kIndices));
  }

  const std::string& bytes() const { return bytes_; }
  Json views() const { return views_; }
  Json accessors() const { return accessors_; }

 private:
  template <typename Number>
  Json Add(const Number* values, size_t count, size_t width,
           ComponentType component, BufferTarget target) {
    PadTo4('\0', &bytes_);
    Json view = {{"buffer", 0},
                 {"byteOffset", bytes_.size()},
                 {"byteLength", count * sizeof(Number)}};
    if (target != kNoTarget) view["target"] = static_cast<int>(target);
    if (count > 0) {
      bytes_.append(reinterpret_cast<const char*>(values),
                    count * sizeof(Number));
    }
    const char* type = width == 1   ? "SCALAR"
                       : width == 3 ? "VEC3"
                       : width == 4 ? "VEC4"
                                    : "MAT4";
    Json accessor = {{"bufferView", views_.size()},
                     {"componentType", static_cast<int>(component)},
                     {"count", count / width},
                     {"type", type}};
    views_.push_back(view);
    return accessor;
  }
  int Push(const Json& accessor) {
    accessors_.push_back(accessor);
    return static_cast<int>(accessors_.size()) - 1;
  }

  std::string bytes_;
  Json views_ = Json::array();
  Json accessors_ = Json::array();
};

void Append(const Vector3d& v, std::vector<float>* values) {
  for (int k = 0; k < 3; ++k) values->push_back(static_cast<float>(v[k]));
}

void Append(const Quaterniond& q, std::vector<float>* values) {
  for (int k = 0; k < 4; ++k) {
    values->push_back(static_cast<float>(q.coeffs()[k]));  // x, y, z, w
  }
}

// The body: a spindle along each bone and a small octahedron at each joint,
// in the rest pose, with the joints that move each corner.
class Body {
 public:
  Body(const JointTree& tree, const std::vector<Vector3d>& rest_m) {
    constexpr double kBall_m = 0.02;
    for (size_t j = 0; j < tree.size(); ++j) {
      AddSpindle(rest_m[j] - kBall_m * Vector3d::UnitY(), j,
                 rest_m[j] + kBall_m * Vector3d::UnitY(), j, rest_m[j],
                 kBall_m);
      if (tree[j].parent < 0) continue;
      const auto parent = static_cast<size_t>(tree[j].parent);
      const Vector3d bone_m = rest_m[j] - rest_m[parent];
      if (bone_m.norm() < kBall_m) continue;
      constexpr double kThickest = 0.15;  // share of the way along the bone
      AddSpindle(rest_m[parent], parent, rest_m[j], j,
                 rest_m[parent] + kThickest * bone_m,
                 std::min(0.1 * bone_m.norm(), 1.5 * kBall_m));
    }
  }

  Json Mesh(const std::string& name, int material, Buffer* buffer) const {
    const Json attributes = {
        {"POSITION",
         buffer->Floats(positions_, 3, /*with_bounds=*/true, kVertices)},
        {"JOINTS_0", buffer->Shorts(joints_, 4)},
        {"WEIGHTS_0",
         buffer->Floats(weights_, 4, /*with_bounds=*/false, kVertices)}};
    const Json primitive = {{"attributes", attributes},
                            {"indices", buffer->Indices(indices_)},
                            {"material", material}};
    return {{"name", name}, {"primitives", Json::array({primitive})}};
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
    Append(at, &positions_);
    for (const uint16_t j : {static_cast<uint16_t>(joint), uint16_t{0},
                             uint16_t{0}, uint16_t{0}}) {
      joints_.push_back(j);
    }
    for (const float weight : {1.0F, 0.0F, 0.0F, 0.0F}) {
      weights_.push_back(weight);
    }
  }

  std::vector<float> positions_;
  std::vector<uint16_t> joints_;
  std::vector<float> weights_;
  std::vector<uint32_t> indices_;
};

// The motion of a person in the rows in which the person is there.
struct Presence {
  std::vector<size_t> rows;  // of the take
  std::vector<TreeMotion::Row> poses;
  std::vector<Vector3d> offsets_m;
  size_t filled = 0;
};

class Scene {
 public:
  Scene(const TrackSequence& tracks, const TrackExportOptions& options)
      : tracks_(tracks),
        axes_(options.axes.value_or(GltfAxes())),
        rows_(MakeTrackRows(tracks, "glTF")),
        tree_(MakeJointTree(tracks.header.skeleton, /*pivots=*/false)) {
    rate_hz_ = RequireFrameRate(tracks, "glTF");
    const std::vector<int64_t> ids = IdsOf(tracks);
    if (ids.empty()) {
      throw InputError("the tracks have nobody in them, nothing to write");
    }
    const std::vector<std::string> titles = PersonTitles(ids, options.names);
    for (size_t p = 0; p < ids.size(); ++p) {
      // Names of nodes are taken once, which readers count on.
      const std::string prefix = ids.size() > 1 ? titles[p] + "_" : "";
      AddPerson(p, TrackId(ids[p]), titles[p], prefix);
    }
  }

  Json Document() const {
    const TrackFrame& first = tracks_.frames.front();
    const Json scene = {{"name", "kinegraph"},
                        {"nodes", scene_nodes_},
                        {"extras",
                         {{"frame_rate_hz", rate_hz_},
                          {"first_frame", first.frame},
                          {"start_s", ToSeconds(first.time)}}}};
    return {{"asset", {{"version", "2.0"}, {"generator", "kinegraph"}}},
            {"scene", 0},
            {"scenes", Json::array({scene})},
            {"nodes", nodes_},
            {"meshes", meshes_},
            {"materials", materials_},
            {"skins", skins_},
            {"animations", Json::array({{{"name", "take"},
                                         {"channels", channels_},
                                         {"samplers", samplers_}}})},
            {"accessors", buffer_.accessors()},
            {"bufferViews", buffer_.views()}};
  }
  const std::string& bytes() const { return buffer_.bytes(); }
  size_t filled() const { return filled_; }
  size_t row_count() const { return rows_.size(); }

 private:
  // Seconds since the first frame: those of a long day would not fit a float.
  float SecondsOf(size_t row) const {
    return static_cast<float>(rows_[row].time_s - rows_.front().time_s);
  }

  Presence Solve(TrackId id) const {
    Presence presence;
    std::vector<const PersonPose*> poses;
    size_t first = 0;
    for (size_t r = 0; r < rows_.size(); ++r) {
      const PersonPose* pose = FindPerson(rows_[r].frame, id);
      if (pose != nullptr) presence.rows.push_back(r);
      if (poses.empty() && pose == nullptr) continue;
      if (poses.empty()) first = r;
      poses.push_back(pose);
    }
    poses.resize(presence.rows.back() - first + 1);
    TreeMotion motion = SolveTreeMotion(tree_, poses, axes_);
    for (const size_t row : presence.rows) {
      presence.poses.push_back(std::move(motion.rows[row - first]));
    }
    presence.offsets_m = std::move(motion.offsets_m);
    presence.filled = motion.filled;
    return presence;
  }

  void AddPerson(size_t person_idx, TrackId id, const std::string& name,
                 const std::string& prefix) {
    const Presence presence = Solve(id);
    filled_ += presence.filled;
    const auto person_node = static_cast<int>(nodes_.size());
    const int first_joint = person_node + 1;
    nodes_.push_back({{"name", name},
                      {"children", Json::array({first_joint})},
                      {"extras", {{"id", id.value()}}}});
    scene_nodes_.push_back(person_node);
    AddJoints(presence, prefix, first_joint);
    AddSkin(presence, name, person_idx, first_joint);
    AddMotion(presence, person_node, first_joint);
  }

  // In the pose of the person's first frame.
  void AddJoints(const Presence& presence, const std::string& prefix,
                 int first_joint) {
    for (size_t j = 0; j < tree_.size(); ++j) {
      const Vector3d at = LocalPosition(presence.poses[0], j);
      const Quaterniond turn = LocalTurn(presence.poses[0], j);
      Json node = {{"name", prefix + tree_[j].name},
                   {"translation", {at.x(), at.y(), at.z()}},
                   {"rotation", {turn.x(), turn.y(), turn.z(), turn.w()}}};
      for (const int child : tree_[j].children) {
        node["children"].push_back(first_joint + child);
      }
      nodes_.push_back(std::move(node));
    }
  }

  void AddSkin(const Presence& presence, const std::string& name,
               size_t person_idx, int first_joint) {
    std::vector<Vector3d> rest_m(tree_.size(), Vector3d::Zero());
    std::vector<float> inverses;
    Json joints = Json::array();
    for (size_t j = 0; j < tree_.size(); ++j) {
      if (tree_[j].parent >= 0) {
        rest_m[j] = rest_m[static_cast<size_t>(tree_[j].parent)] +
                    presence.offsets_m[j];
      }
      for (const double k :
           {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0}) {
        inverses.push_back(static_cast<float>(k));
      }
      Append(-rest_m[j], &inverses);
      inverses.push_back(1.0F);
      joints.push_back(first_joint + static_cast<int>(j));
    }
    const int inverse_accessor = buffer_.Floats(inverses, 16);
    const auto index = static_cast<int>(skins_.size());
    skins_.push_back({{"name", name},
                      {"inverseBindMatrices", inverse_accessor},
                      {"skeleton", first_joint},
                      {"joints", joints}});
    materials_.push_back(Material(name, person_idx));
    meshes_.push_back(Body(tree_, rest_m).Mesh(name, index, &buffer_));
    scene_nodes_.push_back(static_cast<int>(nodes_.size()));
    nodes_.push_back(
        {{"name", name + "_body"}, {"mesh", index}, {"skin", index}});
  }

  static Json Material(const std::string& name, size_t person_idx) {
    // Okabe and Ito's colours, told apart by everybody.
    constexpr std::array<std::array<double, 3>, 7> kColours = {
        {{0.90, 0.60, 0.00},
         {0.34, 0.71, 0.91},
         {0.00, 0.62, 0.45},
         {0.94, 0.89, 0.26},
         {0.00, 0.45, 0.70},
         {0.84, 0.37, 0.00},
         {0.80, 0.47, 0.65}}};
    const auto& c = kColours[person_idx % kColours.size()];
    return {{"name", name},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", {c[0], c[1], c[2], 1.0}},
              {"metallicFactor", 0.0},
              {"roughnessFactor", 0.8}}}};
  }

  Vector3d LocalPosition(const TreeMotion::Row& pose, size_t joint) const {
    const int parent = tree_[joint].parent;
    if (parent < 0) return pose.positions_m[joint];
    const auto p = static_cast<size_t>(parent);
    return pose.global[p].conjugate() *
           (pose.positions_m[joint] - pose.positions_m[p]);
  }

  Quaterniond LocalTurn(const TreeMotion::Row& pose, size_t joint) const {
    const int parent = tree_[joint].parent;
    if (parent < 0) return pose.global[joint];
    return pose.global[static_cast<size_t>(parent)].conjugate() *
           pose.global[joint];
  }

  void AddMotion(const Presence& presence, int person_node, int first_joint) {
    std::vector<float> times_s;
    for (const size_t row : presence.rows) times_s.push_back(SecondsOf(row));
    const int input = buffer_.Floats(times_s, 1, /*with_bounds=*/true);
    for (size_t j = 0; j < tree_.size(); ++j) {
      std::vector<float> places;
      std::vector<float> turns;
      Quaterniond last = Quaterniond::Identity();
      for (const TreeMotion::Row& pose : presence.poses) {
        Append(LocalPosition(pose, j), &places);
        Quaterniond turn = LocalTurn(pose, j);
        // The nearer of the two that say the same, for what lies between rows.
        if (turn.dot(last) < 0.0) turn.coeffs() *= -1.0;
        last = turn;
        Append(turn, &turns);
      }
      const int node = first_joint + static_cast<int>(j);
      AddChannel(node, "translation", "LINEAR", input,
                 buffer_.Floats(places, 3));
      AddChannel(node, "rotation", "LINEAR", input, buffer_.Floats(turns, 4));
    }
    AddVisibility(presence, person_node);
  }

  // Scale 1 while the person is there, else 0.
  void AddVisibility(const Presence& presence, int person_node) {
    if (presence.rows.size() == rows_.size()) return;
    std::vector<float> times_s;
    std::vector<float> scales;
    std::optional<bool> last;
    size_t next = 0;
    for (size_t r = 0; r < rows_.size(); ++r) {
      const bool is_there =
          next < presence.rows.size() && presence.rows[next] == r;
      next += is_there ? 1 : 0;
      if (last == is_there) continue;
      last = is_there;
      times_s.push_back(SecondsOf(r));
      const double scale = is_there ? 1.0 : 0.0;
      Append(Vector3d::Constant(scale), &scales);
    }
    AddChannel(person_node, "scale", "STEP",
               buffer_.Floats(times_s, 1, /*with_bounds=*/true),
               buffer_.Floats(scales, 3));
  }

  void AddChannel(int node, const char* path, const char* interpolation,
                  int input, int output) {
    channels_.push_back({{"sampler", samplers_.size()},
                         {"target", {{"node", node}, {"path", path}}}});
    samplers_.push_back({{"input", input},
                         {"interpolation", interpolation},
                         {"output", output}});
  }

  const TrackSequence& tracks_;
  const AxisMap axes_;
  const std::vector<TrackRow> rows_;
  const JointTree tree_;
  double rate_hz_ = 0.0;
  size_t filled_ = 0;
  Buffer buffer_;
  Json nodes_ = Json::array();
  Json scene_nodes_ = Json::array();
  Json meshes_ = Json::array();
  Json materials_ = Json::array();
  Json skins_ = Json::array();
  Json channels_ = Json::array();
  Json samplers_ = Json::array();
};

void NoteLosses(const TrackSequence& tracks, const Scene& scene,
                Losses* losses) {
  const TrackContents contents = ContentsOf(tracks);
  losses->push_back("configuration is not kept; positions are 32-bit floats");
  NoteFilledJoints(scene.filled(), losses);
  NotePlainPositions(contents, losses);
  NoteAddedRows(tracks, scene.row_count(), "show nobody", losses);
}

// Header, a chunk of JSON and one of bytes (section 4.4 of the specification).
std::string BinaryFile(Json document, std::string bytes) {
  PadTo4('\0', &bytes);
  document["buffers"] = Json::array({{{"byteLength", bytes.size()}}});
  std::string text = document.dump();
  PadTo4(' ', &text);
  constexpr size_t kHeaders = 12 + 2 * 8;
  const size_t size = kHeaders + text.size() + bytes.size();
  if (size > std::numeric_limits<uint32_t>::max()) {
    throw InputError("the take is larger than the 4 GB of a .glb file");
  }
  std::string file = "glTF";
  AddWord(2, &file);
  AddWord(static_cast<uint32_t>(size), &file);
  AddWord(static_cast<uint32_t>(text.size()), &file);
  file += "JSON" + text;
  AddWord(static_cast<uint32_t>(bytes.size()), &file);
  file += std::string("BIN\0", 4) + bytes;
  return file;
}

std::string TextFile(Json document, const std::string& bytes) {
  document["buffers"] = Json::array(
      {{{"byteLength", bytes.size()},
        {"uri", "data:application/octet-stream;base64," + Base64(bytes)}}});
  return document.dump() + "\n";
}

void WriteTracksGltf(const std::string& path, const TrackSequence& tracks,
                     const TrackExportOptions& options, Losses* losses) {
  const Scene scene(tracks, options);
  const std::string end = ".glb";
  const bool is_binary =
      path.size() > end.size() &&
      path.compare(path.size() - end.size(), end.size(), end) == 0;
  AtomicFile file(path);
  file.Write(is_binary ? BinaryFile(scene.Document(), scene.bytes())
                       : TextFile(scene.Document(), scene.bytes()));
  file.Commit();
  NoteLosses(tracks, scene, losses);
}

}  // namespace

TrackFormat GltfTrackFormat() {
  TrackFormat format;
  format.name = "gltf";
  format.layout = "glTF 2.0, animated skeletons of everybody, m";
  format.extensions = {".glb", ".gltf"};
  format.axes = GltfAxes();
  format.has_marker_names = true;
  format.keeps_names = true;
  format.write = WriteTracksGltf;
  format.kept = "time, frame rate, identity, positions (32 bit), bones";
  format.lost =
      "missing joints (filled), status, views, covariances; a person who is "
      "away has scale 0";
  return format;
}

}  // namespace kinegraph
