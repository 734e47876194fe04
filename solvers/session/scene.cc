#include "solvers/session/scene.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/io/configuration/config.h"
#include "core/io/detections/view_pairing.h"
#include "solvers/session/presence.h"

namespace kinegraph {
RunScene PrepareScene(const RunOptions& options, const RunRequest& request,
                      const DetectionHeader& detections) {
  RunScene scene;
  UsedViews used = ChooseViews(detections.view_names, request.cameras,
                               options.cameras, request.without_cameras);
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
