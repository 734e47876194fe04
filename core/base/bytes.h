// Plain values as bytes of this machine, and back.
#ifndef KINEGRAPH_CORE_BASE_BYTES_H_
#define KINEGRAPH_CORE_BASE_BYTES_H_

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"

namespace kinegraph {

class ByteWriter {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  // Of what is never more than 65535; throws InputError.
  void PutCount(size_t count) {
    const auto small = static_cast<uint16_t>(count);
    if (small != count) throw InputError("too many to be counted in two bytes");
    Put(small);
  }
  template <typename Derived>
  void PutMatrix(const Eigen::MatrixBase<Derived>& matrix) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
        Put(static_cast<double>(matrix(r, c)));
      }
    }
  }
  const std::string& bytes() const { return bytes_; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// In the order in which they were put. Throws InputError where bytes lack.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T Get() {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    T value;
    std::memcpy(&value, Next(sizeof(T)).data(), sizeof(T));
    return value;
  }
  size_t GetCount() { return Get<uint16_t>(); }
  template <typename Derived>
  void GetMatrix(Eigen::MatrixBase<Derived>* matrix) {
    for (Eigen::Index c = 0; c < matrix->cols(); ++c) {
      for (Eigen::Index r = 0; r < matrix->rows(); ++r) {
        (*matrix)(r, c) = Get<double>();
      }
    }
  }
  bool done() const { return bytes_.empty(); }

 private:
  [[noreturn]] static void Fail() {
    throw InputError("bytes end before what they should hold");
  }
  std::string_view Next(size_t size) {
    if (size > bytes_.size()) Fail();
    const std::string_view next = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return next;
  }

  std::string_view bytes_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_BYTES_H_
