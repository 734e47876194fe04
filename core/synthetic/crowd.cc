#include "core/synthetic/crowd.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/constants.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;

constexpr double kStep = 0.05;  // of the simulation [s]
constexpr int kStepsPerKnot = 4;
constexpr double kRelaxation = 0.6;        // time constant of velocity [s]
constexpr double kMaxAcceleration = 2.5;   // [m/s^2]
constexpr double kAvoidanceHorizon = 2.5;  // looks ahead this far [s]
// A person sits down only with this much more room than the minimum distance to
// others; while seated, half of it is kept [m].
constexpr double kSeatClearance = 0.35;
// After this time a walk to a goal that was not reached ends [s].
constexpr double kPatience = 9.0;

double Wrap(double angle_rad) { return std::remainder(angle_rad, 2.0 * kPi); }

double AngleOf(const Vector2d& v) { return std::atan2(v.y(), v.x()); }

enum class Action { kWalk, kStand, kTurn, kSit, kLeave, kOutside };

struct Agent {
  Action action = Action::kStand;
  double action_until_s = 0.0;
  Vector2d position = Vector2d::Zero();
  Vector2d velocity = Vector2d::Zero();
  double heading = 0.0;
  double heading_rate = 0.0;
  double wanted_heading = 0.0;
  Vector2d goal = Vector2d::Zero();
  double speed = 1.2;
  bool visitor = false;
  double leaves_after_s = 0.0;
  Itinerary plan;
  std::vector<Eigen::Vector3d> knots;  // of the path

  bool walks() const {
    return action == Action::kWalk || action == Action::kLeave;
  }
  bool inside() const { return action != Action::kOutside; }
  bool sits() const { return action == Action::kSit; }
  // Centre of the space that the person occupies.
  Vector2d centre() const {
    if (!sits()) return position;
    return position - 0.5 * kSeatDistance * Direction(heading);
  }
};

class Crowd {
 public:
  Crowd(const CrowdOptions& options, int people, TimeSpan span, uint64_t seed)
      : options_(options),
        span_(span),
        now_s_(span.begin_s),
        random_(seed),
        agents_(static_cast<size_t>(people)) {}

  std::vector<Itinerary> Run() {
    // Agents that are not placed yet are outside and occupy no space.
    for (Agent& agent : agents_) agent.action = Action::kOutside;
    for (Agent& agent : agents_) Place(agent);
    const auto steps =
        static_cast<int64_t>(std::ceil((span_.end_s - span_.begin_s) / kStep));
    for (int64_t step = 0; step <= steps; ++step) {
      now_s_ = span_.begin_s + kStep * static_cast<double>(step);
      for (Agent& agent : agents_) {
        if (step % kStepsPerKnot == 0) {
          agent.knots.emplace_back(agent.position.x(), agent.position.y(),
                                   agent.heading);
        }
        Decide(agent);
      }
      for (Agent& agent : agents_) {
        if (!agent.inside()) continue;
        Walk(agent);
        Turn(agent);
      }
      KeepApart();
    }
    std::vector<Itinerary> plans;
    for (Agent& agent : agents_) {
      agent.plan.path = UniformSpline(span_.begin_s, kStep * kStepsPerKnot,
                                      std::move(agent.knots));
      PlanGestures(&agent.plan);
      plans.push_back(std::move(agent.plan));
    }
    return plans;
  }

 private:
  double outer_radius() const { return options_.area_radius_m + kOuterMargin; }
  // Minimum distance of the centres of two people.
  double MinDistance(const Agent& a, const Agent& b) const {
    return options_.min_distance_m + (a.sits() ? 0.5 * kSeatClearance : 0.0) +
           (b.sits() ? 0.5 * kSeatClearance : 0.0);
  }

  // Distance from `point` to the nearest other person in the scene; 1e9 if
  // there is none.
  double Room(const Vector2d& point, const Agent& self) const {
    double room = 1e9;
    for (const Agent& other : agents_) {
      if (&other == &self || !other.inside()) continue;
      room = std::min(room, (other.centre() - point).norm());
    }
    return room;
  }

