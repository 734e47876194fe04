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

}  // namespace kinegraph
