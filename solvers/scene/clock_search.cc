#include "solvers/scene/clock_search.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

namespace kinegraph {
namespace {

// A lag must bring this much agreement (of 1): between people who stand about
// any lag looks alike.
constexpr double kMinClockGain = 0.04;
constexpr int kFramesToCompare = 30;
// Of one pair's gain, standard deviation; the best of many lags looks better
// than it is by about three standard errors of the mean.
constexpr double kGainSpread = 0.3;
constexpr double kBestOfMany = 3.0;
// Where people are paired, right clocks bring them clearly nearer to each
// other's epipolar lines: by 27 % and more on takes 100 to 400 ms apart, also
// with 8 px of noise. Turned cameras gain some agreement from one lag or
// another, too, and 7 % of the distance.
constexpr double kCloser = 0.85;
// One view of five that was three frames late at 25 Hz, among the pairs that
// show it: 10 to 28 % where some people stand and errors are 8 px, no lag of
// turned cameras more than 8 %. It is judged on more frames than those on which
// it was looked for.
constexpr double kOneCloser = 0.91;
constexpr int kFramesToJudge = 120;
// Of two people: some two seconds. Where two frames take more, lags are tried
// in longer steps.
constexpr double kMostComparisons = 6e7;

// Agreement of each pair of views by lag, -max .. max, in steps.
class LagTable {
 public:
  LagTable(const CameraRig& cameras, const std::vector<ViewPeople>& ideal,
           const std::vector<int>& frames, int max_lag, int step)
      : views_(cameras.size()),
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

  double Of(size_t a, size_t b, int lag) const {
    if (a > b) return Of(b, a, -lag);
    if (!Compares(a, b) || std::abs(lag) > max_lag_) return 0.0;
    const auto at = static_cast<size_t>((lag + max_lag_) / step_);
    return scores_[a * views_ + b][at].score();
  }
  bool Compares(size_t a, size_t b) const {
    return !scores_[std::min(a, b) * views_ + std::max(a, b)].empty();
  }

