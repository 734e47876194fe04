// Presentation times of a video's frames, read from its container; nothing is
// decoded.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_

#include <string>
#include <vector>

namespace kinegraph {

// Whether the name has, in upper or lower case, the extension of a container
// that browsers play and ReadVideoTimes() reads: .mp4, .m4v, .mov, .webm, .mkv.
bool IsVideoName(const std::string& path);

// MIME type of a video by its name, such as "video/mp4"; empty for other names.
std::string VideoType(const std::string& path);

// Presentation times [s] of the first video track, ascending, zero at the start
// of playback. Frames that an edit list cuts off are omitted. Uses ffprobe.
// Throws InputError naming the file if ffprobe is not installed or finds no
// video track.
std::vector<double> ReadVideoTimes(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_
