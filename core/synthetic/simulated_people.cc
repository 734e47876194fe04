#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/constants.h"
#include "core/base/random.h"
#include "core/synthetic/body.h"
#include "core/synthetic/crowd.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSwingShare = 0.85;    // swing as a share of a step's period
constexpr double kHeelRiseTime = 0.22;  // before the foot leaves the ground [s]
constexpr double kFootFlatTime = 0.13;  // after the heel strikes [s]
// A foot that is off its neutral position by less stays in place [m].
constexpr double kStepThreshold = 0.05;
constexpr double kTurnThreshold = 0.25;  // [rad]
constexpr double kSeatHeight = 0.3;      // of the hips, share of the stature

double Sine(double time_s, double frequency_hz, double phase) {
  return std::sin(2.0 * kPi * frequency_hz * time_s + phase);
}

// (1 - share) a + share b.
double Blend(double a, double b, double share) { return a + share * (b - a); }

ArmPosture Blend(const ArmPosture& a, const ArmPosture& b, double share) {
  return {Blend(a.flexion, b.flexion, share),
          Blend(a.abduction, b.abduction, share),
          Blend(a.rotation, b.rotation, share), Blend(a.elbow, b.elbow, share)};
}

ArmPosture GesturePosture(GestureKind kind, double time_s) {
  switch (kind) {
    case GestureKind::kRaise:
      return {2.5, 0.15, 0.0, 0.35};
    case GestureKind::kWave:
      return {1.3 + 0.1 * Sine(time_s, 1.2, 0.0), 0.8,
              -0.3 + 0.4 * Sine(time_s, 1.2, 0.0), 1.5};
    case GestureKind::kReach:
      return {1.35, 0.05, 0.0, 0.2 + 0.1 * Sine(time_s, 0.5, 0.0)};
    case GestureKind::kPhone:
      return {0.75, 0.25, 0.45, 2.3};
    case GestureKind::kHandOnHip:
      return {-0.35, 0.75, 0.7, 1.5};
  }
  return {};
}

// A foot on the ground: position of the ankle when the foot is flat.
struct Footprint {
  Vector2d position_m = Vector2d::Zero();
  double yaw = 0.0;
};

// One swing of one foot.
struct Step {
  TimeSpan swing;
  Footprint from;
  Footprint to;
  double length_m = 0.0;  // forward component of the displacement
};

class SimulatedActor : public Actor {
 public:
  // `skeleton` is the scene's; `seed` draws personal habits;
  // `trunk_flexibility` scales the rotation of thorax and head relative to the
  // pelvis (0: trunk and head are rigid).
  SimulatedActor(const BodyShape& shape, const Skeleton& skeleton,
                 Itinerary itinerary, TimeSpan span, double trunk_flexibility,
                 uint64_t seed)
      : shape_(shape),
        joints_(PointsOf(shape, skeleton)),
        itinerary_(std::move(itinerary)),
        trunk_flexibility_(trunk_flexibility) {
    Random random(seed);
    habits_.arm_swing = random.Uniform(0.7, 1.3);
    habits_.elbow = random.Uniform(0.15, 0.45);
    habits_.stance = random.Uniform(0.85, 1.25);
    for (double& phase : habits_.phase) phase = random.Uniform(0.0, 2.0 * kPi);
    PlanSteps(span);
  }

  bool PresentAt(double time_s) const override {
    return std::any_of(itinerary_.present.begin(), itinerary_.present.end(),
                       [&](const TimeSpan& span) {
                         return time_s >= span.begin_s && time_s < span.end_s;
                       });
  }

  Pose3d PoseAt(double time_s) const override {
    const BodyPose body = BodyAt(time_s);
    Pose3d pose;
    pose.reserve(joints_.size());
    for (const BodyPoint& joint : joints_) {
      pose.push_back({PositionOf(joint, body), JointStatus::kObserved});
    }
    return pose;
  }

  SegmentPose TrunkAt(double time_s) const override {
    return BodyAt(time_s)[static_cast<size_t>(Segment::kThorax)];
  }

  Obstacle ObstacleAt(double time_s) const override {
    return ObstacleOf(shape_, BodyAt(time_s));
  }

