// COCO keypoint results: [{"image_id": frame, "keypoints": [x, y, c, ...],
// ...}, ...], one file a view. Frames need not ascend, so a file is read whole.
// AlphaPose writes the image's file name instead of a number: then its last
// integer is the frame.
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

constexpr const char* kKeypoints = "keypoints";
constexpr const char* kImageId = "image_id";

class CocoReader {
 public:
  CocoReader(const DetectionHeader& header, const DetectionReadOptions& options)
      : zero_confidence_(options.zero_confidence), collector_(header) {}

  void ReadFile(const std::string& path, size_t view_idx) {
    const JsonValue root = parser_.Parse(path);
    const JsonArray entries =
        Located(path, [&] { return AsArray(root, kOutermost); });
    size_t place = 0;
    Located(
        path, [&] { return "entry " + std::to_string(place); },
        [&] {
          for (const JsonValue entry : entries) {
            ReadEntry(AsObject(entry, "a detection"), view_idx);
            ++place;
          }
        });
  }

  std::unique_ptr<DetectionSource> Finish() {
    if (numbers_.empty() && collector_.header().skeleton.joint_count() == 0) {
      collector_.set_skeleton(Coco17());  // nobody was seen
    }
    return collector_.Finish();
  }

 private:
  void ReadEntry(const JsonObject& entry, size_t view_idx) {
    const int64_t frame = FrameOf(Required(entry, kImageId));
    const JsonArray keypoints =
        AsArray(Required(entry, kKeypoints), kKeypoints);
    if (numbers_.empty()) Prepare(keypoints.size());
    AsNumbers(keypoints, kKeypoints, numbers_.size(), numbers_.data());
    Detection* detection = collector_.Add(frame, view_idx);
    detection->joints.reserve(numbers_.size() / 3);
    for (size_t n = 0; n < numbers_.size(); n += 3) {
      detection->joints.push_back(MakeKeypoint(
          numbers_[n], numbers_[n + 1], numbers_[n + 2], zero_confidence_));
    }
  }

  // By the first person of the recording, unless the skeleton is given.
  void Prepare(size_t number_count) {
    if (collector_.header().skeleton.joint_count() == 0) {
      collector_.set_skeleton(
          *DetectorSkeletons((number_count + 2) / 3, kKeypoints).front());
    }
    numbers_.resize(
        3 * static_cast<size_t>(collector_.header().skeleton.joint_count()));
  }

  static int64_t FrameOf(JsonValue image_id) {
    if (!image_id.is_string()) return AsFrame(image_id, kImageId);
    return FrameOfName(AsText(image_id, kImageId));
  }

  const ZeroConfidence zero_confidence_;
  std::vector<double> numbers_;  // of one person
  DetectionCollector collector_;
  JsonFileParser parser_;
};

std::unique_ptr<DetectionSource> OpenCocoFile(
    const std::string& path, const DetectionReadOptions& options) {
  return OpenViewFiles<CocoReader>(path, options, ".json");
}

// AlphaPose's files have more keys and the same ones.
bool RecogniseCoco(const DetectionHead& head) {
  return head.kind == '[' && !head.has_folders &&
         !head.Contains("\"keypoint_scores\"") &&
         !head.Contains("\"instances\"");
}

// ---- Writing ----

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

// COCO keypoint results, VIEW.json. The score of a person is the mean
// confidence of the joints found, the box the one around them.
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

}  // namespace

DetectionFormat CocoResultsFormat() {
  DetectionFormat format;
  format.name = "coco";
  format.layout = "COCO results, a file a view (AlphaPose too)";
  format.extension = ".json";
  format.files = DetectionFormat::Files::kFileAView;
  format.leaves_out_empty = true;
  format.recognise = RecogniseCoco;
  format.open = OpenCocoFile;
  format.write = WriteCocoResults;
  return format;
}

}  // namespace kinegraph
