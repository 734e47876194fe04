#include "apps/compare/tuning.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "apps/common/app.h"
#include "core/base/constants.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/io/configuration/config.h"
#include "core/io/files/atomic_file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

const Strategy& TunedAs(const Strategy& strategy) {
  if (strategy.tuned_as.empty()) return strategy;
  const auto& all = AllStrategies();
  const auto at = std::find_if(
      all.begin(), all.end(),
      [&](const Strategy& other) { return other.name == strategy.tuned_as; });
  CHECK(at != all.end()) << strategy.tuned_as;
  CHECK_EQ(at->parameters.size(), strategy.parameters.size());
  return *at;
}

// Whose grids have to be walked.
std::vector<Strategy> TunedThemselves(const std::vector<Strategy>& strategies) {
  std::vector<Strategy> tuned;
  for (const Strategy& strategy : strategies) {
    const Strategy& one = TunedAs(strategy);
    const bool known = std::any_of(
        tuned.begin(), tuned.end(),
        [&one](const Strategy& other) { return other.name == one.name; });
    if (!known) tuned.push_back(one);
  }
  return tuned;
}

// One combination without one camera, on the recording of `fold`. A fold is
// scored on its own recording; what is chosen for it is judged in the other
// fold's frames, on the same recording.
struct Piece {
  size_t point = 0;
  size_t fold = 0;  // whose recording
  size_t view = 0;
};

bool SharedRecording(const Comparison& comparison) {
  return comparison.folds[0].recording == comparison.folds[1].recording;
}

std::vector<Piece> PiecesOf(const Comparison& comparison, size_t points) {
  std::vector<Piece> pieces;
  const size_t recordings = SharedRecording(comparison) ? 1 : 2;
  for (size_t point = 0; point < points; ++point) {
    for (size_t fold = 0; fold < recordings; ++fold) {
      for (size_t view = 0; view < comparison.views().size(); ++view) {
        pieces.push_back({point, fold, view});
      }
    }
  }
  return pieces;
}

// Sum and number of truncated errors.
RatioUnit Pool(const HeldOutScores& scores) {
  RatioUnit pooled;
  for (const RatioUnit& unit : TruncatedErrors(scores, AllJoints())) {
    pooled.sum += unit.sum;
    pooled.weight += unit.weight;
  }
  return pooled;
}

void Add(const RatioUnit& unit, RatioUnit* sum) {
  sum->sum += unit.sum;
  sum->weight += unit.weight;
}

double Ratio(const RatioUnit& unit) {
  return unit.weight > 0.0 ? unit.sum / unit.weight : kNan;
}

// The first of the least; 0 when all were refused.
size_t Least(const std::vector<RatioUnit>& errors) {
  size_t best = 0;
  for (size_t i = 1; i < errors.size(); ++i) {
    const double error = Ratio(errors[i]);
    if (std::isnan(Ratio(errors[best])) || error < Ratio(errors[best])) {
      best = i;
    }
  }
  return best;
}

// What was computed of one piece.
struct PieceResult {
  std::array<RatioUnit, 2> errors;  // in the frames of each fold
  double cpu_s = 0.0;
  bool refused =
      false;  // the strategy cannot do this recording with these values
};

PieceResult ComputePiece(const Comparison& comparison, const Strategy& strategy,
                         const StrategyValues& values, const Piece& piece) {
  PieceResult result;
  const int64_t start_ns = ThreadCpuNs();
  try {
    const PreparedRecording& recording =
        *comparison.folds[piece.fold].recording;
    const TrackSequence tracks =
        RunWithout(comparison, strategy, values, recording, piece.view);
    for (size_t scored = 0; scored < 2; ++scored) {
      HeldOutScores scores;
      ScoreWithout(comparison,
                   {comparison.folds[scored].frames,
                    comparison.folds[piece.fold].recording},
                   piece.view, tracks, &scores);
      result.errors[scored] = Pool(scores);
    }
  } catch (const InputError&) {
    result.refused = true;
  } catch (const OptionError&) {
    result.refused = true;
  }
  result.cpu_s = 1e-9 * static_cast<double>(ThreadCpuNs() - start_ns);
  return result;
}

