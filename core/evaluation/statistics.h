// Statistics shared by several measures, and intervals of scores.
#ifndef KINEGRAPH_CORE_EVALUATION_STATISTICS_H_
#define KINEGRAPH_CORE_EVALUATION_STATISTICS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/constants.h"

namespace kinegraph {

// A part of a total.
struct Share {
  int64_t count = 0;
  int64_t total = 0;

  void Add(bool counted) {
    count += counted ? 1 : 0;
    ++total;
  }
  Share& operator+=(const Share& other) {
    count += other.count;
    total += other.total;
    return *this;
  }
  // NaN if the total is zero.
  double fraction() const;
  double percent() const { return 100.0 * fraction(); }
};

// NaN for no values.
double Mean(const std::vector<double>& values);
// Square root of the mean squared distance from the mean (divided by n, not
// n - 1); NaN for no values.
double StandardDeviation(const std::vector<double>& values);
// Quantile `q` in 0..1 with linear interpolation between order statistics, so
// that 0 gives the least and 1 the greatest value; NaN for no values.
double Quantile(std::vector<double> values, double q);
// Quantile of values of which each may count several times: `upto`[i] is the
// total number of the values 0 .. i in `ascending`. Equal to Quantile of the
// repeated values, without a copy.
double QuantileOfRepeated(const std::vector<double>& ascending,
                          const std::vector<int64_t>& upto, double q);

// ---- Confidence intervals of scores: a seeded block bootstrap
//
// Errors of neighbouring frames are correlated, so whole blocks of frames are
// drawn (moving blocks: Kuensch 1989, "The jackknife and the bootstrap for
// general stationary observations"), within each series (an actor, a
// recording). A block that extends over the end continues at the beginning
// (Politis and Romano 1992), so that every frame is drawn with the same
// probability, also in a short series.

struct BootstrapOptions {
  // In units of a series, usually frames: one second at 25 Hz.
  int64_t block_length = 25;
  int64_t resamples = 2000;
  double confidence = 0.95;
  int64_t seed = 1;
};

// All NaN if the score is undefined.
struct Interval {
  double low = kNan;
  double high = kNan;
  double standard_error = kNan;
};

// Number of times each unit (a frame, a person-frame) was drawn; the units of
// all series one after the other.
using DrawCounts = std::vector<int64_t>;

// The percentile interval of `statistic`. Resamples in which the statistic is
// undefined (NaN) are left out. For a paired difference of two methods let the
// statistic compute both from the same counts.
//
// A series no longer than a block would always be drawn as a whole and have an
// interval of zero width; its blocks are half its length.
Interval BlockBootstrap(
    const std::vector<int64_t>& series_lengths,
    const std::function<double(const DrawCounts&)>& statistic,
    const BootstrapOptions& options = {});

// BlockBootstrap for several scores that are computed together; each call of
// the statistic returns one value per score.
std::vector<Interval> BlockBootstrapAll(
    const std::vector<int64_t>& series_lengths, size_t score_count,
    const std::function<std::vector<double>(const DrawCounts&)>& statistic,
    const BootstrapOptions& options = {});

// Additive units: the score is sum / weight over the drawn units, as for a
// share or a mean.
struct RatioUnit {
  double sum = 0.0;
  double weight = 0.0;

  void Add(double value) {
    sum += value;
    weight += 1.0;
  }
};
using RatioSeries = std::vector<RatioUnit>;

// The score of units weighted by `counts`; without counts each counts once.
using RatioScore = double (*)(const std::vector<RatioSeries>& series,
                              const DrawCounts* counts);

// Mean of the series' ratios; series without weight are left out. NaN if all
// are.
double MeanOfRatios(const std::vector<RatioSeries>& series,
                    const DrawCounts* counts = nullptr);
// All units of all series together: the total of the sums divided by the total
// of the weights, as for a mean over joints; NaN without weight.
double PooledRatio(const std::vector<RatioSeries>& series,
                   const DrawCounts* counts = nullptr);

Interval RatioInterval(RatioScore score, const std::vector<RatioSeries>& series,
                       const BootstrapOptions& options = {});
// For score(a) - score(b), with the same units drawn for both. Throws
// OptionError when a and b differ in shape.
Interval PairedInterval(RatioScore score, const std::vector<RatioSeries>& a,
                        const std::vector<RatioSeries>& b,
                        const BootstrapOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_STATISTICS_H_
