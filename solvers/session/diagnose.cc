#include "solvers/session/diagnose.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/io/detections/skeleton_fit.h"
#include "core/skeleton/body_joints.h"
#include "core/tracking/tracker.h"
#include "solvers/cameras/camera_change.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/subject_gauge.h"

namespace kinegraph {

FrozenMatches MatchRecording(const RunOptions& options, const SceneModel& scene,
                             const DetectionSequence& detections) {
  MatchFreezer freezer;
  Tracker tracker(scene, detections.header.skeleton, options.tracker,
                  freezer.Wrap(FeedbackOf(options)));
  std::vector<TrackFrame> finished;
  for (const DetectionFrame& frame : detections.frames) {
    tracker.Process(frame, &finished);
  }
  tracker.Finish(&finished);
  return freezer.Matches(finished);
}

std::vector<const Skeleton*> SkeletonsLike(const Skeleton& own) {
  std::vector<const Skeleton*> skeletons = {&own};
  for (const Skeleton* other : SkeletonsOfSize(own.joints().size())) {
    if (other->joints() != own.joints()) skeletons.push_back(other);
  }
  return skeletons;
}

std::optional<Finding> FindingOfSkeleton(
    const SkeletonFit& fit, const std::vector<const Skeleton*>& skeletons) {
  Finding finding;
  finding.kind = "skeleton";
  finding.evidence =
      "bone lengths are implausible with skeleton " + skeletons[0]->name();
  if (const size_t best = fit.Best(); best != 0) {
    finding.confidence = 0.9;
    finding.fix = "--set=detections.skeleton=" + skeletons[best]->name();
    finding.evidence += " and plausible with " + skeletons[best]->name();
  } else if (fit.Implausible(0)) {
    finding.fix =
        "specify the order of the joints with detections.skeleton, as a "
        "built-in skeleton or as one of the configuration ([skeletons.NAME])";
  } else {
    return std::nullopt;
  }
  return finding;
}

namespace {

// The recorded standard deviations of each camera, with lengths in units of
// `metre`; zero for cameras without a record.
std::vector<CameraChange> StatedSigma(const RefinementRecord& record,
                                      const CameraRig& cameras, double metre) {
  std::vector<CameraChange> sigmas(cameras.size(), CameraChange::Zero());
  if (record.covariance.rows() == 0) return sigmas;
  Eigen::Index at = 0;
  for (const RefinementRecord::Camera& one : record.cameras) {
    CameraChange sigma = CameraChange::Zero();
    for (const int place : one.places) {
      const bool is_length = place >= kCentreAt && place < kCentreAt + 3;
      sigma[place] =
          std::sqrt(record.covariance(at, at)) / (is_length ? metre : 1.0);
      ++at;
    }
    for (size_t v = 0; v < cameras.size(); ++v) {
      if (cameras[v].name() == one.name) sigmas[v] = sigma;
    }
  }
  return sigmas;
}

}  // namespace

Diagnosis DiagnoseRecording(const RunOptions& options,
                            const RunRequest& request,
                            const DetectionSequence& detections,
                            const CalibrationUnit& unit,
                            const std::optional<RefinementRecord>& recorded) {
  // Joint names are examined first, because nothing else can be examined with
  // wrong ones.
  DetectionHeader header = detections.header;
  const auto skeletons = SkeletonsLike(detections.header.skeleton);
  SkeletonFit fit(skeletons);
  for (const DetectionFrame& frame : detections.frames) {
    for (const ViewDetections& view : frame.views) {
      if (fit.full()) break;
      for (const Detection& detection : view.detections) fit.See(detection);
    }
  }
  header.skeleton = *skeletons[fit.Best()];
  const RunScene scene = PrepareScene(options, request, header);
  DoctorInput input;
  input.independent_frames = options.input.independent_frames;
  input.units_per_metre = unit.per_metre;
  input.unit_can_be_set = unit.can_be_changed;
  const bool has_clocks = recorded.has_value() && recorded->has_clocks();
  input.detections = UsedViewsOf(
      scene, has_clocks
                 ? WithRecordedClocks(options, request, *recorded, detections)
                 : AskedFrames(request, detections));
  input.detections.header.skeleton = header.skeleton;
  // People are not rescaled, because the doctor itself reports implausible
  // statures.
  const SubjectScale scale =
      IsHuman(header.skeleton)
          ? SubjectScale()
          : ScaleOf(options, scene.model.cameras, input.detections);
  input.cameras = scale.IntoRun(scene.model.cameras);
  if (recorded.has_value()) {
    input.stated_sigma =
        StatedSigma(*recorded, scene.model.cameras, scale.metres());
  }
  const RunOptions scaled = scale.IntoRun(options);
  input.match = [&](const CameraRig& cameras,
                    const DetectionSequence& aligned) {
    SceneModel model = scene.model;
    model.cameras = cameras;
    return MatchRecording(scaled, model, aligned);
  };
  Diagnosis diagnosis = Diagnose(input);
  diagnosis.cameras = scale.IntoWorld(diagnosis.cameras);
  for (Finding& finding : diagnosis.findings) {
    // A run does not refine recorded clocks again.
    if (has_clocks && finding.fix == kRefineClocks) {
      finding.fix = kCalibrateAnew;
    }
  }
  if (auto skeleton = FindingOfSkeleton(fit, skeletons)) {
    auto& all = diagnosis.findings;
    // Statures that no unit explains follow from wrong joints.
    all.erase(std::remove_if(all.begin(), all.end(),
                             [](const Finding& one) {
                               return one.kind == "unit" &&
                                      one.confidence <= 0.5;
                             }),
              all.end());
    skeleton->confidence = std::max(skeleton->confidence, 0.5);
    all.insert(all.begin(), *std::move(skeleton));
    diagnosis.verdict = DoctorVerdict::kSuspect;
  }
  return diagnosis;
}

}  // namespace kinegraph
