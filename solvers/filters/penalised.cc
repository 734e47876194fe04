#include "solvers/filters/penalised.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "solvers/filters/banded.h"

namespace kinegraph {
namespace {

// Times in mean steps, from the first.
std::vector<double> InFrames(const std::vector<double>& times) {
  const double step = MeanStep(times);
  std::vector<double> frames;
  frames.reserve(times.size());
  for (const double time : times) frames.push_back((time - times[0]) / step);
  return frames;
}

// Weights of the divided difference of the values at x[first] .. x[first +
// order], times the factorial of `order`: for a polynomial of degree `order`
// its derivative of that order.
Eigen::VectorXd DividedDifference(const std::vector<double>& x, size_t first,
                                  int order) {
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(order + 1);
  for (int i = 0; i <= order; ++i) {
    for (int k = 0; k <= order; ++k) {
      if (k != i) weights(i) /= x[first + i] - x[first + k];
    }
    for (int k = 2; k <= order; ++k) weights(i) *= k;
  }
  return weights;
}

struct BandedRow {
  Eigen::Index first = 0;
  Eigen::VectorXd entries;
};

// A PenalisedCurve that is linear in its unknowns.
class LinearCurve : public PenalisedCurve {
 public:
  LinearCurve(double step, Eigen::Index unknowns, int width)
      : PenalisedCurve(step), unknowns_(unknowns), width_(width) {}

  double BestLambda() const final {
    // Searches the cut-off on a logarithmic grid, ten steps per decade.
    const double log_cutoff = LeastOnGrid(
        -3.0, std::log10(0.5), 0.1,
        [this](double x) { return Gcv(LambdaOfFrames(std::pow(10.0, x))); });
    return LambdaOfFrames(std::pow(10.0, log_cutoff));
  }

 protected:
  BandedLeastSquares System(double lambda) const {
    const double root = std::sqrt(lambda);
    BandedLeastSquares system(unknowns_, width_, values_.rows());
    const Eigen::VectorXd none;
    size_t next = 0;
    const auto add_data = [&] {
      system.AddRow(data_[next].first, 1.0, data_[next].entries,
                    values_.col(static_cast<Eigen::Index>(next)));
      ++next;
    };
    for (const auto& [first, row] : roughness_) {
      while (next < data_.size() && data_[next].first <= first) add_data();
      system.AddRow(first, root, row, none);
    }
    while (next < data_.size()) add_data();
    return system;
  }

  // Reduces the roughness to one row per unknown.
  void ReduceRoughness() {
    BandedLeastSquares system(unknowns_, width_, 0);
    const Eigen::VectorXd none;
    for (const auto& [first, row] : roughness_) {
      system.AddRow(first, 1.0, row, none);
    }
    roughness_.clear();
    for (Eigen::Index i = 0; i < unknowns_; ++i) {
      roughness_.push_back({i, system.TriangleRow(i)});
    }
  }

  // Both lists ascend by `first`.
  std::vector<BandedRow> data_;  // one per sample
  std::vector<BandedRow> roughness_;
  Eigen::MatrixXd values_;  // a column per sample

 private:
  double Gcv(double lambda) const {
    const BandedLeastSquares system = System(lambda);
    const Samples x = system.Solve();
    const Eigen::MatrixXd inverse = system.InverseBands();
    double misfit = 0.0;
    double trace = static_cast<double>(data_.size());
    for (size_t i = 0; i < data_.size(); ++i) {
      const auto& [first, row] = data_[i];
      const Eigen::Index n = row.size();
      misfit += (values_.col(static_cast<Eigen::Index>(i)) -
                 x.middleRows(first, n).transpose() * row)
                    .squaredNorm();
      for (Eigen::Index a = 0; a < n; ++a) {
        for (Eigen::Index b = 0; b < n; ++b) {
          trace -= row(a) * row(b) *
                   inverse(std::abs(a - b), first + std::min(a, b));
        }
      }
    }
    return static_cast<double>(data_.size()) * misfit / (trace * trace);
  }

