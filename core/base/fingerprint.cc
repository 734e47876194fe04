#include "core/base/fingerprint.h"

#include <cstdio>

namespace kinegraph {

// FNV-1a, and beside it a product and rotation a byte with other constants: two
// hashes that do not collide together by accident.
void Fingerprint::Add(std::string_view bytes) {
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    a_ = (a_ ^ byte) * 0x100000001b3u;
    b_ = (b_ + byte + 1) * 0xd6e8feb86659fd93u;
    b_ ^= b_ >> 29;
  }
}

std::string Fingerprint::Hex() const {
  char text[33];
  std::snprintf(text, sizeof(text), "%016llx%016llx",
                static_cast<unsigned long long>(a_),
                static_cast<unsigned long long>(b_));
  return text;
}

}  // namespace kinegraph