  // People start at free positions, visitors possibly outside.
  void Place(Agent& agent) {
    agent.action = Action::kOutside;  // occupies no space until placed
    agent.speed = options_.walking_speed_ms *
                  std::clamp(random_.Normal(1.0, 0.13), 0.7, 1.3);
    agent.visitor = random_.Chance(options_.visitors);
    agent.leaves_after_s = span_.begin_s + random_.Uniform(5.0, 14.0);
    double best = -1.0;
    for (int attempt = 0; attempt < 40; ++attempt) {
      const double radius =
          options_.area_radius_m * std::sqrt(random_.Uniform());
      const Vector2d at = radius * Direction(random_.Uniform(-kPi, kPi));
      const double room = Room(at, agent);
      if (room <= best) continue;
      best = room;
      agent.position = at;
      if (best > 2.0 * options_.min_distance_m) break;
    }
    agent.heading = agent.wanted_heading = random_.Uniform(-kPi, kPi);
    if (agent.visitor && random_.Chance(0.6)) {
      agent.position = outer_radius() * Direction(random_.Uniform(-kPi, kPi));
      agent.heading = agent.wanted_heading = AngleOf(-agent.position);
      agent.action_until_s = random_.Uniform(0.5, 6.0);
      return;
    }
    agent.plan.present.push_back({span_.begin_s, span_.end_s});
    Begin(agent, Action::kStand, random_.Uniform(0.2, 1.5));
  }

  // Gestures fill the requested share of time, 1.5 .. 4 s each.
  void PlanGestures(Itinerary* itinerary) {
    if (options_.arm_motion <= 0.0) return;
    constexpr double kMeanLength = 2.75;
    const double mean_pause =
        kMeanLength * (1.0 - options_.arm_motion) / options_.arm_motion;
    double time_s = span_.begin_s + random_.Uniform(0.0, 2.0 * mean_pause);
    while (time_s < span_.end_s) {
      Gesture gesture;
      gesture.span = {time_s, time_s + random_.Uniform(1.5, 4.0)};
      gesture.side = static_cast<int>(random_.Index(2));
      gesture.kind = static_cast<GestureKind>(random_.Index(kGestureKindCount));
      itinerary->gestures.push_back(gesture);
      time_s = gesture.span.end_s + random_.Uniform(0.0, 2.0 * mean_pause);
    }
  }

  void Decide(Agent& agent) {
    const bool over = now_s_ >= agent.action_until_s;
    switch (agent.action) {
      case Action::kLeave:
        if (agent.position.norm() > outer_radius()) {
          agent.plan.present.back().end_s = now_s_;
          agent.velocity.setZero();
          Begin(agent, Action::kOutside, random_.Uniform(2.5, 6.0));
        }
        return;
      case Action::kOutside: {
        // Moves to another entrance while absent, long enough before the return
        // that the smoothing of the path does not affect visible parts.
        const double left = agent.action_until_s - now_s_;
        if (left > 1.2 && left <= 1.2 + kStep) {
          agent.position =
              outer_radius() * Direction(random_.Uniform(-kPi, kPi));
          agent.wanted_heading =
              agent.heading + Wrap(AngleOf(-agent.position) - agent.heading);
          agent.heading = agent.wanted_heading;
          agent.heading_rate = 0.0;
        }
        if (over) ComeIn(agent);
        return;
      }
      case Action::kWalk:
        if (over || (agent.goal - agent.position).norm() < 0.3) {
          // Comes to rest before anything except walking on.
          if (random_.Chance(options_.walking)) {
            BeginWalk(agent);
          } else {
            Begin(agent, Action::kStand, random_.Uniform(0.6, 1.2));
          }
        }
        return;
      case Action::kStand:
      case Action::kTurn:
      case Action::kSit:
        if (over) BeginRandomAction(agent);
        return;
    }
  }

  void Begin(Agent& agent, Action action, double duration_s) {
    agent.action = action;
    agent.action_until_s = now_s_ + duration_s;
  }

