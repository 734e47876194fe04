// What people are called.
#ifndef KINEGRAPH_CORE_DATA_PERSON_NAMES_H_
#define KINEGRAPH_CORE_DATA_PERSON_NAMES_H_

#include <map>
#include <string>

#include "core/base/ids.h"

namespace kinegraph {

// Of those who were given a name, by identity. Kept beside the tracks: the
// tracker knows of none.
using PersonNames = std::map<TrackId, std::string>;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_DATA_PERSON_NAMES_H_
