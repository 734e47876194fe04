#include "apps/compare/study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/common/progress.h"
#include "apps/compare/tuning.h"
#include "core/base/constants.h"
#include "core/base/error.h"

namespace kinegraph {
namespace {

// Points of a strategy, and the errors there on each recording.
struct StrategyPoints {
  std::vector<StrategyValues> points;
  std::vector<PointErrors> errors;  // [recording]
};

Comparison ComparisonOf(FrozenRecording recording,
                        const StudyRequest& request) {
  const auto prepared =
      PrepareRecording(recording.run, recording.options,
                       recording.run.detections, request.threads);
  const FrameRange all = {recording.run.first_frame,
                          recording.run.tracks.frames.back().frame + 1};
  return MakeComparison(std::move(recording.options), std::move(recording.run),
                        {{all, prepared}}, std::nullopt, request.threads);
}

// What is wrong with one of many recordings names it.
template <typename Work>
void ForRecording(const RecordingInput& input, const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    throw InputError("take '" + Printable(input.name) + "': " + error.what());
  }
}

void AddErrors(const Comparison& comparison, const Strategy& strategy,
               StrategyPoints* points) {
  points->errors.push_back(
      ScoreGrid(comparison, strategy, points->points).errors[0][0]);
}

StudyScore ScoreOf(const Comparison& comparison, const StrategyScores& own,
                   const StrategyScores& baseline, bool is_baseline) {
  StudyScore score;
  score.refused = own.refused;
  if (!score.refused.empty()) return score;
  const BootstrapOptions bootstrap = comparison.bootstrap();
  score.mean_px = PooledRatio({own.held_out_errors});
  score.standard_error_px =
      PooledRatioInterval({own.held_out_errors}, bootstrap).standard_error;
  if (is_baseline) return score;
  score.difference_px = score.mean_px - PooledRatio({baseline.held_out_errors});
  const Interval interval = PairedPooledInterval(
      {own.held_out_errors}, {baseline.held_out_errors}, bootstrap);
  score.difference_error_px = interval.standard_error;
  score.verdict = VerdictOf(interval);
  return score;
}

// The study while it is made.
class Maker {
 public:
  explicit Maker(const StudyRequest& request)
      : request_(request), chosen_(request.strategies.size()) {
    study_.strategies = request.strategies;
    study_.baseline_idx = request.baseline_idx;
    study_.tuned = request.tune;
  }

  Study Make() {
    if (request_.tune) WalkGrids();
    for (size_t t = 0; t < request_.recordings.size(); ++t) {
      ForRecording(request_.recordings[t], [&] { ScoreRecording(t); });
    }
    Choose();
    return std::move(study_);
  }

 private:
  // Every grid on every recording.
  void WalkGrids() {
    const std::vector<Strategy> tuned = TunedThemselves(request_.strategies);
    for (const Strategy& one : tuned) grids_[one.name].points = GridOf(one);
    Progress progress("tuning", static_cast<int64_t>(
                                    request_.recordings.size() * tuned.size()));
    for (const RecordingInput& input : request_.recordings) {
      ForRecording(input, [&] {
        const Comparison comparison =
            ComparisonOf(FreezeRecording(input, request_.threads), request_);
        for (const Strategy& one : tuned) {
          AddErrors(comparison, one, &grids_[one.name]);
          progress.Advance();
        }
      });
    }
  }

  // Chosen without a recording (-1: on all); of a strategy that could be run on
  // none of the others, those of the configuration.
  StrategyValues ValuesOf(size_t s, int left_out,
                          const StrategyValues& defaults) const {
    if (!request_.tune) return defaults;
    const StrategyPoints& grid =
        grids_.at(TunedAs(request_.strategies[s]).name);
    const auto best = BestPoint(grid.errors, left_out);
    return best ? grid.points[*best] : defaults;
  }

  // Values that somebody chooses of a strategy, each once.
  std::vector<StrategyValues> Wanted(size_t s,
                                     const StrategyValues& defaults) const {
    std::vector<StrategyValues> wanted;
    const int recordings = static_cast<int>(request_.recordings.size());
    for (int left_out = -1; left_out < recordings; ++left_out) {
      const StrategyValues values = ValuesOf(s, left_out, defaults);
      if (std::find(wanted.begin(), wanted.end(), values) == wanted.end()) {
        wanted.push_back(values);
      }
    }
    return wanted;
  }

