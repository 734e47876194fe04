#include "core/data/identity_edit.h"

namespace kinegraph {
namespace {

constexpr EditOp kOps[] = {EditOp::kJoin,   EditOp::kCut,  EditOp::kSwap,
                           EditOp::kDelete, EditOp::kName, EditOp::kUndecided};

}  // namespace

const char* ToString(EditOp op) {
  switch (op) {
    case EditOp::kJoin:
      return "join";
    case EditOp::kCut:
      return "cut";
    case EditOp::kSwap:
      return "swap";
    case EditOp::kDelete:
      return "delete";
    case EditOp::kName:
      return "name";
    case EditOp::kUndecided:
      break;
  }
  return "undecided";
}

std::optional<EditOp> EditOpByName(const std::string& name) {
  for (const EditOp op : kOps) {
    if (name == ToString(op)) return op;
  }
  return std::nullopt;
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
