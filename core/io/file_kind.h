// Whether a file holds a calibration, detections or tracks.
#ifndef KINEGRAPH_CORE_IO_FILE_KIND_H_
#define KINEGRAPH_CORE_IO_FILE_KIND_H_

#include <string>

namespace kinegraph {

enum class FileKind { kCalibration, kDetections, kTracks };
const char* ToString(FileKind kind);

// By content, for formats that ReadCameras, OpenDetections or ReadTracks
// recognise. A heuristic to choose among them; they check the content.
// Throws InputError when the file cannot be read or resembles none of them.
FileKind RecogniseKind(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILE_KIND_H_