  ActorFacts Facts() const override {
    ActorFacts facts;
    facts.stature_m = shape_.stature;
    facts.present = itinerary_.present;
    facts.seated = itinerary_.seated;
    return facts;
  }

 private:
  // Personal variations, and the phases of small slow movements.
  struct Habits {
    double arm_swing = 1.0;
    double elbow = 0.25;  // [rad]
    double stance = 1.0;
    std::array<double, 6> phase{};  // [rad]
  };

  BodyPose BodyAt(double time_s) const {
    return PlaceBody(shape_, PostureAt(time_s));
  }
  Posture PostureAt(double time_s) const {
    Posture posture;
    for (const int side : {kLeft, kRight}) {
      posture.feet[side] = FootAt(time_s, side);
    }
    const Vector3d root = itinerary_.path.At(time_s);
    const double heading = root.z();
    const Vector2d forward = Direction(heading);
    const Vector2d left(-forward.y(), forward.x());
    const Vector2d apart = (posture.feet[kLeft].ankle_m.head<2>() -
                            posture.feet[kRight].ankle_m.head<2>());
    // Left foot relative to the right one, as a share of the legs' length.
    const double stride = apart.dot(forward) / shape_.leg();

    double transition = 0.0;
    const double seat = SeatShare(time_s, &transition);

    // The pelvis sinks when the feet are apart (inverted pendulum), moves over
    // the standing foot, and sways slightly.
    const double half = 0.5 * apart.norm();
    const double upright = 0.98 * shape_.leg() + shape_.ankle_height -
                           0.42 * half * half / shape_.leg();
    const double raised =
        posture.feet[kLeft].ankle_m.z() - posture.feet[kRight].ankle_m.z();
    const double aside = -0.025 * std::tanh(5.0 * raised) +
                         0.006 * Sine(time_s, 0.23, habits_.phase[0]);
    const double along =
        0.008 * Sine(time_s, 0.17, habits_.phase[1]) - kSeatDistance * seat;
    const Vector2d pelvis = root.head<2>() + aside * left + along * forward;
    const double height = Blend(upright, kSeatHeight * shape_.stature, seat) +
                          0.003 * Sine(time_s, 0.25, habits_.phase[4]);
    posture.pelvis_m = {pelvis.x(), pelvis.y(), height};
    posture.heading = heading;
    posture.lean = 0.03 + 0.04 * stride * stride + 0.6 * transition -
                   0.08 * seat + 0.01 * Sine(time_s, 0.21, habits_.phase[5]);

    // The pelvis rotates with the leading leg, the thorax against it; the head
    // turns slowly and compensates most of the lean.
    const double pelvis_yaw = -0.12 * trunk_flexibility_ * stride;
    posture.heading += pelvis_yaw;
    posture.twist = -2.0 * pelvis_yaw;
    posture.head_yaw = trunk_flexibility_ * 0.3 *
                       Sine(time_s, 0.13, habits_.phase[2]) *
                       Sine(time_s, 0.071, habits_.phase[3]);
    posture.head_pitch =
        trunk_flexibility_ *
        (-0.6 * posture.lean + 0.08 * Sine(time_s, 0.19, habits_.phase[4]));

    for (const int side : {kLeft, kRight}) {
      // Each arm swings with the opposite leg.
      const double swing =
          -SignOf(side) * 0.5 * habits_.arm_swing * stride * (1.0 - seat);
      posture.arms[side] = ArmAt(time_s, side, swing, seat);
    }
    return posture;
  }

  // Position of a foot for a person standing where the path is at `time_s`.
  Footprint Neutral(double time_s, int side) const {
    const Vector3d root = itinerary_.path.At(time_s);
    const double heading = root.z();
    const Vector2d left(-std::sin(heading), std::cos(heading));
    const double aside =
        SignOf(side) * habits_.stance * 1.05 * shape_.hip_half_width;
    // The toes point slightly outwards.
    return {root.head<2>() + aside * left, heading + SignOf(side) * 0.1};
  }

