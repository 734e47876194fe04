#include "core/io/configuration/held_out_set.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "core/base/error.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

std::string CameraName(JsonValue value) {
  if (value.is_string()) return std::string(AsText(value, "camera"));
  return std::to_string(AsFrame(value, "camera"));
}

// The view that a camera of the set means.
std::string ViewOf(const std::string& camera,
                   const std::vector<std::string>& view_names) {
  if (view_names.empty()) return camera;
  if (std::find(view_names.begin(), view_names.end(), camera) !=
      view_names.end()) {
    return camera;
  }
  const std::optional<int64_t> number = LastInteger(camera);
  std::string found;
  int matches = 0;
  for (const std::string& name : view_names) {
    if (!number || LastInteger(name) != number) continue;
    found = name;
    ++matches;
  }
  if (matches != 1) {
    throw InputError("camera: " + std::to_string(matches) + " views fit '" +
                     Printable(camera) + "', expected one");
  }
  return found;
}

double ReadLimit(const JsonObject& root, const char* key) {
  const double value = AsNumber(Required(root, key), key);
  if (!(value >= 0.0)) {
    throw InputError(std::string(key) + ": is negative, expected >= 0");
  }
  return value;
}

HeldOutDetection ReadEntry(const JsonObject& entry,
                           const std::vector<std::string>& view_names) {
  HeldOutDetection detection;
  detection.view_name =
      ViewOf(CameraName(Required(entry, "camera")), view_names);
  detection.frame = AsFrame(Required(entry, "frame"), "frame");
  detection.detection_idx =
      static_cast<int>(AsInteger(Required(entry, "detection"), "detection", 0,
                                 std::numeric_limits<int>::max()));
  detection.person = TrackId(AsId(Required(entry, "person"), "person"));
  return detection;
}

}  // namespace

HeldOutSet ReadHeldOutSet(const std::string& path,
                          const std::vector<std::string>& view_names) {
  JsonFileParser parser;
  const JsonValue value = parser.Parse(path);
  std::string place;
  return Located(
      path, [&] { return place; },
      [&] {
        const JsonObject root = AsObject(value, kOutermost);
        HeldOutSet set;
        set.min_confidence = ReadLimit(root, "confidence_at_least");
        set.cap_px = ReadLimit(root, "cap_px");
        set.pairing_gate_m = ReadLimit(root, "pairing_gate_m");
        for (const JsonValue entry : AsArray(Required(root, "set"), "set")) {
          place = "set[" + std::to_string(set.detections.size()) + "]";
          set.detections.push_back(
              ReadEntry(AsObject(entry, "set"), view_names));
        }
        return set;
      });
}

}  // namespace kinegraph
