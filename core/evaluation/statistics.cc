#include "core/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"

namespace kinegraph {
namespace {

// Position of quantile `q` among `count` ordered values: `between` of the way
// from rank `below` to the next.
struct Rank {
  Rank(int64_t count, double q) {
    const double position = q * static_cast<double>(count - 1);
    below = static_cast<int64_t>(std::floor(position));
    below = std::clamp<int64_t>(below, 0, count - 1);
    between = position - static_cast<double>(below);
  }
  int64_t below;
  double between;
};

double Interpolate(double low, double high, double between) {
  return low + between * (high - low);
}

int64_t BlockLength(int64_t series_length, int64_t wanted) {
  if (series_length > wanted) return wanted;
  return std::max<int64_t>(1, (series_length + 1) / 2);
}

// Draws as many units as the series has, in blocks on a ring.
void DrawSeries(int64_t length, int64_t block_length, Random& random,
                int64_t* counts) {
  const int64_t block = BlockLength(length, block_length);
  for (int64_t drawn = 0; drawn < length;) {
    const int64_t start = random.Index(length);
    const int64_t end = std::min(length, drawn + block);
    for (int64_t i = start; drawn < end; ++i, ++drawn) ++counts[i % length];
  }
}

std::vector<int64_t> Lengths(const std::vector<RatioSeries>& series) {
  std::vector<int64_t> lengths;
  lengths.reserve(series.size());
  for (const RatioSeries& units : series) {
    lengths.push_back(static_cast<int64_t>(units.size()));
  }
  return lengths;
}

// Adds the units of a series; `next` is the index of its first unit in the
// counts.
void AddUnits(const RatioSeries& units, const DrawCounts* counts, size_t* next,
              RatioUnit* sum) {
  for (const RatioUnit& unit : units) {
    const double times =
        counts == nullptr ? 1.0 : static_cast<double>((*counts)[(*next)++]);
    sum->sum += times * unit.sum;
    sum->weight += times * unit.weight;
  }
}

}  // namespace

double Share::fraction() const {
  if (total == 0) return kNan;
  return static_cast<double>(count) / static_cast<double>(total);
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return kNan;
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(values.size());
}

double StandardDeviation(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  if (values.empty()) return kNan;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNan;
  const Rank rank(static_cast<int64_t>(values.size()), q);
  const auto at = values.begin() + rank.below;
  std::nth_element(values.begin(), at, values.end());
  if (rank.between == 0.0) return *at;
  return Interpolate(*at, *std::min_element(at + 1, values.end()),
                     rank.between);
}

double QuantileOfRepeated(const std::vector<double>& ascending,
                          const std::vector<int64_t>& upto, double q) {
  if (upto.empty() || upto.back() == 0) return kNan;
  const Rank rank(upto.back(), q);
  const auto value = [&](int64_t place) {
    const auto at = std::upper_bound(upto.begin(), upto.end(), place);
    return ascending[at - upto.begin()];
  };
  if (rank.between == 0.0) return value(rank.below);
  return Interpolate(value(rank.below), value(rank.below + 1), rank.between);
}

Interval BlockBootstrap(
    const std::vector<int64_t>& series_lengths,
    const std::function<double(const DrawCounts&)>& statistic,
    const BootstrapOptions& options) {
  return BlockBootstrapAll(
      series_lengths, 1,
      [&statistic](const DrawCounts& counts) {
        return std::vector<double>{statistic(counts)};
      },
      options)[0];
}

std::vector<Interval> BlockBootstrapAll(
    const std::vector<int64_t>& series_lengths, size_t score_count,
    const std::function<std::vector<double>(const DrawCounts&)>& statistic,
    const BootstrapOptions& options) {
  std::vector<Interval> intervals(score_count);
  Random random(static_cast<uint64_t>(options.seed));
  DrawCounts counts(static_cast<size_t>(std::accumulate(
      series_lengths.begin(), series_lengths.end(), int64_t{0})));
  if (counts.empty()) return intervals;
  std::vector<std::vector<double>> values(score_count);
  for (int64_t resample = 0; resample < options.resamples; ++resample) {
    std::fill(counts.begin(), counts.end(), 0);
    int64_t* series_counts = counts.data();
    for (const int64_t length : series_lengths) {
      DrawSeries(length, options.block_length, random, series_counts);
      series_counts += length;
    }
    const std::vector<double> scores = statistic(counts);
    for (size_t i = 0; i < score_count; ++i) {
      if (!std::isnan(scores[i])) values[i].push_back(scores[i]);
    }
  }
  const double tail = 0.5 * (1.0 - options.confidence);
  for (size_t i = 0; i < score_count; ++i) {
    intervals[i] = {Quantile(values[i], tail), Quantile(values[i], 1.0 - tail),
                    StandardDeviation(values[i])};
  }
  return intervals;
}

double MeanOfRatios(const std::vector<RatioSeries>& series,
                    const DrawCounts* counts) {
  double total = 0.0;
  int with_weight = 0;
  size_t next = 0;
  for (const RatioSeries& units : series) {
    RatioUnit pooled;
    AddUnits(units, counts, &next, &pooled);
    if (pooled.weight <= 0.0) continue;
    total += pooled.sum / pooled.weight;
    ++with_weight;
  }
  return with_weight == 0 ? kNan : total / with_weight;
}

double PooledRatio(const std::vector<RatioSeries>& series,
                   const DrawCounts* counts) {
  RatioUnit pooled;
  size_t next = 0;
  for (const RatioSeries& units : series) {
    AddUnits(units, counts, &next, &pooled);
  }
  return pooled.sum / pooled.weight;  // NaN for 0 / 0
}

Interval RatioInterval(RatioScore score, const std::vector<RatioSeries>& series,
                       const BootstrapOptions& options) {
  return BlockBootstrap(
      Lengths(series),
      [&](const DrawCounts& counts) { return score(series, &counts); },
      options);
}

Interval PairedInterval(RatioScore score, const std::vector<RatioSeries>& a,
                        const std::vector<RatioSeries>& b,
                        const BootstrapOptions& options) {
  if (Lengths(a) != Lengths(b)) {
    throw OptionError("paired difference",
                      "the two results were not scored on the same frames");
  }
  return BlockBootstrap(
      Lengths(a),
      [&](const DrawCounts& counts) {
        return score(a, &counts) - score(b, &counts);
      },
      options);
}

}  // namespace kinegraph
