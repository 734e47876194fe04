#include "solvers/session/ready_recording.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/clock_search.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/view_agreement.h"
#include "solvers/session/diagnose.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {
namespace {

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

// `detections` with the clocks of the record applied; views that the run does
// not use, or whose camera has no record, are unchanged.
DetectionSequence Clocked(const RunScene& scene, const RefinementRecord& record,
                          const DetectionSequence& detections) {
  std::vector<CameraChange> changes(detections.header.view_names.size(),
                                    CameraChange::Zero());
  const double moved_s = MiddleOf(detections) - record.clock_zero_s;
  for (size_t v = 0; v < scene.used_views.size(); ++v) {
    for (const RefinementRecord::Camera& camera : record.cameras) {
      if (camera.name != scene.model.cameras[v].name()) continue;
      CameraChange& change = changes[scene.used_views[v]];
      change[kOffsetAt] = camera.offset_s + camera.drift * moved_s;
      change[kDriftAt] = camera.drift;
    }
  }
  return WithClocks(detections, changes);
}

// Whether parameters of cameras, not only of clocks, were estimated.
bool EstimatesCameras(const Refinement& refinement) {
  return std::any_of(refinement.places.begin(), refinement.places.end(),
                     [](const std::vector<int>& places) {
                       return FreeParameters::At(places).any_camera();
                     });
}

// For the cameras of `record`, adds the parameters that only `recorded` has,
// with their covariance; parameters of the two records are taken to be
// independent.
void AddUncertainty(const RefinementRecord& recorded,
                    RefinementRecord* record) {
  if (recorded.covariance.rows() == 0) return;
  const Eigen::Index own = record->covariance.rows();
  const Eigen::Index added = recorded.covariance.rows();
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(own + added, own + added);
  both.topLeftCorner(own, own) = record->covariance;
  both.bottomRightCorner(added, added) = recorded.covariance;
  std::map<std::pair<std::string, int>, Eigen::Index> row_of;
  Eigen::Index at = 0;
  for (const RefinementRecord* one : {&std::as_const(*record), &recorded}) {
    for (const RefinementRecord::Camera& camera : one->cameras) {
      for (const int place : camera.places) {
        row_of.try_emplace({camera.name, place}, at++);
      }
    }
  }
  std::vector<Eigen::Index> rows;
  for (RefinementRecord::Camera& camera : record->cameras) {
    camera.places.clear();
    for (int place = 0; place < kChangeSize; ++place) {
      const auto row = row_of.find({camera.name, place});
      if (row == row_of.end()) continue;
      camera.places.push_back(place);
      rows.push_back(row->second);
    }
  }
  record->covariance = Eigen::MatrixXd(both(rows, rows));
}

// `cameras`, each replaced by the camera of the same name in `others`, if any.
CameraRig WithNamesakes(CameraRig cameras, const CameraRig& others) {
  for (Camera& camera : cameras) {
    for (const Camera& other : others) {
      if (other.name() == camera.name()) camera = other;
    }
  }
  return cameras;
}

// Whether anything but clocks is changed.
bool MovesCameras(const std::vector<CameraChange>& changes) {
  return std::any_of(changes.begin(), changes.end(), [](CameraChange change) {
    change[kOffsetAt] = change[kDriftAt] = 0.0;
    return !change.isZero(0.0);
  });
}

}  // namespace

double MiddleOf(const DetectionSequence& detections) {
  if (detections.frames.empty()) return 0.0;
  const TimeNs first = detections.frames.front().time;
  return ToSeconds(first + (detections.frames.back().time - first) / 2);
}

