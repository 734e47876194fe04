// Tracks on one clock without gaps, for formats with a row for every frame. For
// core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_ROWS_H_
#define KINEGRAPH_CORE_IO_TRACKS_ROWS_H_

#include <string>
#include <vector>

#include "core/data/pose.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

struct TrackRow {
  double time_s = 0.0;
  const TrackFrame* frame = nullptr;  // null: the tracks do not have it
};

// A row for every frame number from the first to the last. The times of frames
// that the tracks do not have lie evenly between their neighbours'. Throws
// InputError naming the format for more than ten million.
std::vector<TrackRow> MakeTrackRows(const TrackSequence& tracks,
                                    const std::string& format);

// nullptr when the person is not there.
const PersonPose* FindPerson(const TrackFrame* frame, TrackId id);

// Frame rate of the tracks [Hz]. Throws InputError naming the format when they
// do not tell it.
double RequireFrameRate(const TrackSequence& tracks, const std::string& format);

// That rows were made for frames that the input leaves out.
void NoteAddedRows(const TrackSequence& tracks, size_t row_count,
                   const std::string& what, LostFields* lost_fields);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_ROWS_H_
