// A change of who is who in a recording: what automatic linking did, and what a
// user corrects. One line of NAME.identity.jsonl.
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
  kJoin,       // persons[1] is persons[0]
  kCut,        // in these frames persons[0] is somebody else: persons[1]
  kSwap,       // in these frames the two are exchanged
  kDelete,     // in these frames persons[0] is nobody
  kName,       // persons[0] has a name
  kUndecided,  // a join that the evidence neither makes nor forbids: no change
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
  // Join, undecided: the last frame of the one, the first of the other.
  std::optional<FrameSpan> frames;
  // What spoke for it: "bones" and "motion" in nats of log likelihood ratio,
  // "gap_s", ... in order.
  std::vector<std::pair<std::string, double>> evidence;
  // By how many nats the second best explanation of the recording is worse.
  std::optional<double> margin;
  std::string name;   // kName
  std::string place;  // "file: line 3" of a correction, for messages
};

// What people are called who were given a name, by identity. Kept beside the
// tracks: the tracker knows of none.
using PersonNames = std::map<TrackId, std::string>;

// What people are called after these edits: `name` gives a name, and who is
// joined to somebody without one brings theirs along.
PersonNames NamesAfter(const std::vector<IdentityEdit>& edits);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_IDENTITY_EDIT_H_
