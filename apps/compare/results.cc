#include "apps/compare/results.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/constants.h"
#include "core/base/parallel.h"
#include "core/evaluation/correspondence.h"
#include "core/evaluation/statistics.h"

namespace kinegraph {
namespace {

constexpr double kMmPerM = 1000.0;

Interval Scaled(Interval interval, double factor) {
  interval.low *= factor;
  interval.high *= factor;
  interval.standard_error *= factor;
  return interval;
}

Measure Named(std::string key, std::string title, std::string unit,
              int decimals) {
  Measure measure;
  measure.key = std::move(key);
  measure.title = std::move(title);
  measure.unit = std::move(unit);
  measure.decimals = decimals;
  measure.value = kNan;
  measure.difference = kNan;
  return measure;
}

// Builds the measures of one strategy against the baseline.
class MeasureList {
 public:
  MeasureList(const BootstrapOptions& bootstrap, bool is_baseline)
      : bootstrap_(bootstrap), is_baseline_(is_baseline) {}

  void Plain(Measure measure, double value) {
    measure.value = value;
    measures_.push_back(std::move(measure));
  }

  // A pooled ratio of series.
  void Ratio(Measure measure, const std::vector<RatioSeries>& own,
             const std::vector<RatioSeries>& baseline, double factor,
             const BootstrapOptions& bootstrap) {
    measure.value = factor * PooledRatio(own);
    if (!std::isnan(measure.value)) {
      measure.interval = Scaled(PooledRatioInterval(own, bootstrap), factor);
      measure.difference = measure.value - factor * PooledRatio(baseline);
      if (!is_baseline_ && !std::isnan(measure.difference)) {
        measure.difference_interval =
            Scaled(PairedPooledInterval(own, baseline, bootstrap), factor);
      }
    }
    measure.verdict = VerdictOf(measure.difference_interval);
    measures_.push_back(std::move(measure));
  }
  void Ratio(Measure measure, const std::vector<RatioSeries>& own,
             const std::vector<RatioSeries>& baseline, double factor = 1.0) {
    Ratio(std::move(measure), own, baseline, factor, bootstrap_);
  }

  void Pcp(Measure measure, const PcpResult& own, const PcpResult& baseline) {
    constexpr PcpGroup kAll = PcpGroup::kTotal;
    measure.less_is_better = false;
    measure.value = MeanOfActors(own, kAll);
    measure.interval = MeanOfActorsInterval(own, kAll, bootstrap_);
    measure.difference = measure.value - MeanOfActors(baseline, kAll);
    if (!is_baseline_) {
      measure.difference_interval =
          MeanOfActorsDifference(own, baseline, kAll, bootstrap_);
    }
    measure.verdict = VerdictOf(measure.difference_interval);
    measures_.push_back(std::move(measure));
  }

  std::vector<Measure> Take() { return std::move(measures_); }

