#include "apps/compare/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"
#include "core/base/text.h"
#include "core/io/configuration/config.h"

namespace kinegraph {
namespace {

// "12.34 [12.00, 12.70]"; without an interval "12.34".
std::string ValueCell(const Measure& one) {
  return std::isnan(one.interval.low)
             ? Fixed(one.value, one.decimals)
             : WithInterval(one.value, one.interval, one.decimals);
}

// The verdict in words, depending on whether less or more is better.
std::string Judged(const Measure& measure) {
  if (measure.verdict == Verdict::kNone || measure.verdict == Verdict::kSame) {
    return ToString(measure.verdict);
  }
  return (measure.verdict == Verdict::kLess) == measure.less_is_better
             ? "better"
             : "worse";
}

std::string DifferenceCell(const Measure& measure) {
  if (measure.verdict == Verdict::kNone) return "-";
  return (measure.difference > 0.0 ? "+" : "") +
         WithInterval(measure.difference, measure.difference_interval,
                      measure.decimals);
}

// Empty for NaN and infinity.
std::string Number(double value) {
  return std::isfinite(value) ? fmt::format("{:.10g}", value) : "";
}

// JSON has null for NaN.
Json MeasureJson(const Measure& measure) {
  return {{"title", measure.title},
          {"unit", measure.unit},
          {"value", measure.value},
          {"interval", ToJson(measure.interval)},
          {"difference_to_baseline", measure.difference},
          {"difference_interval", ToJson(measure.difference_interval)},
          {"verdict", Judged(measure)}};
}

Json ValuesJson(const Strategy& strategy, const StrategyValues& values) {
  Json json = Json::object();
  for (size_t i = 0; i < values.size(); ++i) {
    json[strategy.parameters[i].name] = values[i];
  }
  return json;
}

Json TuningJson(const Strategy& strategy, const StrategyTuning& tuning) {
  Json curve = Json::array();
  for (const TuningPoint& point : tuning.points) {
    curve.push_back({{"values", ValuesJson(strategy, point.values)},
                     {"first_px", point.error_px[0]},
                     {"second_px", point.error_px[1]},
                     {"pooled_px", point.pooled_px}});
  }
  return {{"chosen_on", "the other fold, by held_out_mean_px"},
          {"same_fold_px", tuning.same_fold_px},
          {"cross_px", tuning.cross_px},
          {"curve", curve}};
}

// ---- Tables with one line per strategy ----

struct Column {
  std::string header;
  std::function<std::string(const StrategyResult&)> cell;
};

// A column of one measure; "-" if a strategy lacks it.
Column OfMeasure(std::string key, std::string header,
                 std::string (*text)(const Measure&)) {
  return {std::move(header), [=](const StrategyResult& one) {
            const Measure* measure = one.Find(key);
            return measure == nullptr ? "-" : text(*measure);
          }};
}

Column ValueOf(std::string key, std::string header) {
  return OfMeasure(std::move(key), std::move(header), [](const Measure& one) {
    return Fixed(one.value, one.decimals);
  });
}

Column IntervalOf(std::string key, std::string header) {
  return OfMeasure(std::move(key), std::move(header), ValueCell);
}

// The paired difference from the baseline.
Column DifferenceOf(std::string key) {
  return OfMeasure(std::move(key), "vs. baseline", DifferenceCell);
}

Column VerdictOf(std::string key) {
  return OfMeasure(std::move(key), "", Judged);
}

// A table of the strategies that ran and that `shows` accepts; empty if there
// are none.
std::string StrategyTable(
    const CompareResult& result, const std::vector<Column>& columns,
    TableStyle style = TableStyle::kMarkdown,
    const std::function<bool(const StrategyResult&)>& shows = nullptr) {
  const auto header = [](const Column& column) { return column.header; };
  Table table(RowOf("strategy", CellsOf(columns, header)));
  bool any = false;
  for (const StrategyResult* one : result.Ran()) {
    if (shows && !shows(*one)) continue;
    const auto cell = [&](const Column& column) { return column.cell(*one); };
    table.AddRow(RowOf(one->strategy.title, CellsOf(columns, cell)));
    any = true;
  }
  return any ? table.ToString(style) : "";
}

std::string HeldOutTable(const CompareResult& result) {
  return StrategyTable(
      result,
      {IntervalOf(kHeldOut, "mean [px]"), DifferenceOf(kHeldOut),
       VerdictOf(kHeldOut),
       ValueOf("held_out_common_px", "joints that every strategy predicts"),
       VerdictOf("held_out_common_px"),
       ValueOf("held_out_common_median_px",
               "joints that every strategy predicts, median"),
       ValueOf("held_out_median_px", "median"),
       ValueOf("held_out_p90_px", "90th"), ValueOf("held_out_p97_px", "97th"),
       ValueOf("predicted_percent", "predicted [%]")});
}

std::string ClassTable(const CompareResult& result) {
  std::vector<Column> columns;
  for (int c = 0; c < kJointClassCount; ++c) {
    const std::string name = ToString(static_cast<JointClass>(c));
    const std::string key = "held_out_" + name + "_px";
    const Measure* measure = result.baseline().Find(key);
    if (measure == nullptr || std::isnan(measure->value)) continue;
    columns.push_back(ValueOf(key, name));
  }
  return StrategyTable(result, columns);
}

std::string MotionTable(const CompareResult& result) {
  const Column delay = ValueOf("final_after_ms", "pose final after");
  const auto final_after = [=](const StrategyResult& one) {
    return one.scores.run.whole_recording ? "the end" : delay.cell(one) + " ms";
  };
  return StrategyTable(
      result, {IntervalOf("acceleration_m_s2", "acceleration [m/s^2]"),
               ValueOf("jerk_m_s3", "jerk [m/s^3]"),
               ValueOf("power_above_6hz_mm2", "power above 6 Hz [mm^2]"),
               ValueOf("bone_spread_mm", "bone spread [mm]"),
               ValueOf("lag_to_batch_ms", "lag [ms]"),
               {delay.header, final_after},
               ValueOf("joints_given_percent", "joints with a position [%]")});
}

// "l_wrist, r_wrist", or "9 of 17 joints" if there are many; "-" for none.
std::string ExcessiveJoints(const CompareResult& result,
                            const StrategyResult& one,
                            SmoothingBalance::Excess excess) {
  constexpr size_t kMostNames = 4;
  const std::vector<std::string>& joints =
      result.comparison.scene().skeleton.joints();
  Cells names;
  for (size_t j = 0; j < one.scores.balance.size(); ++j) {
    const SmoothingBalance& joint = one.scores.balance[j];
    if (joint.is_excessive && joint.excess == excess) {
      names.push_back(joints[j]);
    }
  }
  if (names.empty()) return "-";
  return names.size() <= kMostNames
             ? fmt::format("{}", fmt::join(names, ", "))
             : fmt::format("{} of {} joints", names.size(), joints.size());
}

std::string BalanceTable(const CompareResult& result) {
  const auto of = [&](SmoothingBalance::Excess excess) {
    return [&result, excess](const StrategyResult& one) {
      return ExcessiveJoints(result, one, excess);
    };
  };
  return StrategyTable(
      result,
      {ValueOf("motion_error_mm", "error [mm]"),
       ValueOf("attainable_error_mm", "attainable error"),
       ValueOf("motion_removed_mm", "motion removed"),
       ValueOf("noise_kept_mm", "noise kept"),
       {"removes motion of", of(SmoothingBalance::Excess::kMotionRemoved)},
       {"keeps noise of", of(SmoothingBalance::Excess::kNoiseKept)}});
}

std::string TruthTable(const CompareResult& result) {
  std::vector<Column> columns = {
      IntervalOf("mpjpe_mm", "MPJPE [mm]"),
      ValueOf("mpjpe_bias_removed_mm", "bias removed [mm]"),
      DifferenceOf("mpjpe_bias_removed_mm"),
      VerdictOf("mpjpe_bias_removed_mm")};
  if (result.baseline().Find("pcp_percent") != nullptr) {
    columns.insert(columns.end(),
                   {ValueOf("pcp_percent", "PCP [%]"),
                    DifferenceOf("pcp_percent"), VerdictOf("pcp_percent")});
  }
  columns.push_back(ValueOf("lag_to_truth_ms", "lag [ms]"));
  return StrategyTable(result, columns);
}

// "velocity, acceleration": the derivatives that the strategy's model yields.
std::string ModelDerivatives(const StrategyResult& one) {
  const DerivativeResult& scores = *one.scores.derivatives;
  Cells of_model;
  if (scores.velocity_source == DerivativeSource::kModel) {
    of_model.emplace_back("velocity");
  }
  if (scores.acceleration_source == DerivativeSource::kModel) {
    of_model.emplace_back("acceleration");
  }
  return of_model.empty() ? "-" : fmt::format("{}", fmt::join(of_model, ", "));
}

std::string DerivativeTable(const CompareResult& result) {
  return StrategyTable(
      result,
      {{"derivatives from the model", ModelDerivatives},
       IntervalOf("velocity_rms_m_s", "velocity, RMS [m/s]"),
       ValueOf("speed_bias_m_s", "speed, bias [m/s]"),
       IntervalOf("acceleration_rms_m_s2", "acceleration, RMS [m/s^2]"),
       ValueOf("acceleration_bias_m_s2", "acceleration, bias"),
       ValueOf("peak_acceleration_error_percent", "peak error [%]"),
       ValueOf("peak_instant_ms", "peak timing error [ms]"),
       ValueOf("contact_acceleration_rms_m_s2",
               "contacts: acceleration, RMS [m/s^2]"),
       ValueOf("contact_peak_acceleration_error_percent",
               "contacts: peak error [%]"),
       ValueOf("contact_peak_instant_ms", "contacts: peak timing error [ms]")});
}

std::string AngleTable(const CompareResult& result) {
  std::vector<Column> columns = {
      IntervalOf("flexion_rms_deg", "all flexions, RMS [deg]"),
      VerdictOf("flexion_rms_deg")};
  for (const AngleErrors& angle : result.baseline().scores.angles) {
    columns.push_back(ValueOf(angle.name + "_rms_deg", angle.name));
  }
  return StrategyTable(result, columns);
}

std::string ConsistencyTable(const CompareResult& result) {
  std::vector<Column> columns = {
      ValueOf("held_out_covered_percent", "held-out covered [%]"),
      ValueOf("held_out_nees_per_dof", "held-out NEES per dof")};
  if (result.comparison.truth.has_value()) {
    columns.push_back(ValueOf("truth_covered_percent", "truth covered [%]"));
    columns.push_back(ValueOf("truth_nees_per_dof", "truth NEES per dof"));
  }
  return StrategyTable(
      result, columns, TableStyle::kMarkdown, [](const StrategyResult& one) {
        return one.scores.held_out_consistency.covered.total > 0;
      });
}

// Whether a chosen value is the first or last of its grid.
bool AtEdge(const Strategy& strategy, const StrategyValues& values) {
  for (size_t i = 0; i < values.size(); ++i) {
    const std::vector<double>& grid = strategy.parameters[i].grid;
    if (values[i] == grid.front() || values[i] == grid.back()) return true;
  }
  return false;
}

std::string TuningTable(const CompareResult& result) {
  Table table({"strategy", "first fold", "second fold",
               "error, chosen on the other fold [px]",
               "error, chosen on the same fold [px]"});
  bool at_edge = false;
  for (const StrategyResult* one : result.Ran()) {
    if (!one->tuning.has_value()) continue;
    const Strategy& strategy = one->strategy;
    const auto chosen = [&](const StrategyValues& values) {
      const bool edge = AtEdge(strategy, values);
      at_edge = at_edge || edge;
      return DescribeValues(strategy, values) + (edge ? " *" : "");
    };
    const bool own = strategy.tuned_as.empty();
    table.AddRow(RowOf(
        strategy.title, CellsOf(one->values, chosen),
        Fixed(own ? one->tuning->cross_px : one->Find(kHeldOut)->value, 2),
        own ? Fixed(one->tuning->same_fold_px, 2) : "as " + strategy.tuned_as));
  }
  return table.ToString(TableStyle::kMarkdown) +
         (at_edge ? "\n\\* the first or last value of the grid.\n" : "");
}

std::string ValuesTable(const CompareResult& result) {
  Table table({"strategy", "parameters"});
  for (const StrategyResult& one : result.strategies) {
    std::string values = DescribeValues(one.strategy, one.values[0]);
    if (one.values.size() == 2 && one.values[1] != one.values[0]) {
      values += "; second fold: " + DescribeValues(one.strategy, one.values[1]);
    }
    table.AddRow({one.strategy.title, values});
  }
  return table.ToString(TableStyle::kMarkdown);
}

std::string LagTable(const CompareResult& result) {
  Table table({"window [frames]", "held-out error [px]",
               "distance from batch, median [mm]", "95th [mm]", "99th [mm]"});
  for (const LagPoint& point : result.lag_sweep) {
    const Measure& mean = *result.strategies[point.result_idx].Find(kHeldOut);
    table.AddRow({std::to_string(point.lag_frames), ValueCell(mean),
                  Fixed(1000.0 * point.median_m, 3),
                  Fixed(1000.0 * point.p95_m, 2),
                  Fixed(1000.0 * point.p99_m, 2)});
  }
  return table.ToString(TableStyle::kMarkdown);
}

// "0..99": the first and the last frame.
std::string FramesText(const Fold& fold) {
  return fmt::format("{}..{}", fold.frames.begin, fold.frames.end - 1);
}

std::string ShiftText(const CompareResult& result) {
  std::string text;
  const Comparison& comparison = result.comparison;
  for (size_t fold = 0; fold < result.shifts_px.size(); ++fold) {
    text += "- frames " + FramesText(comparison.folds[fold]) +
            ", fitted on the other fold:";
    for (size_t view = 0; view < result.shifts_px[fold].size(); ++view) {
      const Eigen::Vector2d& shift = result.shifts_px[fold][view];
      text += fmt::format("{}{} ({}, {}) px", view == 0 ? " " : "; ",
                          comparison.views()[view], Fixed(shift.x(), 2),
                          Fixed(shift.y(), 2));
    }
    text += "\n";
  }
  return text;
}

int64_t ScoredJoints(const CompareResult& result) {
  int64_t joints = 0;
  for (const RatioUnit& unit : result.baseline().scores.held_out_errors) {
    joints += static_cast<int64_t>(unit.weight);
  }
  return joints;
}

// Three lines: strategies that are better, not significantly different, and
// worse by a measure.
std::string Ranking(const CompareResult& result, const std::string& key) {
  std::string text;
  for (const auto& [verdict, name] : {std::pair{Verdict::kLess, "better"},
                                      {Verdict::kSame, "not significant"},
                                      {Verdict::kMore, "worse"}}) {
    Cells titles;
    for (const StrategyResult* one : result.Ran()) {
      if (one->Find(key)->verdict != verdict) continue;
      titles.push_back(one->strategy.title);
    }
    if (titles.empty()) titles.emplace_back("none");
    text += fmt::format("- {}: {}.\n", name, fmt::join(titles, "; "));
  }
  return text;
}

// [fold][view].
Json ShiftsJson(const std::vector<std::vector<Eigen::Vector2d>>& shifts_px) {
  Json json = Json::array();
  for (const auto& of_fold : shifts_px) {
    Json shifts = Json::array();
    for (const Eigen::Vector2d& shift : of_fold) {
      shifts.push_back({shift.x(), shift.y()});
    }
    json.push_back(shifts);
  }
  return json;
}

const char* ToString(DerivativeSource source) {
  switch (source) {
    case DerivativeSource::kModel:
      return "model";
    case DerivativeSource::kModelVelocity:
      return "differences of the model's velocities";
    default:
      return "differences of positions";
  }
}

const char* ToString(SmoothingBalance::Excess excess) {
  return excess == SmoothingBalance::Excess::kNoiseKept ? "noise kept"
                                                        : "motion removed";
}

// The balance of each joint [m].
Json BalanceJson(const std::vector<SmoothingBalance>& balance,
                 const std::vector<std::string>& joints) {
  Json json = Json::object();
  for (size_t j = 0; j < balance.size(); ++j) {
    const SmoothingBalance& one = balance[j];
    json[joints[j]] = {{"segments", one.segments},
                       {"error_m", one.error_m},
                       {"motion_removed_m", one.removed_m},
                       {"noise_kept_m", one.kept_m},
                       {"attainable_error_m", one.attainable_m},
                       {"excess", ToString(one.excess)},
                       {"is_excessive", one.is_excessive}};
  }
  return json;
}

Json StrategyJson(const StrategyResult& one, const CompareResult& result) {
  const std::vector<std::string>& views = result.comparison.views();
  Json entry = {{"name", one.strategy.name}, {"title", one.strategy.title}};
  entry["parameters"] = Json::array();
  for (const StrategyValues& values : one.values) {
    entry["parameters"].push_back(ValuesJson(one.strategy, values));
  }
  if (!one.ran()) {
    entry["refused"] = one.scores.refused;
    return entry;
  }
  entry["whole_take"] = one.scores.run.whole_recording;
  for (const Measure& measure : one.measures) {
    entry["measures"][measure.key] = MeasureJson(measure);
  }
  for (size_t v = 0; v < views.size(); ++v) {
    entry["held_out_mean_px_by_view"][views[v]] =
        one.scores.held_out_by_view[v].figure_px(HeldOutFigure::kMeanTruncated);
  }
  const std::vector<std::string>& joints =
      result.comparison.scene().skeleton.joints();
  if (one.scores.derivatives.has_value()) {
    const DerivativeResult& scores = *one.scores.derivatives;
    entry["derivative_sources"] = {
        {"velocity", ToString(scores.velocity_source)},
        {"acceleration", ToString(scores.acceleration_source)}};
  }
  entry["smoothing_balance"] = BalanceJson(one.scores.balance, joints);
  if (!one.scores.truth_balance.empty()) {
    entry["truth_smoothing_balance"] =
        BalanceJson(one.scores.truth_balance, joints);
  }
  if (one.tuning.has_value()) {
    entry["tuning"] = TuningJson(one.strategy, *one.tuning);
  }
  return entry;
}

// Processor time per person and frame.
double PerFrameUs(const StrategyRun& run) {
  return 1e-3 * static_cast<double>(run.cpu_ns) /
         static_cast<double>(std::max<int64_t>(1, run.person_frames));
}

}  // namespace

std::string RankingText(const CompareResult& result) {
  return "Held-out error against " + result.baseline().strategy.title +
         " (95 % intervals of the paired difference, not corrected for "
         "multiple comparisons: about one in twenty equal strategies appears "
         "different):\n\n" +
         Ranking(result, kHeldOut) +
         "\nThe same for joints that every strategy predicts, so that filling "
         "gaps makes no difference:\n\n" +
         Ranking(result, "held_out_common_px");
}

std::vector<std::string> BalanceSentences(const CompareResult& result) {
  std::vector<std::string> sentences;
  for (const auto& [excess, what] :
       {std::pair{SmoothingBalance::Excess::kMotionRemoved,
                  "warning: motion is removed or delayed by "},
        {SmoothingBalance::Excess::kNoiseKept, "noise is kept by "}}) {
    Cells found;
    for (const StrategyResult* one : result.Ran()) {
      const std::string joints = ExcessiveJoints(result, *one, excess);
      if (joints == "-") continue;
      found.push_back(one->strategy.title + " (" + joints + ")");
    }
    if (found.empty()) continue;
    sentences.push_back(fmt::format("{}{}.", what, fmt::join(found, "; ")));
  }
  return sentences;
}

Json CompareJson(const CompareResult& result) {
  const Comparison& comparison = result.comparison;
  Json json;
  json["baseline"] = result.baseline().strategy.name;
  json["frame_rate"] = comparison.rate_hz();
  json["views"] = comparison.views();
  json["frames"] = Json::array();
  for (const Fold& fold : comparison.folds) {
    json["frames"].push_back(
        {{"begin", fold.frames.begin}, {"end", fold.frames.end}});
  }
  json["people"] = comparison.people.size();
  json["held_out"] = {{"protocol", "held_out_camera_fixed_association"},
                      {"min_confidence", comparison.set.min_confidence},
                      {"cap_px", comparison.cap_px},
                      {"detections", comparison.set.detections.size()},
                      {"joints", ScoredJoints(result)}};
  const BootstrapOptions bootstrap = comparison.bootstrap();
  json["bootstrap"] = {{"block_frames", bootstrap.block_length},
                       {"resamples", bootstrap.resamples},
                       {"confidence", bootstrap.confidence},
                       {"seed", bootstrap.seed}};
  if (!result.shifts_px.empty()) {
    json["shifts_px"] = ShiftsJson(result.shifts_px);
  }
  json["strategies"] = Json::array();
  for (const StrategyResult& one : result.strategies) {
    json["strategies"].push_back(StrategyJson(one, result));
  }
  json["lag_sweep"] = Json::array();
  for (const LagPoint& point : result.lag_sweep) {
    json["lag_sweep"].push_back(
        {{"lag_frames", point.lag_frames},
         {"held_out_mean_px",
          result.strategies[point.result_idx].Find(kHeldOut)->value},
         {"to_batch_median_m", point.median_m},
         {"to_batch_p95_m", point.p95_m},
         {"to_batch_p99_m", point.p99_m}});
  }
  json["config"] = Json::parse(EffectiveConfigJson(comparison.options));
  return json;
}

std::string CompareCsv(const CompareResult& result) {
  Table table({"strategy", "measure", "unit", "value", "low", "high",
               "difference", "difference_low", "difference_high", "verdict"});
  for (const StrategyResult& one : result.strategies) {
    for (const Measure& measure : one.measures) {
      table.AddRow({one.strategy.name, measure.key, measure.unit,
                    Number(measure.value), Number(measure.interval.low),
                    Number(measure.interval.high), Number(measure.difference),
                    Number(measure.difference_interval.low),
                    Number(measure.difference_interval.high), Judged(measure)});
    }
  }
  return table.ToString(TableStyle::kCsv);
}

std::string ErrorsCsv(const CompareResult& result) {
  const std::vector<const StrategyResult*> ran = result.Ran();
  const auto name = [](const StrategyResult* one) {
    return one->strategy.name;
  };
  Table table(RowOf("frame", CellsOf(ran, name)));
  const StrategyScores& first = ran.front()->scores;
  for (size_t j = 0; j < first.joint_units.size(); ++j) {
    const auto unit = static_cast<size_t>(first.joint_units[j]);
    const auto error = [j](const StrategyResult* one) {
      const float error_px = one->scores.joint_errors_px[j];
      // Nine digits identify a float.
      return error_px < 0.0F ? "" : fmt::format("{:.9g}", error_px);
    };
    table.AddRow(
        RowOf(std::to_string(first.unit_frames[unit]), CellsOf(ran, error)));
  }
  return table.ToString(TableStyle::kCsv);
}

std::string DerivativesCsv(const CompareResult& result) {
  Table table({"strategy", "joint", "frames", "n", "velocity_rms_m_s",
               "speed_bias_m_s", "acceleration_rms_m_s2",
               "acceleration_bias_m_s2", "peaks",
               "peak_acceleration_error_percent", "peak_instant_ms"});
  for (const StrategyResult* one : result.Ran()) {
    const DerivativeResult& scores = *one->scores.derivatives;
    for (int scope = 0; scope < kDerivativeScopes; ++scope) {
      for (size_t j = 0; j <= scores.joints.size(); ++j) {
        const bool all = j == scores.joints.size();
        const DerivativeErrors& errors =
            all ? scores.all[scope] : scores.by_joint[scope][j];
        table.AddRow(
            {one->strategy.name, all ? "all" : scores.joints[j],
             scope == 0 ? "all" : "contacts", std::to_string(errors.count),
             Number(errors.velocity_rms_m_s), Number(errors.speed_bias_m_s),
             Number(errors.acceleration_rms_m_s2),
             Number(errors.acceleration_bias_m_s2),
             std::to_string(errors.peaks), Number(errors.peak_error_percent),
             Number(errors.peak_instant_ms)});
      }
    }
  }
  return table.ToString(TableStyle::kCsv);
}

std::string CompareMarkdown(const CompareResult& result,
                            const std::vector<ChosenCutoff>& cutoffs) {
  const Comparison& comparison = result.comparison;
  std::string text = fmt::format(
      "# Smoothing strategies compared\n\nFrames {} at {} Hz, {} cameras, {}, "
      "{} scored joints. The matches of one run are frozen; every "
      "strategy gets the same detections and, except for those on robust "
      "triangulation, the same joints filter and triangulation. "
      "Held-out error: each camera is left out of the frozen matches in turn, "
      "and the pose estimated from the others is projected into it "
      "(`held_out_camera_fixed_association`). For every strategy, a person is "
      "written in the same frames as in the frozen run; a joint without a "
      "position in one of these frames counts as an error of 30 px in the "
      "mean.\n\n{}\n\n{}",
      fmt::join(CellsOf(comparison.folds, FramesText), " and "),
      Fixed(comparison.rate_hz(), 0), comparison.views().size(),
      Counted(static_cast<int64_t>(comparison.people.size()), "person",
              "people"),
      ScoredJoints(result), VerdictText(result), RankingText(result));
  for (const StrategyResult& one : result.strategies) {
    if (one.ran()) continue;
    text += "- cannot be run here: " + one.strategy.title + " (" +
            one.scores.refused + ").\n";
  }
  if (!result.shifts_px.empty()) {
    text +=
        "\n## Shifts\n\nA constant shift of each camera was subtracted from "
        "the detections:\n\n" +
        ShiftText(result);
  }
  text += "\n## Held-out error\n\n" + HeldOutTable(result);
  text +=
      "\n## Held-out error by joint class, mean [px]\n\n" + ClassTable(result);
  text +=
      "\n## Smoothness and delay\n\n" + MotionTable(result) +
      "\nAcceleration, jerk and bone spread are those of joints seen by two or "
      "more views, which are the same for every strategy; the power also "
      "includes inferred joints. Lag: relative to the batch, which has none.\n";
  text +=
      "\n## Motion removed and noise kept\n\n" + BalanceTable(result) +
      "\nRMS errors on time scales below one second, perpendicular to the ray "
      "of the held-out camera, whose detections have independent errors. "
      "Attainable error: of the best linear filter of the triangulation. The "
      "last two columns list the joints whose error exceeds 1.35 times the "
      "attainable one (with 99 % confidence) because motion is removed or "
      "delayed, or because noise is kept.\n";
  if (comparison.truth.has_value()) {
    text += "\n## Against the ground truth\n\n" + TruthTable(result) +
            "\nMPJPE against " + result.baseline().strategy.title + ":\n\n" +
            Ranking(result, "mpjpe_mm");
    text += fmt::format(
        "\n## Velocities and accelerations against the ground truth\n\n{}\n"
        "Derivatives from the model: the velocity or acceleration is part of "
        "the strategy's state or spline; for a state without acceleration, it "
        "is the central difference of the velocity. All other derivatives, and "
        "those of the truth, are central differences of the positions at the "
        "frame rate. Contacts: within 0.1 s of {} instants at which a "
        "descending ankle in the ground truth decelerates by more than one g. "
        "Peak error: estimated / true peak acceleration - 1. Values by joint: "
        "derivatives.csv.\n",
        DerivativeTable(result),
        result.baseline().scores.derivatives->contacts);
    if (comparison.angles) {
      text += "\n## Joint angles against the ground truth, RMS [deg]\n\n" +
              AngleTable(result);
    }
  }
  if (!cutoffs.empty()) {
    text +=
        "\n## Cut-offs that rules choose, x / y / z [Hz]\n\n" +
        CutoffsTable(result, cutoffs) +
        "\nFor a Butterworth filter of the triangulated points, median over "
        "people. All values: cutoffs.csv.\n";
  }
  const std::string consistency = ConsistencyTable(result);
  if (!consistency.empty()) {
    text += "\n## Coverage of the covariances\n\n" + consistency +
            "\nThe ideal values are a coverage of 95 % and a NEES per degree "
            "of freedom of 1. Held-out residuals are normalised by J Sigma J' "
            "+ sigma^2, "
            "with sigma from the table [graph] of the configuration.\n";
  }
  if (!result.lag_sweep.empty()) {
    text += "\n## The window against the batch\n\n" + LagTable(result);
  }
  if (result.strategies.front().tuning.has_value()) {  // then all have it
    text += "\n## Parameters, chosen by held-out error on two folds\n\n" +
            TuningTable(result);
  } else {
    text += "\n## Parameters\n\n" + ValuesTable(result);
  }
  return text;
}

Json RuntimeJson(const CompareResult& result) {
  Json json = Json::array();
  for (const StrategyResult* one : result.Ran()) {
    const StrategyRun& run = one->scores.run;
    Json entry = {{"name", one->strategy.name},
                  {"cpu_us_per_person_frame",
                   run.person_frames == 0 ? Json() : Json(PerFrameUs(run))}};
    if (one->tuning.has_value()) entry["tuning_cpu_s"] = one->tuning->cpu_s;
    json.push_back(entry);
  }
  return json;
}

std::string RuntimeTable(const CompareResult& result) {
  const auto per_frame = [](const StrategyResult& one) {
    return Fixed(PerFrameUs(one.scores.run), 1);
  };
  const auto tuning_s = [](const StrategyResult& one) {
    return one.tuning.has_value() ? Fixed(one.tuning->cpu_s, 1) : "-";
  };
  return StrategyTable(
      result, {{"us per person-frame", per_frame}, {"tuning [s]", tuning_s}},
      TableStyle::kPlain);
}

}  // namespace kinegraph
