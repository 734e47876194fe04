// Edits of identities in tracked frames.
#ifndef KINEGRAPH_CORE_IDENTITY_EDITS_H_
#define KINEGRAPH_CORE_IDENTITY_EDITS_H_

#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"

namespace kinegraph {

// Does what one edit says; a cut without a second person takes the next free
// identity and writes it into the edit. Names and undecided joins change no
// frame. Returns what is wrong with the edit, and then changes nothing: an
// unknown person, frames in which a person is not, two people who are both
// there in a frame; empty when all is well.
std::string ApplyEdit(IdentityEdit* edit, std::vector<TrackFrame>* frames);

// Does what the edits say, in order, and appends those that fit to `done`.
// Returns a line for each that does not: what it asks for and what is wrong.
// Such a join stands in `done` as undecided.
std::vector<std::string> ApplyEdits(std::vector<IdentityEdit> edits,
                                    std::vector<TrackFrame>* frames,
                                    std::vector<IdentityEdit>* done);

// Whether two lines ask for the same: operation, people, frames and name.
bool SameEdit(const IdentityEdit& a, const IdentityEdit& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_EDITS_H_
