// Errors of estimators on recorded motion observed by a modelled detector, over
// clips, detectors and frame rates.
//
//   motion_matrix [--clips=A[:SECONDS],B] [--rates=25,60,native]
//     [--noises=white2,...] [--seeds=FIRST[:END]] [--strategies=A,B]
//     [--joint_sway=METRES] [--rest=SECONDS] [--seconds=S] [--cameras=N]
//     [--solver=sweeps|ceres] [--details]
//     [--oracle=FILE[,FILE]] [--write_oracle=FILE] [--json=FILE]
//
// Ratios are relative to the best fixed tuning in the files of --oracle; for a
// batch with bones, to the better tuning of those with and without bones.
//
// --details adds to the JSON, per detector, coverage by acceleration and by
// number of views, and errors by acceleration, with their ratio to those of the
// strategy "robust" if it runs; not for more than twelve strategies. Coverages
// and ratios have 95 % intervals: a bootstrap over clips and seeds.
//
// --rest lets the person hold the first pose before the clip (AfterRest);
// --joint_sway moves joint centres relative to the bones (WithJointSway).
//
// Association is fixed: every detection belongs to the person. Errors are those
// of the joints from shoulders to ankles; a joint that is not written counts as
// 500 mm. The first second of the clip is counted separately, a rest before it
// not at all.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/evaluation/statistics.h"
#include "research/motion_recordings.h"
#include "solvers/factory.h"
#include "tests/support/simulated_person.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::DetectorModel;
using testing::MotionRecording;
using testing::SteadyClip;

constexpr double kNotWritten_m = 0.5;
constexpr double kApart_s = 1.0;  // beginning that is counted separately
// 95 % quantile of chi-square with three degrees of freedom.
constexpr double kChi95 = 7.8147;
// Upper ends of the bins by a joint's true acceleration [m/s^2].
constexpr std::array<double, 4> kAccelerations = {5.0, 15.0, 30.0, 1e9};

const std::vector<DetectorModel>& Detectors() {
  static const std::vector<DetectorModel> kDetectors = {
      {"white2", 2.0, 0.0, 0.0, 40.0, 0.0},
      {"slow4", 4.0, 0.1, 0.02, 40.0, 0.05},
      {"slow8", 8.0, 0.1, 0.02, 40.0, 0.05},
      {"slowest8", 8.0, 0.3, 0.02, 40.0, 0.05},
      {"hard8", 8.0, 0.0, 0.05, 40.0, 0.15}};
  return kDetectors;
}

struct Strategy {
  std::string name;
  EstimatorFactory factory;
};

bool Counts(const Skeleton& skeleton, int joint_idx) {
  const JointClass joint_class = skeleton.joint_class(joint_idx);
  return joint_class != JointClass::kHead && joint_class != JointClass::kFoot &&
         joint_class != JointClass::kOther;
}

struct Share2 {
  double inside = 0.0;
  double count = 0.0;
  void Add(bool is_inside) {
    inside += is_inside ? 1.0 : 0.0;
    count += 1.0;
  }
  void Add(const Share2& other) {
    inside += other.inside;
    count += other.count;
  }
  double percent() const { return 100.0 * inside / count; }
};

// Errors of one strategy, in one or several cells.
struct Errors {
  std::vector<float> errors_m;
  std::array<std::vector<float>, 4> by_acceleration_m;
  double first_second_sum = 0.0;  // of squared errors [m^2]
  double first_second_count = 0.0;
  Share2 inside;  // of the 95 % ellipsoid
  std::array<Share2, 4> inside_by_acceleration;
  std::array<Share2, 6> inside_by_views;
  double nees = 0.0;
  double log_score = 0.0;
  double cpu_s = 0.0;
  double frames = 0.0;

  double rmse_mm() const {
    double sum = 0.0;
    for (const float e : errors_m) sum += e * e;
    return 1e3 * std::sqrt(sum / static_cast<double>(errors_m.size()));
  }
  double quantile_mm(double share) const {
    return 1e3 * Quantile({errors_m.begin(), errors_m.end()}, share);
  }
};

double RmseOf(const std::vector<float>& errors_m) {
  double sum = 0.0;
  for (const float e : errors_m) sum += e * e;
  return 1e3 * std::sqrt(sum / static_cast<double>(errors_m.size()));
}

