// kinegraph's own format of detections, JSON Lines. Header:
// {"kinegraph_detections": 1, "skeleton": {...}, "frame_rate": 25.0, "views":
// ["cam0", ...]}; then one line per frame: {"frame": 300, "time": 12.0,
// "views": {"cam0": [{"joints": [[x, y, c] or null, ...]}, ...]},
// "capture_times": {"cam0": 12.001}}. capture_times (alias view_times) lists
// only views whose time differs from the frame's. An adapter may state the
// number of frames in the header ("frames").
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/data/checks.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/detections/writer.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

class KinegraphSource : public DetectionSource {
 public:
  KinegraphSource(OwnLines lines, const DetectionReadOptions& options,
                  bool is_of_adapter)
      : options_(options),
        is_of_adapter_(is_of_adapter),
        lines_(std::move(lines)) {
    lines_.ReadHeader([&](const JsonObject& object) { ReadHeader(object); });
  }

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override {
    return is_of_adapter_ ? stated_frames_ : lines_.CountFrames();
  }

  BadFrames bad_frames() const override { return bad_; }

  bool Next(DetectionFrame* frame) override {
    // Gives up on input that is unreadable throughout.
    constexpr int kMostInARow = 1000;
    for (int bad = 1;; ++bad) {
      try {
        return lines_.ReadFrame(
            [&](const JsonObject& object) { ReadFrame(object, frame); });
      } catch (const InputError& error) {
        if (!options_.skip_bad_frames || bad == kMostInARow) throw;
        ++bad_.count;
        bad_.last = error.what();
      }
    }
  }

 private:
  template <typename Target>
  using Key = JsonKey<KinegraphSource, Target>;

  // ---- The header ----

  void ReadHeader(const JsonObject& object) {
    using Self = KinegraphSource;
    static constexpr Key<DetectionHeader> kKeys[] = {
        {"kinegraph_detections", Presence::kRequired, &Self::AcceptVersion},
        {"skeleton", Presence::kRequired, &Self::AcceptSkeleton},
        {"frame_rate", Presence::kOptional, &Self::AcceptFrameRate},
        {"views", Presence::kRequired, &Self::AcceptViewNames},
        {"frames", Presence::kOptional, &Self::AcceptFrameCount}};
    ReadKeys(object, kKeys, this, &header_);
    header_.frame_rate_hz =
        ChooseFrameRate(options_.frame_rate_hz, header_.frame_rate_hz,
                        options_.refuse_other_rate);
    if (options_.skeleton) OverrideSkeleton();
  }

  void AcceptVersion(JsonValue value, std::string_view key, DetectionHeader*) {
    AsInteger(value, key, 1, 1);
  }
  void AcceptSkeleton(JsonValue value, std::string_view,
                      DetectionHeader* header) {
    header->skeleton =
        is_of_adapter_ ? ReadStatedSkeleton(value) : ReadSkeleton(value);
  }
  void AcceptFrameCount(JsonValue value, std::string_view key,
                        DetectionHeader*) {
    if (!value.is_null()) stated_frames_ = AsFrame(value, key);
  }
  void AcceptFrameRate(JsonValue value, std::string_view key,
                       DetectionHeader* header) {
    header->frame_rate_hz = AsFrameRate(value, key);
  }
  void AcceptViewNames(JsonValue value, std::string_view key,
                       DetectionHeader* header) {
    for (const JsonValue name : AsArray(value, key)) {
      header->view_names.emplace_back(AsText(name, key));
    }
    CheckDetectionHeader(*header);
  }

  void OverrideSkeleton() {
    if (options_.skeleton->joint_count() != header_.skeleton.joint_count()) {
      throw InputError("skeleton: found " +
                       std::to_string(header_.skeleton.joint_count()) +
                       " joints, but detections.skeleton has " +
                       std::to_string(options_.skeleton->joint_count()));
    }
    header_.skeleton = *options_.skeleton;
  }

