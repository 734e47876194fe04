#include "solvers/rig/view_pairs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/random.h"

namespace kinegraph {
namespace {

// Only this many of each view's tracklets, the longest, are searched.
constexpr size_t kMostTracklets = 16;
constexpr int kLagsTried = 6;  // in addition to lag 0
// Because the motion of walking repeats with every stride, lags at which the
// motions are nearly as similar as at the best lag are tried too, up to twenty.
constexpr double kNearlyAlike = 0.75;
constexpr int kMostLagsTried = 20;
constexpr int kDraws = 160;  // random samples per lag
// Half as many further samples are larger by this factor, because in a narrow
// field of view a dozen noisy points determine the pose too poorly even if the
// matches are right.
constexpr int kLarge = 3;
// Size of a sample from one match, and from each of two.
constexpr int kOfOne = 12;
constexpr int kOfTwo = 8;
constexpr int kRefined = 3;  // number of best poses refined per lag
// Sampson distances from which joints gain nothing, in units of the person's
// size (about 1.8 m): 0.1 m during the search, half of that at the end.
constexpr double kWide = 0.06;
constexpr double kNarrow = 0.03;
constexpr double kScale = 0.012;  // of the robust loss
// Mean gain of unrelated joints, which lie near epipolar lines by chance.
constexpr double kByChance = 0.35;

// Two tracklets that may match at a lag, with their common joints.
struct Candidate {
  int a = 0;  // tracklets
  int b = 0;
  double seconds = 0.0;  // duration in which both are seen
  double likeness = 0.0;
  // The points alternate: some are fitted, the others held out.
  std::vector<PointPair> fitted;
  std::vector<PointPair> held;
};

std::vector<int> LongestOf(const std::vector<ViewTracklet>& tracklets, int view,
                           size_t most) {
  std::vector<int> of_view;
  for (size_t i = 0; i < tracklets.size(); ++i) {
    if (tracklets[i].view == view) of_view.push_back(static_cast<int>(i));
  }
  std::stable_sort(of_view.begin(), of_view.end(), [&](int x, int y) {
    return tracklets[x].detections.size() > tracklets[y].detections.size();
  });
  if (of_view.size() > most) of_view.resize(most);
  return of_view;
}

// Frames of `a` in which both tracklets are seen.
std::vector<int> CommonFrames(const ViewTracklet& a, const ViewTracklet& b,
                              int lag) {
  std::vector<int> frames;
  for (int k = std::max(a.first, b.first - lag);
       k < std::min(a.end(), b.end() - lag); ++k) {
    if (a.SeenAt(k) && b.SeenAt(k + lag)) frames.push_back(k);
  }
  return frames;
}

Candidate MakeCandidate(const std::vector<ViewTracklet>& tracklets, int a,
                        int b, int lag, double frame_rate_hz,
                        size_t most_frames) {
  const ViewTracklet& one = tracklets[a];
  const ViewTracklet& other = tracklets[b];
  Candidate candidate;
  candidate.a = a;
  candidate.b = b;
  const std::vector<int> frames = CommonFrames(one, other, lag);
  candidate.seconds = static_cast<double>(frames.size()) / frame_rate_hz;
  const double step = std::max(1.0, static_cast<double>(frames.size()) /
                                        static_cast<double>(most_frames));
  const double size = std::sqrt(one.size * other.size);
  int turn = 0;
  for (double at = 0.0; at < static_cast<double>(frames.size()); at += step) {
    const int k = frames[at];
    const NormalisedJoints& points_a = one.At(k);
    const NormalisedJoints& points_b = other.At(k + lag);
    ++turn;
    for (Eigen::Index j = 0; j < points_a.cols(); ++j) {
      if (!points_a.col(j).allFinite() || !points_b.col(j).allFinite()) {
        continue;
      }
      // Frames, and joints two by two, alternate between the lists.
      auto& list = (turn + j / 2) % 2 == 0 ? candidate.fitted : candidate.held;
      list.push_back({points_a.col(j), points_b.col(j), size});
    }
  }
  return candidate;
}

double GainOf(const std::vector<PointPair>& pairs, const RelativePose& pose,
              double width, size_t most) {
  if (pairs.empty()) return 0.0;
  const Eigen::Matrix3d essential = pose.Essential();
  const size_t step = std::max<size_t>(1, pairs.size() / most);
  double gain = 0.0;
  double count = 0.0;
  for (size_t i = 0; i < pairs.size(); i += step) {
    const double squared =
        SampsonSquared(essential, pose.magnification, pairs[i]);
    gain += std::max(0.0, 1.0 - squared / (width * width));
    count += 1.0;
  }
  return gain / count;
}

// A pose and the matches that it implies.
struct Explanation {
  RelativePose pose;
  int lag = 0;
  std::vector<size_t> matched;  // candidates
  std::vector<double> gains;    // by matched candidate
  double score = 0.0;           // [s]
};

// Whether two matches exclude each other: one tracklet may match several of the
// other view only if these do not overlap in time.
bool Exclude(const std::vector<ViewTracklet>& tracklets, const Candidate& one,
             const Candidate& other) {
  return (one.a == other.a && Overlap(tracklets[one.b], tracklets[other.b])) ||
         (one.b == other.b && Overlap(tracklets[one.a], tracklets[other.a]));
}

// Matches greedily; a tracklet has at most one partner at any time.
Explanation Explain(const std::vector<ViewTracklet>& tracklets,
                    const std::vector<Candidate>& candidates,
                    const RelativePose& pose, int lag, double width,
                    size_t most) {
  Explanation result;
  result.pose = pose;
  result.lag = lag;
  std::vector<std::pair<double, size_t>> order;
  std::vector<double> gains(candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    gains[i] = GainOf(candidates[i].held, pose, width, most);
    const double worth = (gains[i] - kByChance) * candidates[i].seconds;
    if (worth > 0.0) order.emplace_back(-worth, i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [worth, i] : order) {
    const bool taken = std::any_of(
        result.matched.begin(), result.matched.end(), [&, i = i](size_t m) {
          return Exclude(tracklets, candidates[i], candidates[m]);
        });
    if (taken) continue;
    result.matched.push_back(i);
    result.gains.push_back(gains[i]);
    result.score -= worth;
  }
  return result;
}

class PairSearch {
 public:
  PairSearch(const std::vector<ViewTracklet>& tracklets,
             const MotionSignals& signals, int a, int b,
             const PairSearchOptions& options)
      : tracklets_(tracklets),
        signals_(signals),
        options_(options),
        of_a_(LongestOf(tracklets, a, kMostTracklets)),
        of_b_(LongestOf(tracklets, b, kMostTracklets)),
        random_(static_cast<uint64_t>(1 + a * 1000 + b +
                                      options.attempt * 1000000)) {}

  PairFit Run(int a, int b) {
    PairFit pair;
    pair.a = a;
    pair.b = b;
    std::vector<Explanation> found;
    const LagsToTry lags = MakeLagsToTry();
    TryLags(lags.likely, &found);
    // A person who walks in circles at a constant speed looks, some strides
    // later, like a person seen from another direction. Many wrong lags then
    // explain one person equally well, and at the right lag, which explains all
    // people, the motions may be less similar than at the wrong ones. If a
    // rival explains nearly as much as the best explanation, the other local
    // maxima are searched too.
    pair.evidence = BestOf(found).score;
    pair.rival = RivalTo(BestOf(found), found);
    if (pair.is_undecided()) TryLags(lags.others, &found);
    if (found.empty()) return pair;
    Explanation best = WithExactLag(BestOf(found));
    Explanation exchanged = Exchanged(best);
    if (exchanged.score > best.score) std::swap(best, exchanged);
    pair.rival_pose = exchanged.score;
    pair.rival = std::max(RivalTo(best, found), pair.rival_pose);
    pair.lag = best.lag;
    pair.pose = best.pose;
    pair.evidence = best.score;
    // Match the short tracklets too.
    of_a_ = LongestOf(tracklets_, a, tracklets_.size());
    of_b_ = LongestOf(tracklets_, b, tracklets_.size());
    const auto candidates = CandidatesAt(best.lag, kFewFrames);
    best = Explain(tracklets_, candidates, best.pose, best.lag, kNarrow,
                   kAllPairs);
    for (size_t m = 0; m < best.matched.size(); ++m) {
      const Candidate& candidate = candidates[best.matched[m]];
      pair.matches.push_back({candidate.a, candidate.b, best.gains[m]});
    }
    return pair;
  }

 private:
  static constexpr size_t kExactFrames = 100;
  static constexpr size_t kFewFrames = 24;
  static constexpr size_t kFewPairs = 48;
  static constexpr size_t kAllPairs = 100000;

  int Effort() const { return 1 + options_.attempt; }

  struct LagsToTry {
    std::vector<int> likely;
    std::vector<int> others;  // local maxima of lower similarity
  };

  // Lag 0, then the local maxima of the similarity of motions, the best first.
  LagsToTry MakeLagsToTry() const {
    const int step = signals_.step();
    const auto reach = static_cast<int>(options_.longest_lag_s *
                                        options_.frame_rate_hz / step);
    std::vector<double> likeness;
    for (int lag = -reach; lag <= reach; ++lag) {
      double sum = 0.0;
      for (const int x : of_a_) {
        for (const int y : of_b_) {
          const auto one = signals_.Compare(static_cast<size_t>(x),
                                            static_cast<size_t>(y), lag);
          if (one.correlation > 0.0) {
            sum += one.correlation * one.correlation * one.samples;
          }
        }
      }
      likeness.push_back(sum);
    }
    std::vector<std::pair<double, int>> peaks;
    for (size_t i = 0; i < likeness.size(); ++i) {
      const double before = i > 0 ? likeness[i - 1] : 0.0;
      const double after = i + 1 < likeness.size() ? likeness[i + 1] : 0.0;
      if (likeness[i] > before && likeness[i] >= after) {
        peaks.emplace_back(-likeness[i], (static_cast<int>(i) - reach) * step);
      }
    }
    std::sort(peaks.begin(), peaks.end());
    LagsToTry lags;
    lags.likely = {0};
    for (const auto& peak : peaks) {
      const int count = static_cast<int>(lags.likely.size());
      const bool is_alike = peak.first <= kNearlyAlike * peaks.front().first &&
                            count <= kMostLagsTried;
      const bool is_likely = count <= kLagsTried * Effort() || is_alike;
      if (peak.second == 0) continue;
      (is_likely ? lags.likely : lags.others).push_back(peak.second);
    }
    return lags;
  }

  void TryLags(const std::vector<int>& lags, std::vector<Explanation>* found) {
    for (const int lag : lags) {
      for (Explanation& one : TryLag(lag)) found->push_back(std::move(one));
    }
  }

  static Explanation BestOf(const std::vector<Explanation>& found) {
    const auto best =
        std::max_element(found.begin(), found.end(),
                         [](const Explanation& x, const Explanation& y) {
                           return x.score < y.score;
                         });
    return best == found.end() ? Explanation() : *best;
  }

  // The score of the best explanation that differs from `best`.
  double RivalTo(const Explanation& best,
                 const std::vector<Explanation>& found) const {
    double rival = 0.0;
    for (const Explanation& other : found) {
      if (IsOther(best, other)) rival = std::max(rival, other.score);
    }
    return rival;
  }

  std::vector<Candidate> CandidatesAt(int lag, size_t most_frames) const {
    std::vector<Candidate> candidates;
    for (const int x : of_a_) {
      for (const int y : of_b_) {
        Candidate one = MakeCandidate(tracklets_, x, y, lag,
                                      options_.frame_rate_hz, most_frames);
        constexpr size_t kLeastPairs = 24;
        if (one.seconds < 0.5 || one.fitted.size() < kLeastPairs) continue;
        const double like =
            signals_
                .Compare(static_cast<size_t>(x), static_cast<size_t>(y),
                         static_cast<int>(std::lround(static_cast<double>(lag) /
                                                      signals_.step())))
                .correlation;
        one.likeness = std::pow(std::max(0.05, like), 2) * one.seconds;
        candidates.push_back(std::move(one));
      }
    }
    return candidates;
  }

  size_t Draw(const std::vector<double>& sums) {
    const double at = random_.Uniform(0.0, sums.back());
    return static_cast<size_t>(std::upper_bound(sums.begin(), sums.end(), at) -
                               sums.begin());
  }

  double DrawMagnification() {
    if (options_.focal_sigma <= 0.0) return 1.0;
    return std::exp(options_.focal_sigma * random_.Uniform(-1.7, 1.7));
  }

  // Adds `count` random points of a match.
  void Add(const Candidate& candidate, int count,
           std::vector<PointPair>* sample) {
    for (int i = 0; i < count; ++i) {
      sample->push_back(candidate.fitted[random_.Index(
          static_cast<int64_t>(candidate.fitted.size()))]);
    }
  }

  // kOfOne * `times` points of one match, or kOfTwo * `times` points of each of
  // two matches.
  std::vector<PointPair> Sample(const std::vector<Candidate>& candidates,
                                const std::vector<double>& sums, int times) {
    const int of_one = kOfOne * times;
    const int of_two = kOfTwo * times;
    std::vector<PointPair> sample;
    const size_t first = std::min(Draw(sums), candidates.size() - 1);
    const bool two = random_.Chance(0.5);
    Add(candidates[first], two ? of_two : of_one, &sample);
    if (!two) return sample;
    const size_t second = std::min(Draw(sums), candidates.size() - 1);
    // A tracklet in both matches needs the same partner in both.
    const bool fits = (candidates[first].a == candidates[second].a) ==
                      (candidates[first].b == candidates[second].b);
    Add(candidates[fits ? second : first], of_two, &sample);
    return sample;
  }

  // Alternates between matching and refining the pose.
  Explanation Refine(const std::vector<Candidate>& candidates,
                     Explanation found, int rounds) const {
    for (int round = 0; round < rounds; ++round) {
      std::vector<PointPair> pairs;
      for (const size_t m : found.matched) {
        const auto& fitted = candidates[m].fitted;
        pairs.insert(pairs.end(), fitted.begin(), fitted.end());
      }
      if (pairs.size() < 16) break;
      const RelativePose pose = WithMostInFront(
          pairs, RefinePose(pairs, found.pose, kScale, options_.focal_sigma));
      found =
          Explain(tracklets_, candidates, pose, found.lag, kNarrow, kAllPairs);
    }
    return found;
  }

  std::vector<Explanation> TryLag(int lag) {
    const std::vector<Candidate> candidates = CandidatesAt(lag, kFewFrames);
    if (candidates.empty()) return {};
    std::vector<double> sums(candidates.size());
    for (size_t i = 0; i < candidates.size(); ++i) {
      sums[i] = candidates[i].likeness + (i > 0 ? sums[i - 1] : 0.0);
    }
    std::vector<Explanation> found;
    const int draws = kDraws * Effort();
    for (int draw = 0; draw < draws + draws / 2; ++draw) {
      const int times = draw < draws ? 1 : kLarge;
      const auto pose =
          EightPoint(Sample(candidates, sums, times), DrawMagnification());
      if (!pose.has_value()) continue;
      found.push_back(
          Explain(tracklets_, candidates, *pose, lag, kWide, kFewPairs));
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Explanation& x, const Explanation& y) {
                       return x.score > y.score;
                     });
    std::vector<Explanation> best;
    for (const Explanation& one : found) {
      if (best.size() >= kRefined || one.matched.empty()) break;
      best.push_back(Refine(candidates, one, 3));
    }
    return best;
  }

  // Tries every lag within one sample of the coarse lag, with more points.
  Explanation WithExactLag(const Explanation& coarse) const {
    Explanation best;
    best.score = -1.0;
    const int reach = options_.longest_lag_s > 0.0 ? signals_.step() : 0;
    for (int lag = coarse.lag - reach; lag <= coarse.lag + reach; ++lag) {
      const auto candidates = CandidatesAt(lag, kExactFrames);
      Explanation one = Refine(
          candidates,
          Explain(tracklets_, candidates, coarse.pose, lag, kWide, kAllPairs),
          2);
      if (one.score > best.score) best = std::move(one);
    }
    return best;
  }

  // The best explanation with another pose in which tracklet a of the longest
  // match of `best` (from WithExactLag) has another partner: people who move
  // alike, such as two who dance face to face, can be exchanged. Of the two
  // explanations TryLag usually finds only one.
  Explanation Exchanged(const Explanation& best) {
    constexpr int kExchangeDraws = 240;
    constexpr double kLeastShare = 0.2;  // of the time of the longest match
    const auto candidates = CandidatesAt(best.lag, kExactFrames);
    Explanation rival;
    if (best.matched.empty()) return rival;
    const Candidate& longest = candidates[*std::max_element(
        best.matched.begin(), best.matched.end(), [&](size_t x, size_t y) {
          return candidates[x].seconds < candidates[y].seconds;
        })];
    for (const Candidate& first : candidates) {
      if (first.a != longest.a || first.b == longest.b ||
          first.seconds < kLeastShare * longest.seconds ||
          !Exclude(tracklets_, longest, first)) {
        continue;
      }
      std::vector<const Candidate*> others;
      for (const Candidate& other : candidates) {
        if (!Exclude(tracklets_, first, other)) others.push_back(&other);
      }
      Explanation found;
      for (int draw = 0; draw < kExchangeDraws; ++draw) {
        std::vector<PointPair> sample;
        const bool is_one = others.empty() || draw % 2 == 0;
        Add(first, kLarge * (is_one ? kOfOne : kOfTwo), &sample);
        if (!is_one) {
          Add(*others[random_.Index(static_cast<int64_t>(others.size()))],
              kLarge * kOfTwo, &sample);
        }
        const auto pose = EightPoint(sample, DrawMagnification());
        if (!pose.has_value()) continue;
        Explanation one =
            Explain(tracklets_, candidates, *pose, best.lag, kWide, kFewPairs);
        if (one.score > found.score) found = std::move(one);
      }
      if (found.matched.empty()) continue;
      found = Refine(candidates, found, 3);
      if (found.score > rival.score && IsOther(best, found)) {
        rival = std::move(found);
      }
    }
    return rival;
  }

  bool IsOther(const Explanation& best, const Explanation& other) const {
    constexpr double kOtherS = 0.25;
    constexpr double kOtherCosine = 0.94;  // of 20 degrees
    const double trace = (best.pose.R.transpose() * other.pose.R).trace();
    return std::abs(best.lag - other.lag) > kOtherS * options_.frame_rate_hz ||
           0.5 * (trace - 1.0) < kOtherCosine;
  }

  const std::vector<ViewTracklet>& tracklets_;
  const MotionSignals& signals_;
  const PairSearchOptions& options_;
  std::vector<int> of_a_;
  std::vector<int> of_b_;
  Random random_;
};

}  // namespace

PairFit SearchViewPair(const std::vector<ViewTracklet>& tracklets,
                       const MotionSignals& signals, int a, int b,
                       const PairSearchOptions& options) {
  return PairSearch(tracklets, signals, a, b, options).Run(a, b);
}

void RefitPose(const std::vector<ViewTracklet>& tracklets, PairFit* pair) {
  constexpr size_t kFrames = 60;
  pair->pose.magnification = 1.0;
  std::vector<PointPair> all;
  for (const TrackletMatch& match : pair->matches) {
    const Candidate one =
        MakeCandidate(tracklets, match.a, match.b, pair->lag, 1.0, kFrames);
    all.insert(all.end(), one.fitted.begin(), one.fitted.end());
    all.insert(all.end(), one.held.begin(), one.held.end());
  }
  constexpr size_t kLeast = 16;
  if (all.size() < kLeast) return;
  // Limits the number of points, to which the cost of a trial is proportional.
  constexpr size_t kMost = 400;
  std::vector<PointPair> few;
  const size_t step = std::max<size_t>(1, all.size() / kMost);
  for (size_t i = 0; i < all.size(); i += step) few.push_back(all[i]);
  constexpr int kTries = 60;
  constexpr int kOfEach = 12;
  Random random(1);
  using Tried = std::pair<double, RelativePose>;  // with its cost
  const auto tried = [&](const RelativePose& pose) {
    return Tried(RobustCost(few, pose, kScale), pose);
  };
  const auto less = [](const Tried& x, const Tried& y) {
    return x.first < y.first;
  };
  std::vector<Tried> found = {tried(pair->pose)};
  for (int i = 0; i < kTries; ++i) {
    std::vector<PointPair> sample;
    for (int k = 0; k < kOfEach; ++k) {
      sample.push_back(few[random.Index(static_cast<int64_t>(few.size()))]);
    }
    if (const auto one = EightPoint(sample, 1.0)) found.push_back(tried(*one));
  }
  std::stable_sort(found.begin(), found.end(), less);
  found.resize(std::min<size_t>(found.size(), kRefined));
  for (Tried& one : found)
    one = tried(RefinePose(few, one.second, kScale, 0.0));
  const RelativePose& best =
      std::min_element(found.begin(), found.end(), less)->second;
  pair->pose = WithMostInFront(few, RefinePose(all, best, kScale, 0.0));
}

}  // namespace kinegraph