  // The next action, by the weights of the options.
  void BeginRandomAction(Agent& agent) {
    if (agent.visitor && now_s_ > agent.leaves_after_s) {
      BeginLeaving(agent);
      return;
    }
    const double total = options_.walking + options_.standing +
                         options_.turning + options_.sitting;
    double draw = random_.Uniform() * total;
    if ((draw -= options_.walking) < 0.0 || total <= 0.0) {
      BeginWalk(agent);
    } else if ((draw -= options_.standing) < 0.0) {
      Begin(agent, Action::kStand, random_.Uniform(1.0, 4.0));
    } else if (draw < options_.turning) {
      const double turn = random_.Uniform(0.8, kPi);
      agent.wanted_heading += random_.Chance(0.5) ? turn : -turn;
      Begin(agent, Action::kTurn, 0.8 + turn / 1.5);
    } else {
      // The seat needs space behind the person.
      const Vector2d seat =
          agent.position - kSeatDistance * Direction(agent.heading);
      if (Room(seat, agent) < options_.min_distance_m + kSeatClearance) {
        Begin(agent, Action::kStand, random_.Uniform(0.5, 1.5));
        return;
      }
      const double duration = 2.0 * kSitDownTime + random_.Uniform(1.0, 5.0);
      // Stands still for a moment before and after.
      agent.plan.seated.push_back({now_s_ + 0.4, now_s_ + 0.4 + duration});
      agent.wanted_heading = agent.heading;
      Begin(agent, Action::kSit, duration + 0.8);
    }
  }

  void BeginWalk(Agent& agent) {
    agent.goal = ChooseGoal(agent);
    Begin(agent, Action::kWalk, kPatience);
  }

  void BeginLeaving(Agent& agent) {
    const Vector2d out = agent.position + 0.5 * agent.velocity;
    const double angle = AngleOf(out) + random_.Normal(0.0, 0.3);
    agent.goal = (outer_radius() + 1.0) * Direction(angle);
    Begin(agent, Action::kLeave, 1e9);
  }

  void ComeIn(Agent& agent) {
    if (Room(agent.position, agent) < 2.0 * options_.min_distance_m) {
      agent.action_until_s = now_s_ + 0.5;  // somebody is near the entrance
      return;
    }
    agent.plan.present.push_back({now_s_, span_.end_s});
    agent.leaves_after_s = now_s_ + random_.Uniform(5.0, 14.0);
    BeginWalk(agent);
  }

  Vector2d ChooseGoal(const Agent& agent) {
    Vector2d goal = agent.position;
    const bool crossing = random_.Chance(options_.crossing);
    for (int attempt = 0; attempt < 30; ++attempt) {
      double radius = options_.area_radius_m * std::sqrt(random_.Uniform());
      double angle = random_.Uniform(-kPi, kPi);
      if (crossing) {  // to the other side
        radius = options_.area_radius_m * random_.Uniform(0.6, 1.0);
        angle = AngleOf(-agent.position) + random_.Normal(0.0, 0.5);
      }
      goal = radius * Direction(angle);
      const bool far = (goal - agent.position).norm() >
                       std::min(1.5, 0.6 * options_.area_radius_m);
      if (far && Room(goal, agent) > 2.0 * options_.min_distance_m) break;
    }
    return goal;
  }

  // Sum of repulsions from people in the way [m/s^2]: from those whom a
  // straight continuation would pass too closely (stronger, the sooner), and
  // from those nearby.
  Vector2d Avoidance(const Agent& agent) const {
    Vector2d push = Vector2d::Zero();
    for (const Agent& other : agents_) {
      if (&other == &agent || !other.inside()) continue;
      const double wanted = MinDistance(agent, other) + 0.3;
      const Vector2d offset = other.centre() - agent.position;
      const double distance = std::max(offset.norm(), 1e-6);
      const Vector2d approach = agent.velocity - other.velocity;
      const double speed_squared = approach.squaredNorm();
      if (speed_squared > 1e-4) {
        const double time_s = std::clamp(offset.dot(approach) / speed_squared,
                                         0.0, kAvoidanceHorizon);
        const Vector2d miss = offset - time_s * approach;
        const double miss_distance = miss.norm();
        if (miss_distance < wanted && time_s > 0.0) {
          // Head on: both step to their right.
          const Vector2d right(approach.y(), -approach.x());
          const Vector2d away =
              miss_distance > 0.05 ? Vector2d(-miss / miss_distance)
                                   : Vector2d(right / std::sqrt(speed_squared));
          push +=
              4.0 * (1.0 - miss_distance / wanted) * std::exp(-time_s) * away;
        }
      }
      if (distance < wanted) {
        push -= 8.0 * (1.0 - distance / wanted) * offset / distance;
      }
    }
    return push;
  }