// The true acceleration of a joint in frame `k` [m/s^2]; 0 at the ends of the
// clip.
double Acceleration(const SteadyClip& clip, size_t k, int joint_idx) {
  // Over about a thirtieth of a second, but at least one frame.
  const auto step =
      static_cast<size_t>(std::max(1.0, std::round(clip.rate_hz / 30.0)));
  if (k < step || k + step >= clip.joints_m.size()) return 0.0;
  const double h = static_cast<double>(step) / clip.rate_hz;
  return (clip.joints_m[k + step][joint_idx] -
          2.0 * clip.joints_m[k][joint_idx] +
          clip.joints_m[k - step][joint_idx])
             .norm() /
         (h * h);
}

void Score(const MotionRecording& recording, const Strategy& strategy,
           double from_s, Errors* errors) {
  const ReplayOutcome outcome =
      RunEstimator(recording.scene, recording.person, strategy.factory);
  errors->cpu_s += 1e-9 * static_cast<double>(outcome.cpu_ns);
  errors->frames += static_cast<double>(outcome.finals.size());
  const SteadyClip& clip = recording.clip;
  for (size_t k = 0; k < clip.joints_m.size(); ++k) {
    const int64_t at = static_cast<int64_t>(k) - recording.first_frame;
    const PersonPose* pose =
        at >= 0 ? &outcome.finals[static_cast<size_t>(at)].person : nullptr;
    for (int j = 0; j < clip.skeleton.joint_count(); ++j) {
      if (!Counts(clip.skeleton, j)) continue;
      const bool written = pose != nullptr &&
                           pose->joints.size() > static_cast<size_t>(j) &&
                           pose->joints[j].present();
      Eigen::Vector3d away(kNotWritten_m, 0.0, 0.0);
      if (written) away = pose->joints[j].position_m - clip.joints_m[k][j];
      const double error = away.norm();
      const double seconds = static_cast<double>(k) / clip.rate_hz;
      if (seconds < from_s + kApart_s) {
        if (seconds < from_s) continue;
        errors->first_second_sum += error * error;
        errors->first_second_count += 1.0;
        continue;
      }
      size_t bin = 0;
      const double acceleration = Acceleration(clip, k, j);
      while (acceleration > kAccelerations[bin]) ++bin;
      errors->errors_m.push_back(static_cast<float>(error));
      errors->by_acceleration_m[bin].push_back(static_cast<float>(error));
      if (!written || pose->covariances.empty() ||
          !pose->covariances[j].has_value()) {
        continue;
      }
      const Eigen::Matrix3d& covariance = *pose->covariances[j];
      const double square = away.dot(covariance.inverse() * away);
      const bool inside = square <= kChi95;
      errors->inside.Add(inside);
      errors->inside_by_acceleration[bin].Add(inside);
      errors->inside_by_views[std::min(5, pose->inlier_views[j])].Add(inside);
      errors->nees += square;
      errors->log_score += -0.5 * (square + std::log(covariance.determinant()));
    }
  }
}

// A clip at one frame rate, seen by one detector.
struct Cell {
  std::string clip;
  double seconds = 1e9;  // of the clip
  double rate_hz = 0.0;
  DetectorModel detector;

  std::string name() const {
    char text[100];
    std::snprintf(text, sizeof(text), "%s,%g,%s", clip.c_str(), rate_hz,
                  detector.name.c_str());
    return text;
  }
};

struct Settings {
  std::vector<std::string> clips = {"walk_30hz", "hop_30hz", "dance_30hz",
                                    "start_walk_stop_120hz",
                                    "start_hop_stop_120hz"};
  std::vector<std::string> rates;
  std::vector<std::string> noises;
  std::vector<std::string> strategies;
  uint64_t first_seed = 1;
  uint64_t end_seed = 2;
  double seconds = 1e9;
  double rest_s = 0.0;
  double joint_sway_m = 0.0;
  int cameras = 4;
  GraphSolver solver = GraphOptions().solver;
  std::vector<std::string> oracles;
  std::string write_oracle;
  std::string json;  // rows of cells
  bool details = false;
};

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    parts.push_back(part);
  }
  return parts;
}

bool Named(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() ||
         std::find(names.begin(), names.end(), name) != names.end();
}

