#include "apps/compare/tuning.h"

#include <fmt/format.h>
#include <glog/logging.h>

#include <cmath>
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

// Number of different prepared recordings: one if the folds share it.
size_t RecordingCount(const Comparison& comparison) {
  const std::vector<Fold>& folds = comparison.folds;
  const bool shared = folds.back().recording == folds.front().recording;
  return shared ? 1 : folds.size();
}

void Add(const RatioUnit& unit, RatioUnit* sum) {
  sum->sum += unit.sum;
  sum->weight += unit.weight;
}

double Ratio(const RatioUnit& unit) {
  return unit.weight > 0.0 ? unit.sum / unit.weight : kNan;
}

// Index of the first point with the smallest mean error; if all points were
// refused, the last index.
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

// One point without one camera, on the recording of a fold.
struct GridPiece {
  size_t point = 0;
  size_t recording = 0;
  size_t view = 0;
  std::vector<RatioUnit> errors;  // in the frames of each fold
  double cpu_s = 0.0;
  bool refused = false;
};

void ScorePiece(const Comparison& comparison, const Strategy& strategy,
                const StrategyValues& values, GridPiece* piece) {
  const int64_t start_ns = ThreadCpuNs();
  piece->errors.resize(comparison.folds.size());
  const std::string refusal = RefusalOf([&] {
    const auto& recording = comparison.folds[piece->recording].recording;
    const TrackSequence tracks =
        RunWithout(comparison, strategy, values, *recording, piece->view);
    for (size_t f = 0; f < comparison.folds.size(); ++f) {
      HeldOutScores scores;
      ScoreWithout(comparison, {comparison.folds[f].frames, recording},
                   piece->view, tracks, &scores);
      for (const RatioUnit& unit : TruncatedErrors(scores, AllJoints())) {
        Add(unit, &piece->errors[f]);
      }
    }
  });
  piece->refused = !refusal.empty();
  piece->cpu_s = 1e-9 * static_cast<double>(ThreadCpuNs() - start_ns);
}

// Chooses the values for each fold on the other one.
StrategyTuning ChooseCrossed(const std::vector<StrategyValues>& grid,
                             const GridErrors& scored) {
  const auto& errors = scored.errors;
  StrategyTuning tuning;
  tuning.cpu_s = scored.cpu_s;
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

constexpr const char* kFoldTables[] = {"first", "second"};

// The parameters of all strategies, as options that ConfigFile::Apply reads.
struct FoldTable {
  std::string frames[2];
  std::vector<StrategyValues> values[2];

  void Describe(OptionVisitor& visitor) {
    for (int fold = 0; fold < 2; ++fold) {
      visitor.Enter(kFoldTables[fold]);
      visitor.Text("frames", &frames[fold],
                   "frames that are scored with these parameters");
      for (size_t s = 0; s < AllStrategies().size(); ++s) {
        const Strategy& strategy = AllStrategies()[s];
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

}  // namespace

GridErrors ScoreGrid(const Comparison& comparison, const Strategy& strategy,
                     const std::vector<StrategyValues>& points,
                     Progress* progress) {
  const size_t folds = comparison.folds.size();
  const size_t recordings = RecordingCount(comparison);
  std::vector<GridPiece> pieces;
  for (size_t point = 0; point < points.size(); ++point) {
    for (size_t recording = 0; recording < recordings; ++recording) {
      for (size_t view = 0; view < comparison.views().size(); ++view) {
        pieces.push_back({point, recording, view, {}});
      }
    }
  }
  ParallelFor(comparison.threads, static_cast<int>(pieces.size()), [&](int i) {
    ScorePiece(comparison, strategy, points[pieces[i].point], &pieces[i]);
    if (progress != nullptr) progress->Advance();
  });
  GridErrors grid;
  grid.errors.assign(recordings,
                     {folds, std::vector<RatioUnit>(points.size())});
  std::vector<char> refused(points.size(), 0);
  for (const GridPiece& piece : pieces) {
    grid.cpu_s += piece.cpu_s;
    if (piece.refused) refused[piece.point] = 1;
    for (size_t f = 0; f < folds; ++f) {
      Add(piece.errors[f], &grid.errors[piece.recording][f][piece.point]);
    }
  }
  for (auto& of_recording : grid.errors) {
    for (auto& in_frames : of_recording) {
      for (size_t point = 0; point < points.size(); ++point) {
        if (refused[point]) in_frames[point] = RatioUnit();
      }
    }
  }
  // If the folds share one recording, its errors hold for all of them.
  grid.errors.resize(folds, grid.errors.front());
  return grid;
}

std::vector<StrategyTuning> TuneStrategies(
    const Comparison& comparison, const std::vector<Strategy>& strategies) {
  CHECK_EQ(comparison.folds.size(), 2u);
  const std::vector<Strategy> to_tune = TunedThemselves(strategies);
  size_t points = 0;
  for (const Strategy& strategy : to_tune) points += GridOf(strategy).size();
  Progress progress("tuning",
                    static_cast<int64_t>(points * RecordingCount(comparison) *
                                         comparison.views().size()));
  std::map<std::string, StrategyTuning> tuned;
  for (const Strategy& strategy : to_tune) {
    const std::vector<StrategyValues> grid = GridOf(strategy);
    tuned[strategy.name] =
        ChooseCrossed(grid, ScoreGrid(comparison, strategy, grid, &progress));
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
      "in\n# [first] on the frames of [second], and vice versa.\n";
  for (size_t fold = 0; fold < 2; ++fold) {
    const char* const table = kFoldTables[fold];
    const FrameRange& frames = parameters.folds[fold];
    text += fmt::format("\n[{}]\nframes = \"{}:{}\"\n", table, frames.begin,
                        frames.end);
    for (size_t s = 0; s < strategies.size(); ++s) {
      if (strategies[s].parameters.empty()) continue;
      text += fmt::format("\n[{}.{}]\n", table, strategies[s].name);
      for (size_t i = 0; i < strategies[s].parameters.size(); ++i) {
        const SmootherParameter& parameter = strategies[s].parameters[i];
        // TOML distinguishes integers from floats; ReadParameters accepts both.
        text +=
            fmt::format("{} = {:.17g}{}\n", parameter.name,
                        parameters.strategies[s][fold][i],
                        parameter.unit.empty() ? "" : "  # " + parameter.unit);
      }
    }
  }
  WriteTextFile(path, text);
}

ParameterFile ReadParameters(const std::string& path,
                             const std::vector<Strategy>& strategies,
                             double rate_hz, const EstimatorOptions& options) {
  // The keys of all strategies are known, whether requested or not.
  FoldTable table;
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
    throw InputError(
        path, "",
        "found the frames of one fold, expected those of both folds or "
        "none");
  }
  for (const Strategy& strategy : strategies) {
    const size_t s = IndexOf(AllStrategies(), strategy.name);
    // A filter whose cut-off a rule chooses has no parameters in the file.
    if (s == AllStrategies().size()) {
      parameters.strategies.push_back(
          {DefaultValues(strategy, rate_hz, options)});
      continue;
    }
    FoldValues values = {table.values[0][s]};
    if (!parameters.folds.empty()) values.push_back(table.values[1][s]);
    parameters.strategies.push_back(std::move(values));
  }
  return parameters;
}

}  // namespace kinegraph
