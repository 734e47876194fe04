// What the writers of detections share: people in JSON, a file a view, and what
// is lost. For core/io/detections alone.
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

// "x, y, confidence, ..." of all joints; zeros, here and below, where one was
// not found.
void WriteKeypoints(const Detection& detection, JsonOutput* out);
// "[x, y], ..." and "c, ...".
void WritePoints(const Detection& detection, JsonOutput* out);
void WriteConfidences(const Detection& detection, JsonOutput* out);

// What COCO's files say of a person beside the joints: of those that were
// found; zeros when there are none.
struct DetectionSummary {
  double score = 0.0;  // mean confidence
  int found = 0;
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();  // the box around them
  Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
};
DetectionSummary Summarise(const Detection& detection);
// "x, y, width, height".
void WriteBox(const DetectionSummary& summary, JsonOutput* out);

// Hands each frame of `source` to `write`, and notes what a format loses that
// stores frame numbers, x, y and confidence only. `skeleton_told` says whether
// a reader recognises the skeleton by the file, `rate_told` whether it assumes
// the right frame rate.
void WriteFrames(DetectionSource* source, bool skeleton_told,
                 LostFields* lost_fields,
                 const std::function<void(const DetectionFrame& frame)>& write,
                 bool rate_told = false);

// A view's file while it is written.
struct ViewFile {
  explicit ViewFile(const std::string& path) : file(path) {}
  // Begins the next entry of a JSON list, on a line of its own.
  JsonOutput& Entry();

  AtomicFile file;
  JsonOutput out;
  bool has_entries = false;
};

// Writes a folder with a file a view, named as the view: a table that begins
// with `heading`, or without one a JSON list. `write` adds what is seen in a
// frame. Returns how many frames have no detection. Throws InputError where a
// name is no file's.
int64_t WriteViewFiles(const std::string& path, const std::string& extension,
                       const std::string& heading, DetectionSource* source,
                       bool skeleton_told, LostFields* lost_fields,
                       void (*write)(int64_t frame,
                                     const std::vector<Detection>& detections,
                                     ViewFile* file));
// Of formats that have an entry a person.
void NoteEmptyFrames(int64_t empty_frames, LostFields* lost_fields);

// Readers of JSON take truth.json in a folder for something else: a view of
// that name is refused. `format` completes "cannot be written as ...".
void RefuseViewTruth(const DetectionHeader& header, const std::string& format);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
