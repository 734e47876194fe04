#include "core/io/tracks/person_names.h"

#include "core/io/files/text_file.h"
#include "core/io/tracks/format.h"

namespace kinegraph {

PersonNames ReadPersonNames(const std::string& path) {
  if (IsPipe(path) || (!IsFolder(path) && !IsFile(path))) return {};
  const TrackFormat* format = RecogniseTracks(LookAtTracks(path));
  if (format == nullptr || format->read_names == nullptr) return {};
  return format->read_names(path);
}

}  // namespace kinegraph
