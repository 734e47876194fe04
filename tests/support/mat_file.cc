#include "tests/support/mat_file.h"

namespace kinegraph::testing {
namespace {

// Data types and array classes of the MAT-file format, version 5.
constexpr uint32_t kInt8 = 1;
constexpr uint32_t kInt32 = 5;
constexpr uint32_t kUint32 = 6;
constexpr uint32_t kDouble = 9;
constexpr uint32_t kMatrix = 14;
constexpr uint32_t kCellClass = 1;
constexpr uint32_t kDoubleClass = 6;

template <typename T>
void Append(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

// A tag (type, length) and the data, padded to a multiple of eight bytes.
std::string Element(uint32_t type, const std::string& data) {
  std::string bytes;
  Append(type, &bytes);
  Append(static_cast<uint32_t>(data.size()), &bytes);
  bytes += data;
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
  return bytes;
}

}  // namespace

std::string MatArray(uint32_t array_class, int32_t rows, int32_t columns,
                     const std::string& name, const std::string& content) {
  std::string flags;
  Append(array_class, &flags);
  Append(uint32_t{0}, &flags);
  std::string dimensions;
  Append(rows, &dimensions);
  Append(columns, &dimensions);
  return Element(kMatrix, Element(kUint32, flags) +
                              Element(kInt32, dimensions) +
                              Element(kInt8, name) + content);
}

std::string MatNumbers(int32_t rows, int32_t columns, double value) {
  std::string numbers;
  for (int32_t i = 0; i < rows * columns; ++i) Append(value, &numbers);
  return MatArray(kDoubleClass, rows, columns, "", Element(kDouble, numbers));
}

std::string MatCell(int32_t rows, int32_t columns,
                    const std::vector<std::string>& entries,
                    const std::string& name) {
  std::string content;
  for (const std::string& entry : entries) content += entry;
  return MatArray(kCellClass, rows, columns, name, content);
}

std::string MatFile(const std::string& elements) {
  std::string header = "MATLAB 5.0 MAT-file, made by a test";
  header.resize(124, ' ');
  Append(uint16_t{0x0100}, &header);
  return header + "IM" + elements;
}

namespace {

std::string PoseMatrix(const Pose3d* pose) {
  if (pose == nullptr) {
    return MatNumbers(0, 0, 0.0);
  }
  std::string numbers;  // column by column
  for (int axis = 0; axis < 3; ++axis) {
    for (const Joint3d& joint : *pose) {
      Append(joint.position_m[axis], &numbers);
    }
  }
  return MatArray(kDoubleClass, static_cast<int32_t>(pose->size()), 3, "",
                  Element(kDouble, numbers));
}

}  // namespace

std::string ActorsGroundTruth(const AnnotatedActors& actors,
                              int64_t frame_count) {
  std::string cells;
  for (const auto& poses : actors) {
    std::string frames;
    for (int64_t frame = 0; frame < frame_count; ++frame) {
      const auto at = poses.find(frame);
      frames += PoseMatrix(at == poses.end() ? nullptr : &at->second);
    }
    cells +=
        MatArray(kCellClass, static_cast<int32_t>(frame_count), 1, "", frames);
  }
  return MatFile(MatArray(kCellClass, 1, static_cast<int32_t>(actors.size()),
                          "actor3D", cells));
}

}  // namespace kinegraph::testing
