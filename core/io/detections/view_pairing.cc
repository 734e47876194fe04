#include "core/io/detections/view_pairing.h"

#include <algorithm>
#include <optional>

#include "core/base/error.h"

namespace kinegraph {
namespace {

constexpr int kNone = -1;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Digits of the last number of a name without leading zeros; compared as text,
// so that no number is too large.
std::optional<std::string> LastDigits(const std::string& name) {
  auto end = name.size();
  while (end > 0 && !IsDigit(name[end - 1])) --end;
  if (end == 0) return std::nullopt;
  auto begin = end;
  while (begin > 0 && IsDigit(name[begin - 1])) --begin;
  while (begin + 1 < end && name[begin] == '0') ++begin;
  return name.substr(begin, end - begin);
}

// The first names of a list, for a message.
std::string Listed(const std::vector<std::string>& names) {
  constexpr size_t kShown = 8;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    text += (i == 0 ? "'" : ", '") + Printable(names[i]) + "'";
  }
  if (names.size() > kShown) {
    text += " and " + std::to_string(names.size() - kShown) + " more";
  }
  return text;
}

std::vector<std::string> NamesOf(const CameraRig& cameras) {
  std::vector<std::string> names;
  for (const Camera& camera : cameras) names.push_back(camera.name());
  return names;
}

int IndexOf(const std::vector<std::string>& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  return at == names.end() ? kNone : static_cast<int>(at - names.begin());
}

int CameraByNumber(const std::string& view,
                   const std::vector<std::string>& cameras,
                   UnpairedViews unpaired) {
  const std::optional<std::string> number = LastDigits(view);
  std::vector<std::string> candidates;
  if (number.has_value()) {
    for (const std::string& camera : cameras) {
      if (LastDigits(camera) == number) candidates.push_back(camera);
    }
  }
  if (candidates.size() == 1) return IndexOf(cameras, candidates.front());
  if (candidates.empty() && unpaired == UnpairedViews::kLeaveOut) return kNone;
  if (candidates.empty()) {
    throw InputError("view '" + Printable(view) +
                     "' has no camera of the same name or number among " +
                     Listed(cameras) + "; cameras.map can name one");
  }
  throw InputError("view '" + Printable(view) + "' may belong to " +
                   Listed(candidates) +
                   "; cameras.map (or cameras.use) must decide");
}

// Every name that the map uses must exist.
void CheckMap(const std::vector<std::string>& views,
              const std::vector<std::string>& cameras,
              const std::map<std::string, std::string>& map) {
  for (const auto& [view, camera] : map) {
    if (IndexOf(views, view) == kNone) {
      throw InputError("cameras.map names view '" + Printable(view) +
                       "', the views are " + Listed(views));
    }
    if (IndexOf(cameras, camera) == kNone) {
      throw InputError("cameras.map gives view '" + Printable(view) +
                       "' camera '" + Printable(camera) +
                       "', the cameras are " + Listed(cameras));
    }
  }
}

}  // namespace

std::vector<int> PairViewsWithCameras(
    const std::vector<std::string>& view_names, const CameraRig& cameras,
    const std::map<std::string, std::string>& map, UnpairedViews unpaired) {
  const std::vector<std::string> camera_names = NamesOf(cameras);
  CheckMap(view_names, camera_names, map);
  std::vector<int> camera_of_view;
  std::vector<int> view_of_camera(cameras.size(), kNone);
  for (size_t v = 0; v < view_names.size(); ++v) {
    const std::string& view = view_names[v];
    const auto mapped = map.find(view);
    int camera =
        IndexOf(camera_names, mapped == map.end() ? view : mapped->second);
    if (camera == kNone) {
      camera = CameraByNumber(view, camera_names, unpaired);
    }
    if (camera == kNone) {
      camera_of_view.push_back(kNone);
      continue;
    }
    int& owner = view_of_camera[static_cast<size_t>(camera)];
    if (owner != kNone) {
      throw InputError(
          "views '" + Printable(view_names[static_cast<size_t>(owner)]) +
          "' and '" + Printable(view) + "' both belong to camera '" +
          Printable(camera_names[static_cast<size_t>(camera)]) +
          "'; cameras.map must decide");
    }
    owner = static_cast<int>(v);
    camera_of_view.push_back(camera);
  }
  return camera_of_view;
}

CameraRig CamerasOfViews(const std::vector<std::string>& view_names,
                         const CameraRig& cameras,
                         const std::map<std::string, std::string>& map) {
  CameraRig paired;
  for (const int camera : PairViewsWithCameras(view_names, cameras, map)) {
    paired.push_back(cameras[static_cast<size_t>(camera)]);
  }
  return paired;
}

}  // namespace kinegraph
