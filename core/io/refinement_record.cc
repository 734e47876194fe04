#include "core/io/refinement_record.h"

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/io/json.h"
#include "core/io/text_file.h"

namespace kinegraph {
namespace {

RefinementRecord::Camera CameraOf(const JsonField& field) {
  RefinementRecord::Camera camera;
  camera.name = field.At("name").Text();
  if (const auto clock = field.Find("clock")) {
    camera.offset_s = clock->At("offset_s").Number();
    camera.drift = clock->At("drift").Number();
  }
  return camera;
}

}  // namespace

bool RefinementRecord::has_clocks() const {
  return std::any_of(cameras.begin(), cameras.end(), [](const Camera& c) {
    return c.offset_s != 0.0 || c.drift != 0.0;
  });
}

std::optional<RefinementRecord> ReadRefinementRecord(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  const std::string text = ReadTextFile(path);
  // Other formats, and our own without a record, are not looked at further.
  if (text.find("\"kinegraph_cameras\"") == std::string::npos ||
      text.find("\"refinement\"") == std::string::npos) {
    return std::nullopt;
  }
  const Json json = ParseJson(text, path);
  const auto root = JsonField(json, path).Find("refinement");
  if (!root.has_value()) return std::nullopt;
  RefinementRecord record;
  if (const auto zero = root->Find("clock_zero_s")) {
    record.clock_zero_s = zero->Number();
  }
  for (const JsonField& camera : root->At("cameras").Elements("camera")) {
    record.cameras.push_back(CameraOf(camera));
  }
  return record;
}

}  // namespace kinegraph
