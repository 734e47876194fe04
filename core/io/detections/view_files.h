// Shared by the writers of detections: writes people as JSON and one file per
// view, and notes lost fields. For core/io/detections only.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json_output.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

// Writes "x, y, confidence, ..." of all joints. Here and below, joints that
// were not found are written as zeros.
void WriteKeypoints(const Detection& detection, JsonOutput* out);
// Write "[x, y], ..." and "confidence, ...".
void WritePoints(const Detection& detection, JsonOutput* out);
void WriteConfidences(const Detection& detection, JsonOutput* out);

// COCO's fields other than the joints, computed from the found joints; zeros if
// there are none.
struct DetectionSummary {
  double score = 0.0;  // mean confidence
  int found = 0;
  Eigen::Vector2d low_px =
      Eigen::Vector2d::Zero();  // corner of the bounding box
  Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
};
DetectionSummary Summarise(const Detection& detection);
// Writes "x, y, width, height".
void WriteBox(const DetectionSummary& summary, JsonOutput* out);

// Passes each frame of `source` to `write`, and notes what is lost by a format
// that stores only frame numbers, x, y and confidence. `skeleton_known`:
// readers of the file can determine the skeleton; `rate_known`: they can
// determine the frame rate; `keeps_times`: the file keeps all times and the
// order of views.
void WriteFrames(DetectionSource* source, bool skeleton_known,
                 LostFields* lost_fields,
                 const std::function<void(const DetectionFrame& frame)>& write,
                 bool rate_known = false, bool keeps_times = false);

// The file of a view that is being written.
struct ViewFile {
  explicit ViewFile(const std::string& path) : file(path) {}
  // Begins the next entry of a JSON list, on its own line.
  JsonOutput& Entry();

  AtomicFile file;
  JsonOutput out;
  bool has_entries = false;
};

// Writes a folder with one file per view, named after the view: a table with
// the first line `heading`, or a JSON list if `heading` is empty. `write` adds
// the detections of a frame in one view. Returns the number of frames in which
// no view has detections. Throws InputError if a view's name cannot be a file
// name.
int64_t WriteViewFiles(const std::string& path, const std::string& extension,
                       const std::string& heading, DetectionSource* source,
                       bool skeleton_known, LostFields* lost_fields,
                       void (*write)(int64_t frame,
                                     const std::vector<Detection>& detections,
                                     ViewFile* file));
// Notes the loss of empty frames, for formats with one entry per person.
void NoteEmptyFrames(int64_t empty_frames, LostFields* lost_fields);

// Throws InputError for a view named "truth", since readers of JSON ignore
// truth.json in a folder. `format` completes "cannot be written as ...".
void RefuseViewTruth(const DetectionHeader& header, const std::string& format);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
