#include "solvers/session/calibrate_recording.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/data/stance.h"
#include "core/skeleton/body_joints.h"
#include "solvers/scene/hypothesis.h"
#include "solvers/scene/plausible.h"
#include "solvers/scene/view_agreement.h"
#include "solvers/session/diagnose.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/run.h"
#include "solvers/session/subject_gauge.h"

namespace kinegraph {
namespace {

// Adults have a stature of 1.70 m with a standard deviation of 0.09 m; statures
// derived from a detector's joints deviate by up to 3 % from the anatomical
// ones. Both spreads are relative to the stature.
constexpr double kStatureM = 1.70;
constexpr double kStatureSpread = 0.053;
constexpr double kChainSpread = 0.03;

TrackSequence QuickTracks(const RunOptions& options, const CameraRig& cameras,
                          const DetectionSequence& recording) {
  RunRequest request;
  request.cameras = cameras;
  return TrackSequenceOf(QuickOptions(options), request, recording);
}

// Median distance of two joints over people and frames; 0 if they are never
// seen together.
double DistanceIn(const TrackSequence& tracks, int a, int b) {
  std::vector<double> distances;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) {
      const auto distance_m = ObservedDistance(person.joints, a, b);
      if (distance_m.has_value()) distances.push_back(*distance_m);
    }
  }
  return Median(std::move(distances));
}

int JointOf(const Skeleton& skeleton, const std::string& name) {
  const int joint = skeleton.IndexOf(name);
  if (joint < 0) {
    throw InputError("--distance: '" + Printable(name) +
                     "' is not a joint of the detections' skeleton " +
                     Printable(skeleton.name()));
  }
  return joint;
}

// Throws InputError if a named joint or view does not exist, before minutes of
// work.
void CheckNames(const KnownLength& length, const DetectionHeader& header) {
  if (length.kind == KnownLength::Kind::kDistance) {
    JointOf(header.skeleton, length.a);
    JointOf(header.skeleton, length.b);
  }
  if (length.kind != KnownLength::Kind::kCameras) return;
  for (const std::string& name : {length.a, length.b}) {
    const auto& views = header.view_names;
    if (std::find(views.begin(), views.end(), name) == views.end()) {
      throw InputError("--cameras_apart: no view is named '" + Printable(name) +
                       "'");
    }
  }
}

// A rotation of the world that moves one direction to another.
Ground Turning(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  Ground turn;
  turn.R = Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
  return turn;
}

// Gives a calibrated rig its scale, its vertical, its floor and its record.
class Finisher {
 public:
  Finisher(const RunOptions& options, const CalibrationInput& input,
           double clock_zero_s, RecordingCalibration* result)
      : options_(options),
        input_(input),
        clock_zero_s_(clock_zero_s),
        result_(result) {}

  void Run() {
    result_->cameras = result_->rig.cameras;
    Metre();
    StandUp();
    Record();
  }

 private:
  const DetectionSequence& recording() const { return result_->rig.recording; }

  const Camera& CameraOf(const std::string& view) const {
    const RigResult& rig = result_->rig;
    for (size_t v = 0; v < rig.used.size(); ++v) {
      if (result_->view_names[rig.used[v]] == view) {
        return result_->cameras[v];
      }
    }
    throw InputError("--cameras_apart: '" + Printable(view) +
                     "' is a view that could not be calibrated");
  }

