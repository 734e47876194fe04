#include "solvers/scene/clock_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/base/median.h"

namespace kinegraph {
namespace {

// Minimum gain in agreement (0 to 1) from a lag: people who stand still agree
// at almost any lag.
constexpr double kMinClockGain = 0.04;
constexpr int kFramesToCompare = 30;
// Standard deviation of the gain of one pair of people. The best of many lags
// appears better than it is by about three standard errors of the mean.
constexpr double kGainSpread = 0.3;
constexpr double kBestOfMany = 3.0;
// Maximum ratio of the distances from epipolar lines after and before. The
// right lags reduce the distances of matched people by at least 27 % in
// recordings whose clocks differ by 100 to 400 ms, even with 8 px of noise.
// With misoriented cameras some lag also increases the agreement, but reduces
// the distances by only 7 %.
constexpr double kCloser = 0.85;
// The same for single views, over the pairs with this view: for one of five
// views with a lag of three frames at 25 Hz, the reduction is 10 to 28 % if
// some people stand still and errors are 8 px; with misoriented cameras it is
// at most 8 % at any lag. This is tested on more frames (kFramesToJudge) than
// the search uses.
constexpr double kOneCloser = 0.91;
constexpr int kFramesToJudge = 120;
// Maximum number of comparisons of two people, about two seconds. If even two
// frames need more, lags are tried in larger steps.
constexpr double kMostComparisons = 6e7;

bool IsWorthIt(const AgreementGain& gain, double closer) {
  const double pairs = std::min(gain.before.possible, gain.after.possible);
  const double chance = kBestOfMany * kGainSpread / std::sqrt(pairs);
  return gain.after.mean_px() < closer * gain.before.mean_px() &&
         gain.gain() > std::max(kMinClockGain, chance);
}

// Finds the lags of the views from the agreement of each pair at lags of -max
// .. max, in steps.
class LagSearch {
 public:
  LagSearch(const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
            const std::vector<int>& frames, int max_lag, int step)
      : cameras_(cameras),
        ideal_(ideal),
        views_(cameras.size()),
        max_lag_(max_lag),
        step_(step),
        scores_(views_ * views_) {
    std::vector<int> lags;
    for (int lag = -max_lag; lag <= max_lag; lag += step) lags.push_back(lag);
    for (const auto& [a, b] : ComparedPairs(views_)) {
      scores_[a * views_ + b] = AgreementsOf(cameras[a], ideal[a], cameras[b],
                                             ideal[b], frames, lags);
    }
  }

  // With each of up to eight views as the reference: chooses the best lag of
  // each other view relative to the next view on its path to the reference,
  // then improves each view's lag relative to all others until nothing changes.
  // Returns the lags with the greatest sum of scores, relative to the first
  // view.
  std::vector<int> BestLags() const {
    constexpr size_t kMostReferences = 8;
    const size_t references = std::min(views_, kMostReferences);
    std::vector<int> best(views_, 0);
    for (size_t i = 0; i < references; ++i) {
      const size_t reference = i * views_ / references;
      std::vector<int> lags(views_, 0);
      for (const auto& way : WaysFrom(reference)) {
        const size_t from = way.second;
        lags[way.first] = BestLag(lags[from], [&](int lag) {
          return Of(from, way.first, lag - lags[from]);
        });
      }
      for (bool changed = true; changed;) {
        changed = false;
        for (size_t v = 0; v < views_; ++v) {
          if (v == reference) continue;
          const int lag = BestLagOf(v, lags);
          changed = changed || lag != lags[v];
          lags[v] = lag;
        }
      }
      if (Total(lags) > Total(best) + 1e-9) best = lags;
    }
    const int first = best.empty() ? 0 : best[0];
    for (int& lag : best) lag -= first;
    return best;
  }

