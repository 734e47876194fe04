// Whether a file contains a calibration, detections or tracks.
#ifndef KINEGRAPH_CORE_IO_FILE_KIND_H_
#define KINEGRAPH_CORE_IO_FILE_KIND_H_

#include <string>

namespace kinegraph {

enum class FileKind { kCalibration, kDetections, kTracks };
const char* ToString(FileKind kind);

// Recognises by content and extension what ReadCameras, OpenDetections or
// ReadTracks can read. This is a heuristic to choose one of these functions,
// which check the content. Throws InputError if the file cannot be read or
// resembles none of the formats.
FileKind RecogniseKind(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILE_KIND_H_