  size_t ViewOf(std::string_view name) const {
    const auto& names = header_.view_names;
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
      throw InputError("views: '" + Printable(std::string(name)) +
                       "' is not named in the header");
    }
    return static_cast<size_t>(at - names.begin());
  }

  // ---- A frame ----

  void ReadFrame(const JsonObject& object, DetectionFrame* frame) {
    using Self = KinegraphSource;
    static constexpr Key<DetectionFrame> kKeys[] = {
        {"frame", Presence::kRequired, &Self::TakeFrame},
        {"time", Presence::kOptional, &Self::AcceptTime},
        {"views", Presence::kRequired, &Self::AcceptViews},
        {"capture_times", Presence::kOptional, &Self::TakeCaptureTimes},
        {"view_times", Presence::kOptional, &Self::TakeCaptureTimes}};
    frame->views.resize(header_.view_names.size());
    for (ViewDetections& view : frame->views) view.detections.clear();
    has_time_ = false;
    capture_times_.reset();
    ReadKeys(object, kKeys, this, frame);
    lines_.CheckFrame(frame->frame);
    SetTimes(frame);
  }

  void TakeFrame(JsonValue value, std::string_view key, DetectionFrame* frame) {
    frame->frame = AsFrame(value, key);
  }
  void AcceptTime(JsonValue value, std::string_view key,
                  DetectionFrame* frame) {
    frame->time = AsTime(value, key);
    has_time_ = true;
  }
  // Stored until the frame's own time is known.
  void TakeCaptureTimes(JsonValue value, std::string_view key,
                        DetectionFrame*) {
    if (capture_times_.has_value()) {
      throw InputError(
          "view_times: given together with capture_times, its synonym");
    }
    capture_times_ = AsObject(value, key);
    capture_key_ = key;
  }

  void SetTimes(DetectionFrame* frame) {
    if (!has_time_) {
      frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    }
    had_time_ = had_time_ || has_time_;
    if (had_time_ && !options_.any_clock && last_time_.has_value() &&
        frame->time <= *last_time_) {
      throw InputError("time: found " + std::to_string(ToSeconds(frame->time)) +
                       (has_time_ ? "" : " (frame / frame_rate)") + " after " +
                       std::to_string(ToSeconds(*last_time_)) +
                       ", expected times to ascend");
    }
    last_time_ = frame->time;
    for (ViewDetections& view : frame->views) view.capture_time = frame->time;
    if (!capture_times_.has_value()) return;
    for (const auto field : *capture_times_) {
      const TimeNs time = AsTime(field.value, capture_key_);
      CheckCaptureTime(std::string(field.key), time, frame->time);
      frame->views[ViewOf(field.key)].capture_time = time;
    }
  }

  void AcceptViews(JsonValue value, std::string_view key,
                   DetectionFrame* frame) {
    const JsonObject views = AsObject(value, key);
    seen_views_.assign(header_.view_names.size(), false);
    for (const auto field : views) {
      const size_t view_idx = ViewOf(field.key);
      if (seen_views_[view_idx]) {
        throw InputError("views: '" + header_.view_names[view_idx] +
                         "' appears twice");
      }
      seen_views_[view_idx] = true;
      std::vector<Detection>& detections = frame->views[view_idx].detections;
      for (const JsonValue person : AsArray(field.value, field.key)) {
        detections.emplace_back();
        detections.back().index_in_file =
            static_cast<int>(detections.size()) - 1;
        ReadJoints(Required(AsObject(person, field.key), "joints"),
                   &detections.back());
      }
    }
  }

  void ReadJoints(JsonValue value, Detection* detection) {
    const auto count = static_cast<size_t>(header_.skeleton.joint_count());
    detection->joints.reserve(count);
    for (const JsonValue joint : AsArray(value, "joints")) {
      if (joint.is_null()) {
        detection->joints.emplace_back();
        continue;
      }
      double numbers[3];
      AsNumbers(joint, "joints", 3, numbers);
      detection->joints.push_back(MakeKeypoint(
          numbers[0], numbers[1], numbers[2], options_.zero_confidence));
    }
    CheckCount("joints", detection->joints.size(), count, "");
  }

  const DetectionReadOptions options_;
  const bool is_of_adapter_;  // through a pipe
  OwnLines lines_;
  DetectionHeader header_;
  int64_t stated_frames_ = -1;
  BadFrames bad_;
  std::optional<TimeNs> last_time_;
  bool had_time_ = false;                    // any frame has stated its time
  bool has_time_ = false;                    // the current frame states it
  std::optional<JsonObject> capture_times_;  // of the current frame
  std::string_view capture_key_;
  std::vector<bool> seen_views_;
};

}  // namespace

