// Identities as distinct types, so that one cannot be confused with an index or
// with an identity of another kind.
#ifndef KINEGRAPH_CORE_BASE_IDS_H_
#define KINEGRAPH_CORE_BASE_IDS_H_

#include <cstdint>
#include <functional>

namespace kinegraph {

template <typename Tag>
class Id {
 public:
  constexpr Id() = default;
  constexpr explicit Id(int64_t value) : value_(value) {}
  constexpr int64_t value() const { return value_; }

  friend constexpr bool operator==(Id a, Id b) { return a.value_ == b.value_; }
  friend constexpr bool operator!=(Id a, Id b) { return a.value_ != b.value_; }
  friend constexpr bool operator<(Id a, Id b) { return a.value_ < b.value_; }

 private:
  int64_t value_ = -1;
};

// A person in the tracker. Never reused within a run.
using TrackId = Id<struct TrackIdTag>;

}  // namespace kinegraph

template <typename Tag>
struct std::hash<kinegraph::Id<Tag>> {
  size_t operator()(kinegraph::Id<Tag> id) const noexcept {
    return std::hash<int64_t>()(id.value());
  }
};

#endif  // KINEGRAPH_CORE_BASE_IDS_H_