  // Finds lags of fewer than half of the views, each relative to all others at
  // their current lags, the largest gain first: their effect on the agreement
  // of all views may be small.
  std::vector<int> LagsOfFew() const {
    // Each pair of views is compared four times: with the old and the new lag
    // of either view.
    const std::vector<int> frames = FramesToLookAt(ideal_, kFramesToJudge, 4);
    std::vector<int> lags(views_, 0);
    for (size_t found = 0; 2 * (found + 1) < views_; ++found) {
      std::vector<int> best = lags;
      double best_gain = 0.0;
      for (size_t v = 0; v < views_; ++v) {
        std::vector<int> trial = lags;
        trial[v] = BestLagOf(v, lags);
        if (trial[v] == lags[v]) continue;
        std::vector<int> alone(views_, 0);
        alone[v] = 1;
        const AgreementGain gain = {Agreement(lags, frames, alone),
                                    Agreement(trial, frames, alone)};
        if (gain.gain() <= best_gain || !IsWorthIt(gain, kOneCloser)) continue;
        best = std::move(trial);
        best_gain = gain.gain();
      }
      if (best == lags) break;
      lags = std::move(best);
    }
    return lags;
  }

  // Agreement over the pairs of views whose marks differ.
  PairAgreement Agreement(const std::vector<int>& lags,
                          const std::vector<int>& frames,
                          const std::vector<int>& marks) const {
    PairAgreement all;
    for (const auto& [a, b] : ComparedPairs(views_)) {
      if (marks[a] == marks[b]) continue;
      std::vector<int> moved;
      for (const int k : frames) {
        const int at = k + lags[a];
        if (at >= 0 && at < static_cast<int>(ideal_[a].frames.size())) {
          moved.push_back(at);
        }
      }
      all.Add(AgreementOf(cameras_[a], ideal_[a], cameras_[b], ideal_[b], moved,
                          lags[b] - lags[a]));
    }
    return all;
  }

 private:
  double Of(size_t a, size_t b, int lag) const {
    if (a > b) return Of(b, a, -lag);
    if (!Compares(a, b) || std::abs(lag) > max_lag_) return 0.0;
    return scores_[a * views_ + b][(lag + max_lag_) / step_].score();
  }
  bool Compares(size_t a, size_t b) const {
    return !scores_[std::min(a, b) * views_ + std::max(a, b)].empty();
  }

  // Best lag of view v with the other views at `lags`; unchanged if none is
  // better.
  int BestLagOf(size_t v, const std::vector<int>& lags) const {
    return BestLag(lags[v], [&](int lag) {
      double score = 0.0;
      for (size_t u = 0; u < views_; ++u) {
        if (u != v) score += Of(u, v, lag - lags[u]);
      }
      return score;
    });
  }

  // The lag with the best score; `best` if none is better than it.
  template <typename Score>
  int BestLag(int best, const Score& score_at) const {
    double best_score = score_at(best);
    for (int lag = -max_lag_; lag <= max_lag_; ++lag) {
      const double score = score_at(lag);
      if (score <= best_score + 1e-9) continue;
      best_score = score;
      best = lag;
    }
    return best;
  }

  double Total(const std::vector<int>& lags) const {
    double total = 0.0;
    for (const auto& [a, b] : ComparedPairs(views_)) {
      total += Of(a, b, lags[b] - lags[a]);
    }
    return total;
  }

  // The views other than `reference`, each with the next view on the path to
  // it: `reference` itself if all pairs are compared.
  std::vector<std::pair<size_t, size_t>> WaysFrom(size_t reference) const {
    std::vector<std::pair<size_t, size_t>> ways;
    std::vector<char> reached(views_, 0);
    std::vector<size_t> order = {reference};
    reached[reference] = 1;
    for (size_t i = 0; i < order.size(); ++i) {
      for (size_t v = 0; v < views_; ++v) {
        if (reached[v] || !Compares(order[i], v)) continue;
        reached[v] = 1;
        ways.emplace_back(v, order[i]);
        order.push_back(v);
      }
    }
    return ways;
  }

