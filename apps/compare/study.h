// Compares strategies over several recordings by leave-one-out: values chosen
// on all but one recording are scored on that one.
//
// The strategy and the values that perform best on the others are scored on the
// recording left out, so no figure is based on a choice made on the same
// recording. "Best" is the least mean over recordings of their mean
// held-out error: each recording has the same weight, whatever its length.
#ifndef KINEGRAPH_APPS_COMPARE_STUDY_H_
#define KINEGRAPH_APPS_COMPARE_STUDY_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/compare/comparison.h"
#include "apps/compare/scores.h"
#include "apps/compare/strategies.h"

namespace kinegraph {

// Held-out errors of a recording at several points, each a strategy with its
// values: the sum of min(error, 30 px) and the number of joints; weight 0 if
// the strategy cannot be run on the recording.
using PointErrors = std::vector<RatioUnit>;

// The point with the least mean over recordings of the recording's mean error,
// ignoring the recording `left_out` (-1: none). Excludes points that cannot be
// run on all of these recordings; nullopt if no point remains.
std::optional<size_t> BestPoint(const std::vector<PointErrors>& recordings,
                                int left_out);

// Scores of a strategy on one recording, with values chosen on the others.
// Without tuning, or if no values could be run on all others, the values are
// those of the configuration.
struct StudyScore {
  std::string refused;  // empty: it ran
  StrategyValues values;
  double mean_px = 0.0;
  double standard_error_px = 0.0;  // block bootstrap over frames
  // Mean error minus that of the baseline, and the standard error of this
  // paired difference.
  double difference_px = 0.0;
  double difference_error_px = 0.0;
  Verdict verdict = Verdict::kNone;
};

struct StudyRecording {
  std::string name;
  std::vector<StudyScore> scores;  // one per strategy
  // The strategy that performs best on the other recordings; nullopt: none
  // could be run on all of them.
  std::optional<size_t> chosen;
};

struct Study {
  std::vector<Strategy> strategies;
  size_t baseline_idx = 0;
  bool tuned = false;
  std::vector<StudyRecording> recordings;
  // Chosen on all recordings, for future ones; nullopt: none could be run on
  // all of them.
  std::optional<size_t> best;
  StrategyValues best_values;
  // Options common to all recordings, on which recommended.toml is based.
  RunOptions options;
  double rate_hz = 0.0;
};

// Numbers of recordings on which the strategy chosen on the others is better
// than the baseline, not significantly different (or the baseline itself), and
// worse.
struct StudyVerdict {
  int recordings = 0;  // on which a choice was made and scored
  int better = 0;
  int same = 0;
  int worse = 0;
  int like_all = 0;  // on which the choice equals Study::best

  void Count(Verdict one) {
    ++(one == Verdict::kLess ? better : one == Verdict::kMore ? worse : same);
  }
};
StudyVerdict HoldsFor(const Study& study);

struct StudyRequest {
  std::vector<RecordingInput> recordings;  // at least two
  std::vector<Strategy> strategies;
  size_t baseline_idx = 0;
  bool tune = false;
  int threads = 1;
};
// Reads one recording at a time. Throws InputError naming the recording.
Study RunStudy(const StudyRequest& request);

// study.md, study.csv and study.json.
std::string StudyMarkdown(const Study& study);
std::string StudyCsv(const Study& study);
std::string StudyJson(const Study& study);
// recommended.toml: the configuration with the best strategy; its header states
// on how many recordings the strategy chosen on the others beats the baseline.
// Empty if no strategy could be run on every recording.
std::string StudyToml(const Study& study);
// The summary printed on a terminal.
std::string StudyDigest(const Study& study, const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_STUDY_H_
