// longcw's annotation_2d.json: {"image_wh", "frames": {"VIEW/TIME.jpg":
// {"camera", "timestamp", "poses": [{"points_2d", "scores"}]}}}.
#include <fmt/format.h>

#include <stdexcept>

#include "core/base/error.h"
#include "core/io/detections/export.h"
#include "core/io/detections/lost_fields.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/longcw.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

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
      WriteImage(header.view_names[v], view, &out);
    }
    out.FlushTo(&file);
  }
  file.Write("\n}}\n");
  file.Commit();
  finder.Report(header.skeleton == Tum14(), lost_fields,
                header.frame_rate_hz == kLongcwFrameRateHz);
}

}  // namespace kinegraph
