// Fast writing of JSON, with numbers as the shortest text that reads back as
// the same bits.
#ifndef KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_
#define KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_

#include <fmt/format.h>

#include <cstdint>
#include <initializer_list>
#include <string_view>
#include <type_traits>

#include "core/base/time.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {

class JsonOutput {
 public:
  void Text(std::string_view text) {
    buffer_.append(text.data(), text.data() + text.size());
  }
  void Integer(int64_t value);
  // Throws std::logic_error if the value is not finite.
  void Number(double value);
  void Seconds(TimeNs time) { Number(ToSeconds(time)); }

  // Appends texts, integers and numbers one after the other.
  template <typename... Parts>
  void Add(const Parts&... parts) {
    (Put(parts), ...);
  }
  // Calls `write` for each value, with `between` separating them.
  template <typename Values, typename Write>
  void Join(const Values& values, const Write& write,
            std::string_view between = ", ") {
    std::string_view separator;
    for (const auto& value : values) {
      Text(separator);
      write(value);
      separator = between;
    }
  }
  void Numbers(std::initializer_list<double> numbers) {
    Join(numbers, [this](double number) { Number(number); });
  }

  // Passes the buffered text to the file.
  void FlushTo(AtomicFile* file) {
    file->Write(buffer_.data(), buffer_.size());
    buffer_.clear();
  }

 private:
  template <typename Part>
  void Put(const Part& part) {
    if constexpr (std::is_integral_v<Part>) {
      Integer(part);
    } else if constexpr (std::is_floating_point_v<Part>) {
      Number(part);
    } else {
      Text(part);
    }
  }

  fmt::memory_buffer buffer_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_JSON_OUTPUT_H_
