// Writing JSON fast: numbers as the shortest text that reads back bit for bit.
// Only sources include this header.
#ifndef KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_
#define KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "core/base/time.h"

namespace kinegraph {

class JsonOutput {
 public:
  void Text(std::string_view text) {
    buffer_.append(text.data(), text.data() + text.size());
  }
  void Integer(int64_t value);
  // Throws std::logic_error when the value is not finite: nothing that is
  // written may be.
  void Number(double value);
  void Seconds(TimeNs time) { Number(ToSeconds(time)); }

  std::string_view text() const { return {buffer_.data(), buffer_.size()}; }
  void Clear() { buffer_.clear(); }

 private:
  fmt::memory_buffer buffer_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_