  // Scales the result by the known length, except rig.cameras, which keep their
  // unit.
  void Metre() {
    const KnownLength& length = input_.length;
    double measured = 0.0;
    double metres = length.metres;
    constexpr int kFrames = 200;
    const double stature =
        StatureOf(result_->cameras, recording(), kFrames).median_m;
    switch (length.kind) {
      case KnownLength::Kind::kPopulation:
        metres = kStatureM;
        measured = stature;
        result_->scale_sigma = std::hypot(kStatureSpread, kChainSpread);
        break;
      case KnownLength::Kind::kStature:
        measured = stature;
        result_->scale_sigma = kChainSpread;
        break;
      case KnownLength::Kind::kDistance:
        measured =
            DistanceIn(QuickTracks(options_, result_->cameras, recording()),
                       JointOf(recording().header.skeleton, length.a),
                       JointOf(recording().header.skeleton, length.b));
        result_->scale_sigma = 0.01;  // assumed
        break;
      case KnownLength::Kind::kCameras:
        measured =
            (CameraOf(length.a).centre() - CameraOf(length.b).centre()).norm();
        break;
    }
    if (!(measured > 0.0)) {
      result_->rig.reasons.push_back(
          "the scale is unknown: lengths are in an arbitrary unit");
      result_->scale_sigma = 1.0;
      return;
    }
    const double factor = metres / measured;
    result_->metres_per_unit = factor;
    result_->stature_m = stature * factor;
    result_->cameras = Rescaled(result_->cameras, factor);
    RigResult& rig = result_->rig;
    RescaleCentres(rig.places, factor, &rig.covariance);
    for (RigView& view : rig.views) view.centre_sigma_m *= factor;
    rig.size_m *= factor;
  }

  // Rotates z upwards and, if the feet show the floor, moves it to z = 0.
  void StandUp() {
    if (!IsHuman(recording().header.skeleton)) return;
    const TrackSequence first =
        QuickTracks(options_, result_->cameras, recording());
    const Eigen::Vector3d of_cameras = UpOfCameras(result_->cameras);
    const Eigen::Vector3d up = StanceOf(first.header.skeleton, first.frames)
                                   .Up({std::nullopt, of_cameras})
                                   .value_or(of_cameras.normalized());
    // No axis may be near the direction in which people stand, because
    // GroundOf would prefer such an axis.
    const Eigen::Vector3d diagonal =
        Eigen::Vector3d::Constant(1.0).normalized();
    result_->cameras = OnGround(result_->cameras, Turning(up, diagonal));
    const TrackSequence tracks =
        QuickTracks(options_, result_->cameras, recording());
    result_->ground = GroundOf(tracks.header, tracks.frames);
    result_->cameras = OnGround(
        result_->cameras,
        result_->ground.value_or(Turning(diagonal, Eigen::Vector3d::UnitZ())));
  }

  // Gradient of log(distance), the distance being that of the two cameras of
  // the known length, with respect to all parameters.
  Eigen::VectorXd LogDistance(Eigen::Index size) const {
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    const Eigen::Vector3d apart =
        CameraOf(input_.length.a).centre() - CameraOf(input_.length.b).centre();
    Eigen::Index at = 0;
    for (size_t v = 0; v < result_->cameras.size(); ++v) {
      const std::string& name = result_->record.cameras[v].name;
      const double sign = name == CameraOf(input_.length.a).name()   ? 1.0
                          : name == CameraOf(input_.length.b).name() ? -1.0
                                                                     : 0.0;
      gradient.segment<3>(at + kCentreAt) = sign / apart.squaredNorm() * apart;
      at += static_cast<Eigen::Index>(result_->rig.places[v].size());
    }
    return gradient;
  }