std::unique_ptr<DetectionSource> OpenLines(const std::string& name,
                                           const DetectionReadOptions& options,
                                           int pipe, int silence_ms) {
  return std::make_unique<KinegraphSource>(OwnLines(name, pipe, silence_ms),
                                           options, /*is_of_adapter=*/true);
}

bool RecogniseKinegraph(const DetectionHead& head) {
  return head.HasKey("kinegraph_detections");
}

std::unique_ptr<DetectionSource> OpenKinegraph(
    const std::string& path, const DetectionReadOptions& options) {
  return std::make_unique<KinegraphSource>(OwnLines(path), options,
                                           /*is_of_adapter=*/false);
}

void WriteKinegraph(const std::string& path, const DetectionWriteOptions&,
                    DetectionSource* source, LostFields* lost_fields) {
  if (!(source->header().frame_rate_hz > 0.0)) {
    lost_fields->push_back("the frame rate is not known (--frame_rate=HZ)");
  }
  DetectionWriter writer(path, source->header());
  WriteFrames(
      source, /*skeleton_known=*/true, lost_fields,
      [&](const DetectionFrame& frame) { writer.Write(frame); },
      /*rate_known=*/true, /*keeps_times=*/true);
  writer.Commit();
}

// ---- Writing ----

class DetectionWriter::Impl {
 public:
  Impl(const std::string& path, const DetectionHeader& header)
      : file_(path),
        joint_count_(header.skeleton.joints().size()),
        has_clock_(header.frame_rate_hz > 0.0) {
    for (const std::string& name : header.view_names) {
      views_.push_back(JsonText(name));
    }
    CheckDetectionHeader(header);
    WriteHeader(header);
  }

  void Write(const DetectionFrame& frame) {
    if (frame.frame <= last_frame_ || frame.views.size() != views_.size()) {
      throw std::logic_error("detections of frame " +
                             std::to_string(frame.frame) +
                             " do not fit the file that is being written");
    }
    const bool is_first = last_frame_ < 0;
    last_frame_ = frame.frame;
    has_clock_ = has_clock_ || frame.time != 0;
    // Whether the 0 of the first frame is its time, or means that times are
    // unknown, follows from the time of the second frame.
    if (is_first && !has_clock_) {
      waiting_ = frame;
      return;
    }
    WriteWaiting();
    WriteLine(frame);
  }

  void Commit() {
    WriteWaiting();
    file_.Commit();
  }

 private:
  void WriteWaiting() {
    if (waiting_.has_value()) WriteLine(*waiting_);
    waiting_.reset();
  }

  void WriteLine(const DetectionFrame& frame) {
    out_.Add("{\"frame\": ", frame.frame);
    // Without a frame rate and without times in the input, all times are 0.
    // They are omitted, so that a reader that is given the rate can compute
    // them.
    if (has_clock_) {
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
    if (!joint.found) return out_.Text("null");
    out_.Text("[");
    out_.Numbers({joint.px.x(), joint.px.y(), joint.confidence});
    out_.Text("]");
  }

  // Lists only views whose time differs from the frame's.
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
  bool has_clock_;
  std::optional<DetectionFrame> waiting_;
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

void WriteDetections(const std::string& path,
                     const DetectionSequence& sequence) {
  DetectionWriter writer(path, sequence.header);
  for (const DetectionFrame& frame : sequence.frames) writer.Write(frame);
  writer.Commit();
}

}  // namespace kinegraph
