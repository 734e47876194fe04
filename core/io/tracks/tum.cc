// TUM's actorsGT.mat of Campus and Shelf, a MATLAB file that an adapter reads
// and writes. An actor's id is its index, the frame number the index of the
// entry, both from 0.
#include "core/io/tracks/format.h"
#include "core/io/tracks/shared.h"

namespace kinegraph {

TrackSequence ReadTumTracks(const std::string& path,
                            const TrackReadOptions& options) {
  return ReadTracksByAdapter(OwnAdapter("tum", AdapterKind::kTracks), path,
                             options);
}

void WriteTumTracks(const std::string& path, const TrackSequence& tracks,
                    const TrackExportOptions& /*options*/,
                    LostFields* lost_fields) {
  WriteTracksByAdapter("tum", path, tracks, {});
  const TrackContents contents = ContentsOf(tracks);
  NotePositionsOnly(contents, lost_fields);
  NoteLosses(contents, {Loss::kClock}, lost_fields);
  if (tracks.frames.front().frame > 0 ||
      tracks.frames.back().frame + 1 !=
          static_cast<int64_t>(tracks.frames.size())) {
    lost_fields->push_back(
        "frames from 0 on that are missing in the input are written without "
        "people");
  }
  if (tracks.header.skeleton != Tum14()) NoteSkeleton(tracks, lost_fields);
}

}  // namespace kinegraph
