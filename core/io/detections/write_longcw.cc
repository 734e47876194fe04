// longcw's annotation_2d.json: {"image_wh", "frames": {"VIEW/TIME.jpg":
// {"camera", "timestamp", "poses": [{"points_2d", "scores"}]}}}.
#include <fmt/format.h>

#include <stdexcept>

#include "core/base/error.h"
#include "core/io/detections/export.h"
#include "core/io/detections/lost_fields.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

void WritePose(const Detection& detection, JsonOutput* out) {
  out->Text("{\"points_2d\": [");
  const char* separator = "";
  for (const Keypoint& joint : detection.joints) {
    out->Text(separator);
    separator = ", ";
    out->Text("[");
    out->Number(joint.found ? joint.px.x() : 0.0);
    out->Text(", ");
    out->Number(joint.found ? joint.px.y() : 0.0);
    out->Text("]");
  }
  out->Text("], \"scores\": [");
  separator = "";
  for (const Keypoint& joint : detection.joints) {
    out->Text(separator);
    separator = ", ";
    out->Number(joint.found ? joint.confidence : 0.0);
  }
  out->Text("]}");
}

}  // namespace

void WriteLongcwDetections(const std::string& path,
                           const DetectionWriteOptions& options,
                           DetectionSource* source, LostFields* lost_fields) {
  const ImageSize& size = options.image_size;
  const DetectionHeader header = source->header();
  RequireLongcwRate(header.frame_rate_hz);
  if (size.width_px <= 0 || size.height_px <= 0) {
    throw InputError(
        "longcw's files tell the image size, which detections do not have "
        "(--image_size=W,H)");
  }
  AtomicFile file(path);
  file.Write(fmt::format("{{\"image_wh\": [{}, {}], \"frames\": {{",
                         size.width_px, size.height_px));
  DetectionLossFinder finder(header);
  DetectionFrame frame;
  JsonOutput out;
  const char* separator = "\n";
  while (source->Next(&frame)) {
    finder.See(frame);
    for (size_t v = 0; v < header.view_names.size(); ++v) {
      const ViewDetections& view = frame.views[v];
      RequireLongcwTime(frame.frame, view.capture_time, header.frame_rate_hz);
      out.Text(separator);
      separator = ",\n";
      const std::string& name = header.view_names[v];
      out.Text(JsonText(
          fmt::format("{}/{:08.3f}.jpg", name, ToSeconds(view.capture_time))));
      out.Text(": {\"camera\": ");
      out.Text(JsonText(name));
      out.Text(", \"timestamp\": ");
      out.Seconds(view.capture_time);
      out.Text(", \"poses\": [");
      const char* comma = "";
      for (const Detection& detection : view.detections) {
        out.Text(comma);
        comma = ", ";
        WritePose(detection, &out);
      }
      out.Text("]}");
    }
    file.Write(out.text().data(), out.text().size());
    out.Clear();
  }
  file.Write("\n}}\n");
  file.Commit();
  finder.Report(header.skeleton == Tum14(), lost_fields,
                header.frame_rate_hz == kLongcwFrameRateHz);
}

}  // namespace kinegraph
