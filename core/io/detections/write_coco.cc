// COCO keypoint results, a file a view: [{"image_id": frame, "category_id": 1,
// "keypoints": [x, y, c, ...], "score": s, "bbox": [x, y, w, h]}, ...].
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/export.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/summary.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/text/json_output.h"

namespace kinegraph {
namespace {

class CocoView {
 public:
  explicit CocoView(const std::string& path) : file_(path) {}

  void Write(int64_t frame, const std::vector<Detection>& detections) {
    for (const Detection& detection : detections) Write(frame, detection);
    out_.FlushTo(&file_);
  }

  void Commit() {
    out_.Text(is_first_ ? "[]\n" : "\n]\n");
    out_.FlushTo(&file_);
    file_.Commit();
  }

 private:
  void Write(int64_t frame, const Detection& detection) {
    const DetectionSummary summary = Summarise(detection);
    const Eigen::Vector2d size_px = summary.high_px - summary.low_px;
    out_.Text(is_first_ ? "[\n" : ",\n");
    is_first_ = false;
    out_.Add("{\"image_id\": ", frame,
             ", \"category_id\": 1, \"keypoints\": [");
    out_.Join(detection.joints,
              [this](const Keypoint& joint) { WriteKeypoint(joint, &out_); });
    out_.Add("], \"score\": ", summary.score, ", \"bbox\": [");
    out_.Numbers(
        {summary.low_px.x(), summary.low_px.y(), size_px.x(), size_px.y()});
    out_.Text("]}");
  }

  AtomicFile file_;
  JsonOutput out_;
  bool is_first_ = true;
};

}  // namespace

void WriteCocoResults(const std::string& path,
                      const DetectionWriteOptions& /*options*/,
                      DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  RefuseViewTruth(header, "COCO results");
  const auto files = MakeViewFiles<CocoView>(header, ".json", folder);
  DetectionLossFinder finder(header);
  const int64_t empty_frames = WriteViewFiles(files, source, &finder);
  folder.Commit();
  finder.Report(IsToldByJointCount(header.skeleton), lost_fields);
  NoteEmptyFrames(empty_frames, lost_fields);
}

}  // namespace kinegraph
