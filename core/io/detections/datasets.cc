// Formats of individual data sets: longcw's annotations of Campus.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/text/names.h"

namespace kinegraph {

// ---- longcw ----
// annotation_2d.json: {"image_wh": [w, h], "frames": {"Camera0/0013.600.jpg":
// {"camera", "timestamp", "poses": [{"points_2d": [[x, y], ...], "scores":
// [...]}]}, ...}}, in pixels.

namespace {

std::vector<std::string> ViewNames(const JsonObject& frames) {
  std::set<std::string, decltype(&NaturalLess)> names(NaturalLess);
  for (const auto image : frames) {
    const JsonObject object = AsObject(image.value, image.key);
    names.emplace(AsText(Required(object, "camera"), "camera"));
  }
  return {names.begin(), names.end()};
}

void ReadPose(const JsonObject& pose, ZeroConfidence zero_confidence,
              size_t count, Detection* detection) {
  std::vector<double> scores(count);
  AsNumbers(Required(pose, "scores"), "scores", count, scores.data());
  const JsonArray points = AsArray(Required(pose, "points_2d"), "points_2d");
  CheckCount("points_2d", points.size(), count, " joints");
  AddPoints(points, "points_2d", scores, zero_confidence, detection);
}

std::unique_ptr<DetectionSource> ReadLongcwFile(
    JsonValue root, const DetectionReadOptions& options, std::string* place) {
  const JsonObject frames =
      AsObject(Required(AsObject(root, kOutermost), "frames"), "frames");
  DetectionHeader header = HeaderOf(ViewNames(frames), options, Tum14());
  if (!(header.frame_rate_hz > 0.0)) header.frame_rate_hz = kLongcwFrameRateHz;
  if (header.view_names.empty()) throw InputError("frames: is empty");
  DetectionCollector collector(header);
  std::set<std::pair<int64_t, size_t>> seen;
  for (const auto image : frames) {
    *place = Printable(std::string(image.key));
    const JsonObject object = AsObject(image.value, "the image");
    const auto view_at =
        std::find(header.view_names.begin(), header.view_names.end(),
                  AsText(Required(object, "camera"), "camera"));
    const auto view_idx =
        static_cast<size_t>(view_at - header.view_names.begin());
    const LongcwTime time =
        ReadLongcwTime(Required(object, "timestamp"), header.frame_rate_hz);
    if (!seen.emplace(time.frame, view_idx).second) {
      throw InputError("frame " + std::to_string(time.frame) +
                       " appears twice for this camera");
    }
    DetectionFrame* frame = collector.Touch(time.frame);
    frame->views[view_idx].capture_time = time.time;
    for (const JsonValue pose : AsArray(Required(object, "poses"), "poses")) {
      ReadPose(AsObject(pose, "poses"), options.zero_confidence,
               header.skeleton.joints().size(),
               collector.Add(time.frame, view_idx));
    }
  }
  return collector.Finish();
}

void WriteImage(const std::string& name, const ViewDetections& view,
                JsonOutput* out) {
  const double time_s = ToSeconds(view.capture_time);
  out->Add(JsonText(fmt::format("{}/{:08.3f}.jpg", name, time_s)),
           ": {\"camera\": ", JsonText(name), ", \"timestamp\": ", time_s,
           ", \"poses\": [");
  out->Join(view.detections, [out](const Detection& detection) {
    out->Text("{\"points_2d\": [");
    WritePoints(detection, out);
    out->Text("], \"scores\": [");
    WriteConfidences(detection, out);
    out->Text("]}");
  });
  out->Text("]}");
}

}  // namespace

std::unique_ptr<DetectionSource> OpenLongcw(
    const std::string& path, const DetectionReadOptions& options) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] { return ReadLongcwFile(root, options, &place); });
}

bool RecogniseLongcw(const DetectionHead& head) {
  return head.HasKey("frames") && head.HasKey("image_wh");
}

// Writes one annotation_2d.json. It identifies frames by their times, which
// requires a frame rate, and contains the image size, which must be given.
void WriteLongcw(const std::string& path, const DetectionWriteOptions& options,
                 DetectionSource* source, LostFields* lost_fields) {
  const ImageSize& size = options.image_size;
  const DetectionHeader header = source->header();
  RequireLongcwRate(header.frame_rate_hz);
  if (size.width_px <= 0 || size.height_px <= 0) {
    throw InputError(
        "longcw's files contain the image size, which detections do not have "
        "(--image_size=W,H)");
  }
  AtomicFile file(path);
  file.Write(fmt::format("{{\"image_wh\": [{}, {}], \"frames\": {{",
                         size.width_px, size.height_px));
  JsonOutput out;
  const char* separator = "\n";
  const auto write = [&](const DetectionFrame& frame) {
    for (size_t v = 0; v < header.view_names.size(); ++v) {
      const ViewDetections& view = frame.views[v];
      RequireLongcwTime(frame.frame, view.capture_time, header.frame_rate_hz);
      out.Text(separator);
      separator = ",\n";
      WriteImage(header.view_names[v], view, &out);
    }
    out.FlushTo(&file);
  };
  WriteFrames(source, header.skeleton == Tum14(), lost_fields, write,
              header.frame_rate_hz == kLongcwFrameRateHz);
  file.Write("\n}}\n");
  file.Commit();
}

}  // namespace kinegraph
