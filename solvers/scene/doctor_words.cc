#include "solvers/scene/doctor_words.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace kinegraph {

std::string Format(const char* format, double a, double b, double c) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, a, b, c);
  return text.data();
}

double Shared(double confidence, size_t count) {
  return std::min(0.95, confidence) / static_cast<double>(count);
}

}  // namespace kinegraph