SteadyClip Load(const std::string& name) {
  const auto path = testing::FindData("motion/" + name + ".jsonl");
  if (!path.has_value()) {
    std::fprintf(stderr, "needs data 'motion' (set KINEGRAPH_DATA)\n");
    std::exit(1);
  }
  return testing::LoadSteadyClip(path->string());
}

std::vector<Cell> CellsOf(const Settings& settings) {
  std::vector<Cell> cells;
  for (const std::string& clip_and_seconds : settings.clips) {
    const size_t colon = clip_and_seconds.find(':');
    const std::string clip = clip_and_seconds.substr(0, colon);
    const double seconds =
        colon == std::string::npos
            ? 1e9
            : std::atof(clip_and_seconds.c_str() + colon + 1);
    const double native_hz = Load(clip).rate_hz;
    std::vector<double> rates = {25.0, native_hz};
    if (native_hz < 60.0) rates.push_back(60.0);
    for (const double rate_hz : rates) {
      char text[20];
      std::snprintf(text, sizeof(text), "%g", rate_hz);
      const std::string alias = rate_hz == native_hz ? "native" : text;
      if (!Named(settings.rates, text) && !Named(settings.rates, alias)) {
        continue;
      }
      for (const DetectorModel& detector : Detectors()) {
        if (!Named(settings.noises, detector.name)) continue;
        cells.push_back({clip, seconds, rate_hz, detector});
      }
    }
  }
  return cells;
}

// Strategies with specified instead of learnt noise (FixedNoise), as in commit
// 98b8b86, for all tunings of process noise and loss.
std::vector<Strategy> FixedTunings(OutputKind kind, bool bones,
                                   GraphSolver solver) {
  std::vector<Strategy> strategies;
  for (const LossKind loss : {LossKind::kGemanMcClure, LossKind::kHuber}) {
    for (const double multiple :
         {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0}) {
      EstimatorOptions options;
      options.graph = testing::FixedNoise();
      options.graph.solver = solver;
      options.graph.loss = loss;
      if (loss == LossKind::kHuber) options.graph.loss_scale = 1.5;
      for (double& q : options.graph.process_noise) q *= multiple;
      options.graph.bones = bones;
      options.graph.bone_sigma_from = NoiseFrom::kFixed;
      char name[60];
      std::snprintf(name, sizeof(name), "%s%s %s x%g",
                    OutputNames()[static_cast<int>(kind)].c_str(),
                    bones ? "_bones" : "",
                    loss == LossKind::kHuber ? "huber" : "gm", multiple);
      strategies.push_back({name, MakeOutput(kind, options)});
    }
  }
  return strategies;
}

std::vector<Strategy> AllStrategies(GraphSolver solver) {
  std::vector<Strategy> strategies;
  const auto add = [&](const std::string& name, OutputKind kind,
                       const EstimatorOptions& options) {
    strategies.push_back({name, MakeOutput(kind, options)});
  };
  EstimatorOptions defaults;
  defaults.graph.solver = solver;
  add("window", OutputKind::kWindow, defaults);
  add("batch", OutputKind::kBatch, defaults);
  EstimatorOptions fixed;
  fixed.graph = testing::FixedNoise();
  fixed.graph.solver = solver;
  add("window_fixed", OutputKind::kWindow, fixed);
  add("batch_fixed", OutputKind::kBatch, fixed);
  EstimatorOptions bones = defaults;
  bones.graph.bones = true;
  add("batch_bones", OutputKind::kBatch, bones);
  bones.graph.bone_sigma_from = NoiseFrom::kFixed;
  add("batch_bones_fixed", OutputKind::kBatch, bones);
  add("robust", OutputKind::kRobustTriangulation, defaults);
  add("paper", OutputKind::kGaussian, defaults);
  for (const double cutoff_hz : {3.0, 4.5, 6.0, 9.0, 12.0}) {
    EstimatorOptions options;
    options.filters.points = PointKind::kRobust;
    options.filters.butterworth.cutoff_hz = cutoff_hz;
    char name[40];
    std::snprintf(name, sizeof(name), "butterworth %g Hz", cutoff_hz);
    add(name, OutputKind::kButterworth, options);
  }
  for (const double scale : {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0}) {
    EstimatorOptions options;
    options.filters.points = PointKind::kRobust;
    options.filters.kalman.process_noise_scale = scale;
    char name[40];
    std::snprintf(name, sizeof(name), "rts x%g", scale);
    add(name, OutputKind::kRts, options);
  }
  return strategies;
}

