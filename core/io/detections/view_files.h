// What the writers of detections share: people in JSON, a file a view, and what
// is lost. For core/io/detections alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_

#include <memory>
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

// Watches what is written by a format that stores frame numbers, x, y and
// confidence only.
class DetectionLossFinder {
 public:
  explicit DetectionLossFinder(const DetectionHeader& header)
      : header_(header) {}
  void See(const DetectionFrame& frame);
  // `skeleton_told` says whether a reader recognises the skeleton by the file,
  // `rate_told` whether it assumes the right frame rate.
  void Report(bool skeleton_told, LostFields* lost_fields,
              bool rate_told = false) const;

 private:
  DetectionHeader header_;
  int64_t zero_confidence_joints_ = 0;
  int64_t moved_ = 0;  // detections whose index in the frame changes
  bool own_times_ = false;
};

// Writes a folder with a file a view, named as the view: of each a File is made
// from its path and `more`, which writes frame after frame. Returns how many
// frames have no detection. Throws InputError where a name is no file's.
template <typename File, typename... More>
int64_t WriteViewFiles(const std::string& path, const std::string& extension,
                       DetectionSource* source, bool skeleton_told,
                       LostFields* lost_fields, const More&... more) {
  AtomicFolder folder(path);
  std::vector<std::unique_ptr<File>> files;
  for (const std::string& view : source->header().view_names) {
    CheckFileName(view, "view");
    files.push_back(
        std::make_unique<File>(folder.PathOf(view + extension), more...));
  }
  DetectionLossFinder finder(source->header());
  int64_t empty_frames = 0;
  DetectionFrame frame;
  while (source->Next(&frame)) {
    finder.See(frame);
    bool any = false;
    for (size_t v = 0; v < files.size(); ++v) {
      files[v]->Write(frame.frame, frame.views[v].detections);
      any = any || !frame.views[v].detections.empty();
    }
    empty_frames += any ? 0 : 1;
  }
  for (const auto& file : files) file->Commit();
  folder.Commit();
  finder.Report(skeleton_told, lost_fields);
  return empty_frames;
}
// Of formats that have an entry a person.
void NoteEmptyFrames(int64_t empty_frames, LostFields* lost_fields);

// Readers of JSON take truth.json in a folder for something else: a view of
// that name is refused. `format` completes "cannot be written as ...".
void RefuseViewTruth(const DetectionHeader& header, const std::string& format);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