  const CameraRig& cameras_;
  const std::vector<ViewPeople>& ideal_;
  size_t views_;
  int max_lag_;
  int step_;
  std::vector<std::vector<PairAgreement>> scores_;
};

}  // namespace

bool ClockSearch::found() const {
  return std::any_of(lag_frames.begin(), lag_frames.end(),
                     [](int lag) { return lag != 0; });
}

ClockSearch SearchClocks(const CameraRig& cameras,
                         const std::vector<ViewPeople>& ideal, int max_lag) {
  const size_t views = cameras.size();
  ClockSearch search;
  search.lag_frames.assign(views, 0);
  if (views < 2) return search;
  const auto count = static_cast<int>(ideal[0].frames.size());
  const int reach = std::min(max_lag, count / 3);
  // A large range of lags, i.e. at a high frame rate, is searched in steps of
  // max_lag / 200, but at least three frames. For the default of ten seconds
  // this is a twentieth of a second, in which people hardly move.
  int step = max_lag > 300 ? std::max(3, max_lag / 200) : 1;
  const int lags_tried = 2 * reach / step + 1;
  const std::vector<int> searched =
      FramesToLookAt(ideal, kFramesToCompare, 4 * lags_tried);
  if (searched.empty()) return search;
  step *= 1 + static_cast<int>(lags_tried * ComparisonsOfAll(ideal, searched) /
                               kMostComparisons);
  const LagSearch lag_search(cameras, ideal, searched, reach, step);
  const std::vector<int> frames = FramesToLookAt(ideal, kFramesToCompare, 4);
  const std::vector<int> none(views, 0);
  const std::vector<int> every = IndicesUpTo(views);
  std::vector<int> lags = lag_search.BestLags();
  search.all = {lag_search.Agreement(none, frames, every),
                lag_search.Agreement(lags, frames, every)};
  if (!IsWorthIt(search.all, kCloser)) {
    lags = lag_search.LagsOfFew();
    search.all.after = lag_search.Agreement(lags, frames, every);
  }
  for (size_t v = 0; v < views; ++v) search.lag_frames[v] = lags[v] - lags[0];
  search.moved = {lag_search.Agreement(none, frames, lags),
                  lag_search.Agreement(lags, frames, lags)};
  return search;
}

int64_t UsualStep(const std::vector<DetectionFrame>& frames) {
  constexpr double kLeastShare = 0.9;
  std::vector<int64_t> steps;
  for (size_t k = 1; k < frames.size(); ++k) {
    steps.push_back(frames[k].frame - frames[k - 1].frame);
  }
  if (steps.empty()) return 1;
  const int64_t usual =
      std::max<int64_t>(1, std::llround(Median({steps.begin(), steps.end()})));
  const auto multiples =
      std::count_if(steps.begin(), steps.end(),
                    [&](int64_t step) { return step % usual == 0; });
  return static_cast<double>(multiples) >=
                 kLeastShare * static_cast<double>(steps.size())
             ? usual
             : 1;
}

DetectionSequence OnGrid(const DetectionSequence& detections, int64_t step,
                         int64_t longest) {
  const std::vector<DetectionFrame>& frames = detections.frames;
  const auto steps_to = [&](size_t k) {
    return static_cast<int64_t>(std::llround(
        static_cast<double>(frames[k].frame - frames[k - 1].frame) /
        static_cast<double>(step)));
  };
  int64_t gaps = 0;
  for (size_t k = 1; k < frames.size(); ++k) gaps += steps_to(k) > 1 ? 1 : 0;
  if (gaps == 0) return detections;
  // At most ten empty frames per recorded frame.
  longest = std::min(longest, 5 * static_cast<int64_t>(frames.size()) / gaps);
  DetectionSequence grid;
  grid.header = detections.header;
  for (size_t k = 0; k < frames.size(); ++k) {
    const int64_t steps = k > 0 ? steps_to(k) : 0;
    for (int64_t i = 1; i < steps; ++i) {
      if (i > longest) i = std::max(i, steps - longest);
      if (i >= steps) break;
      const DetectionFrame& before = frames[k - 1];
      DetectionFrame empty;
      empty.frame = before.frame + i * step;
      empty.time = before.time +
                   static_cast<TimeNs>(
                       static_cast<double>(frames[k].time - before.time) *
                       static_cast<double>(i) / static_cast<double>(steps));
      empty.views.resize(frames[k].views.size());
      for (ViewDetections& view : empty.views) view.capture_time = empty.time;
      grid.frames.push_back(std::move(empty));
    }
    grid.frames.push_back(frames[k]);
  }
  return grid;
}

DetectionSequence Realigned(const DetectionSequence& detections,
                            const std::vector<int>& lag_frames) {
  return FramesMoved(
      detections, [&](size_t view, int64_t k) { return k + lag_frames[view]; });
}

}  // namespace kinegraph
