// Parts of a text.
#ifndef KINEGRAPH_CORE_BASE_SPLIT_H_
#define KINEGRAPH_CORE_BASE_SPLIT_H_

#include <string>
#include <string_view>
#include <vector>

namespace kinegraph {

// What stands before, between and behind the separators, be it nothing: one
// part more than there are separators.
std::vector<std::string> Split(const std::string& text, char separator);

// Whether `text` ends in `end` and is more than that.
bool EndsIn(std::string_view text, std::string_view end);

// `text` without the blanks at its ends.
std::string Trimmed(const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_SPLIT_H_
