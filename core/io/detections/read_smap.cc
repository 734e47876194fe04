// SMAP's output on CMU Panoptic, one file a view and frame: {"3d_pairs":
// {"num", "pred_2d": people x 15 x [x, y, relative depth, score]}}.
#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/text/bulk_json.h"

namespace kinegraph {
namespace {

// Coordinates are those of the network's input: the 1920 x 1080 image scaled
// to a width of 832 and centred in a height of 512.
constexpr double kImageWidthPx = 1920.0;
constexpr double kImageHeightPx = 1080.0;
constexpr double kInputWidthPx = 832.0;
constexpr double kInputHeightPx = 512.0;
constexpr double kScale = kImageWidthPx / kInputWidthPx;
constexpr double kBarPx = 0.5 * (kInputHeightPx - kImageHeightPx / kScale);

void ReadPerson(JsonValue person, ZeroConfidence zero_confidence,
                int joint_count, Detection* detection) {
  for (const JsonValue joint : AsArray(person, "pred_2d")) {
    double numbers[4];
    AsNumbers(joint, "pred_2d", 4, numbers);
    Keypoint point =
        MakeKeypoint(numbers[0], numbers[1], numbers[3], zero_confidence);
    point.px = (point.px - Eigen::Vector2d(0.0, kBarPx)) * kScale;
    detection->joints.push_back(point);
  }
  if (detection->joints.size() != static_cast<size_t>(joint_count)) {
    throw InputError("pred_2d: found " +
                     std::to_string(detection->joints.size()) +
                     " joints, expected " + std::to_string(joint_count));
  }
}

std::unique_ptr<DetectionSource> OpenSmapFile(
    const std::string& path, const DetectionReadOptions& options) {
  const auto files = ListViewFiles(path);
  DetectionHeader header;
  header.skeleton = options.skeleton.value_or(Panoptic15());
  header.frame_rate_hz = options.frame_rate_hz;
  for (const auto& [view, file] : files) header.view_names.push_back(view);
  DetectionCollector collector(header);
  collector.Touch(options.first_frame);
  JsonFileParser parser;
  for (size_t v = 0; v < files.size(); ++v) {
    const std::string& file = files[v].second;
    const JsonValue root = parser.Parse(file);
    Located(
        file, [] { return "3d_pairs"; },
        [&] {
          const JsonObject pairs = AsObject(
              Required(AsObject(root, kOutermost), "3d_pairs"), "3d_pairs");
          for (const JsonValue person :
               AsArray(Required(pairs, "pred_2d"), "pred_2d")) {
            ReadPerson(person, options.zero_confidence,
                       header.skeleton.joint_count(),
                       collector.Add(options.first_frame, v));
          }
        });
  }
  return collector.Finish();
}

bool RecogniseSmap(const DetectionHead& head) {
  return head.HasKey("3d_pairs");
}

}  // namespace

DetectionFormat SmapFormat() {
  DetectionFormat format;
  format.name = "smap";
  format.layout = "a file a view";
  format.extension = ".json";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseSmap;
  format.open = OpenSmapFile;
  return format;
}

}  // namespace kinegraph
