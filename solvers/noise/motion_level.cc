#include "solvers/noise/motion_level.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kLeastLevel = 1.0 / 40.0;
constexpr double kGreatestLevel = 1000.0;
// The part of a point's error that never lasts: of its variance, and a tenth of
// a millimetre, which keeps it above zero.
constexpr double kFreshShare = 0.02;
constexpr double kLeastVarianceM2 = 1e-8;

// Whether a correction would lose what stands in the last two of the 16 digits
// of a variance: what is predicted is so vague, as after a pause of hours, that
// nothing is known.
bool LosesDigits(double predicted_m2, double variance_m2) {
  return predicted_m2 > 1e14 * (kFreshShare * variance_m2 + kLeastVarianceM2);
}

}  // namespace

double UsualProcessNoise(JointClass joint_class) {
  // head trunk shoulder elbow wrist hip knee ankle foot other
  constexpr std::array<double, kJointClassCount> kUsual = {
      0.6, 0.6, 0.6, 1.3, 3.8, 0.65, 3.5, 8.4, 8.4, 3.8};
  return kUsual[static_cast<int>(joint_class)];
}

double LogLevelStep() {
  return std::log(kGreatestLevel / kLeastLevel) / (kLevelCount - 1);
}

double LogLevel(int level) {
  return std::log(kLeastLevel) + level * LogLevelStep();
}

void FilterBank::Predict(double dt_s, double phi, double power,
                         Filter* filter) {
  const double dt = dt_s;
  const double q = power;
  for (Axis& x : filter->axes) {
    x.p += dt * x.v;
    x.n *= phi;
    x.pp += dt * (2.0 * x.pv + dt * x.vv) + q * dt * dt * dt / 3.0;
    x.pv += dt * x.vv + 0.5 * q * dt * dt;
    x.vv += q * dt;
    x.pn = phi * (x.pn + dt * x.vn);
    x.vn *= phi;
    x.nn = phi * phi * x.nn + 1.0 - phi * phi;
  }
}

FilterBank::Innovation FilterBank::Innovate(
    const Filter& filter, const FramePoint& point,
    const ErrorCorrelation& correlation) {
  const double fresh_share = 1.0 + kFreshShare - correlation.share;
  Innovation innovation;
  for (int i = 0; i < 3; ++i) {
    const Axis& x = filter.axes[i];
    const double variance = point.covariance_m2(i, i);
    const double gain = std::sqrt(correlation.share * variance);
    const double error = point.position_m[i] - x.p - gain * x.n;
    const double spread = x.pp + 2.0 * gain * x.pn + gain * gain * x.nn +
                          fresh_share * variance + kLeastVarianceM2;
    innovation.gain[i] = gain;
    innovation.error[i] = error;
    innovation.spread[i] = spread;
    innovation.mean_square += error * error / spread / 3.0;
    innovation.log_spread += std::log(spread);
  }
  return innovation;
}

void FilterBank::Correct(const Innovation& innovation, double wider,
                         Filter* filter) {
  for (int i = 0; i < 3; ++i) {
    Axis& x = filter->axes[i];
    const double gain = innovation.gain[i];
    const double error = innovation.error[i];
    const double s = wider * innovation.spread[i];
    const double hp = x.pp + gain * x.pn;
    const double hv = x.pv + gain * x.vn;
    const double hn = x.pn + gain * x.nn;
    x.p += hp / s * error;
    x.v += hv / s * error;
    x.n += hn / s * error;
    x.pp -= hp * hp / s;
    x.pv -= hp * hv / s;
    x.vv -= hv * hv / s;
    x.pn -= hp * hn / s;
    x.vn -= hv * hn / s;
    x.nn -= hn * hn / s;
  }
}