  // Fills in the record for cameras.json, including the uncertainty of the
  // scale, which is common to all centres.
  void Record() {
    RigResult& rig = result_->rig;
    RefinementRecord& record = result_->record;
    record.clock_zero_s = clock_zero_s_;
    const Eigen::Index size = rig.covariance.rows();
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(size, size);
    Eigen::VectorXd centres = Eigen::VectorXd::Zero(size);
    Eigen::Index at = 0;
    for (size_t v = 0; v < rig.used.size(); ++v) {
      const RigView& view = rig.views[rig.used[v]];
      record.cameras.push_back({result_->cameras[v].name(), view.clock_s,
                                view.drift, rig.places[v]});
      const Eigen::Matrix3d R =
          result_->cameras[v].R().transpose() * rig.cameras[v].R();
      for (const int place : rig.places[v]) {
        if (place == kCentreAt) {
          turn.block<3, 3>(at, at) = R;
          centres.segment<3>(at) = result_->cameras[v].centre();
        }
        ++at;
      }
    }
    record.covariance = turn * rig.covariance * turn.transpose();
    if (input_.length.kind == KnownLength::Kind::kCameras) {
      const Eigen::VectorXd by_distance = LogDistance(size);
      result_->scale_sigma =
          std::sqrt(by_distance.dot(record.covariance * by_distance));
      // The distance is exact: rescaling all centres undoes every change of it.
      const Eigen::MatrixXd held = Eigen::MatrixXd::Identity(size, size) -
                                   centres * by_distance.transpose();
      record.covariance = held * record.covariance * held.transpose();
      return;
    }
    record.covariance +=
        std::pow(result_->scale_sigma, 2) * centres * centres.transpose();
  }

  const RunOptions& options_;
  const CalibrationInput& input_;
  double clock_zero_s_;
  RecordingCalibration* result_;
};

// Checks by people's noses whether the world is a mirror image, which the views
// themselves cannot determine. The calibration is rejected if the images are
// also upside down; otherwise a warning is added, because exchanging left and
// right has the same effect.
void CheckMirror(const std::vector<std::string>& view_names,
                 const RigInput& input, RigResult* rig) {
  const std::vector<int> frames =
      FramesToLookAt(PeopleOfViews(rig->recording), kFramesToLookAt);
  const DetectionSequence seen = FramesOf(rig->recording, frames);
  const Noses noses = NosesOf(rig->cameras, IdealPeople(seen, rig->cameras),
                              seen.header.skeleton);
  if (!noses.are_backwards()) return;
  const std::string behind =
      fmt::format("noses are behind the shoulders in {} of {} poses",
                  noses.backwards, noses.looked_at);
  if (StandOnHeads(seen)) {
    rig->verdict = RigVerdict::kRefused;
    rig->reasons = {
        "y counts from the bottom of the images, so the reconstruction is "
        "mirrored: people are upside down, and " +
        behind + ": calibrate and track with " +
        MirrorFlag(FromTheBottom(input.intrinsics), view_names)};
    return;
  }
  rig->reasons.push_back(
      behind + ": left and right are exchanged (track with " +
      ExchangeSidesFlag(std::vector<char>(view_names.size(), 1), view_names) +
      "), or pixels were mirrored after detection, and the room is a mirror "
      "image (detections.mirror_px)");
}

}  // namespace

RecordingCalibration CalibrateRecording(const RunOptions& options,
                                        const CalibrationInput& input,
                                        const DetectionSequence& detections) {
  RunRequest request;
  request.cameras = input.cameras;
  const RunScene scene = PrepareScene(options, request, detections.header);
  RigInput rig;
  rig.intrinsics = scene.model.cameras;
  rig.focal_sigma = input.focal_sigma;
  rig.focal_stated = input.focal_stated;
  rig.lenses_known = input.lenses_known;
  rig.in_step = input.in_step;
  rig.progress = input.progress;
  rig.detections = UsedViewsOf(scene, detections);
  rig.match = [&](const CameraRig& cameras,
                  const DetectionSequence& recording) {
    SceneModel model = scene.model;
    model.cameras = cameras;
    model.frame_rate_hz = recording.header.frame_rate_hz;
    return MatchRecording(options, model, recording);
  };
  CheckNames(input.length, rig.detections.header);
  RecordingCalibration result;
  result.view_names = scene.view_names;
  result.rig = EstimateRig(rig);
  if (result.rig.verdict != RigVerdict::kRefused) {
    CheckMirror(scene.view_names, rig, &result.rig);
  }
  if (result.rig.verdict != RigVerdict::kRefused) {
    Finisher(options, input, MiddleOf(detections), &result).Run();
  }
  return result;
}

}  // namespace kinegraph
