#include "solvers/session/scene.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/io/configuration/config.h"
#include "core/io/detections/view_pairing.h"
#include "solvers/session/presence.h"

namespace kinegraph {
namespace {

bool IsNamed(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The views of a run with their cameras. Views named in `without` (by view or
// camera) are left out; if `cameras.use` selects cameras, the views of all
// other cameras are left out too.
struct UsedViews {
  std::vector<int> views;  // indices into the detections' views
  CameraRig cameras;
  PairedBy paired_by = PairedBy::kMap;
};

UsedViews ChooseViews(const RunOptions& options, const RunRequest& request,
                      const std::vector<std::string>& view_names) {
  const std::vector<std::string>& without = request.without_cameras;
  const ViewPairing pairing = PairViewsWithCameras(
      view_names, request.cameras, options.cameras.map,
      options.cameras.use.empty() ? UnpairedViews::kRefuse
                                  : UnpairedViews::kLeaveOut,
      without);
  UsedViews used;
  used.paired_by = pairing.paired_by;
  for (size_t v = 0; v < view_names.size(); ++v) {
    const int c = pairing.camera_of_view[v];
    if (c < 0 || IsNamed(without, view_names[v])) continue;
    const Camera& camera = request.cameras[c];
    if (IsNamed(without, camera.name())) continue;
    used.views.push_back(static_cast<int>(v));
    used.cameras.push_back(camera);
  }
  for (const std::string& name : without) {
    const bool known =
        IsNamed(view_names, name) ||
        std::any_of(request.cameras.begin(), request.cameras.end(),
                    [&](const Camera& c) { return c.name() == name; });
    if (!known) {
      std::string views;
      for (const std::string& view : view_names) {
        views += (views.empty() ? "" : ", ") + Printable(view);
      }
      throw InputError("--without_cameras: no view or camera is named '" +
                       Printable(name) + "', the views are " + views);
    }
  }
  if (used.views.empty()) {
    throw InputError("no view with a camera is left");
  }
  return used;
}

}  // namespace

RunScene PrepareScene(const RunOptions& options, const RunRequest& request,
                      const DetectionHeader& detections) {
  RunScene scene;
  UsedViews used = ChooseViews(options, request, detections.view_names);
  scene.used_views = std::move(used.views);
  scene.model.cameras = std::move(used.cameras);
  scene.paired_by = used.paired_by;
  for (const int v : scene.used_views) {
    scene.view_names.push_back(detections.view_names[v]);
  }
  scene.model.skeleton =
      options.skeleton.empty()
          ? detections.skeleton
          : ResolveSkeleton(options.skeleton, options.user_skeletons);
  scene.model.frame_rate_hz = detections.frame_rate_hz;
  if (!(scene.model.frame_rate_hz > 0.0)) {
    throw OptionError("input.frame_rate",
                      "not given, and the detections do not specify it [Hz]");
  }
  scene.model.kept_matches = options.output.observations ? KeptMatches::kWeights
                                                         : request.kept_matches;
  const std::vector<int> map =
      MapByName(detections.skeleton, scene.model.skeleton);
  if (std::all_of(map.begin(), map.end(), [](int j) { return j < 0; })) {
    throw OptionError("skeleton",
                      "'" + scene.model.skeleton.name() +
                          "' shares no joint with the detections' '" +
                          detections.skeleton.name() + "'");
  }
  scene.header.skeleton = scene.model.skeleton;
  scene.header.mode = ToString(options.estimators.mode);
  scene.header.frame_rate_hz = scene.model.frame_rate_hz;
  scene.header.view_names = scene.view_names;
  scene.header.config_json = EffectiveConfigJson(options);
  return scene;
}

void KeepUsedViews(const RunScene& scene, DetectionFrame* frame,
                   DetectionFrame* kept) {
  kept->frame = frame->frame;
  kept->time = frame->time;
  kept->views.resize(scene.used_views.size());
  for (size_t v = 0; v < scene.used_views.size(); ++v) {
    std::swap(kept->views[v], frame->views[scene.used_views[v]]);
  }
  DropAbsentJoints(scene.least_confidence, kept);
}

DetectionSequence UsedViewsOf(const RunScene& scene,
                              DetectionSequence detections) {
  DetectionSequence used;
  used.header = std::move(detections.header);
  used.header.view_names = scene.view_names;
  for (DetectionFrame& frame : detections.frames) {
    KeepUsedViews(scene, &frame, &used.frames.emplace_back());
  }
  return used;
}

DetectionSequence AskedFrames(const RunRequest& request,
                              const DetectionSequence& detections) {
  DetectionSequence asked;
  asked.header = detections.header;
  for (const DetectionFrame& frame : detections.frames) {
    if (ContainsFrame(request.frames, frame.frame)) {
      asked.frames.push_back(frame);
    }
  }
  return asked;
}

}  // namespace kinegraph
