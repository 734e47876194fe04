// What an exact factor for errors that last would bring over the deflation of
// information (solvers/noise/information.h) that stands in its place.
//
//   lasting_factor [--seeds=FIRST:END] [--sigma_mm=13] [--json=FILE]
//
// Linear smoothers on clips of data/motion: each coordinate of each joint,
// shoulders to ankles, by itself, with constant velocity and observed in place.
// Of its errors the share `a` lasts 0.1 s and the rest is white, and both are
// told to the smoothers, so that they differ in one thing:
//   exact     the lasting error is a state, e_k = phi e_k-1 + white of 1 -
//   phi^2 deflated  white errors, information and covariances as information.h
//   says white     white errors of the whole variance
// Process noise follows the true acceleration (its mean square over half a
// second), times the factor of a grid at which the exact smoother finds the
// observations most likely. Prints a Markdown table.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "solvers/noise/information.h"
#include "tests/support/motion_takes.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::MotionClip;

constexpr double kLastingS = 0.1;
constexpr double kApartS = 1.0;     // of the beginning, which is not scored
constexpr double kInside = 3.8415;  // 95 % of chi-square with one degree

using Series = std::vector<double>;

// What a smoother takes observation k and the step behind it for.
struct Step {
  double variance_m2 = 0.0;    // of the white part of the error
  double process_noise = 0.0;  // m^2/s^3
  double stated = 1.0;         // factor on the covariance
};

// Variance and time of the part of the error that is a state; N = 2: none.
struct Lasting {
  double variance_m2 = 0.0;
  double phi = 0.0;
};

struct Smoothed {
  Series position_m;
  Series variance_m2;
  double log_likelihood = 0.0;
};

// Kalman filter and Rauch-Tung-Striebel smoother of position, velocity and, for
// N = 3, the lasting error.
template <int N>
Smoothed Smooth(const Series& observed_m, double frame_s,
                const std::vector<Step>& steps, const Lasting& lasting) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  Matrix transition = Matrix::Identity();
  transition(0, 1) = frame_s;
  Vector seen = Vector::Zero();
  seen[0] = 1.0;
  Vector mean = Vector::Zero();
  mean[0] = observed_m[0];
  Matrix covariance = Matrix::Zero();
  covariance(0, 0) = 1.0;  // 1 m, 3 m/s
  covariance(1, 1) = 9.0;
  if constexpr (N == 3) {
    transition(2, 2) = lasting.phi;
    seen[2] = 1.0;
    covariance(2, 2) = lasting.variance_m2;
  }
  const size_t count = observed_m.size();
  std::vector<Vector> means(count), predicted_means(count);
  std::vector<Matrix> covariances(count), predicted(count);
  Smoothed smoothed;
  for (size_t k = 0; k < count; ++k) {
    if (k > 0) {
      const double q = steps[k - 1].process_noise;
      mean = transition * mean;
      covariance = transition * covariance * transition.transpose();
      covariance(0, 0) += q * std::pow(frame_s, 3) / 3.0;
      covariance(0, 1) += q * frame_s * frame_s / 2.0;
      covariance(1, 0) += q * frame_s * frame_s / 2.0;
      covariance(1, 1) += q * frame_s;
      if constexpr (N == 3) {
        covariance(2, 2) +=
            lasting.variance_m2 * (1.0 - lasting.phi * lasting.phi);
      }
    }
    predicted_means[k] = mean;
    predicted[k] = covariance;
    const Vector gain_top = covariance * seen;
    const double spread = seen.dot(gain_top) + steps[k].variance_m2;
    const double surprise = observed_m[k] - seen.dot(mean);
    mean += gain_top * (surprise / spread);
    covariance -= gain_top * gain_top.transpose() / spread;
    if (k * frame_s > kApartS) {
      smoothed.log_likelihood -=
          0.5 * (std::log(spread) + surprise * surprise / spread);
    }
    means[k] = mean;
    covariances[k] = covariance;
  }
  smoothed.position_m.resize(count);
  smoothed.variance_m2.resize(count);
  for (size_t k = count; k-- > 0;) {
    if (k + 1 < count) {
      const Matrix gain = predicted[k + 1]
                              .ldlt()
                              .solve(transition * covariances[k])
                              .transpose();
      mean = means[k] + gain * (mean - predicted_means[k + 1]);
      covariance = covariances[k] +
                   gain * (covariance - predicted[k + 1]) * gain.transpose();
    }
    smoothed.position_m[k] = mean[0];
    smoothed.variance_m2[k] = covariance(0, 0) * steps[k].stated;
  }
  return smoothed;
}

