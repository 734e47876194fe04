// A text in parts.
#ifndef KINEGRAPH_CORE_BASE_SPLIT_H_
#define KINEGRAPH_CORE_BASE_SPLIT_H_

#include <string>
#include <vector>

namespace kinegraph {

// What stands before, between and behind the separators, be it nothing: one
// part more than there are separators.
std::vector<std::string> Split(const std::string& text, char separator);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_SPLIT_H_
