// What people are called after edits of who is who.
#ifndef KINEGRAPH_CORE_DATA_IDENTITY_NAMES_H_
#define KINEGRAPH_CORE_DATA_IDENTITY_NAMES_H_

#include <vector>

#include "core/data/identity_edit.h"
#include "core/data/person_names.h"

namespace kinegraph {

// What people are called after these edits: `name` gives a name, and who is
// joined to somebody without one brings theirs along.
PersonNames NamesAfter(const std::vector<IdentityEdit>& edits);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_IDENTITY_NAMES_H_