 private:
  BootstrapOptions bootstrap_;
  bool is_baseline_;
  std::vector<Measure> measures_;
};

void AddHeldOutMeasures(const StrategyScores& own,
                        const StrategyScores& baseline, MeasureList* list) {
  list->Ratio(Named("held_out_mean_px",
                    "held-out error, mean of min(error, 30 px)", "px", 2),
              {own.held_out_errors}, {baseline.held_out_errors});
  list->Ratio(Named("held_out_common_px",
                    "held-out error of the joints that all predict", "px", 2),
              {own.held_out_common}, {baseline.held_out_common});
  list->Plain(
      Named("held_out_common_median_px",
            "held-out error of the joints that all predict, median", "px", 2),
      own.held_out_common_median_px);
  const struct {
    HeldOutFigure figure;
    const char* key;
    const char* title;
  } kQuantiles[] = {
      {HeldOutFigure::kMedian, "held_out_median_px", "held-out error, median"},
      {HeldOutFigure::kP90, "held_out_p90_px",
       "held-out error, 90th percentile"},
      {HeldOutFigure::kP97, "held_out_p97_px",
       "held-out error, 97th percentile"}};
  for (const auto& quantile : kQuantiles) {
    Measure measure = Named(quantile.key, quantile.title, "px", 2);
    measure.interval =
        own.held_out.intervals_px[static_cast<int>(quantile.figure)];
    list->Plain(measure, own.held_out.figure_px(quantile.figure));
  }
  list->Plain(Named("predicted_percent", "joints predicted", "%", 1),
              own.held_out.predicted.percent());
  for (int c = 0; c < kJointClassCount; ++c) {
    const std::string name = ToString(static_cast<JointClass>(c));
    list->Ratio(
        Named("held_out_" + name + "_px", "held-out error, " + name, "px", 2),
        {own.held_out_by_class[c]}, {baseline.held_out_by_class[c]});
  }
}

void AddMotionMeasures(const StrategyScores& own,
                       const StrategyScores& baseline,
                       const BootstrapOptions& bootstrap, MeasureList* list) {
  list->Ratio(Named("acceleration_m_s2", "acceleration", "m/s^2", 2),
              own.acceleration, baseline.acceleration);
  list->Ratio(Named("jerk_m_s3", "jerk", "m/s^3", 1), own.jerk, baseline.jerk);
  // Units are segments of two seconds that overlap by half.
  BootstrapOptions segments = bootstrap;
  segments.block_length = 2;
  list->Ratio(Named("power_above_6hz_mm2", "power above 6 Hz", "mm^2", 2),
              own.power, baseline.power, kMmPerM * kMmPerM, segments);
  list->Plain(Named("bone_spread_mm", "bone-length spread", "mm", 1),
              kMmPerM * own.bone_spread_m);
  list->Plain(Named("joints_given_percent", "joints given", "%", 1),
              own.joints_possible == 0
                  ? kNan
                  : 100.0 * static_cast<double>(own.joints) /
                        static_cast<double>(own.joints_possible));
  list->Plain(Named("lag_to_batch_ms", "lag behind batch", "ms", 0),
              kMmPerM * own.lag_to_batch_s.value_or(kNan));
  // 0: at once. NaN: at the end of the recording.
  list->Plain(
      Named("final_after_ms", "final after", "ms", 0),
      own.run.delay.has_value() ? kMmPerM * ToSeconds(*own.run.delay) : kNan);
}

void AddTruthMeasures(const StrategyScores& own, const StrategyScores& baseline,
                      MeasureList* list) {
  list->Ratio(Named("mpjpe_mm", "MPJPE", "mm", 1), own.mpjpe, baseline.mpjpe,
              kMmPerM);
  list->Ratio(Named("mpjpe_bias_removed_mm", "MPJPE, bias removed", "mm", 1),
              own.mpjpe_bias_removed, baseline.mpjpe_bias_removed, kMmPerM);
  if (own.pcp.has_value() && baseline.pcp.has_value()) {
    list->Pcp(Named("pcp_percent", "PCP", "%", 2), *own.pcp, *baseline.pcp);
  }
  list->Plain(Named("lag_to_truth_ms", "lag behind the truth", "ms", 0),
              kMmPerM * own.lag_to_truth_s.value_or(kNan));
  list->Plain(Named("truth_covered_percent",
                    "true joints in the 95 % ellipsoid", "%", 1),
              own.truth_consistency.covered.percent());
  list->Plain(
      Named("truth_nees_per_dof", "NEES per degree of freedom, truth", "", 2),
      own.truth_consistency.nees_per_dof);
}

std::vector<Measure> MeasuresOf(const Comparison& comparison,
                                const StrategyScores& own,
                                const StrategyScores& baseline) {
  const bool is_baseline = &own == &baseline;
  const BootstrapOptions bootstrap = comparison.bootstrap();
  MeasureList list(bootstrap, is_baseline);
  AddHeldOutMeasures(own, baseline, &list);
  AddMotionMeasures(own, baseline, bootstrap, &list);
  list.Plain(Named("held_out_covered_percent",
                   "held-out joints in the 95 % ellipse", "%", 1),
             own.held_out_consistency.covered.percent());
  list.Plain(Named("held_out_nees_per_dof",
                   "NEES per degree of freedom, held-out", "", 2),
             own.held_out_consistency.nees_per_dof);
  if (comparison.truth.has_value()) AddTruthMeasures(own, baseline, &list);
  return list.Take();
}

// Distances between the joints that two views saw, ascending frames [m].
std::vector<double> Distances(const TrackSequence& a, const TrackSequence& b) {
  std::vector<double> distances;
  for (const TrackFrame& frame : a.frames) {
    const TrackFrame* other = FindFrame(b, frame.frame);
    if (other == nullptr) continue;
    for (const PersonPose& person : frame.people) {
      const auto same = std::find_if(
          other->people.begin(), other->people.end(),
          [&person](const PersonPose& one) { return one.id == person.id; });
      if (same == other->people.end()) continue;
      for (size_t j = 0; j < person.joints.size(); ++j) {
        if (person.joints[j].status != JointStatus::kObserved ||
            same->joints[j].status != JointStatus::kObserved) {
          continue;
        }
        distances.push_back(
            (person.joints[j].position_m - same->joints[j].position_m).norm());
      }
    }
  }
  return distances;
}

void AddLagSweep(CompareResult* result) {
  const auto batch =
      std::find_if(result->strategies.begin(), result->strategies.end(),
                   [](const StrategyResult& one) {
                     return one.strategy.name == kOfflineReference &&
                            one.scores.refused.empty();
                   });
  if (batch == result->strategies.end()) return;
  for (size_t s = 0; s < result->strategies.size(); ++s) {
    const StrategyResult& one = result->strategies[s];
    if (one.strategy.lag_frames < 0 || !one.scores.refused.empty()) continue;
    const std::vector<double> distances =
        Distances(one.scores.run.alike, batch->scores.run.alike);
    result->lag_sweep.push_back(
        {s, one.strategy.lag_frames, Quantile(distances, 0.5),
         Quantile(distances, 0.95), Quantile(distances, 0.99)});
  }
}

}  // namespace

const char* ToString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNone:
      return "-";
    case Verdict::kSame:
      return "not told apart";
    case Verdict::kLess:
      return "less";
    case Verdict::kMore:
      return "more";
  }
  return "-";
}

const Measure* StrategyResult::Find(const std::string& key) const {
  for (const Measure& measure : measures) {
    if (measure.key == key) return &measure;
  }
  return nullptr;
}

Verdict VerdictOf(const Interval& difference) {
  if (std::isnan(difference.low) || std::isnan(difference.high)) {
    return Verdict::kNone;
  }
  if (difference.high < 0.0) return Verdict::kLess;
  if (difference.low > 0.0) return Verdict::kMore;
  return Verdict::kSame;
}

void AddMeasures(CompareResult* result) {
  std::vector<StrategyScores*> scores;
  for (StrategyResult& one : result->strategies) scores.push_back(&one.scores);
  AddCommon(std::move(scores));
  const StrategyScores& baseline = result->baseline().scores;
  ParallelFor(result->comparison.threads,
              static_cast<int>(result->strategies.size()), [&](int s) {
                StrategyResult& one = result->strategies[s];
                if (!one.scores.refused.empty()) return;
                one.measures =
                    MeasuresOf(result->comparison, one.scores, baseline);
              });
  AddLagSweep(result);
}

}  // namespace kinegraph
