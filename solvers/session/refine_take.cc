#include "solvers/session/refine_take.h"

#include <utility>

#include "solvers/scene/clock_search.h"
#include "solvers/scene/consistency.h"
#include "solvers/session/diagnose.h"

namespace kinegraph {
namespace {

// Longest lag that is looked for [s].
constexpr double kLongestLagS = 10.0;
constexpr double kMinConfidence = 0.3;

std::vector<int> LagsOf(const RunScene& scene,
                        const DetectionSequence& detections) {
  std::vector<ViewPeople> people = PeopleOfViews(detections, kMinConfidence);
  for (size_t v = 0; v < people.size(); ++v) {
    people[v] = Undistorted(people[v], scene.model.cameras[v]);
  }
  const auto longest =
      static_cast<int>(kLongestLagS * scene.model.frame_rate_hz);
  return SearchClocks(scene.model.cameras, people, longest).lag_frames;
}

// The changes of all views of the take: none for those that are not used.
std::vector<CameraChange> ChangesOfAll(const RunScene& scene, size_t views,
                                       const Refinement& refinement) {
  std::vector<CameraChange> all(views, CameraChange::Zero());
  for (size_t v = 0; v < scene.used_views.size(); ++v) {
    all[static_cast<size_t>(scene.used_views[v])] = refinement.changes[v];
  }
  return all;
}

}  // namespace

RefinedTake RefineTake(const RunOptions& options, const RunRequest& request,
                       const DetectionSequence& detections) {
  const RunScene scene = PrepareScene(options, request, detections.header);
  DetectionSequence asked;
  asked.header = detections.header;
  DetectionSequence used;
  used.header = detections.header;
  used.header.view_names = scene.view_names;
  for (DetectionFrame frame : detections.frames) {
    if (!ContainsFrame(request.frames, frame.frame)) continue;
    asked.frames.push_back(frame);
    KeepUsedViews(scene, &frame, &used.frames.emplace_back());
  }
  std::vector<int> lags(scene.used_views.size(), 0);
  if (options.refine.refine_clock && scene.used_views.size() > 1) {
    lags = LagsOf(scene, used);
    used = Realigned(used, lags);
  }
  RefinedTake take;
  take.stated = scene.model.cameras;
  take.refinement =
      RefineScene(scene.model.cameras, used,
                  MatchTake(options, scene.model, used), options.refine);
  for (size_t v = 0; v < lags.size(); ++v) {
    // The frames were moved by whole beats already.
    take.refinement.changes[v][kOffsetAt] -=
        lags[v] / scene.model.frame_rate_hz;
  }
  const CameraRig refined =
      RefinedCameras(take.stated, take.refinement.changes);
  take.cameras = request.cameras;
  for (Camera& camera : take.cameras) {
    for (const Camera& one : refined) {
      if (one.name() == camera.name()) camera = one;
    }
  }
  take.detections =
      WithClocks(asked, ChangesOfAll(scene, detections.header.view_names.size(),
                                     take.refinement));
  return take;
}

}  // namespace kinegraph