  Eigen::Index unknowns_;
  int width_;
};

class WhittakerCurve final : public LinearCurve {
 public:
  WhittakerCurve(int order, const std::vector<double>& times,
                 const std::vector<char>& sampled, const Samples& values)
      : LinearCurve(MeanStep(times), values.rows(), order + 1), order_(order) {
    const std::vector<double> x = InFrames(times);
    for (size_t i = 0; i < x.size(); ++i) {
      const auto first = static_cast<Eigen::Index>(i);
      if (sampled[i]) data_.push_back({first, Eigen::VectorXd::Ones(1)});
      if (i + order >= x.size()) continue;
      const double span = (x[i + order] - x[i]) / order;
      roughness_.push_back(
          {first, std::sqrt(span) * DividedDifference(x, i, order)});
    }
    values_ = SampledRowsOf(times, sampled, values).values.transpose();
  }

  Samples Fit(double lambda, CurveDerivatives*) const override {
    return System(lambda).Solve();
  }

 private:
  // The gain is 1 / (1 + lambda (2 sin(pi f))^(2 order)), f up to 1/2.
  double LambdaOfFrames(double cutoff) const override {
    const double sine = std::sin(M_PI * std::min(cutoff, 0.5));
    return std::pow(2.0 * sine, -2.0 * order_);
  }
  double CutoffInFrames(double lambda) const override {
    const double sine = 0.5 * std::pow(lambda, -0.5 / order_);
    return std::asin(std::min(1.0, sine)) / M_PI;
  }

  int order_;
};

class QuinticCurve final : public LinearCurve {
 public:
  QuinticCurve(const std::vector<double>& times, const SampledRows& samples)
      : LinearCurve(MeanStep(samples.times),
                    samples.values.rows() + kDegree - 1, kDegree + 1) {
    const std::vector<double> x = InFrames(samples.times);
    for (const double time : times) {
      at_.push_back((time - samples.times[0]) / step());
    }
    // The knots outside are arbitrary; the curve is not evaluated there.
    for (int k = kDegree; k > 0; --k) knots_.push_back(-k);
    knots_.insert(knots_.end(), x.begin(), x.end());
    for (int k = 1; k <= kDegree; ++k) knots_.push_back(x.back() + k);
    // Three-point Gauss-Legendre is exact for degree five; a squared third
    // derivative has degree four.
    const double side = std::sqrt(0.6);
    const std::array<double, 3> places = {-side, 0.0, side};
    const std::array<double, 3> weights = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
    for (size_t i = 0; i < x.size(); ++i) {
      data_.push_back(Basis(x[i], 0));
      if (i + 1 == x.size()) continue;
      const double half = 0.5 * (x[i + 1] - x[i]);
      for (int q = 0; q < 3; ++q) {
        BandedRow row = Basis(x[i] + half * (1.0 + places[q]), 3);
        row.entries *= std::sqrt(half * weights[q]);
        roughness_.push_back(std::move(row));
      }
    }
    values_ = samples.values.transpose();
    ReduceRoughness();
  }

  Samples Fit(double lambda, CurveDerivatives* derivatives) const override {
    const Samples coefficients = System(lambda).Solve();
    if (derivatives != nullptr) {
      derivatives->first = At(coefficients, 1) / step();
      derivatives->second = At(coefficients, 2) / (step() * step());
    }
    return At(coefficients, 0);
  }

 private:
  // The curve or a derivative per mean step.
  Samples At(const Samples& coefficients, int derivative) const {
    Samples result(static_cast<Eigen::Index>(at_.size()), values_.rows());
    for (size_t i = 0; i < at_.size(); ++i) {
      const auto [first, row] = Basis(at_[i], derivative);
      result.row(static_cast<Eigen::Index>(i)) =
          row.transpose() * coefficients.middleRows(first, row.size());
    }
    return result;
  }

  // For many samples per wave the gain is 1 / (1 + lambda (2 pi f)^6).
  double LambdaOfFrames(double cutoff) const override {
    return std::pow(2.0 * M_PI * cutoff, -6.0);
  }
  double CutoffInFrames(double lambda) const override {
    return std::pow(lambda, -1.0 / 6.0) / (2.0 * M_PI);
  }

  static constexpr int kDegree = 5;

  // A derivative of the B-splines that are non-zero at x (de Boor 1978, chapter
  // X).
  BandedRow Basis(double x, int derivative) const {
    const auto above = std::upper_bound(knots_.begin() + kDegree + 1,
                                        knots_.end() - kDegree - 1, x);
    const auto k = static_cast<int>(above - knots_.begin()) - 1;
    const auto knot = [&](int i) { return knots_[static_cast<size_t>(i)]; };
    // b(i): the B-spline that begins at knot k - degree + i.
    Eigen::VectorXd b = Eigen::VectorXd::Ones(1);
    for (int degree = 1; degree <= kDegree; ++degree) {
      const bool rises = degree <= kDegree - derivative;
      Eigen::VectorXd next = Eigen::VectorXd::Zero(degree + 1);
      for (int i = 0; i < degree; ++i) {
        const double left = knot(k - degree + 1 + i);
        const double right = knot(k + 1 + i);
        const double share = b(i) / (right - left);
        next(i) += share * (rises ? right - x : -degree);
        next(i + 1) += share * (rises ? x - left : degree);
      }
      b = std::move(next);
    }
    return {k - kDegree, std::move(b)};
  }

