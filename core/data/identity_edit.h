// A change of identities in a recording, by automatic linking or by a user's
// correction: one line of NAME.identity.jsonl.
#ifndef KINEGRAPH_CORE_DATA_IDENTITY_EDIT_H_
#define KINEGRAPH_CORE_DATA_IDENTITY_EDIT_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ids.h"

namespace kinegraph {

enum class EditOp {
  kJoin,  // persons[1] is the same person as persons[0]
  // In these frames persons[0] is another person, with the unused identity
  // persons[1] or, if that is not given, the next free one.
  kCut,
  kSwap,    // in these frames the two are exchanged
  kDelete,  // in these frames persons[0] is removed
  kName,    // persons[0] has a name
  // A join that the evidence neither supports nor excludes: no change.
  kUndecided,
};
// "join", "cut", ...
const char* ToString(EditOp op);
std::optional<EditOp> EditOpByName(const std::string& name);

// Frame numbers, both ends included.
struct FrameSpan {
  int64_t first = 0;
  int64_t last = 0;

  bool Contains(int64_t frame) const { return first <= frame && frame <= last; }
};

struct IdentityEdit {
  EditOp op = EditOp::kJoin;
  std::vector<TrackId> persons;
  // Cut, swap, delete: the frames to change. Join, undecided: persons[0]'s last
  // frame and persons[1]'s first, which is earlier if the two overlap. Name:
  // none.
  std::optional<FrameSpan> frames;
  // Evidence for the edit, in the order of the file; of a join: "bones",
  // "motion" and "other" as log likelihood ratios in nats, "gap_s", ...
  std::vector<std::pair<std::string, double>> evidence;
  // Difference from the second best explanation of the recording [nats].
  std::optional<double> margin;
  std::string name;   // kName
  std::string place;  // "file: line 3" of a correction, for messages
};

// Names given to people, by identity. They are not part of a TrackSequence, and
// the tracker does not use them.
using PersonNames = std::map<TrackId, std::string>;

// The names after these edits: kName sets a name, and kJoin removes the name of
// persons[1] and gives it to persons[0] if that is unnamed.
PersonNames NamesAfter(const std::vector<IdentityEdit>& edits);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_IDENTITY_EDIT_H_
