#include "core/data/identity_names.h"

namespace kinegraph {

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