void FilterBank::Add(TimeNs time, const std::optional<FramePoint>& point,
                     const ErrorCorrelation& correlation, Levels* evidence) {
  const auto start = [&] {
    filters_ = {};
    for (Filter& filter : filters_) {
      for (int i = 0; i < 3; ++i) filter.axes[i].p = point->position_m[i];
    }
  };
  if (!started_) {
    if (!point.has_value()) return;
    started_ = true;
    time_ = time;
    start();
  }
  constexpr double kKnown = 3.0;  // of the mean of e^2 / S
  const double dt_s = ToSeconds(time - time_);
  time_ = time;
  const double phi = std::exp(-dt_s / correlation.time_s);
  for (int level = 0; level < kLevelCount; ++level) {
    Predict(dt_s, phi, usual_ * std::exp(LogLevel(level)), &filters_[level]);
  }
  if (!point.has_value()) return;
  for (int i = 0; i < 3; ++i) {
    // The last level is driven most.
    if (LosesDigits(filters_.back().axes[i].pp, point->covariance_m2(i, i))) {
      start();
    }
  }
  for (int level = 0; level < kLevelCount; ++level) {
    Filter& filter = filters_[level];
    const Innovation innovation = Innovate(filter, *point, correlation);
    const double mean = innovation.mean_square;
    const double robust =
        mean <= kKnown ? mean : kKnown * (1.0 + std::log(mean / kKnown));
    (*evidence)[level] -= 0.5 * (innovation.log_spread + 3.0 * robust);
    Correct(innovation, std::max(1.0, mean / kKnown), &filter);
  }
}

namespace {

bool MovesWithTheBody(JointClass joint_class) {
  return joint_class == JointClass::kHead ||
         joint_class == JointClass::kTrunk ||
         joint_class == JointClass::kShoulder ||
         joint_class == JointClass::kHip;
}

enum class Side { kNone, kLeft, kRight };

Side SideOf(const Skeleton& skeleton, int joint_idx) {
  if (skeleton.mirror(joint_idx) == joint_idx) return Side::kNone;
  const bool left = skeleton.joints()[joint_idx].rfind("l_", 0) == 0;
  return left ? Side::kLeft : Side::kRight;
}

}  // namespace

MotionGroups::MotionGroups(const Skeleton& skeleton) {
  std::map<std::pair<JointClass, Side>, int> known;
  for (int j = 0; j < skeleton.joint_count(); ++j) {
    const JointClass joint_class = skeleton.joint_class(j);
    const Side side =
        MovesWithTheBody(joint_class) ? Side::kNone : SideOf(skeleton, j);
    const auto [group, is_new] =
        known.try_emplace({joint_class, side}, static_cast<int>(known.size()));
    if (is_new) classes_.push_back(joint_class);
    of_joint_.push_back(group->second);
  }
}

double MotionGroups::share_of_class(int group) const {
  return 1.0 / static_cast<double>(std::count(classes_.begin(), classes_.end(),
                                              classes_[group]));
}

double RecordingLevel(const Levels& evidence) {
  constexpr double kSpread = 1.0;  // of ln level
  Levels posterior;
  for (int i = 0; i < kLevelCount; ++i) {
    const double away = LogLevel(i) / kSpread;
    posterior[i] = evidence[i] - 0.5 * away * away;
  }
  const int best = static_cast<int>(
      std::max_element(posterior.begin(), posterior.end()) - posterior.begin());
  double level = LogLevel(best);
  if (best > 0 && best + 1 < kLevelCount) {
    const double below = posterior[best] - posterior[best - 1];
    const double above = posterior[best] - posterior[best + 1];
    if (below + above > 0.0) {
      level += 0.5 * LogLevelStep() * (below - above) / (below + above);
    }
  }
  return std::max(level, std::log(0.1));
}

