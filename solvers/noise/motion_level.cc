#include "solvers/noise/motion_level.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kinegraph {
namespace {

constexpr double kLeastLevel = 1.0 / 40.0;
constexpr double kGreatestLevel = 1000.0;
// Added to the variance of the white part of a point's error, which could be
// zero: a fraction of the point's variance, and (0.1 mm)^2.
constexpr double kFreshShare = 0.02;
constexpr double kLeastVarianceM2 = 1e-8;

double LogLevelStep() {
  return std::log(kGreatestLevel / kLeastLevel) / (kLevelCount - 1);
}

// Whether subtracting the correction would leave only two of the 16 significant
// digits of the variance. The prediction is then so uncertain, as after a pause
// of hours, that it carries no information.
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

double LogLevel(int level) {
  return std::log(kLeastLevel) + level * LogLevelStep();
}

void FilterBank::Axis::Predict(double dt, double phi, double q) {
  p += dt * v;
  n *= phi;
  pp += dt * (2.0 * pv + dt * vv) + q * dt * dt * dt / 3.0;
  pv += dt * vv + 0.5 * q * dt * dt;
  vv += q * dt;
  pn = phi * (pn + dt * vn);
  vn *= phi;
  nn = phi * phi * nn + 1.0 - phi * phi;
}

FilterBank::Innovation FilterBank::Axis::Innovate(double position_m,
                                                  double variance_m2,
                                                  double lasting_share) const {
  const double fresh_share = 1.0 + kFreshShare - lasting_share;
  const double gain = std::sqrt(lasting_share * variance_m2);
  return {gain, position_m - p - gain * n,
          pp + 2.0 * gain * pn + gain * gain * nn + fresh_share * variance_m2 +
              kLeastVarianceM2};
}

void FilterBank::Axis::Correct(const Innovation& innovation, double wider) {
  const auto& [gain, error, spread] = innovation;
  const double s = wider * spread;
  const double hp = pp + gain * pn;
  const double hv = pv + gain * vn;
  const double hn = pn + gain * nn;
  p += hp / s * error;
  v += hv / s * error;
  n += hn / s * error;
  pp -= hp * hp / s;
  pv -= hp * hv / s;
  vv -= hv * hv / s;
  pn -= hp * hn / s;
  vn -= hv * hn / s;
  nn -= hn * hn / s;
}

void FilterBank::Start(const FramePoint& point) {
  filters_ = {};
  for (auto& axes : filters_) {
    for (int i = 0; i < 3; ++i) axes[i].p = point.position_m[i];
  }
}

void FilterBank::Add(TimeNs time, const std::optional<FramePoint>& point,
                     const ErrorCorrelation& correlation, Levels* evidence) {
  if (!time_.has_value()) {
    if (!point.has_value()) return;
    time_ = time;
    Start(*point);
  }
  // Threshold on the mean over axes of (z - H x)^2 / S.
  constexpr double kOutlier = 3.0;
  const double dt_s = ToSeconds(time - *time_);
  time_ = time;
  const double phi = std::exp(-dt_s / correlation.time_s);
  for (int level = 0; level < kLevelCount; ++level) {
    const double q = usual_ * std::exp(LogLevel(level));
    for (Axis& axis : filters_[level]) axis.Predict(dt_s, phi, q);
  }
  if (!point.has_value()) return;
  for (int i = 0; i < 3; ++i) {
    // The last level has the most process noise.
    if (LosesDigits(filters_.back()[i].pp, point->covariance_m2(i, i))) {
      Start(*point);
    }
  }
  for (int level = 0; level < kLevelCount; ++level) {
    std::array<Axis, 3>& axes = filters_[level];
    std::array<Innovation, 3> innovations;
    double mean = 0.0;        // of (z - H x)^2 / S over the axes
    double log_spread = 0.0;  // sum of ln S over the axes
    for (int i = 0; i < 3; ++i) {
      Innovation& seen = innovations[i];
      seen = axes[i].Innovate(point->position_m[i], point->covariance_m2(i, i),
                              correlation.share);
      mean += seen.error * seen.error / seen.spread / 3.0;
      log_spread += std::log(seen.spread);
    }
    const double robust =
        mean <= kOutlier ? mean : kOutlier * (1.0 + std::log(mean / kOutlier));
    (*evidence)[level] -= 0.5 * (log_spread + 3.0 * robust);
    for (int i = 0; i < 3; ++i) {
      axes[i].Correct(innovations[i], std::max(1.0, mean / kOutlier));
    }
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
  // Diffusion of the Ornstein-Uhlenbeck process in discrete steps. By detailed
  // balance `stationary_` is the stationary distribution of these jumps between
  // neighbours, but not of the whole process, which also has the jumps to any
  // level that are added below.
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
  constexpr size_t kCacheSize = 64;  // else a jittery clock would fill memory
  if (known_.size() >= kCacheSize) known_.clear();
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
  // Eigen's blocked product is three times slower at this size.
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
