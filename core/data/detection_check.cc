#include "core/data/detection_check.h"

#include <cmath>

#include "core/base/error.h"

namespace kinegraph {
namespace {

constexpr double kLongestLag_s = 10.0;
// Differences of two times fit a TimeNs: 145 years before and after 1970.
constexpr TimeNs kLatestTime = 4'600'000'000'000'000'000;

void CheckCount(const std::string& of, const char* what, size_t found,
                size_t expected) {
  if (found == expected) return;
  throw InputError(of + ": found " + std::to_string(found) + " " + what +
                   ", expected " + std::to_string(expected));
}

}  // namespace

void CheckCaptureTime(const std::string& view, TimeNs capture_time,
                      TimeNs frame_time) {
  // In doubles: the difference of any two times would not fit a TimeNs.
  const double lag_s = ToSeconds(capture_time) - ToSeconds(frame_time);
  if (std::abs(lag_s) <= kLongestLag_s) return;
  throw InputError("view_times: '" + Printable(view) + "' has " +
                   std::to_string(ToSeconds(capture_time)) +
                   " s in a frame of " + std::to_string(ToSeconds(frame_time)) +
                   " s, expected clocks within 10 s of each other");
}

void CheckDetectionFrame(const DetectionHeader& header,
                         const DetectionFrame& frame) {
  const std::string name = "frame " + std::to_string(frame.frame);
  CheckCount(name, "views", frame.views.size(), header.view_names.size());
  if (frame.time > kLatestTime || frame.time < -kLatestTime) {
    throw InputError(name + ": found a time of " +
                     std::to_string(ToSeconds(frame.time)) +
                     " s, expected at most 4.6e9 s");
  }
  const auto joints = static_cast<size_t>(header.skeleton.joint_count());
  for (size_t v = 0; v < frame.views.size(); ++v) {
    const ViewDetections& view = frame.views[v];
    const std::string& view_name = header.view_names[v];
    CheckCaptureTime(view_name, view.capture_time, frame.time);
    for (const Detection& detection : view.detections) {
      const auto of = [&] {
        return name + ", view '" + Printable(view_name) + "'";
      };
      if (detection.joints.size() != joints) {
        CheckCount(of(), "joints", detection.joints.size(), joints);
      }
      for (const Keypoint& joint : detection.joints) {
        if (!joint.found ||
            (joint.px.allFinite() && std::isfinite(joint.confidence))) {
          continue;
        }
        throw InputError(of() + ": a joint that was found is not finite");
      }
    }
  }
}

}  // namespace kinegraph