  std::vector<double> knots_;
  std::vector<double> at_;  // times of the frames, in mean steps of samples
};

class CubicCurve final : public PenalisedCurve {
 public:
  CubicCurve(const std::vector<double>& times_s, SampledRows samples)
      : PenalisedCurve(MeanStep(samples.times)),
        times_s_(times_s),
        samples_(std::move(samples)) {}

  Samples Fit(double lambda, CurveDerivatives* derivatives) const override {
    return SmoothingSpline(lambda * Cube(), samples_.times, samples_.values,
                           times_s_, derivatives);
  }
  double BestLambda() const override {
    return ChooseLambdaByGcv(samples_.times, samples_.values) / Cube();
  }

 private:
  double Cube() const { return step() * step() * step(); }
  // Far below the frame rate the gain is 1 / (1 + lambda (2 pi f)^4) (Craven
  // and Wahba 1979).
  double LambdaOfFrames(double cutoff) const override {
    const double w = 2.0 * M_PI * cutoff;
    return 1.0 / (w * w * w * w);
  }
  double CutoffInFrames(double lambda) const override {
    return std::pow(lambda, -0.25) / (2.0 * M_PI);
  }

  std::vector<double> times_s_;
  SampledRows samples_;
};

}  // namespace

std::unique_ptr<PenalisedCurve> MakeWhittaker(int order,
                                              const std::vector<double>& times,
                                              const std::vector<char>& sampled,
                                              const Samples& values) {
  return std::make_unique<WhittakerCurve>(order, times, sampled, values);
}

std::unique_ptr<PenalisedCurve> MakeQuinticSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values) {
  return std::make_unique<QuinticCurve>(times,
                                        SampledRowsOf(times, sampled, values));
}

std::unique_ptr<PenalisedCurve> MakeCubicSpline(
    const std::vector<double>& times, const std::vector<char>& sampled,
    const Samples& values) {
  return std::make_unique<CubicCurve>(times,
                                      SampledRowsOf(times, sampled, values));
}

// ---- Trend filtering ----

namespace {

// Solves for one column y, at times x in frames. D maps values to changes of
// slope.
class TrendSolver {
 public:
  TrendSolver(double lambda, const std::vector<double>& x,
              const Eigen::VectorXd& y)
      : lambda_(lambda), y_(y), count_(y.size() - 2) {
    for (Eigen::Index i = 0; i < count_; ++i) {
      const auto k = static_cast<size_t>(i);
      const double before = 1.0 / (x[k + 1] - x[k]);
      const double behind = 1.0 / (x[k + 2] - x[k + 1]);
      D_.emplace_back(before, -before - behind, behind);
    }
  }

  Eigen::VectorXd Run() {
    const Eigen::VectorXd Dy = Times(y_);
    u_ = Eigen::VectorXd::Zero(count_);
    above_ = below_ = Eigen::VectorXd::Ones(count_);
    constexpr int kMaxSteps = 200;
    // Relative to the duality gap of the start. At worst the distance to the
    // solution is the root of twice the gap; with well-defined kinks it is
    // proportional to the gap.
    constexpr double kLeastGap = 1e-16;
    double sharpness = 1e-10;
    double first_gap = 0.0;
    for (int step = 0; step < kMaxSteps; ++step) {
      const Eigen::VectorXd z = TransposeTimes(u_);  // y - z is the trend
      const double gap =
          lambda_ * (Dy - Times(z)).cwiseAbs().sum() - u_.dot(Dy - Times(z));
      if (step == 0) first_gap = gap;
      if (!(gap > kLeastGap * first_gap)) break;
      sharpness = std::max(sharpness, 2.0 * 2.0 * count_ / gap);
      if (!NewtonStep(Dy, sharpness)) break;
    }
    return y_ - TransposeTimes(u_);
  }