ReadyRecording RefineRecording(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections) {
  RunScene scene = PrepareScene(options, request, detections.header);
  const DetectionSequence asked = AskedFrames(request, detections);
  DetectionSequence used = WithUsualConfidences(UsedViewsOf(scene, asked));
  double rate_hz = scene.model.frame_rate_hz;  // of the frames that lags count
  int64_t number_step = 1;  // between the numbers of these frames
  std::vector<int> lags(scene.used_views.size(), 0);
  if (options.refine.refine_clock && scene.used_views.size() > 1) {
    if (!options.input.independent_frames) {
      number_step = UsualStep(used.frames);
      rate_hz /= static_cast<double>(number_step);
      used = OnGrid(used, number_step, std::llround(kLongestLagS * rate_hz));
    }
    const CameraRig& cameras = scene.model.cameras;
    lags = SearchClocks(cameras, IdealPeople(used, cameras),
                        static_cast<int>(kLongestLagS * rate_hz))
               .lag_frames;
  }
  ReadyRecording ready;
  Refinement& refinement = ready.refinement.emplace();
  const CameraRig stated = scene.model.cameras;
  const SubjectScale scale = ScaleOf(options, scene.model.cameras, used);
  scene.model.cameras = scale.IntoRun(scene.model.cameras);
  const RunOptions scaled = scale.IntoRun(options);
  const auto refine = [&](const DetectionSequence& detections_used) {
    refinement = RefineScene(
        scene.model.cameras, detections_used,
        MatchRecording(scaled, scene.model, detections_used), options.refine);
  };
  DetectionSequence as_recorded;
  const std::vector<int> none(lags.size(), 0);
  if (lags != none) {
    as_recorded = Realigned(used, lags);
    std::swap(used, as_recorded);
  }
  refine(used);
  if (lags != none && refinement.hardly_moves) {
    // A person at rest gives no information on the clock.
    lags = none;
    used = std::move(as_recorded);
    refine(used);
  }
  for (const int lag : lags) {
    refinement.lag_numbers.push_back(lag * number_step);
  }
  if (refinement.any_taken()) {
    SceneModel refined = scene.model;
    refined.cameras = RefinedCameras(scene.model.cameras, refinement.changes);
    const DetectionSequence moved = WithClocks(used, refinement.changes);
    RefineAgain(scene.model.cameras, moved,
                MatchRecording(scaled, refined, moved), BundleOptions(),
                &refinement);
  }
  for (size_t v = 0; v < lags.size(); ++v) {
    // The fit used frames that were already shifted by the lags.
    refinement.changes[v][kOffsetAt] -= lags[v] / rate_hz;
  }
  scale.IntoWorld(&refinement);
  const CameraRig refined = RefinedCameras(stated, refinement.changes);
  if (MovesCameras(refinement.changes)) {
    ready.world_motion = WorldMotionOf(stated, refined);
  }
  ready.cameras = WithNamesakes(request.cameras, refined);
  ready.record = RecordOf(scene, refinement, MiddleOf(asked));
  ready.detections = Clocked(scene, *ready.record, asked);
  return ready;
}

DetectionSequence WithRecordedClocks(const RunOptions& options,
                                     const RunRequest& request,
                                     const RefinementRecord& record,
                                     const DetectionSequence& detections) {
  return Clocked(PrepareScene(options, request, detections.header), record,
                 AskedFrames(request, detections));
}

std::unique_ptr<CameraUncertainty> UncertaintyOf(
    const RefinementRecord& record, const RunScene& scene,
    const Skeleton& detection_skeleton) {
  if (record.covariance.rows() == 0) return nullptr;
  // The rows of the covariance that belong to cameras used by the run.
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
  if (rows.empty()) return nullptr;
  return std::make_unique<CameraUncertainty>(
      scene.model.cameras, places, record.covariance(rows, rows),
      MapByName(detection_skeleton, scene.model.skeleton), record.clock_zero_s);
}

bool ChangesCameras(const RunOptions& options) {
  return options.refine.any() || options.refine.ground != GroundKind::kOff;
}

ReadyRecording MakeRecordingReady(
    const RunOptions& options, const RunRequest& request,
    const std::optional<RefinementRecord>& recorded,
    const std::function<DetectionSequence()>& read) {
  ReadyRecording ready;
  ready.cameras = request.cameras;
  ready.record = recorded;
  const bool has_clocks = recorded.has_value() && recorded->has_clocks();
  if (has_clocks && options.refine.any()) {
    throw OptionError(
        options.refine.refine_clock ? "cameras.refine_clock" : "cameras.refine",
        "this calibration contains refined clocks already: use the calibration "
        "from before the refinement, or leave out cameras.refine and "
        "cameras.refine_clock");
  }
  if (has_clocks) {
    ready.detections = WithRecordedClocks(options, request, *recorded, read());
  }
  if (!ChangesCameras(options)) return ready;
  DetectionSequence own;
  if (!ready.detections.has_value()) own = read();
  if (options.refine.any()) {
    ready = RefineRecording(options, request, own);
    // Cameras that are unchanged are as uncertain as before.
    if (recorded.has_value() && !EstimatesCameras(*ready.refinement)) {
      AddUncertainty(*recorded, &*ready.record);
    }
  }
  if (options.refine.ground == GroundKind::kOff) return ready;
  // The ground is estimated from one more run over the recording, with the
  // current cameras.
  RunRequest refined = request;
  refined.cameras = ready.cameras;
  ready.ground = FindGround(
      options, refined, ready.detections.has_value() ? *ready.detections : own);
  ready.misses_ground = !ready.ground.has_value();
  if (ready.misses_ground) return ready;
  ready.cameras = OnGround(ready.cameras, *ready.ground);
  if (ready.record.has_value()) TurnRecord(*ready.ground, &*ready.record);
  return ready;
}

}  // namespace kinegraph