  // Faster steps at higher speed: cadence grows with the square root of speed
  // (Grieve and Gear 1966 found an exponent of about 0.4 to 0.5).
  double StepPeriod(double time_s) const {
    constexpr double kHalf = 0.15;
    const double speed_ms = (itinerary_.path.At(time_s + kHalf) -
                             itinerary_.path.At(time_s - kHalf))
                                .head<2>()
                                .norm() /
                            (2.0 * kHalf);
    // 0.845 m: the legs of a person of the default stature of 1.72 m.
    const double leg_factor = std::sqrt(shape_.leg() / 0.845);
    return leg_factor *
           std::clamp(0.54 * std::sqrt(1.2 / std::max(speed_ms, 0.1)), 0.48,
                      0.75);
  }

  // Whether the feet stay in place, from 0.1 s before the person begins to sit
  // down until they stand again.
  bool SeatedAround(double time_s) const {
    return std::any_of(itinerary_.seated.begin(), itinerary_.seated.end(),
                       [&](const TimeSpan& span) {
                         return time_s > span.begin_s - 0.1 &&
                                time_s < span.end_s;
                       });
  }

  // Feet step alternately. A foot lands at its neutral position in the middle
  // of the coming stance, so that the body passes over it; when the body stops,
  // so do the feet.
  void PlanSteps(TimeSpan span) {
    std::array<Footprint, 2> feet = {Neutral(span.begin_s, kLeft),
                                     Neutral(span.begin_s, kRight)};
    int next = habits_.phase[0] < kPi ? kLeft : kRight;
    double time_s = span.begin_s;
    while (time_s < span.end_s) {
      const double period = StepPeriod(time_s + 0.3);
      const double swing = kSwingShare * period;
      const double middle_of_stance = time_s + 0.5 * (swing + 2.0 * period);
      auto displaced = [&](int side) {
        const Footprint target = Neutral(middle_of_stance, side);
        return (target.position_m - feet[side].position_m).norm() >
                   kStepThreshold ||
               std::abs(target.yaw - feet[side].yaw) > kTurnThreshold;
      };
      if (!displaced(next)) next = 1 - next;
      if (!displaced(next) || SeatedAround(time_s + swing)) {
        time_s += 0.05;
        continue;
      }
      Step step;
      step.swing = {time_s, time_s + swing};
      step.from = feet[next];
      step.to = Neutral(middle_of_stance, next);
      step.length_m =
          Direction(step.to.yaw).dot(step.to.position_m - step.from.position_m);
      steps_[next].push_back(step);
      feet[next] = step.to;
      next = 1 - next;
      time_s += period;
    }
    for (const int side : {kLeft, kRight}) {
      if (!steps_[side].empty()) continue;  // stands still all the time
      Step rest;
      rest.swing = {span.begin_s, span.begin_s + 0.5};
      rest.from = rest.to = feet[side];
      steps_[side].push_back(rest);
    }
  }

  FootPosture FootAt(double time_s, int side) const {
    const std::vector<Step>& steps = steps_[side];
    const auto after = std::upper_bound(
        steps.begin(), steps.end(), time_s,
        [](double t, const Step& step) { return t < step.swing.begin_s; });
    // The current or last swing, or the first one to come.
    const Step& current = after == steps.begin() ? *after : *(after - 1);
    const double duration = current.swing.end_s - current.swing.begin_s;
    const double progress = (time_s - current.swing.begin_s) / duration;
    const double share = SmoothStep(progress);
    const Vector2d on_ground =
        current.from.position_m +
        share * (current.to.position_m - current.from.position_m);
    FootPosture foot;
    foot.yaw = Blend(current.from.yaw, current.to.yaw, share);

    // The heel rises before the swing and the foot strikes with the heel; both
    // grow with the step's length.
    double toes_down = 0.0;
    double toes_up = 0.0;
    double lift = 0.0;
    auto add = [&](const Step& step) {
      const double t0 = step.swing.begin_s;
      const double t1 = step.swing.end_s;
      const double size = std::clamp(step.length_m / 1.3, 0.0, 1.1);
      toes_down += 0.6 * size *
                   SmoothBump(time_s, t0 - kHeelRiseTime, t0 + 0.08 * (t1 - t0),
                              t0 + 0.62 * (t1 - t0));
      toes_up += 0.28 * size *
                 SmoothBump(time_s, t0 + 0.5 * (t1 - t0), t1 - 0.03,
                            t1 + kFootFlatTime);
      lift += (0.035 + 0.045 * size) *
              SmoothBump(time_s, t0, t0 + 0.45 * (t1 - t0), t1);
    };
    add(current);
    if (after != steps.end() && after != steps.begin()) add(*after);
    foot.pitch = toes_down - toes_up;

    // The foot rolls over the ball with toes down and over the heel with toes
    // up; the ankle moves accordingly.
    const double ball = 0.68 * shape_.foot_length;
    const double heel = 0.2 * shape_.foot_length;
    const double height = shape_.ankle_height;
    const double forward =
        ball * (1.0 - std::cos(toes_down)) + height * std::sin(toes_down) -
        heel * (1.0 - std::cos(toes_up)) - height * std::sin(toes_up);
    const double up =
        ball * std::sin(toes_down) + height * (std::cos(toes_down) - 1.0) +
        heel * std::sin(toes_up) + height * (std::cos(toes_up) - 1.0);
    const Vector2d position = on_ground + forward * Direction(foot.yaw);
    foot.ankle_m = {position.x(), position.y(), height + up + lift};
    return foot;
  }