// Errors of every point of a grid, over all views: [take of][frames of][point].
using GridErrors = std::array<std::array<std::vector<RatioUnit>, 2>, 2>;

// A point that was refused anywhere has no error.
GridErrors PoolPieces(const Comparison& comparison,
                      const std::vector<Piece>& pieces,
                      const std::vector<PieceResult>& results, size_t points) {
  GridErrors errors;
  for (auto& of_recording : errors) {
    for (auto& in_frames : of_recording) in_frames.resize(points);
  }
  std::vector<char> refused(points, 0);
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    for (size_t scored = 0; scored < 2; ++scored) {
      Add(results[i].errors[scored], &errors[piece.fold][scored][piece.point]);
      if (SharedRecording(comparison)) {
        Add(results[i].errors[scored],
            &errors[1 - piece.fold][scored][piece.point]);
      }
    }
    if (results[i].refused) refused[piece.point] = 1;
  }
  for (auto& of_recording : errors) {
    for (auto& in_frames : of_recording) {
      for (size_t point = 0; point < points; ++point) {
        if (refused[point]) in_frames[point] = RatioUnit();
      }
    }
  }
  return errors;
}

// Chooses on one fold and scores on the other.
StrategyTuning ChooseCrossed(const std::vector<StrategyValues>& grid,
                             const GridErrors& errors) {
  StrategyTuning tuning;
  for (size_t point = 0; point < grid.size(); ++point) {
    RatioUnit both = errors[0][0][point];
    Add(errors[1][1][point], &both);
    tuning.points.push_back(
        {grid[point],
         {Ratio(errors[0][0][point]), Ratio(errors[1][1][point])},
         Ratio(both)});
  }
  RatioUnit cross, same;
  for (size_t fold = 0; fold < 2; ++fold) {
    const size_t chosen = Least(errors[fold][1 - fold]);
    tuning.chosen.push_back(grid[chosen]);
    Add(errors[fold][fold][chosen], &cross);
    Add(errors[fold][fold][Least(errors[fold][fold])], &same);
  }
  tuning.cross_px = Ratio(cross);
  tuning.same_fold_px = Ratio(same);
  return tuning;
}

StrategyTuning Tune(const Comparison& comparison, const Strategy& strategy,
                    const Tick& tick) {
  const std::vector<StrategyValues> grid = strategy.parameters.empty()
                                               ? std::vector<StrategyValues>{{}}
                                               : GridOf(strategy);
  const std::vector<Piece> pieces = PiecesOf(comparison, grid.size());
  std::vector<PieceResult> results(pieces.size());
  ParallelFor(comparison.threads, static_cast<int>(pieces.size()), [&](int i) {
    results[i] =
        ComputePiece(comparison, strategy, grid[pieces[i].point], pieces[i]);
    if (tick) tick();
  });
  StrategyTuning tuning =
      ChooseCrossed(grid, PoolPieces(comparison, pieces, results, grid.size()));
  for (const PieceResult& result : results) tuning.cpu_s += result.cpu_s;
  return tuning;
}

// All parameters of all strategies, for the readers and writers of options.
struct FoldTable {
  const std::vector<Strategy>* strategies = nullptr;
  std::string first = "first";
  std::string second = "second";
  std::string frames[2];
  std::vector<StrategyValues> values[2];

  void Describe(OptionVisitor& visitor) {
    for (int fold = 0; fold < 2; ++fold) {
      visitor.Enter(fold == 0 ? first : second);
      visitor.Text("frames", &frames[fold], "that are scored with these");
      for (size_t s = 0; s < strategies->size(); ++s) {
        const Strategy& strategy = (*strategies)[s];
        if (strategy.parameters.empty()) continue;
        visitor.Enter(strategy.name);
        for (size_t i = 0; i < strategy.parameters.size(); ++i) {
          visitor.Number(strategy.parameters[i].name, &values[fold][s][i],
                         NonNegative(), strategy.parameters[i].unit, "");
        }
        visitor.Leave();
      }
      visitor.Leave();
    }
  }
};

