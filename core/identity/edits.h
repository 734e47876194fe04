// Applies edits of identities to tracked frames.
#ifndef KINEGRAPH_CORE_IDENTITY_EDITS_H_
#define KINEGRAPH_CORE_IDENTITY_EDITS_H_

#include <string>
#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/pose.h"

namespace kinegraph {

// Applies one edit; a cut without a second person takes the next free identity
// and stores it in the edit. Names and undecided joins change no frame. If the
// edit is invalid, returns the reason and changes nothing: for example an
// unknown person, frames in which the person is absent, or a join of two people
// who are both present in a frame. Empty on success.
std::string ApplyEdit(IdentityEdit* edit, std::vector<TrackFrame>* frames);

// Applies the edits in order and appends the valid ones to `done`. Returns a
// line for each invalid one: the edit and the reason. An invalid join is
// appended to `done` as undecided.
std::vector<std::string> ApplyEdits(std::vector<IdentityEdit> edits,
                                    std::vector<TrackFrame>* frames,
                                    std::vector<IdentityEdit>* done);

// Whether two edits request the same: operation, people, frames and name.
bool SameEdit(const IdentityEdit& a, const IdentityEdit& b);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IDENTITY_EDITS_H_