  // 0: upright, 1: seated. `transition` is 1 in the middle of sitting down or
  // standing up and falls to 0 towards either end.
  double SeatShare(double time_s, double* transition) const {
    double share = 0.0;
    *transition = 0.0;
    for (const TimeSpan& seat : itinerary_.seated) {
      const double down = (time_s - seat.begin_s) / kSitDownTime;
      const double up = (seat.end_s - time_s) / kSitDownTime;
      share += SmoothStep(down) * SmoothStep(up);
      *transition +=
          SmoothBump(down, 0.0, 0.5, 1.1) + SmoothBump(up, 0.0, 0.5, 1.1);
    }
    return share;
  }

  ArmPosture ArmAt(double time_s, int side, double swing, double seat) const {
    const double sway = 0.03 * Sine(time_s, 0.31, habits_.phase[2 + side]);
    const ArmPosture hanging = {0.02 + swing + sway, 0.1 + sway * sway, 0.05,
                                habits_.elbow + 0.35 * swing};
    const ArmPosture on_thigh = {0.4, 0.12, 0.15, 0.95};
    ArmPosture arm = Blend(hanging, on_thigh, seat);
    for (const Gesture& gesture : itinerary_.gestures) {
      if (gesture.side != side) continue;
      constexpr double kRamp = 0.75;
      const double share = SmoothStep((time_s - gesture.span.begin_s) / kRamp) *
                           SmoothStep((gesture.span.end_s - time_s) / kRamp);
      if (share <= 0.0) continue;
      arm = Blend(arm, GesturePosture(gesture.kind, time_s), share);
    }
    return arm;
  }

  BodyShape shape_;
  std::vector<BodyPoint> joints_;  // of the scene's skeleton
  Itinerary itinerary_;
  double trunk_flexibility_;
  Habits habits_;
  std::array<std::vector<Step>, 2> steps_;
};

BodyShape RandomShape(const SceneOptions& options, Random* random) {
  const double stature =
      std::clamp(random->Normal(options.stature_m, options.stature_sigma_m),
                 options.stature_m - 2.5 * options.stature_sigma_m,
                 options.stature_m + 2.5 * options.stature_sigma_m);
  const double leg_share = std::clamp(random->Normal(1.0, 0.015), 0.96, 1.04);
  return MakeBodyShape(stature, leg_share);
}

}  // namespace

std::vector<std::shared_ptr<const Actor>> SimulatePeople(
    const SceneOptions& options, const Skeleton& skeleton) {
  Random random(static_cast<uint64_t>(options.seed));
  const TimeSpan span = {-kSceneMargin, options.duration_s + kSceneMargin};
  std::vector<Itinerary> itineraries = SimulateCrowd(
      options.motion, static_cast<int>(options.people), span, random.Fork());
  std::vector<std::shared_ptr<const Actor>> people;
  for (Itinerary& itinerary : itineraries) {
    const BodyShape shape = RandomShape(options, &random);
    people.push_back(std::make_shared<SimulatedActor>(
        shape, skeleton, std::move(itinerary), span, options.trunk_flexibility,
        random.Fork()));
  }
  return people;
}

}  // namespace kinegraph
