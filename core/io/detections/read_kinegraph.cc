// Our own detections, JSON Lines. Header: {"kinegraph_detections": 1,
// "skeleton": {...}, "frame_rate": 25.0, "views": ["cam0", ...]}; then a line a
// frame: {"frame": 300, "time": 12.0, "views": {"cam0": [{"joints":
// [[x, y, c] or null, ...]}, ...]}, "capture_times": {"cam0": 12.001}}.
// capture_times, also called view_times, names only views whose clock is not
// the frame's.
#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/io/detections/export.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

class KinegraphSource : public DetectionSource {
 public:
  KinegraphSource(const std::string& path, const DetectionReadOptions& options)
      : options_(options), lines_(path) {
    JsonValue line;
    if (!lines_.Next(&line)) {
      throw InputError(path, "", "is empty, expected a header line");
    }
    Locate([&] { ReadHeader(AsObject(line, "the header")); });
  }

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override {
    const int64_t lines = lines_.CountLines();
    return lines < 0 ? -1 : lines - 1;
  }

  bool Next(DetectionFrame* frame) override {
    JsonValue line;
    if (!lines_.Next(&line)) return false;
    Locate([&] { ReadFrame(AsObject(line, "the frame"), frame); });
    return true;
  }

 private:
  template <typename Read>
  void Locate(const Read& read) const {
    Located(
        lines_.path(), [&] { return lines_.Place(); }, read);
  }

  void ReadHeader(const JsonObject& object) {
    ObjectKeys keys(
        {"kinegraph_detections", "skeleton", "frame_rate", "views"});
    for (const auto field : object) {
      switch (keys.Take(field.key)) {
        case 0:
          AsInteger(field.value, field.key, 1, 1);
          break;
        case 1:
          header_.skeleton = ReadSkeleton(field.value);
          break;
        case 2:
          header_.frame_rate_hz = AsFrameRate(field.value, field.key);
          break;
        case 3:
          ReadViewNames(AsArray(field.value, field.key));
          break;
        default:
          break;
      }
    }
    keys.Require(0);
    keys.Require(1);
    keys.Require(3);
    if (options_.frame_rate_hz > 0.0) {
      header_.frame_rate_hz = options_.frame_rate_hz;
    }
    if (options_.skeleton) OverrideSkeleton();
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

  void ReadViewNames(const JsonArray& names) {
    for (const JsonValue name : names) {
      const std::string text(AsText(name, "views"));
      if (FindView(text) >= 0) {
        throw InputError("views: '" + Printable(text) + "' stands there twice");
      }
      header_.view_names.push_back(text);
    }
    if (header_.view_names.empty()) throw InputError("views: is empty");
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

  void ReadFrame(const JsonObject& object, DetectionFrame* frame) {
    frame->views.resize(header_.view_names.size());
    for (ViewDetections& view : frame->views) view.detections.clear();
    ObjectKeys keys({"frame", "time", "views", "capture_times", "view_times"});
    JsonObject capture_times;
    for (const auto field : object) {
      switch (keys.Take(field.key)) {
        case 0:
          frame->frame = AsFrame(field.value, field.key);
          break;
        case 1:
          frame->time = AsTime(field.value, field.key);
          break;
        case 2:
          ReadViews(AsObject(field.value, field.key), frame);
          break;
        case 3:
        case 4:
          if (keys.Has(3) && keys.Has(4)) {
            throw InputError(
                "view_times: stands beside capture_times, which "
                "says the same");
          }
          capture_times = AsObject(field.value, field.key);
          break;
        default:
          break;
      }
    }
    keys.Require(0);
    keys.Require(2);
    if (frame->frame <= last_frame_) {
      throw InputError("frame: found " + std::to_string(frame->frame) +
                       " after " + std::to_string(last_frame_) +
                       ", expected frames to ascend");
    }
    last_frame_ = frame->frame;
    if (!keys.Has(1)) {
      frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    } else if (last_time_.has_value() && frame->time <= *last_time_) {
      throw InputError("time: found " + std::to_string(ToSeconds(frame->time)) +
                       " after " + std::to_string(ToSeconds(*last_time_)) +
                       ", expected times to ascend");
    }
    last_time_ = frame->time;
    for (ViewDetections& view : frame->views) view.capture_time = frame->time;
    if (keys.Has(3) || keys.Has(4)) {
      const char* const name = keys.Has(3) ? "capture_times" : "view_times";
      for (const auto field : capture_times) {
        frame->views[ViewOf(field.key)].capture_time =
            AsTime(field.value, name);
      }
    }
  }

  void ReadViews(const JsonObject& views, DetectionFrame* frame) {
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
  JsonLineReader lines_;
  DetectionHeader header_;
  int64_t last_frame_ = -1;
  std::optional<TimeNs> last_time_;
  std::vector<bool> seen_views_;
};

std::unique_ptr<DetectionSource> Open(const std::string& path,
                                      const DetectionReadOptions& options) {
  return std::make_unique<KinegraphSource>(path, options);
}

bool Recognise(const DetectionHead& head) {
  return head.HasKey("kinegraph_detections");
}

}  // namespace

DetectionFormat KinegraphDetectionFormat() {
  DetectionFormat format;
  format.name = "kinegraph";
  format.layout = "JSON Lines";
  format.extension = ".jsonl";
  format.files = DetectionFormat::Files::kOne;
  format.recognise = Recognise;
  format.open = Open;
  format.write = WriteKinegraphDetections;
  return format;
}

}  // namespace kinegraph
