// COCO keypoint results, a file a view: [{"image_id": frame, "category_id": 1,
// "keypoints": [x, y, c, ...], "score": s, "bbox": [x, y, w, h]}, ...].
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/export.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/lost_fields.h"
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

  void Write(int64_t frame, const Detection& detection) {
    const DetectionSummary summary = Summarise(detection);
    const Eigen::Vector2d size_px = summary.high_px - summary.low_px;
    out_.Text(is_first_ ? "[\n" : ",\n");
    is_first_ = false;
    out_.Text("{\"image_id\": ");
    out_.Integer(frame);
    out_.Text(", \"category_id\": 1, \"keypoints\": ");
    WriteKeypoints(detection);
    out_.Text(", \"score\": ");
    out_.Number(summary.score);
    out_.Text(", \"bbox\": ");
    WriteNumbers(
        {summary.low_px.x(), summary.low_px.y(), size_px.x(), size_px.y()});
    out_.Text("}");
    Flush();
  }

  void Commit() {
    out_.Text(is_first_ ? "[]\n" : "\n]\n");
    Flush();
    file_.Commit();
  }

 private:
  void WriteKeypoints(const Detection& detection) {
    std::vector<double> numbers;
    numbers.reserve(3 * detection.joints.size());
    for (const Keypoint& joint : detection.joints) {
      if (joint.found) {
        numbers.insert(numbers.end(),
                       {joint.px.x(), joint.px.y(), joint.confidence});
      } else {
        numbers.insert(numbers.end(), 3, 0.0);
      }
    }
    WriteNumbers(numbers);
  }

  void WriteNumbers(const std::vector<double>& numbers) {
    const char* separator = "[";
    for (const double number : numbers) {
      out_.Text(separator);
      out_.Number(number);
      separator = ", ";
    }
    out_.Text("]");
  }

  void Flush() {
    file_.Write(out_.text().data(), out_.text().size());
    out_.Clear();
  }

  AtomicFile file_;
  JsonOutput out_;
  bool is_first_ = true;
};

bool IsEmpty(const DetectionFrame& frame) {
  for (const ViewDetections& view : frame.views) {
    if (!view.detections.empty()) return false;
  }
  return true;
}

}  // namespace

void WriteCocoResults(const std::string& path,
                      const DetectionWriteOptions& /*options*/,
                      DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  RefuseViewTruth(header, "COCO results");
  const auto files = MakeViewFiles<CocoView>(header, ".json", folder);
  DetectionLossFinder finder(header);
  DetectionFrame frame;
  int64_t empty_frames = 0;
  while (source->Next(&frame)) {
    finder.See(frame);
    empty_frames += IsEmpty(frame) ? 1 : 0;
    for (size_t v = 0; v < files.size(); ++v) {
      for (const Detection& detection : frame.views[v].detections) {
        files[v]->Write(frame.frame, detection);
      }
    }
  }
  for (const auto& file : files) file->Commit();
  folder.Commit();
  finder.Report(IsToldByJointCount(header.skeleton), lost_fields);
  if (empty_frames > 0) {
    lost_fields->push_back(std::to_string(empty_frames) +
                           " frames without any detection are not kept");
  }
}

}  // namespace kinegraph
