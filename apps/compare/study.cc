#include "apps/compare/study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/common/app.h"
#include "apps/compare/scores.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/parallel.h"

namespace kinegraph {
namespace {

// Points of every strategy, and the errors there.
struct StrategyPoints {
  std::vector<StrategyValues> points;
  std::vector<PointErrors> errors;  // [take]
};

size_t IndexOf(const std::vector<Strategy>& strategies,
               const std::string& name) {
  const auto at =
      std::find_if(strategies.begin(), strategies.end(),
                   [&name](const Strategy& one) { return one.name == name; });
  return static_cast<size_t>(at - strategies.begin());
}

// Strategies whose grids are walked, those asked for first.
std::vector<Strategy> WithThoseTunedAs(std::vector<Strategy> strategies) {
  for (size_t s = 0; s < strategies.size(); ++s) {
    const std::string& name = strategies[s].tuned_as;
    if (name.empty() || IndexOf(strategies, name) < strategies.size()) continue;
    strategies.push_back(ChooseStrategies({name}).front());
  }
  return strategies;
}

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

// Sum and number of truncated errors without one view.
RatioUnit ScorePoint(const Comparison& comparison, const Strategy& strategy,
                     const StrategyValues& values, size_t view) {
  RatioUnit pooled;
  const Fold& fold = comparison.folds.front();
  HeldOutScores scores;
  ScoreWithout(comparison, fold, view,
               RunWithout(comparison, strategy, values, *fold.recording, view),
               &scores);
  for (const RatioUnit& unit : TruncatedErrors(scores, AllJoints())) {
    pooled.sum += unit.sum;
    pooled.weight += unit.weight;
  }
  return pooled;
}

PointErrors ScorePoints(const Comparison& comparison, const Strategy& strategy,
                        const std::vector<StrategyValues>& points) {
  const size_t views = comparison.views().size();
  std::vector<RatioUnit> pieces(points.size() * views);
  std::vector<char> refused(pieces.size(), 0);
  ParallelFor(comparison.threads, static_cast<int>(pieces.size()), [&](int i) {
    const auto piece = static_cast<size_t>(i);
    try {
      pieces[piece] = ScorePoint(comparison, strategy, points[piece / views],
                                 piece % views);
    } catch (const InputError&) {
      refused[piece] = 1;
    } catch (const OptionError&) {
      refused[piece] = 1;
    }
  });
  PointErrors errors(points.size());
  for (size_t point = 0; point < points.size(); ++point) {
    bool runs = true;
    for (size_t view = 0; view < views; ++view) {
      const size_t piece = point * views + view;
      errors[point].sum += pieces[piece].sum;
      errors[point].weight += pieces[piece].weight;
      runs = runs && refused[piece] == 0;
    }
    if (!runs) errors[point] = RatioUnit();
  }
  return errors;
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
      : request_(request),
        tuned_(WithThoseTunedAs(request.strategies)),
        grids_(tuned_.size()),
        chosen_(request.strategies.size()) {
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
    for (size_t s = 0; s < tuned_.size(); ++s) {
      if (!tuned_[s].tuned_as.empty()) continue;
      grids_[s].points = tuned_[s].parameters.empty()
                             ? std::vector<StrategyValues>{{}}
                             : GridOf(tuned_[s]);
    }
    SharedProgress progress(
        "tuning",
        static_cast<int64_t>(request_.recordings.size() * tuned_.size()));
    for (const RecordingInput& input : request_.recordings) {
      ForRecording(input, [&] {
        const Comparison comparison =
            ComparisonOf(FreezeRecording(input, request_.threads), request_);
        for (size_t s = 0; s < tuned_.size(); ++s) {
          grids_[s].errors.push_back(
              ScorePoints(comparison, tuned_[s], grids_[s].points));
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
    const Strategy& strategy = request_.strategies[s];
    const size_t from =
        strategy.tuned_as.empty() ? s : IndexOf(tuned_, strategy.tuned_as);
    const auto best = BestPoint(grids_[from].errors, left_out);
    return best ? grids_[from].points[*best] : defaults;
  }

  // Values that somebody chooses of a strategy, and where they stand among
  // them.
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
      chosen_[s].errors.push_back(
          ScorePoints(comparison, request_.strategies[s], chosen_[s].points));
    }
    StudyRecording recording;
    recording.name = request_.recordings[t].name;
    std::vector<StrategyScores> scores;
    {
      SharedProgress progress(
          "scoring " + recording.name,
          PiecesOfScoring(comparison, request_.strategies.size()));
      scores = ScoreStrategies(comparison, request_.strategies, values,
                               [&progress] { progress.Advance(); });
    }
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
  const std::vector<Strategy> tuned_;
  std::vector<StrategyPoints> grids_;   // of tuned_
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