std::vector<Strategy> Chosen(const Settings& settings) {
  std::vector<Strategy> chosen;
  for (const std::string& name : settings.strategies) {
    if (name == "tunings_window" || name == "tunings_batch" ||
        name == "tunings_batch_bones") {
      for (Strategy& s :
           FixedTunings(name == "tunings_window" ? OutputKind::kWindow
                                                 : OutputKind::kBatch,
                        name == "tunings_batch_bones", settings.solver)) {
        chosen.push_back(std::move(s));
      }
      continue;
    }
    for (Strategy& s : AllStrategies(settings.solver)) {
      if (s.name == name || s.name.substr(0, s.name.find(' ')) == name) {
        chosen.push_back(std::move(s));
      }
    }
  }
  return chosen;
}

// The recorded best fixed tuning of a cell and kind of estimator.
struct Frozen {
  std::string tuning;
  double rmse_mm = 0.0;
  double p999_mm = 0.0;
  double log_score = 0.0;
};
using Oracle = std::map<std::string, Frozen>;  // "kind,clip,rate,noise"

void ReadOracle(const std::string& path, Oracle* oracle) {
  std::ifstream file(path);
  if (!file) {
    std::fprintf(stderr, "cannot read oracle '%s'\n", path.c_str());
    std::exit(2);
  }
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> parts = Split(line);
    if (parts.size() != 8) continue;
    (*oracle)[parts[0] + "," + parts[1] + "," + parts[2] + "," + parts[3]] = {
        parts[4], std::atof(parts[5].c_str()), std::atof(parts[6].c_str()),
        std::atof(parts[7].c_str())};
  }
}

constexpr char kBatchBones[] = "batch_bones";

std::string KindOf(const std::string& strategy) {
  if (strategy.compare(0, 6, "window") == 0) return "window";
  return strategy.compare(0, std::strlen(kBatchBones), kBatchBones) == 0
             ? kBatchBones
             : "batch";
}

// The tuning to which a strategy is compared in a cell; null: none recorded.
const Frozen* TunedFor(const Oracle& oracle, const std::string& strategy,
                       const std::string& cell) {
  const std::string kind = KindOf(strategy);
  const Frozen* best = nullptr;
  for (const std::string& one :
       kind == kBatchBones ? std::vector<std::string>{"batch", kBatchBones}
                           : std::vector<std::string>{kind}) {
    const auto found = oracle.find(one + "," + cell);
    if (found == oracle.end()) continue;
    if (best == nullptr || found->second.rmse_mm < best->rmse_mm) {
      best = &found->second;
    }
  }
  return best;
}

void PrintSummary(const std::string& name, const Errors& e) {
  std::printf("%-18s rmse %7.2f mm, coverage %.1f %%, NEES/3 %.2f",
              name.c_str(), e.rmse_mm(), e.inside.percent(),
              e.nees / e.inside.count / 3.0);
  std::printf("; by acceleration:");
  for (size_t b = 0; b < 4; ++b) {
    std::printf(" %.1f mm %.1f %% (%zu)", RmseOf(e.by_acceleration_m[b]),
                e.inside_by_acceleration[b].percent(),
                e.by_acceleration_m[b].size());
  }
  std::printf("; by views:");
  for (size_t v = 0; v < 6; ++v) {
    if (e.inside_by_views[v].count < 100) continue;
    std::printf(" %zu: %.1f %%", v, e.inside_by_views[v].percent());
  }
  std::printf("; %.3f ms per frame\n", 1e3 * e.cpu_s / e.frames);
}

void Merge(const Errors& part, Errors* whole) {
  const auto append = [](const std::vector<float>& from,
                         std::vector<float>* to) {
    to->insert(to->end(), from.begin(), from.end());
  };
  append(part.errors_m, &whole->errors_m);
  for (size_t b = 0; b < 4; ++b) {
    append(part.by_acceleration_m[b], &whole->by_acceleration_m[b]);
    whole->inside_by_acceleration[b].Add(part.inside_by_acceleration[b]);
  }
  for (size_t v = 0; v < 6; ++v) {
    whole->inside_by_views[v].Add(part.inside_by_views[v]);
  }
  whole->inside.Add(part.inside);
  whole->first_second_sum += part.first_second_sum;
  whole->first_second_count += part.first_second_count;
  whole->nees += part.nees;
  whole->log_score += part.log_score;
  whole->cpu_s += part.cpu_s;
  whole->frames += part.frames;
}

