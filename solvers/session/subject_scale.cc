#include "solvers/session/subject_scale.h"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "solvers/cameras/refine.h"

namespace kinegraph {
namespace {

ViewBias ScaledBias(double factor, ViewBias bias) {
  for (ViewBias::OfJoint& joint : bias.joints) {
    for (double& m : joint.across_m) m *= factor;
    for (double& m : joint.along_m) m *= factor;
  }
  return bias;
}

}  // namespace

SubjectScale SubjectScale::OfSize(double size_m) {
  if (!(size_m > 0.0 && std::isfinite(size_m))) {
    throw std::logic_error("a subject has no size");
  }
  SubjectScale scale;
  scale.metres_ = size_m / kPersonSize_m;
  return scale;
}

double SubjectScale::size_m() const { return kPersonSize_m * metres_; }

CameraRig SubjectScale::IntoRun(const CameraRig& cameras) const {
  return Rescaled(cameras, 1.0 / metres_);
}

CameraRig SubjectScale::IntoWorld(const CameraRig& cameras) const {
  return Rescaled(cameras, metres_);
}

RunOptions SubjectScale::IntoRun(RunOptions options) const {
  if (is_one()) return options;
  options.tracker.gates.working_distance_m /= metres_;
  for (double& m : options.identity.entries) m /= metres_;
  std::shared_ptr<const ViewBias>& given =
      options.estimators.graph.given_view_bias;
  if (given != nullptr) {
    given = std::make_shared<ViewBias>(ScaledBias(1 / metres_, *given));
  }
  return options;
}

TrackFrame SubjectScale::Times(double factor, TrackFrame frame) {
  if (factor != 1.0) Scale(factor, &frame);
  return frame;
}

LearntNoise SubjectScale::IntoWorld(LearntNoise noise) const {
  const double squared = metres_ * metres_;
  for (LearntNoise::OfClass& of_class : noise.classes) {
    // Stated for a reference distance in metres; proportional to 1 / distance.
    of_class.sigma_px *= metres_;
    of_class.process_noise *= squared;
    of_class.least_process_noise *= squared;
    of_class.greatest_process_noise *= squared;
  }
  return noise;
}

ViewBias SubjectScale::IntoWorld(ViewBias bias) const {
  return ScaledBias(metres_, std::move(bias));
}

void SubjectScale::IntoWorld(Refinement* refinement) const {
  if (is_one()) return;
  for (auto* changes : {&refinement->changes, &refinement->sigmas}) {
    for (CameraChange& change : *changes) {
      change.segment<3>(kCentreAt) *= metres_;
    }
  }
  if (refinement->covariance.size() == 0) return;
  RescaleCentres(refinement->places, metres_, &refinement->covariance);
}

}  // namespace kinegraph
