// A fingerprint of bytes.
#ifndef KINEGRAPH_CORE_BASE_FINGERPRINT_H_
#define KINEGRAPH_CORE_BASE_FINGERPRINT_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace kinegraph {

// 128 bits that tell contents apart (not against somebody who means harm).
class Fingerprint {
 public:
  void Add(std::string_view bytes);
  std::string Hex() const;  // 32 digits

 private:
  uint64_t a_ = 0xcbf29ce484222325u;
  uint64_t b_ = 0x9e3779b97f4a7c15u;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_FINGERPRINT_H_