// For one detector and strategy, the errors by clip and seed, over all rates.
using Units = std::map<std::string, Errors>;

Errors Pooled(const Units& units) {
  Errors whole;
  for (const auto& [name, part] : units) Merge(part, &whole);
  return whole;
}

// Sum and weight of a unit in a fraction or mean.
using PartOf = std::function<std::pair<double, double>(const Errors&)>;

// Weighted mean over all units, divided by that of `below` if given; with
// `root`, the square root of this; times `scale`; with an interval from
// resampling units. NaN, which becomes null in JSON, without weight.
nlohmann::json WithInterval(const Units& units, const PartOf& part,
                            double scale, const Units* below = nullptr,
                            bool root = false) {
  std::vector<std::array<double, 4>> sums;
  for (const auto& [name, e] : units) {
    const auto [sum, weight] = part(e);
    const auto [sum_below, weight_below] =
        below == nullptr ? std::pair{1.0, 1.0} : part(below->at(name));
    sums.push_back({sum, weight, sum_below, weight_below});
  }
  const auto statistic = [&](const DrawCounts& counts) {
    std::array<double, 4> total = {};
    for (size_t i = 0; i < sums.size(); ++i) {
      for (size_t k = 0; k < 4; ++k) {
        total[k] += static_cast<double>(counts[i]) * sums[i][k];
      }
    }
    const double ratio = total[0] / total[1] / (total[2] / total[3]);
    return scale * (root ? std::sqrt(ratio) : ratio);
  };
  BootstrapOptions options;
  options.block_length = 1;
  const Interval interval =
      BlockBootstrap({static_cast<int64_t>(sums.size())}, statistic, options);
  return {{"value", statistic(DrawCounts(sums.size(), 1))},
          {"interval", {{"low", interval.low}, {"high", interval.high}}}};
}

PartOf Covered(const std::function<const Share2&(const Errors&)>& of) {
  return [of](const Errors& e) { return std::pair{of(e).inside, of(e).count}; };
}

nlohmann::json DetailsOf(const Units& units, const Units* robust) {
  const Errors whole = Pooled(units);
  nlohmann::json details = {
      {"rmse_mm", whole.rmse_mm()},
      {"covered",
       WithInterval(units, Covered([](const Errors& e) -> const Share2& {
                      return e.inside;
                    }),
                    100.0)}};
  for (size_t b = 0; b < 4; ++b) {
    const auto squares = [b](const Errors& e) {
      const auto count = static_cast<double>(e.by_acceleration_m[b].size());
      if (count == 0.0) return std::pair{0.0, 0.0};
      return std::pair{count * std::pow(RmseOf(e.by_acceleration_m[b]), 2),
                       count};
    };
    const auto inside = [b](const Errors& e) -> const Share2& {
      return e.inside_by_acceleration[b];
    };
    nlohmann::json bin = {
        {"joint_frames", whole.by_acceleration_m[b].size()},
        {"rmse_mm", RmseOf(whole.by_acceleration_m[b])},
        {"covered", WithInterval(units, Covered(inside), 100.0)}};
    if (robust != nullptr) {
      bin["to_robust"] = WithInterval(units, squares, 1.0, robust, true);
    }
    details["by_acceleration"].push_back(bin);
  }
  for (size_t v = 0; v < 6; ++v) {
    const auto inside = [v](const Errors& e) -> const Share2& {
      return e.inside_by_views[v];
    };
    details["by_views"].push_back(
        {{"joint_frames", whole.inside_by_views[v].count},
         {"covered", WithInterval(units, Covered(inside), 100.0)}});
  }
  return details;
}

