#include "solvers/graph/assembler.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solvers/factors/factors.h"

namespace kinegraph {
namespace {

constexpr TimeNs kNever = std::numeric_limits<TimeNs>::min();

// Confidence, clamped to the trusted range: GraphOptions::min_confidence to 1.
double TrustedConfidence(const GraphOptions& options, double confidence) {
  return std::min(1.0, std::max(options.min_confidence, confidence));
}

bool Measured(const Keypoint& joint) {
  return joint.found && joint.px.allFinite() && std::isfinite(joint.confidence);
}

double MeanConfidence(const std::vector<FreshView>& views) {
  double sum = 0.0;
  int count = 0;
  for (const FreshView& view : views) {
    for (const Keypoint& joint : view.joints) {
      if (!Measured(joint)) continue;
      sum += joint.confidence;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

bool Triangulated(const EstimatorFrame& frame, size_t joint) {
  if (!frame.has_initial || joint >= frame.initial.size()) return false;
  const Joint3d& initial = frame.initial[joint];
  if (!initial.present() || !initial.position_m.allFinite()) return false;
  return frame.triangulated.empty() ? initial.status == JointStatus::kObserved
                                    : frame.triangulated[joint] != 0;
}

// The tracker passes views in the order in which the track was first matched in
// them; the second pass uses camera order. Sorting makes the problem depend on
// the matches only.
std::vector<const FreshView*> InCameraOrder(const EstimatorFrame& frame) {
  std::vector<const FreshView*> views;
  views.reserve(frame.views.size());
  for (const FreshView& view : frame.views) views.push_back(&view);
  std::sort(views.begin(), views.end(),
            [](const FreshView* a, const FreshView* b) {
              return a->view_idx < b->view_idx;
            });
  return views;
}

}  // namespace

Assembler::Assembler(const SceneModel& scene, const GraphOptions& options)
    : scene_(scene),
      options_(options),
      last_measured_(scene.cameras.size() * scene.skeleton.joint_count(),
                     kNever) {}

FrameRecord Assembler::Append(const EstimatorFrame& frame,
                              PersonProblem* problem) {
  CHECK(problem->times.empty() || frame.time > problem->times.back());
  if (frame.has_initial) {
    centre_ = MeanPosition(frame.initial).value_or(centre_);
  }
  problem->joints.resize(scene_.skeleton.joint_count());
  FrameRecord record;
  record.frame = frame.frame;
  record.time = frame.time;
  record.score = MeanConfidence(frame.views);
  record.triangulated.resize(problem->joints.size());

  const bool birth = problem->times.empty();
  problem->centres.push_back(
      {centre_,
       birth ? 0.0
             : CentrePerSigma(options_,
                              ToSeconds(frame.time - problem->times.back()))});
  problem->times.push_back(frame.time);
  for (size_t j = 0; j < problem->joints.size(); ++j) {
    JointChain& chain = problem->joints[j];
    record.triangulated[j] = Triangulated(frame, j);
    State state = State::Zero();
    state.head<3>() =
        record.triangulated[j] ? frame.initial[j].position_m : centre_;
    chain.states.push_back(state);
    if (birth) {
      chain.prior = BirthPrior(centre_, options_.birth_position_sigma_m,
                               options_.birth_velocity_sigma_mps);
    } else {
      const JointClass joint_class =
          scene_.skeleton.joint_class(static_cast<int>(j));
      chain.process_noise.push_back(
          options_.process_noise[static_cast<int>(joint_class)]);
    }
  }
  for (const FreshView* view : InCameraOrder(frame)) {
    const int slot = static_cast<int>(record.views.size());
    record.views.push_back({view->view_idx, view->detection_idx});
    AppendView(frame, *view, slot, problem);
  }
  for (JointChain& chain : problem->joints) {
    chain.first.push_back(static_cast<int32_t>(chain.measurements.size()));
  }
  if (options_.user_factors) AppendUserFactors(frame, problem);
  return record;
}

void Assembler::AppendUserFactors(const EstimatorFrame& frame,
                                  PersonProblem* problem) {
  UserFrame user;
  user.frame = frame.frame;
  user.time = frame.time;
  user.has_previous = problem->times.size() > 1;
  user.skeleton = &scene_.skeleton;
  user.initial = frame.has_initial ? &frame.initial : nullptr;
  for (PlacedFactor& placed :
       PlaceUserFactors(options_.user_factors, user, problem->times.size() - 1,
                        static_cast<int>(problem->joints.size()))) {
    problem->user.push_back(std::move(placed));
  }
}

void Assembler::AppendView(const EstimatorFrame& frame, const FreshView& view,
                           int slot, PersonProblem* problem) {
  const Camera& camera = scene_.cameras[view.view_idx];
  const double depth_m = camera.Depth(centre_);
  if (!(depth_m > kNearestDepthM)) return;
  const size_t joint_count = problem->joints.size();
  for (size_t j = 0; j < joint_count && j < view.joints.size(); ++j) {
    const Keypoint& joint = view.joints[j];
    if (!Measured(joint)) continue;
    PixelMeasurement measurement;
    measurement.px = joint.px;
    measurement.camera = &camera;
    measurement.view_slot = static_cast<int16_t>(slot);
    measurement.offset_s = ToSeconds(view.capture_time - frame.time);
    measurement.sigma_px =
        PixelSigma(options_, scene_.skeleton.joint_class(static_cast<int>(j)),
                   joint.confidence, depth_m, camera.focal_px());
    measurement.model_sigma_px = measurement.sigma_px;
    measurement.log_confidence = static_cast<float>(
        std::log(TrustedConfidence(options_, joint.confidence)));
    TimeNs& last = last_measured_[view.view_idx * joint_count + j];
    const double since_s = last == kNever
                               ? std::numeric_limits<double>::infinity()
                               : ToSeconds(frame.time - last);
    measurement.information = InformationScale(options_, since_s);
    last = frame.time;
    problem->joints[j].measurements.push_back(measurement);
  }
}

double PixelSigma(const GraphOptions& options, JointClass joint_class,
                  double confidence, double depth_m, double focal_px) {
  constexpr double kReferenceSize = 1000.0 / 4.0;  // px per metre
  const double trusted = TrustedConfidence(options, confidence);
  const double sigma_px = options.sigma_px[static_cast<int>(joint_class)] *
                          std::pow(trusted, -options.confidence_power) *
                          focal_px / depth_m / kReferenceSize;
  return std::max(options.min_sigma_px, sigma_px);
}

double InformationScale(const GraphOptions& options, double dt_s) {
  if (options.correlation_time_s <= 0.0) return options.information_scale;
  const double half = 0.5 * dt_s / options.correlation_time_s;
  // (1 - e^-2h) / (1 + e^-2h) = tanh h.
  return options.information_scale * std::tanh(half);
}

double CentrePerSigma(const GraphOptions& options, double dt_s) {
  // Correlation time of a joint's offset from the person's centre [s].
  constexpr double kHeldS = 3.0;
  return std::sqrt(std::tanh(0.5 * dt_s / kHeldS)) /
         options.birth_position_sigma_m;
}

SolveSchedule MakeSchedule(const GraphOptions& options) {
  // 1.5 sigmas: nearly efficient for clean observations, yet an outlier has at
  // most the influence of two good observations (Huber and Ronchetti, Robust
  // Statistics).
  constexpr double kHuberScale = 1.5;
  // Earlier stages only provide a start.
  constexpr int kEarlyIterations = 3;
  const int last_iterations = static_cast<int>(options.max_iterations);
  SolveSchedule schedule;
  schedule.step_tolerance_m = options.step_tolerance_m;
  if (IsConvex(options.loss)) {
    schedule.stages = {{options.loss, options.loss_scale, last_iterations}};
    return schedule;
  }
  schedule.stages.push_back({LossKind::kHuber, kHuberScale, kEarlyIterations});
  for (const double multiple : options.stages) {
    schedule.stages.push_back(
        {options.loss, multiple * options.loss_scale, kEarlyIterations});
  }
  schedule.stages.back().max_iterations = last_iterations;
  return schedule;
}

}  // namespace kinegraph
