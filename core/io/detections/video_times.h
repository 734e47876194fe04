// When the pictures of a video are shown, as its container says; nothing is
// decoded.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_

#include <string>
#include <vector>

namespace kinegraph {

// By the end of its name: the containers that browsers play and that
// ReadVideoTimes() knows (.mp4, .m4v, .mov, .webm, .mkv), in any case.
bool IsVideoName(const std::string& path);

// "video/mp4" and the like, of such a name.
std::string VideoType(const std::string& path);

// Times of the pictures of the first video track [s], ascending, zero where
// playback begins; pictures before it, which an edit list cuts off, are left
// out. Read by ffprobe. Throws InputError naming the file when ffprobe is not
// there, or finds no such track.
std::vector<double> ReadVideoTimes(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIDEO_TIMES_H_
