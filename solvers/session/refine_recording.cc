#include "solvers/session/refine_recording.h"

#include <algorithm>
#include <utility>

#include "solvers/cameras/refine.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/view_agreement.h"
#include "solvers/session/diagnose.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {
namespace {

std::vector<int> LagsOf(const RunScene& scene,
                        const DetectionSequence& detections) {
  const std::vector<ViewPeople> people = Undistorted(
      PeopleOfViews(detections, kMinJointConfidence), scene.model.cameras);
  const auto longest =
      static_cast<int>(kLongestLagS * scene.model.frame_rate_hz);
  return SearchClocks(scene.model.cameras, people, longest).lag_frames;
}

RefinementRecord RecordOf(const RunScene& scene, const Refinement& refinement,
                          double clock_zero_s) {
  RefinementRecord record;
  record.clock_zero_s = clock_zero_s;
  record.covariance = refinement.covariance;
  for (size_t v = 0; v < scene.model.cameras.size(); ++v) {
    const CameraChange& change = refinement.changes[v];
    record.cameras.push_back({scene.model.cameras[v].name(), change[kOffsetAt],
                              change[kDriftAt], refinement.places[v]});
  }
  return record;
}

// `detections` of all views with the record's clocks; those that the run does
// not use, and cameras that the record does not know, stay as they are.
DetectionSequence Clocked(const RunScene& scene, const RefinementRecord& record,
                          const DetectionSequence& detections) {
  std::vector<CameraChange> changes(detections.header.view_names.size(),
                                    CameraChange::Zero());
  const double moved_s = MiddleOf(detections) - record.clock_zero_s;
  for (size_t v = 0; v < scene.used_views.size(); ++v) {
    for (const RefinementRecord::Camera& camera : record.cameras) {
      if (camera.name != scene.model.cameras[v].name()) continue;
      CameraChange& change = changes[static_cast<size_t>(scene.used_views[v])];
      change[kOffsetAt] = camera.offset_s + camera.drift * moved_s;
      change[kDriftAt] = camera.drift;
    }
  }
  return WithClocks(detections, changes);
}

DetectionSequence Asked(const RunRequest& request,
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

// The frames with the views that have a camera.
DetectionSequence UsedViewsOf(const RunScene& scene,
                              const DetectionSequence& detections) {
  DetectionSequence used;
  used.header = detections.header;
  used.header.view_names = scene.view_names;
  for (DetectionFrame frame : detections.frames) {
    KeepUsedViews(scene, &frame, &used.frames.emplace_back());
  }
  return used;
}

// `cameras`, each replaced by the one of its name in `others`, if any.
CameraRig WithNamesakes(CameraRig cameras, const CameraRig& others) {
  for (Camera& camera : cameras) {
    for (const Camera& other : others) {
      if (other.name() == camera.name()) camera = other;
    }
  }
  return cameras;
}

}  // namespace

double MiddleOf(const DetectionSequence& detections) {
  if (detections.frames.empty()) return 0.0;
  const TimeNs first = detections.frames.front().time;
  return ToSeconds(first + (detections.frames.back().time - first) / 2);
}

RefinedRecording RefineRecording(const RunOptions& options,
                                 const RunRequest& request,
                                 const DetectionSequence& detections) {
  RunScene scene = PrepareScene(options, request, detections.header);
  const DetectionSequence asked = Asked(request, detections);
  DetectionSequence used = WithUsualConfidences(UsedViewsOf(scene, asked));
  std::vector<int> lags(scene.used_views.size(), 0);
  if (options.refine.refine_clock && scene.used_views.size() > 1) {
    lags = LagsOf(scene, used);
  }
  RefinedRecording recording;
  recording.stated = scene.model.cameras;
  const SubjectScale scale = ScaleOf(options, scene.model.cameras, used);
  scene.model.cameras = scale.IntoRun(std::move(scene.model.cameras));
  const RunOptions scaled = scale.IntoRun(options);
  const auto refine = [&](const DetectionSequence& detections_used) {
    recording.refinement = RefineScene(
        scene.model.cameras, detections_used,
        MatchRecording(scaled, scene.model, detections_used), options.refine);
  };
  if (std::any_of(lags.begin(), lags.end(), [](int lag) { return lag != 0; })) {
    DetectionSequence as_told = Realigned(used, lags);
    std::swap(used, as_told);
    refine(used);
    if (recording.refinement.hardly_moves) {
      // Whoever rests looks alike at any time.
      std::fill(lags.begin(), lags.end(), 0);
      used = std::move(as_told);
      refine(used);
    }
  } else {
    refine(used);
  }
  recording.refinement.lag_frames = lags;
  if (recording.refinement.any_taken()) {
    SceneModel refined = scene.model;
    refined.cameras =
        RefinedCameras(scene.model.cameras, recording.refinement.changes);
    const DetectionSequence moved =
        WithClocks(used, recording.refinement.changes);
    RefineAgain(scene.model.cameras, moved,
                MatchRecording(scaled, refined, moved), BundleOptions(),
                &recording.refinement);
  }
  for (size_t v = 0; v < lags.size(); ++v) {
    // The frames were moved by whole beats already.
    recording.refinement.changes[v][kOffsetAt] -=
        lags[v] / scene.model.frame_rate_hz;
  }
  scale.IntoWorld(&recording.refinement);
  recording.cameras = WithNamesakes(
      request.cameras,
      RefinedCameras(recording.stated, recording.refinement.changes));
  recording.record = RecordOf(scene, recording.refinement, MiddleOf(asked));
  recording.detections = Clocked(scene, recording.record, asked);
  return recording;
}

DetectionSequence WithRecordedClocks(const RunOptions& options,
                                     const RunRequest& request,
                                     const RefinementRecord& record,
                                     const DetectionSequence& detections) {
  return Clocked(PrepareScene(options, request, detections.header), record,
                 Asked(request, detections));
}

std::unique_ptr<CameraUncertainty> UncertaintyOf(
    const RefinementRecord& record, const RunScene& scene,
    const Skeleton& detection_skeleton) {
  if (record.covariance.rows() == 0) return nullptr;
  // Rows of the record's cameras, for those that the run uses.
  std::vector<std::vector<int>> places;
  std::vector<Eigen::Index> rows;
  for (const Camera& camera : scene.model.cameras) {
    places.emplace_back();
    Eigen::Index at = 0;
    for (const RefinementRecord::Camera& one : record.cameras) {
      if (one.name == camera.name()) {
        places.back() = one.places;
        for (size_t i = 0; i < one.places.size(); ++i) {
          rows.push_back(at + static_cast<Eigen::Index>(i));
        }
      }
      at += static_cast<Eigen::Index>(one.places.size());
    }
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  if (size == 0) return nullptr;
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index k = 0; k < size; ++k) {
      covariance(i, k) = record.covariance(rows[static_cast<size_t>(i)],
                                           rows[static_cast<size_t>(k)]);
    }
  }
  return std::make_unique<CameraUncertainty>(
      scene.model.cameras, places, covariance,
      MapByName(detection_skeleton, scene.model.skeleton), record.clock_zero_s);
}

}  // namespace kinegraph
