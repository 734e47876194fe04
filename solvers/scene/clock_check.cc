#include "solvers/scene/clock_check.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

namespace kinegraph {
namespace {

// Velocities are taken over this time before and after: positions that are
// triangulated frame by frame are too rough for less.
constexpr TimeNs kSpan = 100'000'000;
// At less than half of it the velocity is not known.
constexpr double kLeastSpanS = 0.1;
// Over more it is no velocity.
constexpr double kMostSpanS = 0.5;
// What moves more slowly tells the detector's bias rather than the time.
constexpr double kLeastSpeedMps = 0.3;

// Where a sample's joint is in another frame.
std::optional<Eigen::Vector3d> PositionIn(const ClockCheck::Moment& moment,
                                          const ClockCheck::Sample& sample) {
  for (const auto& [id, joints] : moment.people) {
    if (id != sample.person) continue;
    if (!joints[sample.joint].present()) return std::nullopt;
    return joints[sample.joint].position_m;
  }
  return std::nullopt;
}

}  // namespace

ClockCheck::ClockCheck(CameraRig cameras)
    : cameras_(std::move(cameras)), late_(cameras_.size()) {}

void ClockCheck::SeeTracks(const TrackFrame& frame) {
  Moment& moment = recent_.emplace_back();
  moment.time = frame.time;
  for (const PersonPose& person : frame.people) {
    moment.people.emplace_back(person.id, person.joints);
  }
  while (!waiting_.empty() && waiting_.front().time + kSpan <= frame.time) {
    Weigh(waiting_.front());
    waiting_.pop_front();
  }
  const TimeNs needed =
      (waiting_.empty() ? frame.time : waiting_.front().time) - kSpan;
  while (recent_.size() > 1 && recent_[1].time <= needed) recent_.pop_front();
}

const ClockCheck::Moment& ClockCheck::NearestTo(TimeNs time) const {
  return *std::min_element(
      recent_.begin(), recent_.end(), [&](const Moment& a, const Moment& b) {
        return std::abs(a.time - time) < std::abs(b.time - time);
      });
}

void ClockCheck::Weigh(const Sample& sample) {
  const Moment& before = NearestTo(sample.time - kSpan);
  const Moment& after = NearestTo(sample.time + kSpan);
  const double span_s = ToSeconds(after.time - before.time);
  if (span_s < kLeastSpanS || span_s > kMostSpanS) return;
  const auto from = PositionIn(before, sample);
  const auto to = PositionIn(after, sample);
  if (!from.has_value() || !to.has_value()) return;
  const Camera& camera = cameras_[sample.view];
  const auto from_px = camera.Project(*from);
  const auto to_px = camera.Project(*to);
  if (!from_px.has_value() || !to_px.has_value()) return;
  const Eigen::Vector2d px_per_s = (*to_px - *from_px) / span_s;
  const double m_per_px = camera.Depth(*to) / camera.focal_px();
  const double speed_mps = px_per_s.norm() * m_per_px;
  if (speed_mps < kLeastSpeedMps) return;
  const double late_s =
      sample.residual_px.dot(px_per_s) / px_per_s.squaredNorm();
  const double squared_speed = sample.weight * speed_mps * speed_mps;
  Lateness& lateness = late_[sample.view];
  lateness.late_s.emplace_back(late_s - sample.told_late_s, squared_speed);
  lateness.weight += sample.weight;
  lateness.squared_speed += squared_speed;
}

std::vector<ClockCheck::View> ClockCheck::Views() const {
  std::vector<View> views;
  for (const Lateness& lateness : late_) {
    View& view = views.emplace_back();
    view.samples = lateness.late_s.size();
    if (view.samples == 0) continue;
    view.late_s = WeightedMedian(lateness.late_s);
    view.error_m = std::abs(view.late_s) *
                   std::sqrt(lateness.squared_speed / lateness.weight);
  }
  return views;
}

}  // namespace kinegraph
