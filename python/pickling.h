// Converts values to bytes and back, for pickle and copy.deepcopy. The bytes
// are valid for this version on this machine only; store recordings in a file
// format.
#ifndef KINEGRAPH_PYTHON_PICKLING_H_
#define KINEGRAPH_PYTHON_PICKLING_H_

#include <Eigen/Core>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/kinematics/kinematics.h"

namespace kinegraph {

// Appends visited values.
class ByteWriter {
 public:
  static constexpr bool kReads = false;

  void Raw(const void* data, size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  size_t Count(size_t count) {
    Raw(&count, sizeof(count));
    return count;
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Sets visited values. Throws if the bytes end early.
class ByteReader {
 public:
  static constexpr bool kReads = true;

  explicit ByteReader(std::string bytes) : bytes_(std::move(bytes)) {}

  void Raw(void* data, size_t size) {
    if (size > bytes_.size() - at_) {
      throw std::runtime_error("pickle: the state ends too early");
    }
    std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }
  // Every element takes at least one byte, so a larger count means damage.
  size_t Count(size_t) {
    size_t count = 0;
    Raw(&count, sizeof(count));
    if (count > bytes_.size() - at_) {
      throw std::runtime_error("pickle: the state ends too early");
    }
    return count;
  }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

template <typename Bytes, typename T>
std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>> Visit(
    Bytes& bytes, T& value) {
  bytes.Raw(&value, sizeof(value));
}
template <typename Bytes, typename T, int kRows, int kColumns>
void Visit(Bytes& bytes, Eigen::Matrix<T, kRows, kColumns>& value) {
  static_assert(kRows > 0 && kColumns > 0);
  bytes.Raw(value.data(), sizeof(T) * kRows * kColumns);
}
template <typename Bytes>
void Visit(Bytes& bytes, std::string& value) {
  value.resize(bytes.Count(value.size()));
  bytes.Raw(value.data(), value.size());
}
template <typename Bytes>
void Visit(Bytes& bytes, TrackId& id) {
  int64_t value = id.value();
  Visit(bytes, value);
  id = TrackId(value);
}

// Declared before their definitions, which call each other.
template <typename Bytes, typename T>
void Visit(Bytes& bytes, std::optional<T>& value);
template <typename Bytes, typename T>
void Visit(Bytes& bytes, std::vector<T>& values);

template <typename Bytes, typename... T>
void VisitAll(Bytes& bytes, T&... values) {
  (Visit(bytes, values), ...);
}

template <typename Bytes>
void Visit(Bytes& bytes, Bone& bone) {
  VisitAll(bytes, bone.a, bone.b);
}
template <typename Bytes>
void Visit(Bytes& bytes, Skeleton& skeleton) {
  std::string name = skeleton.name();
  std::vector<std::string> joints = skeleton.joints();
  std::vector<Bone> bones = skeleton.bones();
  VisitAll(bytes, name, joints, bones);
  if constexpr (Bytes::kReads) skeleton = Skeleton(name, joints, bones);
}

template <typename Bytes>
void Visit(Bytes& bytes, Joint3d& joint) {
  VisitAll(bytes, joint.position_m, joint.status);
}
template <typename Bytes>
void Visit(Bytes& bytes, ViewMatch& match) {
  VisitAll(bytes, match.view_idx, match.detection_idx, match.weights);
}
template <typename Bytes>
void Visit(Bytes& bytes, PersonPose& person) {
  VisitAll(bytes, person.id, person.joints, person.inlier_views,
           person.covariances, person.matches, person.score);
}
template <typename Bytes>
void Visit(Bytes& bytes, TrackFrame& frame) {
  VisitAll(bytes, frame.frame, frame.time, frame.people);
}
template <typename Bytes>
void Visit(Bytes& bytes, TrackSequence& tracks) {
  TrackHeader& header = tracks.header;
  VisitAll(bytes, header.skeleton, header.mode, header.frame_rate_hz,
           header.view_names, header.config_json, tracks.frames);
}

template <typename Bytes>
void Visit(Bytes& bytes, Keypoint& joint) {
  VisitAll(bytes, joint.px, joint.confidence, joint.found);
}
template <typename Bytes>
void Visit(Bytes& bytes, Detection& detection) {
  VisitAll(bytes, detection.joints, detection.index_in_file);
}
template <typename Bytes>
void Visit(Bytes& bytes, ViewDetections& view) {
  VisitAll(bytes, view.capture_time, view.detections);
}
template <typename Bytes>
void Visit(Bytes& bytes, DetectionFrame& frame) {
  VisitAll(bytes, frame.frame, frame.time, frame.views);
}
template <typename Bytes>
void Visit(Bytes& bytes, DetectionSequence& detections) {
  DetectionHeader& header = detections.header;
  VisitAll(bytes, header.skeleton, header.view_names, header.frame_rate_hz,
           detections.frames);
}

template <typename Bytes>
void Visit(Bytes& bytes, KinematicsRow& row) {
  VisitAll(bytes, row.frame, row.time, row.id, row.values);
}
template <typename Bytes>
void Visit(Bytes& bytes, KinematicsTable& table) {
  VisitAll(bytes, table.up, table.has_times, table.angles, table.columns,
           table.rows, table.notes);
}

template <typename Bytes, typename T>
void Visit(Bytes& bytes, std::optional<T>& value) {
  bool has_value = value.has_value();
  Visit(bytes, has_value);
  if (!has_value) {
    value.reset();
    return;
  }
  if constexpr (Bytes::kReads) value.emplace();
  Visit(bytes, *value);
}
template <typename Bytes, typename T>
void Visit(Bytes& bytes, std::vector<T>& values) {
  values.resize(bytes.Count(values.size()));
  for (T& value : values) Visit(bytes, value);
}

// Writing does not modify the value.
template <typename T>
std::string BytesOf(const T& value) {
  ByteWriter writer;
  Visit(writer, const_cast<T&>(value));  // NOLINT: one Visit for both ways
  return writer.Take();
}
template <typename T>
T OfBytes(std::string bytes) {
  ByteReader reader(std::move(bytes));
  T value;
  Visit(reader, value);
  return value;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_PYTHON_PICKLING_H_
