#include "core/data/identity_edit.h"

#include <algorithm>
#include <array>

namespace kinegraph {
namespace {

// In the order of EditOp.
constexpr std::array<const char*, 6> kOps = {"join",   "cut",  "swap",
                                             "delete", "name", "undecided"};

}  // namespace

const char* ToString(EditOp op) { return kOps[static_cast<size_t>(op)]; }

std::optional<EditOp> EditOpByName(const std::string& name) {
  const auto at = std::find(kOps.begin(), kOps.end(), name);
  if (at == kOps.end()) return std::nullopt;
  return static_cast<EditOp>(at - kOps.begin());
}

PersonNames NamesAfter(const std::vector<IdentityEdit>& edits) {
  PersonNames names;
  for (const IdentityEdit& edit : edits) {
    if (edit.op == EditOp::kName && !edit.persons.empty()) {
      names[edit.persons[0]] = edit.name;
    }
    if (edit.op != EditOp::kJoin || edit.persons.size() != 2) continue;
    const auto other = names.find(edit.persons[1]);
    if (other == names.end()) continue;
    names.emplace(edit.persons[0], other->second);
    names.erase(other);
  }
  return names;
}

}  // namespace kinegraph
