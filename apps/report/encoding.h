// Bytes and text that may stand inside an HTML page.
#ifndef KINEGRAPH_APPS_REPORT_ENCODING_H_
#define KINEGRAPH_APPS_REPORT_ENCODING_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace kinegraph {

std::string Base64(const unsigned char* bytes, size_t size);

// The numbers as they lie in memory. Pages read them as little-endian, which
// is what every machine is that we build on.
template <typename Number>
std::string Base64(const std::vector<Number>& numbers) {
  return Base64(reinterpret_cast<const unsigned char*>(numbers.data()),
                numbers.size() * sizeof(Number));
}

// The nearest whole multiple of `quantum`, kept inside the type.
template <typename Integer>
Integer Quantise(double value, double quantum) {
  const double scaled = std::round(value / quantum);
  const double low = std::numeric_limits<Integer>::min();
  const double high = std::numeric_limits<Integer>::max();
  return static_cast<Integer>(std::clamp(scaled, low, high));
}

// JSON text without any "<": no tag and no comment can begin or end in it.
std::string WithoutAngleBrackets(const std::string& json);

// Text as HTML shows it, for elements and quoted attributes.
std::string HtmlText(const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_REPORT_ENCODING_H_
