#include "core/io/detections/writer.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "core/io/detections/export.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {

class DetectionWriter::Impl {
 public:
  Impl(const std::string& path, const DetectionHeader& header)
      : file_(path),
        joint_count_(header.skeleton.joints().size()),
        has_clock_(header.frame_rate_hz > 0.0) {
    for (const std::string& name : header.view_names) {
      views_.push_back(JsonText(name));
    }
    WriteHeader(header);
  }

  void Write(const DetectionFrame& frame) {
    if (frame.frame <= last_frame_ || frame.views.size() != views_.size()) {
      throw std::logic_error("detections of frame " +
                             std::to_string(frame.frame) +
                             " do not fit the file that is being written");
    }
    last_frame_ = frame.frame;
    out_.Add("{\"frame\": ", frame.frame);
    // Without a clock all times are 0; left out, a reader that is told the
    // frame rate can fill them in.
    if (has_clock_ || frame.time != 0) {
      out_.Text(", \"time\": ");
      out_.Seconds(frame.time);
    }
    out_.Text(", \"views\": {");
    for (size_t v = 0; v < views_.size(); ++v) {
      out_.Add(v == 0 ? "" : ", ", views_[v], ": [");
      WriteView(frame.views[v]);
      out_.Text("]");
    }
    out_.Text("}");
    WriteCaptureTimes(frame);
    out_.Text("}\n");
    out_.FlushTo(&file_);
  }

  void Commit() { file_.Commit(); }

 private:
  void WriteHeader(const DetectionHeader& header) {
    out_.Add("{\"kinegraph_detections\": 1, \"skeleton\": ",
             SkeletonJson(header.skeleton), ", \"frame_rate\": ");
    if (header.frame_rate_hz > 0.0) {
      out_.Number(header.frame_rate_hz);
    } else {
      out_.Text("null");
    }
    out_.Text(", \"views\": [");
    out_.Join(views_, [this](const std::string& view) { out_.Text(view); });
    out_.Text("]}\n");
    out_.FlushTo(&file_);
  }

  void WriteView(const ViewDetections& view) {
    out_.Join(view.detections, [this](const Detection& detection) {
      if (detection.joints.size() != joint_count_) {
        throw std::logic_error(
            "a detection does not have the joints of its file");
      }
      out_.Text("{\"joints\": [");
      out_.Join(detection.joints,
                [this](const Keypoint& joint) { WriteJoint(joint); });
      out_.Text("]}");
    });
  }

  void WriteJoint(const Keypoint& joint) {
    if (!joint.found) {
      out_.Text("null");
      return;
    }
    out_.Text("[");
    out_.Numbers({joint.px.x(), joint.px.y(), joint.confidence});
    out_.Text("]");
  }

  // Only of views whose clock is not the frame's.
  void WriteCaptureTimes(const DetectionFrame& frame) {
    bool any = false;
    for (size_t v = 0; v < views_.size(); ++v) {
      if (frame.views[v].capture_time == frame.time) continue;
      out_.Add(any ? ", " : ", \"capture_times\": {", views_[v], ": ");
      out_.Seconds(frame.views[v].capture_time);
      any = true;
    }
    if (any) out_.Text("}");
  }

  AtomicFile file_;
  const size_t joint_count_;
  const bool has_clock_;
  std::vector<std::string> views_;  // quoted
  int64_t last_frame_ = -1;
  JsonOutput out_;
};

DetectionWriter::DetectionWriter(const std::string& path,
                                 const DetectionHeader& header)
    : impl_(std::make_unique<Impl>(path, header)) {}
DetectionWriter::~DetectionWriter() = default;
void DetectionWriter::Write(const DetectionFrame& frame) {
  impl_->Write(frame);
}
void DetectionWriter::Commit() { impl_->Commit(); }

void WriteKinegraphDetections(const std::string& path,
                              const DetectionWriteOptions& /*options*/,
                              DetectionSource* source,
                              LostFields* lost_fields) {
  if (!(source->header().frame_rate_hz > 0.0)) {
    lost_fields->push_back("the frame rate is not known (--frame_rate=HZ)");
  }
  DetectionWriter writer(path, source->header());
  DetectionFrame frame;
  while (source->Next(&frame)) writer.Write(frame);
  writer.Commit();
}

void WriteDetections(const std::string& path,
                     const DetectionSequence& sequence) {
  DetectionWriter writer(path, sequence.header);
  for (const DetectionFrame& frame : sequence.frames) writer.Write(frame);
  writer.Commit();
}

}  // namespace kinegraph