class Matrix {
 public:
  explicit Matrix(const Settings& settings)
      : settings_(settings), strategies_(Chosen(settings)) {
    for (const std::string& path : settings.oracles) ReadOracle(path, &oracle_);
    if (settings.write_oracle.empty()) return;
    frozen_ = std::fopen(settings.write_oracle.c_str(), "w");
    std::fprintf(frozen_,
                 "# Best fixed tuning of each cell in hindsight; seeds %d:%d\n"
                 "# estimator,clip,rate_hz,noise,tuning,rmse_mm,p999_mm,"
                 "log_score\n",
                 static_cast<int>(settings.first_seed),
                 static_cast<int>(settings.end_seed));
  }
  ~Matrix() {
    if (frozen_ != nullptr) std::fclose(frozen_);
  }
  Matrix(const Matrix&) = delete;
  Matrix& operator=(const Matrix&) = delete;

  void Run() {
    for (const Cell& cell : CellsOf(settings_)) {
      const ByStrategy found = Measure(cell);
      Report(cell, found);
      Freeze(cell, found);
    }
    Summarize();
    if (settings_.json.empty()) return;
    std::ofstream(settings_.json) << rows_.dump(1) << "\n";
  }

 private:
  using ByStrategy = std::map<std::string, Errors>;

  ByStrategy Measure(const Cell& cell) {
    ByStrategy found;
    SteadyClip clip =
        testing::FirstSeconds(testing::Resample(Load(cell.clip), cell.rate_hz),
                              std::min(cell.seconds, settings_.seconds));
    if (settings_.rest_s > 0.0) {
      clip = testing::AfterRest(clip, settings_.rest_s);
    }
    for (uint64_t seed = settings_.first_seed; seed < settings_.end_seed;
         ++seed) {
      const SteadyClip seen =
          settings_.joint_sway_m > 0.0
              ? testing::WithJointSway(clip, settings_.joint_sway_m, seed)
              : clip;
      const MotionRecording recording = testing::ObserveMotion(
          seen, testing::MotionCameras(settings_.cameras), cell.detector,
          1000 * seed + 17);
      for (const Strategy& strategy : strategies_) {
        Errors errors;
        Score(recording, strategy, settings_.rest_s, &errors);
        Merge(errors, &found[strategy.name]);
        Merge(errors, &units_[cell.detector.name][strategy.name]
                             [cell.clip + " " + std::to_string(seed)]);
      }
    }
    return found;
  }

  void Report(const Cell& cell, const ByStrategy& found) {
    std::printf("%-34s", cell.name().c_str());
    nlohmann::json row = {{"cell", cell.name()}};
    for (const Strategy& strategy : strategies_) {
      const Errors& e = found.at(strategy.name);
      std::printf(" | %s %.2f", strategy.name.c_str(), e.rmse_mm());
      nlohmann::json& figures = row["strategies"][strategy.name];
      figures = {{"rmse_mm", e.rmse_mm()},
                 {"covered_percent", e.inside.percent()}};
      const Frozen* tuned = TunedFor(oracle_, strategy.name, cell.name());
      if (tuned != nullptr) {
        Compare(e, *tuned, &figures);
        ratios_[strategy.name].push_back(figures["ratio"]);
      }
      if (settings_.details) {
        std::printf(" [cov %.1f, 1st s %.1f]", e.inside.percent(),
                    1e3 * std::sqrt(e.first_second_sum /
                                    std::max(1.0, e.first_second_count)));
      }
    }
    std::printf("\n");
    std::fflush(stdout);
    rows_.push_back(row);
  }

  static void Compare(const Errors& e, const Frozen& tuned,
                      nlohmann::json* figures) {
    const double ratio = e.rmse_mm() / tuned.rmse_mm;
    const double p999_ratio = e.quantile_mm(0.999) / tuned.p999_mm;
    std::printf(" (%.3f, p999 %.2f)", ratio, p999_ratio);
    (*figures)["ratio"] = ratio;
    (*figures)["tuned_mm"] = tuned.rmse_mm;
    (*figures)["tuning"] = tuned.tuning;
    (*figures)["p999_ratio"] = p999_ratio;
    (*figures)["log_score_gain"] =
        e.log_score / e.inside.count - tuned.log_score;
  }

