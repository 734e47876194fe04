// Reading what people are called in a file of tracks.
#ifndef KINEGRAPH_CORE_IO_TRACKS_PERSON_NAMES_H_
#define KINEGRAPH_CORE_IO_TRACKS_PERSON_NAMES_H_

#include <string>

#include "core/data/person_names.h"

namespace kinegraph {

// The names that are kept in our JSON Lines ("names" of the header), CSV
// (column `name`), NPZ (array `names`) and TRC (person_3_Anna.trc); none for
// other formats, for files without names and for pipes, which cannot be read
// twice. Throws InputError when names are there and no names.
PersonNames ReadPersonNames(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_PERSON_NAMES_H_
