// Our own detections, JSON Lines. Header: {"kinegraph_detections": 1,
// "skeleton": {...}, "frame_rate": 25.0, "views": ["cam0", ...]}; then a line a
// frame: {"frame": 300, "time": 12.0, "views": {"cam0": [{"joints":
// [[x, y, c] or null, ...]}, ...]}, "capture_times": {"cam0": 12.001}}.
// capture_times, also called view_times, names only views whose clock is not
// the frame's.
#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/data/detection_check.h"
#include "core/io/detections/export.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/own_lines.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

class KinegraphSource : public DetectionSource {
 public:
  KinegraphSource(const std::string& path, const DetectionReadOptions& options)
      : options_(options), lines_(path) {
    lines_.ReadHeader([&](const JsonObject& object) { ReadHeader(object); });
  }

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override { return lines_.CountFrames(); }

  BadFrames bad_frames() const override { return bad_; }

  bool Next(DetectionFrame* frame) override {
    // What cannot be read at all must not be tried for ever.
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
        {"views", Presence::kRequired, &Self::AcceptViewNames}};
    ReadKeys(object, kKeys, this, &header_);
    if (options_.frame_rate_hz > 0.0) {
      header_.frame_rate_hz = options_.frame_rate_hz;
    }
    if (options_.skeleton) OverrideSkeleton();
  }

  void AcceptVersion(JsonValue value, std::string_view key, DetectionHeader*) {
    AsInteger(value, key, 1, 1);
  }
  void AcceptSkeleton(JsonValue value, std::string_view,
                      DetectionHeader* header) {
    header->skeleton = ReadSkeleton(value);
  }
  void AcceptFrameRate(JsonValue value, std::string_view key,
                       DetectionHeader* header) {
    header->frame_rate_hz = AsFrameRate(value, key);
  }
  void AcceptViewNames(JsonValue value, std::string_view key,
                       DetectionHeader* header) {
    for (const JsonValue name : AsArray(value, key)) {
      const std::string text(AsText(name, key));
      if (FindView(text) >= 0) {
        throw InputError("views: '" + Printable(text) + "' stands there twice");
      }
      header->view_names.push_back(text);
    }
    if (header->view_names.empty()) throw InputError("views: is empty");
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

  int FindView(std::string_view name) const {
    const auto& names = header_.view_names;
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? -1 : static_cast<int>(at - names.begin());
  }

  size_t ViewOf(std::string_view name) const {
    const int view_idx = FindView(name);
    if (view_idx < 0) {
      throw InputError("views: '" + Printable(std::string(name)) +
                       "' is not named in the header");
    }
    return static_cast<size_t>(view_idx);
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
  // Read when the frame's own time is known.
  void TakeCaptureTimes(JsonValue value, std::string_view key,
                        DetectionFrame*) {
    if (capture_times_.has_value()) {
      throw InputError(
          "view_times: stands beside capture_times, which says the same");
    }
    capture_times_ = AsObject(value, key);
    capture_key_ = key;
  }

  void SetTimes(DetectionFrame* frame) {
    if (!has_time_) {
      frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    } else if (!options_.any_clock && last_time_.has_value() &&
               frame->time <= *last_time_) {
      throw InputError("time: found " + std::to_string(ToSeconds(frame->time)) +
                       " after " + std::to_string(ToSeconds(*last_time_)) +
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
                         "' stands there twice");
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
    if (detection->joints.size() != count) {
      throw InputError("joints: found " +
                       std::to_string(detection->joints.size()) +
                       ", expected " + std::to_string(count));
    }
  }

  const DetectionReadOptions options_;
  OwnLines lines_;
  DetectionHeader header_;
  BadFrames bad_;
  std::optional<TimeNs> last_time_;
  bool has_time_ = false;                    // of one frame
  std::optional<JsonObject> capture_times_;  // of one frame
  std::string_view capture_key_;
  std::vector<bool> seen_views_;
};

std::unique_ptr<DetectionSource> OpenKinegraphFile(
    const std::string& path, const DetectionReadOptions& options) {
  return std::make_unique<KinegraphSource>(path, options);
}

bool RecogniseKinegraph(const DetectionHead& head) {
  return head.HasKey("kinegraph_detections");
}

}  // namespace

DetectionFormat KinegraphDetectionFormat() {
  DetectionFormat format;
  format.name = "kinegraph";
  format.layout = "JSON Lines";
  format.extension = ".jsonl";
  format.files = DetectionFormat::Files::kOne;
  format.recognise = RecogniseKinegraph;
  format.open = OpenKinegraphFile;
  format.write = WriteKinegraphDetections;
  return format;
}

}  // namespace kinegraph
