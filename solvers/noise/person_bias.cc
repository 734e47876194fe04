#include "solvers/noise/person_bias.h"

#include <cmath>
#include <utility>

#include "solvers/factors/jacobian.h"

namespace kinegraph {
namespace {

// A body turns little in that time.
constexpr double kLongest_s = 0.3;

// Errors of neighbouring frames are alike: ten looks a second tell it all.
constexpr double kPeriodS = 0.1;

}  // namespace

PersonBias::PersonBias(const SceneModel& scene,
                       std::shared_ptr<ViewBiasPool> pool)
    : scene_(scene),
      pool_(std::move(pool)),
      joints_(scene.skeleton),
      triangulator_(scene.cameras) {
  if (pool_ == nullptr) return;
  pending_ = pool_->Register(joints_, static_cast<int>(scene.cameras.size()));
  seen_.sums.resize(joints_.names().size());
}

void PersonBias::Observe(const PersonProblem& problem, size_t k,
                         const std::vector<bool>& triangulated) {
  if (pool_ == nullptr) return;
  const TimeNs time = problem.times[k];
  before_ = pool_->Before(time);
  const auto position = [&](int j) -> std::optional<Eigen::Vector3d> {
    if (!triangulated[static_cast<size_t>(j)]) return std::nullopt;
    return Eigen::Vector3d(
        problem.joints[static_cast<size_t>(j)].states[k].head<3>());
  };
  const std::optional<BodyStance> frame = joints_.FrameOf(position);
  frames_.push_back(frame);
  if (!frame.has_value()) return;
  last_ = frame;
  last_time_ = time;
  if (!pool_->learns()) return;
  if (learnt_ && time - learnt_time_ < LookAfter()) return;
  learnt_ = true;
  learnt_time_ = time;
  Learn(problem, k);
}

// As near to the period as frames come.
TimeNs PersonBias::LookAfter() const {
  return FromSeconds(kPeriodS - 0.5 / scene_.frame_rate_hz);
}

void PersonBias::Learn(const PersonProblem& problem, size_t k) {
  seen_.time = problem.times[k];
  bool any = false;
  for (int j = 0; j < scene_.skeleton.joint_count(); ++j) {
    any = AddJoint(problem, k, j) || any;
  }
  if (any) pool_->Hand(&seen_, pending_.get());
}

bool PersonBias::AddJoint(const PersonProblem& problem, size_t k,
                          int joint_idx) {
  const JointChain& chain = problem.joints[static_cast<size_t>(joint_idx)];
  if (!triangulator_.Load(chain, k)) return false;
  const JointClass joint_class = scene_.skeleton.joint_class(joint_idx);
  scales_.Add(joint_class, triangulator_.residuals());
  const auto point = triangulator_.Robust(scales_.Scale(joint_class));
  if (!point.has_value()) return false;
  std::vector<BiasView> views;
  for (size_t v = 0; v < triangulator_.views().size(); ++v) {
    const PixelPoint& seen = triangulator_.views()[v];
    if (point->weights[v] <= 0.0) continue;
    BiasView view;
    const auto image = seen.camera->Project(point->position_m, &view.jacobian);
    const auto direction = DirectionOf(joints_, *last_, joint_idx,
                                       point->position_m, *seen.camera);
    if (!image.has_value() || !direction.has_value()) continue;
    view.view_idx = static_cast<int>(seen.camera - scene_.cameras.data());
    view.direction = *direction;
    view.residual_px = seen.px - *image;
    view.per_sigma = std::sqrt(point->weights[v]) / seen.sigma_px;
    views.push_back(view);
  }
  if (views.size() < 2) return false;
  if (!AddViews(views,
                &seen_.sums[static_cast<size_t>(joints_.IndexOf(joint_idx))])) {
    return false;
  }
  for (const BiasView& view : views) {
    seen_.azimuths.emplace_back(view.view_idx, view.direction.azimuth);
  }
  return true;
}

void PersonBias::Apply(const ViewBias& bias, const BodyStance& frame, size_t k,
                       PersonProblem* problem) const {
  for (int j = 0; j < scene_.skeleton.joint_count(); ++j) {
    const ViewBias::OfJoint& of_joint =
        bias.joints[static_cast<size_t>(joints_.IndexOf(j))];
    if (!of_joint.used) continue;
    JointChain& chain = problem->joints[static_cast<size_t>(j)];
    const Eigen::Vector3d point_m = chain.states[k].head<3>();
    for (int32_t m = chain.first[k]; m < chain.first[k + 1]; ++m) {
      PixelMeasurement& measurement = chain.measurements[m];
      const auto direction =
          DirectionOf(joints_, frame, j, point_m, *measurement.camera);
      if (!direction.has_value()) continue;
      measurement.bias_px = BiasOf(of_joint, *direction).cast<float>();
    }
  }
}

void PersonBias::ApplyCausally(size_t k, PersonProblem* problem) {
  if (before_ == nullptr || before_->empty() || !last_.has_value()) return;
  if (ToSeconds(problem->times[k] - last_time_) > kLongest_s) return;
  Apply(*before_, *last_, k, problem);
}

const BodyStance* PersonBias::NearestFrame(
    size_t k, const std::vector<TimeNs>& times) const {
  const BodyStance* nearest = nullptr;
  double least_s = kLongest_s;
  const auto consider = [&](size_t i) {
    const double away_s = std::abs(ToSeconds(times[i] - times[k]));
    if (away_s > least_s) return false;
    if (!frames_[i].has_value()) return true;
    nearest = &*frames_[i];
    least_s = away_s;
    return false;
  };
  for (size_t i = k; i < times.size() && consider(i);) ++i;
  for (size_t i = k; i > 0 && consider(i - 1);) --i;
  return nearest;
}

std::shared_ptr<const ViewBias> PersonBias::OfTake() const {
  if (pool_ == nullptr) return nullptr;
  std::shared_ptr<const ViewBias> bias = pool_->Now();
  return bias == nullptr || bias->empty() ? nullptr : bias;
}

bool PersonBias::HasRound() const {
  return pool_ != nullptr && pool_->learns() && round_ < ViewBiasPool::kRounds;
}

std::shared_ptr<const ViewBias> PersonBias::OfRound() const {
  return pool_->BeforeRound(round_);
}

PersonBias::Round PersonBias::BeginRound(const CameraRig& cameras,
                                         const ErrorCorrelation& correlation) {
  return {this, cameras, correlation};
}

PersonBias::Round::Round(PersonBias* person, const CameraRig& cameras,
                         const ErrorCorrelation& correlation)
    : person_(person),
      cameras_(cameras),
      independent_(IndependentShare(correlation, kPeriodS)),
      series_(person->pool_->EmptySeries()),
      sums_(person->joints_.names().size()) {}

void PersonBias::Round::Add(const PersonProblem& solved, size_t k) {
  const TimeNs time = solved.times[k];
  if (looked_ && time - look_time_ < person_->LookAfter()) return;
  const BiasJoints& joints = person_->joints_;
  const auto stance = joints.FrameOf([&](int j) {
    return std::optional<Eigen::Vector3d>(
        solved.joints[static_cast<size_t>(j)].states[k].head<3>());
  });
  if (!stance.has_value()) return;
  looked_ = true;
  look_time_ = time;
  for (BiasSums& sums : sums_) sums.Clear();
  for (int j = 0; j < static_cast<int>(solved.joints.size()); ++j) {
    const std::vector<BiasView> views = ViewsOf(solved, k, j, *stance);
    AddSolvedViews(views, independent_,
                   &sums_[static_cast<size_t>(joints.IndexOf(j))]);
    for (const BiasView& view : views) {
      series_->AddAzimuth(view.view_idx, view.direction.azimuth);
    }
  }
  series_->Add(time, sums_);
}

std::vector<BiasView> PersonBias::Round::ViewsOf(
    const PersonProblem& solved, size_t k, int joint_idx,
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
        DirectionOf(person_->joints_, stance, joint_idx, point_m, *seen.camera);
    if (!image.has_value() || !direction.has_value()) continue;
    view.view_idx = static_cast<int>(seen.camera - cameras_.data());
    view.direction = *direction;
    view.residual_px = seen.px - *image;
    view.per_sigma = std::sqrt(seen.weight * seen.information) / seen.sigma_px;
    views.push_back(view);
  }
  return views;
}

void PersonBias::Round::HandIn() {
  person_->pool_->HandSolved(std::move(series_), person_->pending_.get());
  ++person_->round_;
}

void PersonBias::ApplyTake(const ViewBias& bias,
                           const std::vector<TimeNs>& times, size_t begin,
                           size_t end, PersonProblem* part) const {
  for (size_t k = begin; k < end; ++k) {
    const BodyStance* frame = NearestFrame(k, times);
    if (frame != nullptr) Apply(bias, *frame, k - begin, part);
  }
}

}  // namespace kinegraph