LevelChain::LevelChain(double recording_level) {
  constexpr double kSpread = 1.0;  // of ln level
  constexpr double kTime_s = 0.5;
  constexpr double kAnywhere_hz = 0.2;
  for (int i = 0; i < kLevelCount; ++i) {
    const double away = (LogLevel(i) - recording_level) / kSpread;
    stationary_[i] = std::exp(-0.5 * away * away);
  }
  stationary_ /= stationary_.sum();
  // Diffusion of the Ornstein-Uhlenbeck process, in steps: detailed balance
  // makes its stationary distribution that of the jumps.
  const double rate_hz =
      kSpread * kSpread / kTime_s / (LogLevelStep() * LogLevelStep());
  rates_.setZero();
  for (int i = 0; i + 1 < kLevelCount; ++i) {
    const double root = std::sqrt(stationary_[i + 1] / stationary_[i]);
    rates_(i + 1, i) += rate_hz * root;
    rates_(i, i + 1) += rate_hz / root;
  }
  rates_.array() += kAnywhere_hz / kLevelCount;
  for (int i = 0; i < kLevelCount; ++i) {
    rates_(i, i) = 0.0;
    rates_(i, i) = -rates_.col(i).sum();
  }
}

const LevelChain::Matrix& LevelChain::Transition(TimeNs dt) {
  constexpr TimeNs kRounding = 2;  // ns
  const auto known = known_.lower_bound(dt - kRounding);
  if (known != known_.end() && known->first <= dt + kRounding) {
    return known->second;
  }
  constexpr size_t kMany = 64;  // a clock that jitters by more
  if (known_.size() >= kMany) known_.clear();
  return known_.emplace(dt, Exponential(ToSeconds(dt))).first->second;
}

LevelChain::Matrix LevelChain::Exponential(double dt_s) const {
  // exp(dt rates) by squaring a Taylor series.
  constexpr int kTerms = 10;
  Matrix scaled = dt_s * rates_;
  int squarings = 0;
  while (scaled.cwiseAbs().colwise().sum().maxCoeff() > 0.25) {
    scaled *= 0.5;
    ++squarings;
  }
  // Eigen's blocked product costs three times as much at this size.
  Matrix result = Matrix::Identity();
  Matrix term = Matrix::Identity();
  Matrix product;
  for (int i = 1; i <= kTerms; ++i) {
    product.noalias() = scaled.lazyProduct(term);
    term = product / i;
    result += term;
  }
  for (int i = 0; i < squarings; ++i) {
    product.noalias() = result.lazyProduct(result);
    result = product;
  }
  return result;
}

LevelChain::Vector Likelihood(const Levels& evidence) {
  const double most = *std::max_element(evidence.begin(), evidence.end());
  LevelChain::Vector likelihood;
  for (int i = 0; i < kLevelCount; ++i) {
    likelihood[i] = std::exp(evidence[i] - most);
  }
  return likelihood;
}

LevelChain::Vector Believe(const LevelChain::Vector& predicted,
                           const LevelChain::Vector& likelihood) {
  const LevelChain::Vector belief =
      predicted.cwiseProduct(likelihood).cwiseMax(1e-300);
  return belief / belief.sum();
}

std::vector<double> SmoothLevels(const LevelChain::Vector& first,
                                 const std::vector<TimeNs>& times,
                                 const std::vector<LevelChain::Vector>& seen,
                                 LevelChain* chain) {
  const size_t count = seen.size();
  std::vector<double> levels(count);
  if (count == 0) return levels;
  const auto transition = [&](size_t k) -> const LevelChain::Matrix& {
    return chain->Transition(times[k + 1] - times[k]);
  };
  std::vector<LevelChain::Vector> forward(count);
  forward[0] = Believe(first, seen[0]);
  for (size_t k = 0; k + 1 < count; ++k) {
    forward[k + 1] = Believe(transition(k) * forward[k], seen[k + 1]);
  }
  LevelChain::Vector log_levels;
  for (int i = 0; i < kLevelCount; ++i) log_levels[i] = LogLevel(i);
  LevelChain::Vector backward = LevelChain::Vector::Ones();
  for (size_t k = count; k-- > 0;) {
    const LevelChain::Vector both =
        forward[k].cwiseProduct(backward).cwiseMax(1e-300);
    levels[k] = both.dot(log_levels) / both.sum();
    if (k == 0) break;
    backward = transition(k - 1).transpose() *
               backward.cwiseProduct(seen[k]).cwiseMax(1e-300);
    backward /= backward.maxCoeff();
  }
  return levels;
}

}  // namespace kinegraph