struct Score {
  double squares_m2 = 0.0;
  double inside = 0.0;
  double count = 0.0;
  double log_likelihood = 0.0;

  void Add(const Smoothed& smoothed, const Series& truth_m, double frame_s) {
    for (size_t k = 0; k < truth_m.size(); ++k) {
      if (k * frame_s <= kApartS) continue;
      const double error_m = smoothed.position_m[k] - truth_m[k];
      squares_m2 += error_m * error_m;
      inside += error_m * error_m < kInside * smoothed.variance_m2[k] ? 1 : 0;
      count += 1;
    }
    log_likelihood += smoothed.log_likelihood;
  }
  // Of three coordinates.
  double rms_mm() const { return 1e3 * std::sqrt(3.0 * squares_m2 / count); }
  double inside_percent() const { return 100.0 * inside / count; }
};

struct Coordinates {
  std::vector<Series> position_m;       // [joint * 3 + axis]
  std::vector<Series> acceleration_sq;  // its mean square nearby, m^2/s^4
};

Coordinates CoordinatesOf(const MotionClip& clip) {
  const size_t count = clip.joints_m.size();
  const long reach = std::lround(0.25 * clip.rate_hz);
  Coordinates all;
  for (int j = 0; j < clip.skeleton.joint_count(); ++j) {
    const JointClass joint_class = clip.skeleton.joint_class(j);
    if (joint_class == JointClass::kHead || joint_class == JointClass::kFoot ||
        joint_class == JointClass::kOther) {
      continue;
    }
    Series squares(count, 0.0);
    double mean = 0.0;
    for (size_t k = 1; k + 1 < count; ++k) {
      const Eigen::Vector3d bend = clip.joints_m[k - 1][j] -
                                   2.0 * clip.joints_m[k][j] +
                                   clip.joints_m[k + 1][j];
      squares[k] = (bend * clip.rate_hz * clip.rate_hz).squaredNorm() / 3.0;
      mean += squares[k] / count;
    }
    Series nearby(count);
    for (size_t k = 0; k < count; ++k) {
      const long first = std::max(0L, static_cast<long>(k) - reach);
      const long last =
          std::min(static_cast<long>(count) - 1, static_cast<long>(k) + reach);
      double sum = 0.0;
      for (long i = first; i <= last; ++i) sum += squares[i];
      nearby[k] = sum / (last - first + 1) + 0.05 * mean + 1e-3;
    }
    for (int axis = 0; axis < 3; ++axis) {
      Series& position = all.position_m.emplace_back(count);
      for (size_t k = 0; k < count; ++k) {
        position[k] = clip.joints_m[k][j][axis];
      }
      all.acceleration_sq.push_back(nearby);
    }
  }
  return all;
}

Series Observe(const Series& truth_m, double sigma_m,
               const ErrorCorrelation& correlation, double phi,
               Random* random) {
  Series observed = truth_m;
  double lasting = random->Normal();
  for (size_t k = 0; k < observed.size(); ++k) {
    if (k > 0) {
      lasting = phi * lasting + std::sqrt(1.0 - phi * phi) * random->Normal();
    }
    observed[k] +=
        sigma_m * (std::sqrt(correlation.share) * lasting +
                   std::sqrt(1.0 - correlation.share) * random->Normal());
  }
  return observed;
}

struct Scores {
  Score exact, deflated, white;
};

// All smoothers, with process noise `factor` times the acceleration's square.
Scores ScoreAll(const Coordinates& clip, double frame_s, double sigma_m,
                const ErrorCorrelation& correlation, double factor,
                uint64_t first_seed, uint64_t end_seed) {
  const double variance = sigma_m * sigma_m;
  const double phi = std::exp(-frame_s / correlation.time_s);
  const Lasting lasting = {correlation.share * variance, phi};
  Scores scores;
  for (size_t i = 0; i < clip.position_m.size(); ++i) {
    std::vector<Step> exact, deflated, white;
    for (const double square : clip.acceleration_sq[i]) {
      const double q = factor * square;
      // A hair of white noise keeps the exact one's matrices regular.
      exact.push_back(
          {std::max(1e-8, (1.0 - correlation.share) * variance), q, 1.0});
      deflated.push_back(
          {variance * InformationDivisor(correlation, frame_s, q, variance), q,
           CovarianceFactor(correlation, frame_s, q, variance)});
      white.push_back({variance, q, 1.0});
    }
    for (uint64_t seed = first_seed; seed < end_seed; ++seed) {
      Random random(seed * 1000 + i);
      const Series& truth = clip.position_m[i];
      const Series observed =
          Observe(truth, sigma_m, correlation, phi, &random);
      scores.exact.Add(Smooth<3>(observed, frame_s, exact, lasting), truth,
                       frame_s);
      scores.deflated.Add(Smooth<2>(observed, frame_s, deflated, {}), truth,
                          frame_s);
      scores.white.Add(Smooth<2>(observed, frame_s, white, {}), truth, frame_s);
    }
  }
  return scores;
}

