// Formats of detections that keep a file a view in one folder. For the writers
// of core/io/detections alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_

#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/data/detection.h"
#include "core/io/detections/lost_fields.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/text/json_output.h"

namespace kinegraph {

// "x, y, confidence", zeros where the joint was not found.
inline void WriteKeypoint(const Keypoint& joint, JsonOutput* out) {
  if (!joint.found) return out->Text("0, 0, 0");
  out->Numbers({joint.px.x(), joint.px.y(), joint.confidence});
}

// "[x, y], ..." and "c, ..." of all joints, zeros where one was not found.
inline void WritePoints(const Detection& detection, JsonOutput* out) {
  out->Join(detection.joints, [out](const Keypoint& joint) {
    out->Text("[");
    out->Numbers(
        {joint.found ? joint.px.x() : 0.0, joint.found ? joint.px.y() : 0.0});
    out->Text("]");
  });
}
inline void WriteConfidences(const Detection& detection, JsonOutput* out) {
  out->Join(detection.joints, [out](const Keypoint& joint) {
    out->Number(joint.found ? joint.confidence : 0.0);
  });
}

// What COCO's files say of a person beside the joints: of those that were
// found; zeros when there are none.
struct DetectionSummary {
  double score = 0.0;  // mean confidence
  int found = 0;
  Eigen::Vector2d low_px = Eigen::Vector2d::Zero();  // the box around them
  Eigen::Vector2d high_px = Eigen::Vector2d::Zero();
};

inline DetectionSummary Summarise(const Detection& detection) {
  DetectionSummary summary;
  for (const Keypoint& joint : detection.joints) {
    if (!joint.found) continue;
    const bool is_first = summary.found++ == 0;
    summary.low_px = is_first ? joint.px : summary.low_px.cwiseMin(joint.px);
    summary.high_px = is_first ? joint.px : summary.high_px.cwiseMax(joint.px);
    summary.score += joint.confidence;
  }
  if (summary.found > 0) summary.score /= summary.found;
  return summary;
}

// Begins a File for each view, named as the view; `more` goes to its
// constructor behind the path. Throws InputError where a name is no file's.
template <typename File, typename... More>
std::vector<std::unique_ptr<File>> MakeViewFiles(const DetectionHeader& header,
                                                 const std::string& extension,
                                                 const AtomicFolder& folder,
                                                 const More&... more) {
  std::vector<std::unique_ptr<File>> files;
  for (const std::string& view : header.view_names) {
    CheckFileName(view, "view");
    files.push_back(
        std::make_unique<File>(folder.PathOf(view + extension), more...));
  }
  return files;
}

// Writes all frames of the source, view by view, and completes the files.
// Returns how many frames have no detection.
template <typename File>
int64_t WriteViewFiles(const std::vector<std::unique_ptr<File>>& files,
                       DetectionSource* source, DetectionLossFinder* finder) {
  int64_t empty_frames = 0;
  DetectionFrame frame;
  while (source->Next(&frame)) {
    finder->See(frame);
    bool any = false;
    for (size_t v = 0; v < files.size(); ++v) {
      files[v]->Write(frame.frame, frame.views[v].detections);
      any = any || !frame.views[v].detections.empty();
    }
    empty_frames += any ? 0 : 1;
  }
  for (const auto& file : files) file->Commit();
  return empty_frames;
}

// Of formats that have an entry a person.
inline void NoteEmptyFrames(int64_t empty_frames, LostFields* lost_fields) {
  if (empty_frames == 0) return;
  lost_fields->push_back(std::to_string(empty_frames) +
                         " frames without any detection are not kept");
}

// Readers of JSON take truth.json in a folder for something else: a view of
// that name is refused. `format` completes "cannot be written as ...".
inline void RefuseViewTruth(const DetectionHeader& header,
                            const std::string& format) {
  for (const std::string& view : header.view_names) {
    if (view == "truth") {
      throw InputError("the view 'truth' cannot be written as " + format);
    }
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