  // With the other views at theirs; as it is where nothing is better.
  int BestLagOf(size_t v, const std::vector<int>& lags) const {
    const auto score_at = [&](int lag) {
      double score = 0.0;
      for (size_t u = 0; u < views_; ++u) {
        if (u != v) score += Of(u, v, lag - lags[u]);
      }
      return score;
    };
    int best = lags[v];
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

 private:
  size_t views_;
  int max_lag_;
  int step_;
  std::vector<std::vector<PairAgreement>> scores_;
};

// The views other than `middle`, each with the view nearer to it by which it is
// reached: where all pairs are compared that is the middle.
std::vector<std::pair<size_t, size_t>> WaysFrom(size_t middle,
                                                const LagTable& table,
                                                size_t views) {
  std::vector<std::pair<size_t, size_t>> ways;
  std::vector<char> reached(views, 0);
  std::vector<size_t> order = {middle};
  reached[middle] = 1;
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t v = 0; v < views; ++v) {
      if (reached[v] || !table.Compares(order[i], v)) continue;
      reached[v] = 1;
      ways.emplace_back(v, order[i]);
      order.push_back(v);
    }
  }
  return ways;
}

// From up to eight views in turn as the middle: each other view's best lag on
// the way to it, then each view against all others until nothing changes.
std::vector<int> BestLags(const LagTable& table, size_t views, int max_lag) {
  constexpr size_t kMostMiddles = 8;
  const size_t middles = std::min(views, kMostMiddles);
  std::vector<int> best(views, 0);
  double best_total = table.Total(best);
  for (size_t i = 0; i < middles; ++i) {
    const size_t middle = i * views / middles;
    std::vector<int> lags(views, 0);
    for (const auto& [v, from] : WaysFrom(middle, table, views)) {
      lags[v] = lags[from];
      for (int lag = -max_lag; lag <= max_lag; ++lag) {
        if (table.Of(from, v, lag - lags[from]) >
            table.Of(from, v, lags[v] - lags[from]) + 1e-9) {
          lags[v] = lag;
        }
      }
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (size_t v = 0; v < views; ++v) {
        if (v == middle) continue;
        const int lag = table.BestLagOf(v, lags);
        changed = changed || lag != lags[v];
        lags[v] = lag;
      }
    }
    if (table.Total(lags) > best_total + 1e-9) {
      best_total = table.Total(lags);
      best = lags;
    }
  }
  const int first = best.empty() ? 0 : best[0];
  for (int& lag : best) lag -= first;
  return best;
}

// Over the pairs of views whose marks differ.
PairAgreement AgreementWith(const CameraRig& cameras,
                            const std::vector<ViewPeople>& ideal,
                            const std::vector<int>& lags,
                            const std::vector<int>& frames,
                            const std::vector<int>& marks) {
  PairAgreement all;
  for (const auto& [a, b] : ComparedPairs(cameras.size())) {
    if (marks[a] == marks[b]) continue;
    std::vector<int> moved;
    for (const int k : frames) {
      const int at = k + lags[a];
      if (at >= 0 && at < static_cast<int>(ideal[a].frames.size())) {
        moved.push_back(at);
      }
    }
    all.Add(AgreementOf(cameras[a], ideal[a], cameras[b], ideal[b], moved,
                        lags[b] - lags[a]));
  }
  return all;
}

bool IsWorthIt(const AgreementGain& gain, double closer) {
  const double pairs = std::min(gain.before.possible, gain.after.possible);
  const double chance = kBestOfMany * kGainSpread / std::sqrt(pairs);
  return gain.after.mean_px() < closer * gain.before.mean_px() &&
         gain.gain() > std::max(kMinClockGain, chance);
}

// Lags of fewer than half of the views, each against all others as they are,
// the one that gains most first: what all views together hardly show.
std::vector<int> LagsOfFew(const CameraRig& cameras,
                           const std::vector<ViewPeople>& ideal,
                           const LagTable& table) {
  const size_t views = cameras.size();
  // Each pair of views before and after, from both sides.
  const std::vector<int> frames = FramesToLookAt(ideal, kFramesToJudge, 4);
  std::vector<int> lags(views, 0);
  for (size_t found = 0; 2 * (found + 1) < views; ++found) {
    size_t best_view = views;
    int best_lag = 0;
    double best_gain = 0.0;
    for (size_t v = 0; v < views; ++v) {
      std::vector<int> trial = lags;
      trial[v] = table.BestLagOf(v, lags);
      if (trial[v] == lags[v]) continue;
      std::vector<int> alone(views, 0);
      alone[v] = 1;
      const AgreementGain gain = {
          AgreementWith(cameras, ideal, lags, frames, alone),
          AgreementWith(cameras, ideal, trial, frames, alone)};
      if (gain.gain() <= best_gain || !IsWorthIt(gain, kOneCloser)) continue;
      best_view = v;
      best_lag = trial[v];
      best_gain = gain.gain();
    }
    if (best_view == views) break;
    lags[best_view] = best_lag;
  }
  return lags;
}

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
  // People hardly move in three frames of a fast camera, nor in a twentieth of
  // a second.
  int step = max_lag > 300 ? std::max(3, max_lag / 200) : 1;
  const int lags_tried = 2 * reach / step + 1;
  const std::vector<int> searched =
      FramesToLookAt(ideal, kFramesToCompare, 4 * lags_tried);
  if (searched.empty()) return search;
  step *= 1 + static_cast<int>(lags_tried * ComparisonsOfAll(ideal, searched) /
                               kMostComparisons);
  const LagTable table(cameras, ideal, searched, reach, step);
  const std::vector<int> frames = FramesToLookAt(ideal, kFramesToCompare, 4);
  const std::vector<int> none(views, 0);
  std::vector<int> every(views);
  std::iota(every.begin(), every.end(), 0);
  std::vector<int> lags = BestLags(table, views, reach);
  search.all = {AgreementWith(cameras, ideal, none, frames, every),
                AgreementWith(cameras, ideal, lags, frames, every)};
  if (!IsWorthIt(search.all, kCloser)) {
    lags = LagsOfFew(cameras, ideal, table);
    search.all.after = AgreementWith(cameras, ideal, lags, frames, every);
  }
  for (size_t v = 0; v < views; ++v) search.lag_frames[v] = lags[v] - lags[0];
  search.moved = {AgreementWith(cameras, ideal, none, frames, lags),
                  AgreementWith(cameras, ideal, lags, frames, lags)};
  return search;
}

DetectionSequence Realigned(const DetectionSequence& detections,
                            const std::vector<int>& lag_frames) {
  return FramesMoved(
      detections, [&](size_t view, int64_t k) { return k + lag_frames[view]; });
}

}  // namespace kinegraph
