// NaN and infinities as Python writes them into JSON, which knows neither.
#ifndef KINEGRAPH_CORE_IO_TEXT_NOT_A_NUMBER_H_
#define KINEGRAPH_CORE_IO_TEXT_NOT_A_NUMBER_H_

#include <string_view>

namespace kinegraph {

// The one that `text` begins with; empty where it begins with none.
inline std::string_view NotANumberAt(std::string_view text) {
  for (const std::string_view name : {"NaN", "Infinity", "-Infinity"}) {
    if (text.substr(0, name.size()) == name) return text.substr(0, name.size());
  }
  return {};
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_NOT_A_NUMBER_H_
