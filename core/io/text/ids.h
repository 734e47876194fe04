// Identities in files. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TEXT_IDS_H_
#define KINEGRAPH_CORE_IO_TEXT_IDS_H_

#include <cstdint>
#include <limits>

namespace kinegraph {

// Every reader takes what every writer may write. Nobody computes with ids.
inline constexpr int64_t kMaxId = std::numeric_limits<int64_t>::max();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TEXT_IDS_H_