std::string RangeText(const FrameRange& range) {
  return std::to_string(range.begin) + ":" + std::to_string(range.end);
}

}  // namespace

int64_t PiecesOfTuning(const Comparison& comparison,
                       const std::vector<Strategy>& strategies) {
  size_t pieces = 0;
  for (const Strategy& strategy : TunedThemselves(strategies)) {
    pieces += PiecesOf(comparison, GridOf(strategy).size()).size();
  }
  return static_cast<int64_t>(pieces);
}

std::vector<StrategyTuning> TuneStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies,
    const Tick& tick) {
  CHECK_EQ(comparison.folds.size(), 2u);
  std::map<std::string, StrategyTuning> tuned;
  for (const Strategy& strategy : TunedThemselves(strategies)) {
    tuned[strategy.name] = Tune(comparison, strategy, tick);
  }
  std::vector<StrategyTuning> tunings;
  for (const Strategy& strategy : strategies) {
    tunings.push_back(tuned.at(TunedAs(strategy).name));
  }
  return tunings;
}

void WriteParameters(const std::vector<Strategy>& strategies,
                     const ParameterFile& parameters, const std::string& path) {
  std::string text =
      "# Parameters of smoothing strategies, chosen by held-out error: those "
      "of\n# [first] on the frames of [second], and the other way round.\n";
  for (size_t fold = 0; fold < 2; ++fold) {
    const std::string table = fold == 0 ? "first" : "second";
    text += "\n[" + table + "]\nframes = \"" +
            RangeText(parameters.folds[fold]) + "\"\n";
    for (size_t s = 0; s < strategies.size(); ++s) {
      if (strategies[s].parameters.empty()) continue;
      text += "\n[" + table + "." + strategies[s].name + "]\n";
      for (size_t i = 0; i < strategies[s].parameters.size(); ++i) {
        char value[40];
        std::snprintf(value, sizeof(value), "%.17g",
                      parameters.strategies[s][fold][i]);
        text += strategies[s].parameters[i].name + " = " + value;
        // TOML tells integers from numbers; both are read.
        text += strategies[s].parameters[i].unit.empty()
                    ? "\n"
                    : "  # " + strategies[s].parameters[i].unit + "\n";
      }
    }
  }
  WriteTextFile(path, text);
}

ParameterFile ReadParameters(const std::string& path,
                             const std::vector<Strategy>& strategies,
                             double rate_hz, const EstimatorOptions& options) {
  // All strategies are known keys, whichever were asked for.
  FoldTable table;
  table.strategies = &AllStrategies();
  for (const Strategy& strategy : AllStrategies()) {
    const StrategyValues values = DefaultValues(strategy, rate_hz, options);
    table.values[0].push_back(values);
    table.values[1].push_back(values);
  }
  ConfigFile config = ConfigFile::Read(path);
  config.Apply(&table);
  config.RejectUnknown();
  ParameterFile parameters;
  for (const std::string& frames : table.frames) {
    if (frames.empty()) continue;
    const std::vector<FrameRange> ranges = ParseFrameRanges(frames, "frames");
    if (ranges.size() != 1) {
      throw InputError(path, "key 'frames'",
                       "found '" + Printable(frames) + "', expected one range");
    }
    parameters.folds.push_back(ranges.front());
  }
  if (parameters.folds.size() == 1) {
    throw InputError(path, "", "frames of one fold, expected of both or none");
  }
  for (const Strategy& strategy : strategies) {
    const auto at = std::find_if(
        AllStrategies().begin(), AllStrategies().end(),
        [&](const Strategy& other) { return other.name == strategy.name; });
    const auto s = static_cast<size_t>(at - AllStrategies().begin());
    FoldValues values = {table.values[0][s]};
    if (!parameters.folds.empty()) values.push_back(table.values[1][s]);
    parameters.strategies.push_back(std::move(values));
  }
  return parameters;
}

}  // namespace kinegraph
