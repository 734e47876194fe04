#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/common/config_folder.h"
#include "apps/common/table.h"
#include "apps/compare/output.h"
#include "core/io/configuration/config.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

std::string Pixels(double value) { return Fixed(value, 2) + " px"; }

// A part of a dotted key, unquoted if TOML allows it.
std::string KeyPart(const std::string& part) {
  const bool bare =
      !part.empty() && std::all_of(part.begin(), part.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ||
               c == '-';
      });
  return bare ? part : JsonText(part);
}

// Effective keys by their dotted names, values in TOML syntax (scalars and
// lists of scalars look alike in JSON and TOML). Null values are left out.
std::map<std::string, std::string> Flatten(const Json& json,
                                           const std::string& prefix) {
  std::map<std::string, std::string> keys;
  for (const auto& [key, value] : json.items()) {
    const std::string name =
        prefix.empty() ? KeyPart(key) : prefix + "." + KeyPart(key);
    if (value.is_object()) {
      keys.merge(Flatten(value, name));
    } else if (!value.is_null()) {
      keys[name] = DumpJson(value);
    }
  }
  return keys;
}

std::map<std::string, std::string> FlatKeysOf(const RunOptions& options) {
  return Flatten(ParseJson(EffectiveConfigJson(options), "the configuration"),
                 "");
}

// When a pose of the strategy becomes final.
std::string DelayText(const StrategyResult& one) {
  const double delay_ms = one.Find("final_after_ms")->value;
  if (std::isnan(delay_ms)) return "final at the end of the recording";
  if (delay_ms == 0.0) return "final at once";
  return "final after " + Fixed(delay_ms, 0) + " ms";
}

// Whether two strategies' intervals of the mean overlap.
bool Overlap(const Measure& a, const Measure& b) {
  return !std::isnan(a.interval.low) && !std::isnan(b.interval.low) &&
         a.interval.low <= b.interval.high && b.interval.low <= a.interval.high;
}

// The strategy with the least mean held-out error among those that ran; nullptr
// if nothing could be scored.
const StrategyResult* BestStrategy(const CompareResult& result) {
  const StrategyResult* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const StrategyResult* one : result.Ran()) {
    const double mean = one->Find(kHeldOut)->value;
    if (!(mean < least)) continue;
    best = one;
    least = mean;
  }
  return best;
}

// Names the strategy nearest to the truth; empty without a truth.
std::string TruthText(const CompareResult& result) {
  const StrategyResult* nearest = nullptr;
  double least_mm = std::numeric_limits<double>::infinity();
  for (const StrategyResult& one : result.strategies) {
    const Measure* error = one.Find("mpjpe_mm");
    if (error == nullptr || !(error->value < least_mm)) continue;
    least_mm = error->value;
    nearest = &one;
  }
  if (nearest == nullptr) return "";
  return " Nearest to the ground truth: " + nearest->strategy.title +
         ", MPJPE " + Fixed(least_mm, 1) + " mm.";
}

}  // namespace

std::string ChangedKeysToml(const RunOptions& options) {
  const std::map<std::string, std::string> defaults = FlatKeysOf(RunOptions());
  std::string text;
  for (const auto& [key, value] : FlatKeysOf(options)) {
    const auto at = defaults.find(key);
    if (at != defaults.end() && at->second == value) continue;
    text += key + " = " + value + "\n";
  }
  return text + SkeletonTables(options.user_skeletons);
}

std::string VerdictText(const CompareResult& result) {
  const StrategyResult* best = BestStrategy(result);
  if (best == nullptr) return "No strategy could be scored.";
  const Measure& mean = *best->Find(kHeldOut);
  std::string text =
      fmt::format("Best: {}, mean held-out error {}, {}.", best->strategy.title,
                  Pixels(mean.value), DelayText(*best));
  if (best != &result.baseline() && !std::isnan(mean.difference)) {
    text += fmt::format(" Against {}: {} {}", result.baseline().strategy.title,
                        Pixels(std::abs(mean.difference)),
                        mean.difference < 0.0 ? "less" : "more");
    if (!std::isnan(mean.difference_interval.low)) {
      text += fmt::format(
          " (95 % interval of the paired difference {} to {} px), {}",
          Fixed(mean.difference_interval.low, 2),
          Fixed(mean.difference_interval.high, 2),
          mean.verdict == Verdict::kSame ? "not significant" : "significant");
    }
    text += ".";
  }
  Cells close;
  for (const StrategyResult* one : result.Ran()) {
    if (one == best || !Overlap(mean, *one->Find(kHeldOut))) continue;
    close.push_back(one->strategy.title);
  }
  if (!close.empty()) {
    text += fmt::format(
        " Strategies whose own interval overlaps that of the best: {}.",
        fmt::join(close, "; "));
  }
  return text + TruthText(result);
}

std::string RecommendedToml(const CompareResult& result) {
  const StrategyResult* best = BestStrategy(result);
  if (best == nullptr) return "";
  RunOptions wanted = result.comparison.options;
  wanted.estimators =
      OptionsOfStrategy(best->strategy, best->values.front(),
                        result.comparison.rate_hz(), wanted.estimators);
  std::string text = fmt::format(
      "# Made by `kinegraph compare`: the configuration it was given, with the "
      "best\n# strategy. {}: mean held-out error {}, {}.\n",
      best->strategy.title, Pixels(best->Find(kHeldOut)->value),
      DelayText(*best));
  if (best->values.size() > 1) {
    text += "# The values are those of the first fold.\n";
  }
  return text + ChangedKeysToml(wanted);
}

std::string Digest(const CompareResult& result, const std::string& folder) {
  Table table({"strategy", "held-out, px", "vs. baseline", "accel., m/s^2",
               "pose final after"});
  for (const StrategyResult& one : result.strategies) {
    const std::string title = Cut(one.strategy.title, 38);
    if (!one.ran()) {
      table.AddRow({title, "-", "-", "-", "-"});
      continue;
    }
    const Measure& mean = *one.Find(kHeldOut);
    const Measure& acceleration = *one.Find("acceleration_m_s2");
    const Measure& delay = *one.Find("final_after_ms");
    const std::string mark = mean.verdict == Verdict::kSame ? " =" : "";
    table.AddRow(
        {title, Fixed(mean.value, 2),
         mean.verdict == Verdict::kNone ? "-"
                                        : Fixed(mean.difference, 2) + mark,
         Fixed(acceleration.value, 2),
         std::isnan(delay.value) ? "the end" : Fixed(delay.value, 0) + " ms"});
  }
  std::string balance;
  for (const std::string& sentence : BalanceSentences(result)) {
    balance += Wrapped(sentence, kTerminalColumns, "  ");
  }
  return table.ToString() +
         "Mean held-out error; =: not significantly different "
         "from the baseline.\n\n" +
         Wrapped(VerdictText(result), kTerminalColumns) + balance +
         "written to " + folder +
         ":\n  compare.md (all tables), compare.csv, compare.json, "
         "runtime.json\n  recommended.toml: your configuration with the best "
         "strategy, for track --config\n";
}

}  // namespace kinegraph
