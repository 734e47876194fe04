#include "core/io/text/json_output.h"

#include <fmt/compile.h>

#include <cmath>
#include <iterator>
#include <stdexcept>

namespace kinegraph {

void JsonOutput::Integer(int64_t value) {
  fmt::format_to(std::back_inserter(buffer_), FMT_COMPILE("{}"), value);
}

void JsonOutput::Number(double value) {
  if (!std::isfinite(value)) {
    throw std::logic_error("a number to be written is not finite");
  }
  if (value == 0.0) {  // "-0" would be read as an integer and lose its sign
    Text(std::signbit(value) ? "-0.0" : "0");
    return;
  }
  fmt::format_to(std::back_inserter(buffer_), FMT_COMPILE("{}"), value);
}

}  // namespace kinegraph
