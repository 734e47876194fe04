#include "core/tracking/options.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/median.h"

namespace kinegraph {
namespace {

constexpr double kUsualDistance = 4.0;  // m

// The point nearest to all optical axes in the least-squares sense. False when
// the axes do not determine it.
bool MeetingPoint(const CameraRig& cameras, Eigen::Vector3d* point_m) {
  // A smallest eigenvalue below this share of the number of cameras means that
  // the axes lie within about 10 degrees (RMS) of a common direction.
  constexpr double kParallel = 0.03;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) {
    const Eigen::Vector3d axis = camera.R().row(2).transpose();
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * camera.centre();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal);
  const double share =
      solver.eigenvalues()[0] / static_cast<double>(cameras.size());
  if (!(share > kParallel)) return false;
  *point_m = solver.eigenvectors() *
             solver.eigenvalues().cwiseInverse().asDiagonal() *
             solver.eigenvectors().transpose() * right;
  return true;
}

}  // namespace

void GateOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("units", &units, {"pixels", "metres"},
                 "gates in pixels, from the keys of other tables, or derived "
                 "from lengths in metres at the working distance");
  visitor.Number("speed_mps", &speed_mps, NonNegative(), "m/s",
                 "metres: speed at which a joint's gate grows after the last "
                 "update");
  visitor.Number("working_distance", &working_distance_m, NonNegative(), "m",
                 "metres: distance of people from the cameras; 0: that of the "
                 "point where the optical axes meet");
}

double WorkingDistance(const CameraRig& cameras) {
  Eigen::Vector3d meeting;
  if (cameras.size() < 2 || !MeetingPoint(cameras, &meeting)) {
    return kUsualDistance;
  }
  std::vector<double> depths;
  for (const Camera& camera : cameras) depths.push_back(camera.Depth(meeting));
  const double depth = Median(depths);
  return depth > 0.0 ? depth : kUsualDistance;
}

double PixelsPerMetre(const CameraRig& cameras, double working_distance_m) {
  std::vector<double> focal;
  for (const Camera& camera : cameras) focal.push_back(camera.focal_px());
  return Median(focal) / working_distance_m;
}

TrackerOptions WithScaledGates(TrackerOptions options, const CameraRig& cameras,
                               double frame_rate_hz) {
  const GateOptions& gates = options.gates;
  if (gates.units == GateUnits::kPixels) return options;
  const double scale = PixelsPerMetre(cameras, gates.working_distance_m > 0.0
                                                   ? gates.working_distance_m
                                                   : WorkingDistance(cameras));
  const double epipolar_px = scale * gates.epipolar_m + gates.detector_px;
  options.reconstruction.alpha_epi_px = epipolar_px;
  options.initialisation.alpha_group_px = epipolar_px;
  options.initialisation.alpha_filter_px = epipolar_px;
  options.association.alpha_2d_px_per_frame =
      scale * (gates.reach_m + gates.speed_mps / frame_rate_hz) +
      gates.motion_detector_px;
  options.association.lambda_a_per_frame =
      gates.affinity_decay_per_s / frame_rate_hz;
  options.reconstruction.lambda_t_per_frame =
      gates.view_decay_per_s / frame_rate_hz;
  options.reconstruction.tau_frames =
      std::max(1.0, gates.view_age_s * frame_rate_hz);
  return options;
}

void TrackLifeOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("confirm_s", &confirm_s, Between(0.0, 40.0), "s",
                 "a track is confirmed by an update this long after its birth; "
                 "in paper mode a second is 25 frames");
  visitor.Number(
      "max_age_s", &max_age_s, Positive(), "s",
      "a track without an update is deleted after this time; in paper "
      "mode a second is 25 frames");
  visitor.Number("min_found_joints", &min_found_joints, Between(0.0, 17.0),
                 "joints of 17",
                 "detections with fewer found joints are ignored");
  visitor.Boolean("backfill", &backfill,
                  "graph mode: also write a track's frames before it was "
                  "confirmed");
  visitor.Number("max_gap_s", &max_gap_s, NonNegative(), "s",
                 "graph mode: gaps up to this length are bridged and written");
  visitor.Boolean("second_pass", &second_pass,
                  "graph mode, offline: associate again with the smoothed "
                  "tracks");
}

TrackLifeOptions LifeInFrames(const TrackLifeOptions& options,
                              double frame_rate_hz) {
  TrackLifeOptions life = options;
  life.in_seconds = false;
  if (options.in_seconds) {
    // A detector misses people for a frame or more at any frame rate: at low
    // rates ages and gaps grow with the frame interval, up to five times.
    constexpr double kRareHz = 12.5;  // below it 0.4 s are fewer than 5 frames
    constexpr double kMostTimes = 5.0;
    const double per_s =
        std::max(frame_rate_hz, std::min(kRareHz, kMostTimes * frame_rate_hz));
    life.max_age_frames = options.max_age_s * per_s;
    life.max_gap_frames = options.max_gap_s * per_s;
    life.confirm_hits = std::max<int64_t>(
        2, 1 + std::llround(options.confirm_s * frame_rate_hz));
    // A life of less than a frame and a half (half a frame is a tolerance) ends
    // with the first missed frame.
    if (life.max_age_frames < 1.5) life.confirm_hits = 1;
  }
  if (options.independent_frames) life.confirm_hits = 1;
  return life;
}

TrackerOptions TrackerOptions::At(double frame_rate_hz) const {
  TrackerOptions options = *this;
  options.life = LifeInFrames(life, frame_rate_hz);
  options.association.reach_m_per_frame =
      life.in_seconds ? association.max_speed_mps / frame_rate_hz : 0.0;
  options.association.horizon_s =
      life.in_seconds ? association.prediction_s : 0.0;
  if (!life.in_seconds) options.reconstruction.lost = LostRule::kSeen;
  return options;
}

void TrackerOptions::Describe(OptionVisitor& visitor) {
  visitor.Table("association", &association);
  visitor.Table("reconstruction", &reconstruction);
  visitor.Table("initialisation", &initialisation);
  visitor.Table("tracking", &life);
  visitor.Table("gates", &gates);
}

}  // namespace kinegraph
