#include "solvers/noise/confidence_power.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace kinegraph {
namespace {

// Beyond two errors would fall with the fourth power of what detectors call
// sure; none was seen to.
constexpr std::array<double, 7> kPowers = {0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0};

// [s], how long a detector's errors last, usually.
constexpr double kMemory = 0.1;

constexpr double kLogGreatest = 2.7725887222397811;  // ln 16

double LogScale(int i, int count) {
  return kLogGreatest * (2.0 * i / (count - 1) - 1.0);
}

// Greatest value of the parabola through the greatest entry and its neighbours.
template <size_t N>
double Greatest(const std::array<double, N>& values) {
  const auto at = static_cast<size_t>(
      std::max_element(values.begin(), values.end()) - values.begin());
  if (at == 0 || at + 1 == N) return values[at];
  const double slope = 0.5 * (values[at + 1] - values[at - 1]);
  const double bend = values[at + 1] - 2.0 * values[at] + values[at - 1];
  return bend < 0.0 ? values[at] - 0.5 * slope * slope / bend : values[at];
}

}  // namespace

ConfidenceLearner::ConfidenceLearner(double believed_power,
                                     double frame_rate_hz)
    : believed_power_(believed_power),
      frame_s_(std::max(1.0 / frame_rate_hz, kMemory)),
      // Share of the information of independent ones (InformationScale).
      weight_(std::tanh(0.5 * frame_s_ / kMemory)),
      powers_(kPowers.begin(), kPowers.end()) {
  const auto at =
      std::lower_bound(powers_.begin(), powers_.end(), believed_power);
  if (at == powers_.end() || *at != believed_power) {
    powers_.insert(at, believed_power);
  }
  by_power_.resize(powers_.size());
  log_likelihood_.resize(powers_.size());
  for (auto& of_power : log_likelihood_) {
    for (Scales& of_class : of_power) of_class.fill(0.0);
  }
}

bool ConfidenceLearner::BeginFrame(TimeNs time) {
  constexpr double kEarly = 0.5;  // of a millisecond: clocks are rounded
  if (last_.has_value() &&
      ToSeconds(time - *last_) < frame_s_ - 1e-3 * kEarly) {
    return false;
  }
  last_ = time;
  return true;
}

bool ConfidenceLearner::Linearise(const std::vector<PixelPoint>& views,
                                  const std::vector<double>& log_confidences,
                                  const Eigen::Vector3d& point_m) {
  linearised_.clear();
  for (size_t v = 0; v < views.size(); ++v) {
    Matrix23d J;
    const auto image = views[v].camera->Project(point_m, &J);
    if (!image.has_value()) return false;
    const Eigen::Vector2d residual = (*image - views[v].px) / views[v].sigma_px;
    J /= views[v].sigma_px;
    linearised_.push_back({J.transpose() * J, J.transpose() * residual,
                           residual.squaredNorm(),
                           log_confidences[v] - mean_log_});
  }
  return true;
}

// With S the least sum of squares under the power's weights, d its degrees of
// freedom and s the scale: -ln |sigmas| - ln |J' W J| / 2 - d ln s - (t + d) /
// 2 ln(1 + S / (t s^2)), t the tails'. False where the views leave a direction
// open.
bool ConfidenceLearner::LogLikelihood(double added_power,
                                      Scales* log_likelihood) const {
  constexpr double kTails = 4.0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  double square = 0.0;
  double log_sigmas = 0.0;
  for (const View& view : linearised_) {
    const double weight = std::exp(2.0 * added_power * view.above_mean);
    normal += weight * view.square;
    pull += weight * view.pull;
    square += weight * view.residual_square;
    log_sigmas -= 2.0 * added_power * view.above_mean;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(normal);
  const Eigen::Vector3d diagonal = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(diagonal.minCoeff() > 0.0)) {
    return false;
  }
  square = std::max(0.0, square - pull.dot(factor.solve(pull)));
  const double freedom = 2.0 * static_cast<double>(linearised_.size()) - 3.0;
  const double same = -log_sigmas - diagonal.array().log().sum();
  for (int i = 0; i < kScaleCount; ++i) {
    const double log_scale = LogScale(i, kScaleCount);
    const double tail =
        std::log1p(square * std::exp(-2.0 * log_scale) / kTails);
    (*log_likelihood)[static_cast<size_t>(i)] =
        same - freedom * log_scale - 0.5 * (kTails + freedom) * tail;
  }
  return std::isfinite(square + same);
}

void ConfidenceLearner::Add(JointClass joint_class,
                            const std::vector<PixelPoint>& views,
                            const std::vector<double>& log_confidences,
                            const Eigen::Vector3d& point_m,
                            const ConfidenceWeighting& weighting) {
  for (const double log_confidence : log_confidences) {
    ++count_;
    mean_log_ += (log_confidence - mean_log_) / static_cast<double>(count_);
  }
  if (!Linearise(views, log_confidences, point_m)) return;
  for (size_t p = 0; p < powers_.size(); ++p) {
    const double added = powers_[p] - believed_power_ - weighting.added_power;
    if (!LogLikelihood(added, &by_power_[p])) return;
  }
  for (size_t p = 0; p < powers_.size(); ++p) {
    Scales& sum = log_likelihood_[p][static_cast<size_t>(joint_class)];
    for (size_t i = 0; i < sum.size(); ++i) {
      sum[i] += weight_ * by_power_[p][i];
    }
  }
}

ConfidenceWeighting ConfidenceLearner::Fit() const {
  // Between detectors the power varies by about so much.
  constexpr double kSpread = 0.5;
  ConfidenceWeighting best;
  best.mean_log = mean_log_;
  double greatest = -1e300;
  for (size_t p = 0; p < powers_.size(); ++p) {
    const double added = powers_[p] - believed_power_;
    double posterior = -0.5 * (added / kSpread) * (added / kSpread);
    for (const Scales& of_class : log_likelihood_[p]) {
      posterior += Greatest(of_class);
    }
    const bool is_believed = added == 0.0;
    if (posterior > greatest || (is_believed && posterior >= greatest)) {
      greatest = posterior;
      best.added_power = added;
    }
  }
  return best;
}

}  // namespace kinegraph
