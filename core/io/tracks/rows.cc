#include "core/io/tracks/rows.h"

#include <algorithm>

#include "core/base/error.h"

namespace kinegraph {

std::vector<TrackRow> MakeTrackRows(const TrackSequence& tracks,
                                    const std::string& format) {
  constexpr int64_t kMaxRows = 10'000'000;
  std::vector<TrackRow> rows;
  if (tracks.frames.empty()) return rows;
  const int64_t first = tracks.frames.front().frame;
  const int64_t count = tracks.frames.back().frame - first + 1;
  if (count > kMaxRows) {
    throw InputError("the tracks span " + std::to_string(count) +
                     " frames, a " + format + " file may have " +
                     std::to_string(kMaxRows));
  }
  rows.resize(static_cast<size_t>(count));
  size_t last = 0;
  for (const TrackFrame& frame : tracks.frames) {
    const auto row = static_cast<size_t>(frame.frame - first);
    rows[row] = {ToSeconds(frame.time), &frame};
    for (size_t r = last + 1; r < row; ++r) {
      const double share =
          static_cast<double>(r - last) / static_cast<double>(row - last);
      rows[r].time_s =
          rows[last].time_s + share * (rows[row].time_s - rows[last].time_s);
    }
    last = row;
  }
  return rows;
}

const PersonPose* FindPerson(const TrackFrame* frame, TrackId id) {
  if (frame == nullptr) return nullptr;
  const auto at =
      std::find_if(frame->people.begin(), frame->people.end(),
                   [id](const PersonPose& person) { return person.id == id; });
  return at == frame->people.end() ? nullptr : &*at;
}

double RequireFrameRate(const TrackSequence& tracks,
                        const std::string& format) {
  if (tracks.header.frame_rate_hz > 0.0) return tracks.header.frame_rate_hz;
  throw InputError(format +
                   " needs a frame rate, which the input does not tell "
                   "(--frame_rate=HZ)");
}

void NoteAddedRows(const TrackSequence& tracks, size_t row_count,
                   const std::string& what, LostFields* lost_fields) {
  if (row_count <= tracks.frames.size()) return;
  lost_fields->push_back(std::to_string(row_count - tracks.frames.size()) +
                         " frames that the input leaves out " + what);
}

}  // namespace kinegraph
