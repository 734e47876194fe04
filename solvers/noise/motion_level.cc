#include "solvers/noise/motion_level.h"

#include <algorithm>
#include <cmath>

namespace kinegraph {

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