  void Walk(Agent& agent) const {
    Vector2d wanted = Vector2d::Zero();
    if (agent.walks()) {
      const Vector2d to_goal = agent.goal - agent.position;
      const double distance = std::max(to_goal.norm(), 1e-9);
      const double angle = Wrap(AngleOf(to_goal) - agent.heading);
      // Turns before walking off, slows down when arriving.
      const double facing =
          std::clamp((1.0 + 2.0 * std::cos(angle)) / 3.0, 0.05, 1.0);
      const double speed = std::min(agent.speed, 1.3 * distance) * facing;
      wanted = to_goal / distance * speed;
      agent.wanted_heading = agent.heading + angle;
    }
    Vector2d acceleration = (wanted - agent.velocity) / kRelaxation;
    if (agent.walks()) acceleration += Avoidance(agent);
    const double size = acceleration.norm();
    if (size > kMaxAcceleration) acceleration *= kMaxAcceleration / size;
    agent.velocity += kStep * acceleration;
    const double limit = 1.3 * agent.speed;
    if (agent.velocity.norm() > limit)
      agent.velocity *= limit / agent.velocity.norm();
    agent.position += kStep * agent.velocity;
    // A walker looks in the direction of motion.
    if (agent.walks() && agent.velocity.norm() > 0.3) {
      agent.wanted_heading =
          agent.heading + Wrap(AngleOf(agent.velocity) - agent.heading);
    }
  }

  // Critically damped turning.
  void Turn(Agent& agent) const {
    constexpr double kStiffness = 16.0;  // [1/s^2]
    constexpr double kMaxRate = 2.5;     // [rad/s]
    const double pull = kStiffness * (agent.wanted_heading - agent.heading) -
                        2.0 * std::sqrt(kStiffness) * agent.heading_rate;
    agent.heading_rate =
        std::clamp(agent.heading_rate + kStep * std::clamp(pull, -10.0, 10.0),
                   -kMaxRate, kMaxRate);
    agent.heading += kStep * agent.heading_rate;
  }

  // Separates people whom steering did not keep apart.
  void KeepApart() {
    for (size_t i = 0; i < agents_.size(); ++i) {
      for (size_t k = i + 1; k < agents_.size(); ++k) {
        Agent& a = agents_[i];
        Agent& b = agents_[k];
        if (!a.inside() || !b.inside()) continue;
        const Vector2d offset = b.centre() - a.centre();
        const double distance = std::max(offset.norm(), 1e-6);
        const double overlap = MinDistance(a, b) - distance;
        if (overlap <= 0.0) continue;
        const Vector2d away = offset / distance;
        // A sitting person is not pushed. At most 0.6 m/s, like a step aside.
        const double push = std::min(overlap, 0.6 * kStep);
        const double share_a = a.sits() ? 0.0 : (b.sits() ? 1.0 : 0.5);
        const double share_b = b.sits() ? 0.0 : 1.0 - share_a;
        a.position -= share_a * push * away;
        b.position += share_b * push * away;
        const double closing = (a.velocity - b.velocity).dot(away);
        if (closing > 0.0) {
          a.velocity -= share_a * closing * away;
          b.velocity += share_b * closing * away;
        }
      }
    }
  }

  const CrowdOptions& options_;
  TimeSpan span_;
  double now_s_;
  Random random_;
  std::vector<Agent> agents_;
};

}  // namespace

std::vector<Itinerary> SimulateCrowd(const CrowdOptions& options, int people,
                                     TimeSpan span, uint64_t seed) {
  return Crowd(options, people, span, seed).Run();
}

}  // namespace kinegraph