  void ScoreRecording(size_t t) {
    const Comparison comparison = ComparisonOf(
        FreezeRecording(request_.recordings[t], request_.threads), request_);
    std::vector<FoldValues> values;
    for (size_t s = 0; s < request_.strategies.size(); ++s) {
      const StrategyValues defaults =
          DefaultValues(request_.strategies[s], comparison.rate_hz(),
                        comparison.options.estimators);
      values.push_back({ValuesOf(s, static_cast<int>(t), defaults)});
      if (t == 0) defaults_.push_back(defaults);
      chosen_[s].points = Wanted(s, defaults);
      AddErrors(comparison, request_.strategies[s], &chosen_[s]);
    }
    StudyRecording recording;
    recording.name = request_.recordings[t].name;
    const std::vector<StrategyScores> scores = ScoreStrategies(
        comparison, request_.strategies, values, "scoring " + recording.name);
    const StrategyScores& baseline = scores[request_.baseline_idx];
    if (!baseline.refused.empty()) {
      throw InputError("the baseline cannot be run: " + baseline.refused);
    }
    for (size_t s = 0; s < scores.size(); ++s) {
      recording.scores.push_back(
          ScoreOf(comparison, scores[s], baseline, s == request_.baseline_idx));
      recording.scores.back().values = values[s].front();
    }
    study_.recordings.push_back(std::move(recording));
    if (t == 0) {
      study_.options = comparison.options;
      study_.rate_hz = comparison.rate_hz();
    }
  }

  // The errors of every strategy with the values that are chosen without a
  // recording: the "points" among which the strategy is chosen.
  std::optional<size_t> BestStrategy(int left_out) const {
    std::vector<PointErrors> recordings(request_.recordings.size());
    for (size_t s = 0; s < request_.strategies.size(); ++s) {
      size_t point = 0;
      if (request_.tune) {
        const auto& points = chosen_[s].points;
        const StrategyValues values = ValuesOf(s, left_out, defaults_[s]);
        point = static_cast<size_t>(
            std::find(points.begin(), points.end(), values) - points.begin());
      }
      for (size_t t = 0; t < recordings.size(); ++t) {
        const PointErrors& errors = chosen_[s].errors[t];
        recordings[t].push_back(point < errors.size() ? errors[point]
                                                      : RatioUnit());
      }
    }
    return BestPoint(recordings, left_out);
  }

  void Choose() {
    for (size_t t = 0; t < study_.recordings.size(); ++t) {
      study_.recordings[t].chosen = BestStrategy(static_cast<int>(t));
    }
    study_.best = BestStrategy(-1);
    if (study_.best) {
      study_.best_values = ValuesOf(*study_.best, -1, defaults_[*study_.best]);
    }
  }

  const StudyRequest& request_;
  std::map<std::string, StrategyPoints> grids_;
  std::vector<StrategyPoints> chosen_;  // of the strategies asked for
  std::vector<StrategyValues> defaults_;
  Study study_;
};

}  // namespace

std::optional<size_t> BestPoint(const std::vector<PointErrors>& recordings,
                                int left_out) {
  std::optional<size_t> best;
  double least = kNan;
  const size_t points = recordings.empty() ? 0 : recordings.front().size();
  for (size_t point = 0; point < points; ++point) {
    double sum = 0.0;
    int count = 0;
    for (size_t t = 0; t < recordings.size(); ++t) {
      if (static_cast<int>(t) == left_out) continue;
      const RatioUnit& unit = recordings[t][point];
      sum += unit.weight > 0.0 ? unit.sum / unit.weight : kNan;
      ++count;
    }
    const double mean = count > 0 ? sum / count : kNan;
    if (std::isnan(mean) || (best && mean >= least)) continue;
    best = point;
    least = mean;
  }
  return best;
}

StudyVerdict HoldsFor(const Study& study) {
  StudyVerdict verdict;
  for (const StudyRecording& recording : study.recordings) {
    if (!recording.chosen ||
        !recording.scores[*recording.chosen].refused.empty())
      continue;
    ++verdict.recordings;
    if (recording.chosen == study.best) ++verdict.like_all;
    switch (recording.scores[*recording.chosen].verdict) {
      case Verdict::kLess:
        ++verdict.better;
        break;
      case Verdict::kMore:
        ++verdict.worse;
        break;
      default:
        ++verdict.same;
    }
  }
  return verdict;
}

Study RunStudy(const StudyRequest& request) { return Maker(request).Make(); }

}  // namespace kinegraph
