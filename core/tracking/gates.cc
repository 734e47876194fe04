#include "core/tracking/gates.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "core/base/median.h"
#include "core/tracking/options.h"

namespace kinegraph {
namespace {

constexpr double kUsualDistance = 4.0;  // m

// The point nearest to all optical axes in the least-squares sense. False when
// the axes do not determine it.
bool MeetingPoint(const CameraRig& cameras, Eigen::Vector3d* point_m) {
  // Below this share of a camera the axes are within some 10 degrees.
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
                 "gates in pixels, as the other tables give them, or in metres "
                 "where the cameras look");
  visitor.Number("speed_mps", &speed_mps, NonNegative(), "m/s",
                 "metres: how far a joint may be from its prediction grows by "
                 "this with the time since the last update");
  visitor.Number("working_distance", &working_distance_m, NonNegative(), "m",
                 "metres: of people from cameras; 0: where the optical axes "
                 "meet");
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

}  // namespace kinegraph