  void Freeze(const Cell& cell, const ByStrategy& found) {
    if (frozen_ == nullptr) return;
    std::map<std::string, std::string> best;
    for (const Strategy& strategy : strategies_) {
      std::string& least = best[KindOf(strategy.name)];
      if (least.empty() ||
          found.at(strategy.name).rmse_mm() < found.at(least).rmse_mm()) {
        least = strategy.name;
      }
    }
    for (const auto& [kind, name] : best) {
      const Errors& e = found.at(name);
      std::fprintf(frozen_, "%s,%s,%s,%.3f,%.3f,%.4f\n", kind.c_str(),
                   cell.name().c_str(), name.c_str(), e.rmse_mm(),
                   e.quantile_mm(0.999), e.log_score / e.inside.count);
    }
    std::fflush(frozen_);
  }

  void Summarize() {
    for (const auto& [name, ratios] : ratios_) {
      double sum = 0.0;
      for (const double ratio : ratios) sum += std::log(ratio);
      std::printf(
          "%-18s ratio to the best fixed tuning: geometric mean %.3f, worst "
          "%.3f\n",
          name.c_str(), std::exp(sum / static_cast<double>(ratios.size())),
          *std::max_element(ratios.begin(), ratios.end()));
    }
    for (const auto& [detector, by_strategy] : units_) {
      if (strategies_.size() > 12) break;
      nlohmann::json row = {{"detector", detector}};
      const auto robust = by_strategy.find("robust");
      for (const auto& [name, units] : by_strategy) {
        PrintSummary(detector + " " + name, Pooled(units));
        if (!settings_.details) continue;
        row["strategies"][name] = DetailsOf(
            units, robust == by_strategy.end() ? nullptr : &robust->second);
      }
      if (settings_.details) rows_.push_back(row);
    }
  }

  const Settings& settings_;
  std::vector<Strategy> strategies_;
  Oracle oracle_;
  std::FILE* frozen_ = nullptr;
  nlohmann::json rows_ = nlohmann::json::array();
  std::map<std::string, std::vector<double>> ratios_;
  std::map<std::string, std::map<std::string, Units>> units_;  // by detector
};

bool FlagValue(const char* argument, const std::string& name,
               std::string* value) {
  const std::string start = "--" + name + "=";
  if (std::strncmp(argument, start.c_str(), start.size()) != 0) return false;
  *value = argument + start.size();
  return true;
}

int Main(int argc, char** argv) {
  Settings settings;
  settings.strategies = {"window", "batch"};
  for (int i = 1; i < argc; ++i) {
    std::string value;
    if (FlagValue(argv[i], "clips", &value)) {
      settings.clips = Split(value);
    } else if (FlagValue(argv[i], "rates", &value)) {
      settings.rates = Split(value);
    } else if (FlagValue(argv[i], "noises", &value)) {
      settings.noises = Split(value);
    } else if (FlagValue(argv[i], "strategies", &value)) {
      settings.strategies = Split(value);
    } else if (FlagValue(argv[i], "seconds", &value)) {
      settings.seconds = std::atof(value.c_str());
    } else if (FlagValue(argv[i], "rest", &value)) {
      settings.rest_s = std::atof(value.c_str());
    } else if (FlagValue(argv[i], "joint_sway", &value)) {
      settings.joint_sway_m = std::atof(value.c_str());
    } else if (FlagValue(argv[i], "solver", &value)) {
      if (value != "sweeps" && value != "ceres") {
        std::fprintf(stderr, "unknown solver %s\n", value.c_str());
        return 2;
      }
      settings.solver = value == "sweeps" ? GraphSolver::kBlockTridiagonal
                                          : GraphSolver::kCeres;
    } else if (FlagValue(argv[i], "cameras", &value)) {
      settings.cameras = std::atoi(value.c_str());
    } else if (FlagValue(argv[i], "oracle", &value)) {
      settings.oracles = Split(value);
    } else if (FlagValue(argv[i], "write_oracle", &settings.write_oracle)) {
    } else if (FlagValue(argv[i], "json", &settings.json)) {
    } else if (std::strcmp(argv[i], "--details") == 0) {
      settings.details = true;
    } else if (FlagValue(argv[i], "seeds", &value)) {
      char* end = nullptr;
      settings.first_seed = std::strtoull(value.c_str(), &end, 10);
      settings.end_seed = *end == ':' ? std::strtoull(end + 1, nullptr, 10)
                                      : settings.first_seed + 1;
    } else {
      std::fprintf(stderr, "unknown argument %s\n", argv[i]);
      return 2;
    }
  }
  Matrix(settings).Run();
  return 0;
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) { return kinegraph::Main(argc, argv); }
