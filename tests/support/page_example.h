// Example files in pages of the documentation.
#ifndef KINEGRAPH_TESTS_SUPPORT_PAGE_EXAMPLE_H_
#define KINEGRAPH_TESTS_SUPPORT_PAGE_EXAMPLE_H_

#include <stdexcept>
#include <string>

#include "core/io/files/text_file.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// The block that begins with "```json NAME" in a page of the project. Throws
// std::out_of_range if there is none.
inline std::string PageExample(const std::string& page,
                               const std::string& name) {
  const std::string text = ReadTextFile(ProjectFile(page).string());
  const std::string begin = "\n```json " + name + "\n";
  const size_t at = text.find(begin);
  if (at == std::string::npos) {
    throw std::out_of_range(page + " has no example " + name);
  }
  const size_t from = at + begin.size();
  return text.substr(from, text.find("```", from) - from);
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_PAGE_EXAMPLE_H_
