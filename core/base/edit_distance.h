// How far apart two words are, for "did you mean ...?".
#ifndef KINEGRAPH_CORE_BASE_EDIT_DISTANCE_H_
#define KINEGRAPH_CORE_BASE_EDIT_DISTANCE_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// Levenshtein's distance: the least number of characters to insert, delete or
// replace that turns `a` into `b`. Takes time in proportion to both lengths.
size_t EditDistance(const std::string& a, const std::string& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_EDIT_DISTANCE_H_