nlohmann::json ToJson(const Score& score) {
  return {{"mm", score.rms_mm()}, {"inside_percent", score.inside_percent()}};
}

int Main(uint64_t first_seed, uint64_t end_seed, double sigma_m,
         const std::string& json_path) {
  const auto data = testing::FindData("motion");
  if (!data.has_value()) {
    std::fprintf(stderr, "needs real data (set KINEGRAPH_DATA)\n");
    return 1;
  }
  const std::pair<std::string, std::vector<double>> clips[] = {
      {"walk_30hz", {30.0, 120.0}},
      {"hop_30hz", {30.0, 120.0}},
      {"dance_30hz", {30.0, 120.0}},
      {"start_walk_stop_120hz", {25.0, 120.0}},
      {"start_hop_stop_120hz", {25.0, 120.0}}};
  nlohmann::json rows = nlohmann::json::array();
  std::printf(
      "| clip, Hz | share that lasts | exact | deflated | ratio | white |\n"
      "|---|---|---|---|---|---|\n");
  for (const auto& [name, rates] : clips) {
    const MotionClip clip =
        testing::LoadMotionClip((*data / (name + ".jsonl")).string());
    for (const double rate_hz : rates) {
      const Coordinates coordinates =
          CoordinatesOf(testing::Resample(clip, rate_hz));
      for (const double share : {0.5, 1.0}) {
        Scores best;
        for (int g = -4; g <= 4; ++g) {
          const Scores scores =
              ScoreAll(coordinates, 1.0 / rate_hz, sigma_m, {share, kLastingS},
                       0.05 * std::pow(2.0, g), first_seed, end_seed);
          if (g == -4 ||
              scores.exact.log_likelihood > best.exact.log_likelihood) {
            best = scores;
          }
        }
        const double ratio = best.deflated.rms_mm() / best.exact.rms_mm();
        std::printf(
            "| %s, %.0f | %.1f | %.2f mm, %.1f %% | %.2f mm, %.1f %% | "
            "%.3f | %.2f mm, %.1f %% |\n",
            name.c_str(), rate_hz, share, best.exact.rms_mm(),
            best.exact.inside_percent(), best.deflated.rms_mm(),
            best.deflated.inside_percent(), ratio, best.white.rms_mm(),
            best.white.inside_percent());
        std::fflush(stdout);
        rows.push_back({{"clip", name},
                        {"rate_hz", rate_hz},
                        {"share", share},
                        {"ratio", ratio},
                        {"exact", ToJson(best.exact)},
                        {"deflated", ToJson(best.deflated)},
                        {"white", ToJson(best.white)}});
      }
    }
  }
  if (!json_path.empty()) std::ofstream(json_path) << rows.dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  uint64_t first_seed = 1, end_seed = 3;
  double sigma_m = 0.013;
  std::string json_path;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.rfind("--seeds=", 0) == 0) {
      char* end = nullptr;
      first_seed = std::strtoull(argument.c_str() + 8, &end, 10);
      end_seed = *end == ':' ? std::strtoull(end + 1, nullptr, 10) : 0;
    } else if (argument.rfind("--sigma_mm=", 0) == 0) {
      sigma_m = 1e-3 * std::atof(argument.c_str() + 11);
    } else if (argument.rfind("--json=", 0) == 0) {
      json_path = argument.substr(7);
    } else {
      std::fprintf(stderr, "unknown argument %s\n", argv[i]);
      return 2;
    }
  }
  if (end_seed <= first_seed || !(sigma_m > 0.0)) {
    std::fprintf(stderr, "--seeds is FIRST:END, --sigma_mm is positive\n");
    return 2;
  }
  return kinegraph::Main(first_seed, end_seed, sigma_m, json_path);
}
