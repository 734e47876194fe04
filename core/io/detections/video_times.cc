#include "core/io/detections/video_times.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/adapters/adapter.h"

namespace kinegraph {

bool IsVideoName(const std::string& path) { return !VideoType(path).empty(); }

std::string VideoType(const std::string& path) {
  for (const auto& [ending, type] : {std::pair{".mp4", "video/mp4"},
                                     {".m4v", "video/mp4"},
                                     {".mov", "video/quicktime"},
                                     {".webm", "video/webm"},
                                     {".mkv", "video/x-matroska"}}) {
    if (EndsInAnyCase(path, ending)) return type;
  }
  return "";
}

std::vector<double> ReadVideoTimes(const std::string& path) {
  // Only the file itself: lists of other files or addresses are not followed.
  const Adapter ffprobe = {
      {"ffprobe", "-v", "error", "-protocol_whitelist", "file",
       "-format_whitelist", "mov,matroska", "-select_streams", "v:0",
       "-show_entries", "packet=pts_time,flags", "-of", "csv=p=0", "-i"},
      AdapterKind::kDetections,
      "ffprobe",
      "apt-get install ffmpeg"};
  std::vector<double> times_s;
  for (const std::string& line : Split(OutputOf(ffprobe, path), '\n')) {
    // "1.234000,K__"; the flag D marks frames that an edit list discards.
    const std::vector<std::string> cells = Split(line, ',');
    const auto time_s = ParseNumber<double>(cells.front());
    const bool is_shown =
        cells.size() > 1 && cells[1].find('D') == std::string::npos;
    // Times before the start of playback are negative; ffprobe rounds to
    // microseconds.
    if (is_shown && time_s.has_value() && *time_s > -1e-6) {
      times_s.push_back(*time_s);
    }
  }
  if (times_s.empty()) throw InputError(path, "", "has no video track");
  std::sort(times_s.begin(), times_s.end());
  return times_s;
}

}  // namespace kinegraph
