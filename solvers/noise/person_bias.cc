#include "solvers/noise/person_bias.h"

#include <cmath>

#include "solvers/factors/jacobian.h"

namespace kinegraph {
namespace {

// A body turns little in that time.
constexpr double kLongest_s = 0.3;

// Errors of neighbouring frames are alike: ten looks a second tell it all.
constexpr double kPeriodS = 0.1;

}  // namespace

BiasObserver::BiasObserver(const BiasJoints& joints, const CameraRig& cameras,
                           double frame_rate_hz,
                           const ErrorCorrelation& correlation,
                           BiasSeries* series)
    : joints_(joints),
      cameras_(cameras),
      // As near to the period as frames come.
      look_after_(FromSeconds(kPeriodS - 0.5 / frame_rate_hz)),
      independent_(IndependentShare(correlation, kPeriodS)),
      series_(series),
      sums_(joints.names().size()) {}

void BiasObserver::Add(const PersonProblem& solved, size_t k) {
  const TimeNs time = solved.times[k];
  if (looked_.has_value() && time - *looked_ < look_after_) return;
  const auto stance = joints_.FrameOf([&](int j) {
    return std::optional<Eigen::Vector3d>(
        solved.joints[static_cast<size_t>(j)].states[k].head<3>());
  });
  if (!stance.has_value()) return;
  looked_ = time;
  for (BiasSums& sums : sums_) sums.Clear();
  for (int j = 0; j < static_cast<int>(solved.joints.size()); ++j) {
    const std::vector<BiasView> views = ViewsOf(solved, k, j, *stance);
    AddViews(views, independent_,
             &sums_[static_cast<size_t>(joints_.IndexOf(j))]);
    for (const BiasView& view : views) {
      series_->AddAzimuth(view.view_idx, view.direction.azimuth);
    }
  }
  series_->Add(time, sums_);
}

std::vector<BiasView> BiasObserver::ViewsOf(const PersonProblem& solved,
                                            size_t k, int joint_idx,
                                            const BodyStance& stance) const {
  const JointChain& chain = solved.joints[static_cast<size_t>(joint_idx)];
  std::vector<BiasView> views;
  for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
    const PixelMeasurement& seen = chain.measurements[m];
    if (seen.gated || seen.weight <= 0.0) continue;
    Eigen::Vector3d point_m;
    PointAt(chain.states[k].data(), seen.offset_s, point_m.data());
    BiasView view;
    const auto image = seen.camera->Project(point_m, &view.jacobian);
    const auto direction =
        DirectionOf(joints_, stance, joint_idx, point_m, *seen.camera);
    if (!image.has_value() || !direction.has_value()) continue;
    view.view_idx = static_cast<int>(seen.camera - cameras_.data());
    view.direction = *direction;
    view.residual_px = seen.px - *image;
    view.per_sigma = std::sqrt(seen.weight * seen.information) / seen.sigma_px;
    views.push_back(view);
  }
  return views;
}

namespace {

// Where the body stands in the frame nearest to frame `k` that tells; null:
// nowhere near.
const BodyStance* NearestStance(
    const std::vector<TimeNs>& times,
    const std::vector<std::optional<BodyStance>>& stances, size_t k) {
  const BodyStance* nearest = nullptr;
  double least_s = kLongest_s;
  const auto consider = [&](size_t i) {
    const double away_s = std::abs(ToSeconds(times[i] - times[k]));
    if (away_s > least_s) return false;
    if (!stances[i].has_value()) return true;
    nearest = &*stances[i];
    least_s = away_s;
    return false;
  };
  for (size_t i = k; i < times.size() && consider(i);) ++i;
  for (size_t i = k; i > 0 && consider(i - 1);) --i;
  return nearest;
}

}  // namespace

void WriteBias(const BiasJoints& joints, const ViewBias& bias,
               const std::vector<FrameRecord>& records,
               PersonProblem* recording) {
  const ViewBias ordered = InOrderOf(joints.names(), bias);
  std::vector<std::optional<BodyStance>> stances;
  for (size_t k = 0; k < records.size(); ++k) {
    stances.push_back(
        joints.FrameOf([&](int j) -> std::optional<Eigen::Vector3d> {
          const auto joint = static_cast<size_t>(j);
          if (!records[k].triangulated[joint]) return std::nullopt;
          return Eigen::Vector3d(recording->joints[joint].states[k].head<3>());
        }));
  }
  for (size_t k = 0; k < records.size(); ++k) {
    const BodyStance* stance = NearestStance(recording->times, stances, k);
    if (stance == nullptr) continue;
    for (size_t j = 0; j < recording->joints.size(); ++j) {
      const int joint_idx = static_cast<int>(j);
      const ViewBias::OfJoint& of_joint =
          ordered.joints[static_cast<size_t>(joints.IndexOf(joint_idx))];
      if (!of_joint.used) continue;
      JointChain& chain = recording->joints[j];
      const Eigen::Vector3d point_m = chain.states[k].head<3>();
      for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
        PixelMeasurement& measurement = chain.measurements[m];
        const auto direction = DirectionOf(joints, *stance, joint_idx, point_m,
                                           *measurement.camera);
        if (!direction.has_value()) continue;
        measurement.bias_px = BiasOf(of_joint, *direction).cast<float>();
      }
    }
  }
}

}  // namespace kinegraph