 private:
  Eigen::VectorXd Times(const Eigen::VectorXd& z) const {
    Eigen::VectorXd result(count_);
    for (Eigen::Index i = 0; i < count_; ++i) {
      result(i) = D_[static_cast<size_t>(i)].dot(z.segment<3>(i));
    }
    return result;
  }
  Eigen::VectorXd TransposeTimes(const Eigen::VectorXd& u) const {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(count_ + 2);
    for (Eigen::Index i = 0; i < count_; ++i) {
      result.segment<3>(i) += D_[static_cast<size_t>(i)] * u(i);
    }
    return result;
  }
  // Distance from a solution: gradient, and products of slacks and multipliers.
  double Residual(const Eigen::VectorXd& u, const Eigen::VectorXd& above,
                  const Eigen::VectorXd& below, const Eigen::VectorXd& Dy,
                  double sharpness) const {
    const Eigen::VectorXd gradient =
        Times(TransposeTimes(u)) - Dy + above - below;
    const Eigen::ArrayXd up = above.array() * (lambda_ - u.array());
    const Eigen::ArrayXd down = below.array() * (lambda_ + u.array());
    return std::sqrt(gradient.squaredNorm() +
                     (up - 1.0 / sharpness).matrix().squaredNorm() +
                     (down - 1.0 / sharpness).matrix().squaredNorm());
  }
  bool NewtonStep(const Eigen::VectorXd& Dy, double sharpness) {
    const Eigen::ArrayXd up = lambda_ - u_.array();
    const Eigen::ArrayXd down = lambda_ + u_.array();
    const Eigen::ArrayXd diagonal = above_.array() / up + below_.array() / down;
    // (D D' + diagonal) du = right.
    PentadiagonalFactors factors(count_);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const Eigen::RowVector3d& q = D_[static_cast<size_t>(i)];
      double first = 0.0;
      double second = 0.0;
      if (i + 1 < count_) {
        first = q.tail<2>().dot(D_[static_cast<size_t>(i) + 1].head<2>());
      }
      if (i + 2 < count_) second = q(2) * D_[static_cast<size_t>(i) + 2](0);
      factors.SetRow(i, q.squaredNorm() + diagonal(i), first, second);
    }
    Samples right = Dy - Times(TransposeTimes(u_)) -
                    ((1.0 / up - 1.0 / down) / sharpness).matrix();
    factors.Solve(&right);
    const Eigen::VectorXd du = right.col(0);
    const Eigen::VectorXd d_above =
        ((1.0 / sharpness + above_.array() * du.array()) / up - above_.array())
            .matrix();
    const Eigen::VectorXd d_below =
        ((1.0 / sharpness - below_.array() * du.array()) / down -
         below_.array())
            .matrix();
    double length = 1.0;
    for (Eigen::Index i = 0; i < count_; ++i) {
      if (d_above(i) < 0.0) length = std::min(length, -above_(i) / d_above(i));
      if (d_below(i) < 0.0) length = std::min(length, -below_(i) / d_below(i));
    }
    length *= 0.99;
    const double before = Residual(u_, above_, below_, Dy, sharpness);
    constexpr int kMaxHalvings = 40;
    for (int k = 0; k < kMaxHalvings; ++k, length *= 0.5) {
      const Eigen::VectorXd u = u_ + length * du;
      if (!(u.cwiseAbs().maxCoeff() < lambda_)) continue;
      const Eigen::VectorXd above = above_ + length * d_above;
      const Eigen::VectorXd below = below_ + length * d_below;
      if (Residual(u, above, below, Dy, sharpness) >
          (1.0 - 0.01 * length) * before) {
        continue;
      }
      u_ = u;
      above_ = above;
      below_ = below;
      return true;
    }
    return false;
  }

  double lambda_;
  Eigen::VectorXd y_;
  Eigen::Index count_;  // number of changes of slope
  std::vector<Eigen::RowVector3d> D_;
  Eigen::VectorXd u_;
  Eigen::VectorXd above_, below_;  // multipliers of the two bounds
};

}  // namespace

Samples TrendFilter(double lambda, const std::vector<double>& times,
                    const Samples& values) {
  if (values.rows() < 3) return values;
  const std::vector<double> x = InFrames(times);
  Samples trend(values.rows(), values.cols());
  for (Eigen::Index c = 0; c < values.cols(); ++c) {
    trend.col(c) = TrendSolver(lambda, x, values.col(c)).Run();
  }
  return trend;
}

}  // namespace kinegraph
