// Writing 2D detections in our own format.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_

#include <memory>
#include <string>

#include "core/data/detection.h"

namespace kinegraph {

// JSON Lines, one frame a line. The file appears under its name in Commit();
// without it nothing is left. A detection's index_in_file is not kept: when
// read again it is its place in the line.
//
//   DetectionWriter writer(path, header);
//   while (source->Next(&frame)) writer.Write(frame);
//   writer.Commit();
class DetectionWriter {
 public:
  // Throws InputError when the file cannot be made.
  DetectionWriter(const std::string& path, const DetectionHeader& header);
  ~DetectionWriter();
  DetectionWriter(const DetectionWriter&) = delete;
  DetectionWriter& operator=(const DetectionWriter&) = delete;

  // Frames ascend. Throws std::logic_error when they do not, when a number is
  // not finite or when views or joints are not those of the header.
  void Write(const DetectionFrame& frame);
  void Commit();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// All frames at once.
void WriteDetections(const std::string& path,
                     const DetectionSequence& sequence);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_
