// Writing 2D detections in kinegraph's own format.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_

#include <memory>
#include <string>

#include "core/data/detection.h"

namespace kinegraph {

// JSON Lines, one frame per line. Commit() makes the file appear; without it,
// the file is discarded. index_in_file is not stored: a reader sets it to the
// position in the line.
//
//   DetectionWriter writer(path, header);
//   while (source->Next(&frame)) writer.Write(frame);
//   writer.Commit();
class DetectionWriter {
 public:
  // Throws InputError if the file cannot be created, or if `header` has no
  // views, two views of the same name or an invalid frame rate.
  DetectionWriter(const std::string& path, const DetectionHeader& header);
  ~DetectionWriter();
  DetectionWriter(const DetectionWriter&) = delete;
  DetectionWriter& operator=(const DetectionWriter&) = delete;

  // Frame numbers must ascend. Throws std::logic_error if they do not, if a
  // number is not finite or if views or joints do not match the header.
  void Write(const DetectionFrame& frame);
  void Commit();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Writes all frames.
void WriteDetections(const std::string& path,
                     const DetectionSequence& sequence);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_WRITER_H_
