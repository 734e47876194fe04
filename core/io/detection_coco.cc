// COCO keypoint results: [{"image_id": frame, "keypoints": [x, y, c, ...],
// ...}, ...], one file a view. Frames need not ascend, so a file is read whole.
// AlphaPose writes the image's file name instead of a number: then its last
// integer is the frame.
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/io/bulk_json.h"
#include "core/io/detection_formats.h"
#include "core/io/names.h"

namespace kinegraph {
namespace {

constexpr const char* kKeypoints = "keypoints";
constexpr const char* kImageId = "image_id";

class CocoReader {
 public:
  CocoReader(const DetectionHeader& header, ZeroConfidence zero_confidence)
      : zero_confidence_(zero_confidence),
        numbers_(3 * static_cast<size_t>(header.skeleton.joint_count())),
        collector_(header) {}

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

  std::unique_ptr<DetectionSource> Finish() { return collector_.Finish(); }

 private:
  void ReadEntry(const JsonObject& entry, size_t view_idx) {
    const int64_t frame = FrameOf(Required(entry, kImageId));
    AsNumbers(Required(entry, kKeypoints), kKeypoints, numbers_.size(),
              numbers_.data());
    Detection* detection = collector_.Add(frame, view_idx);
    detection->joints.reserve(numbers_.size() / 3);
    for (size_t n = 0; n < numbers_.size(); n += 3) {
      detection->joints.push_back(MakeKeypoint(
          numbers_[n], numbers_[n + 1], numbers_[n + 2], zero_confidence_));
    }
  }

  static int64_t FrameOf(JsonValue image_id) {
    if (!image_id.is_string()) return AsFrame(image_id, kImageId);
    const std::string_view name = AsText(image_id, kImageId);
    const std::optional<int64_t> frame = FrameOfFileName(name);
    if (frame) return *frame;
    throw InputError(std::string(kImageId) + ": found the text '" +
                     Printable(std::string(name)) +
                     "', expected a frame number or a file name with one");
  }

  const ZeroConfidence zero_confidence_;
  std::vector<double> numbers_;  // of one person
  DetectionCollector collector_;
  JsonFileParser parser_;
};

}  // namespace

std::unique_ptr<DetectionSource> OpenCocoResults(
    const std::string& path, const DetectionReadOptions& options) {
  const auto files = ListViewFiles(path);
  DetectionHeader header;
  header.skeleton = options.skeleton.value_or(Coco17());
  header.frame_rate_hz = options.frame_rate_hz;
  for (const auto& [view, file] : files) header.view_names.push_back(view);
  CocoReader reader(header, options.zero_confidence);
  for (size_t v = 0; v < files.size(); ++v) reader.ReadFile(files[v].second, v);
  return reader.Finish();
}

}  // namespace kinegraph
