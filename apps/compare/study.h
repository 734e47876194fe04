// A comparison over several recordings: values chosen on some are scored on
// others.
//
// Every recording is left out once. The strategy and its values that do best on
// the others are scored on it, so no figure comes from what was chosen on the
// same recording. "Best" is the least mean over recordings of their mean
// held-out error: each recording counts the same, however long it is.
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

// Held-out errors of a recording at several points: the sum of min(error, 30
// px) and the number of joints; no weight where the recording refuses the
// point.
using PointErrors = std::vector<RatioUnit>;

// The point with the least mean over recordings of the recording's mean error;
// the recording `left_out` (-1: none) has no say. A point that one of them
// refuses is not chosen; nullopt when there is no other.
std::optional<size_t> BestPoint(const std::vector<PointErrors>& recordings,
                                int left_out);

// What a strategy scored on one recording, with values chosen on the others.
struct StudyScore {
  std::string refused;  // empty: it ran
  StrategyValues values;
  double mean_px = 0.0;
  double standard_error_px = 0.0;  // block bootstrap over frames
  // To the baseline, paired.
  double difference_px = 0.0;
  double difference_error_px = 0.0;
  Verdict verdict = Verdict::kNone;
};

struct StudyRecording {
  std::string name;
  std::vector<StudyScore> scores;  // one a strategy
  // The strategy that does best on the other recordings; nullopt: none could be
  // run.
  std::optional<size_t> chosen;
};

struct Study {
  std::vector<Strategy> strategies;
  size_t baseline_idx = 0;
  bool tuned = false;
  std::vector<StudyRecording> recordings;
  // Chosen on all recordings, for the next one; nullopt: none could be run.
  std::optional<size_t> best;
  StrategyValues best_values;
  // Of the first recording, as recommended.toml starts from.
  RunOptions options;
  double rate_hz = 0.0;
};

// On how many recordings the choice made without them is better than the
// baseline, not told apart from it (or the baseline itself), and worse.
struct StudyVerdict {
  int recordings = 0;  // with something to choose and to score
  int better = 0;
  int same = 0;
  int worse = 0;
  int like_all = 0;  // whose choice is the strategy that all recordings choose

  void Count(Verdict one) {
    ++(one == Verdict::kLess ? better : one == Verdict::kMore ? worse : same);
  }
};
StudyVerdict HoldsFor(const Study& study);

struct StudyRequest {
  std::vector<RecordingInput> recordings;  // two or more
  std::vector<Strategy> strategies;
  size_t baseline_idx = 0;
  bool tune = false;
  int threads = 1;
};
// Reads one take at a time. Throws InputError naming the recording.
Study RunStudy(const StudyRequest& request);

// study.md, study.csv and study.json.
std::string StudyMarkdown(const Study& study);
std::string StudyCsv(const Study& study);
std::string StudyJson(const Study& study);
// recommended.toml: the configuration with the best strategy; its head says for
// how many recordings it holds. Empty without a best one.
std::string StudyToml(const Study& study);
// For a terminal.
std::string StudyDigest(const Study& study, const std::string& folder);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_STUDY_H_
