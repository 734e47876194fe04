#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "apps/common/plot.h"
#include "apps/compare/output.h"
#include "core/base/constants.h"

namespace kinegraph {
namespace {

constexpr char kHeldOutLabel[] =
    "held-out error, mean of min(error, 30 px) [px]";

struct NamedPlot {
  std::string name;
  std::vector<Plot> panels;
  PlotSize size;
};

std::vector<const StrategyResult*> Chosen(const CompareResult& result,
                                          const PlotChoice& choice) {
  const std::vector<const StrategyResult*> ran = result.Ran();
  std::vector<const StrategyResult*> chosen;
  for (const std::string& name : choice.strategies) {
    for (const StrategyResult* one : ran) {
      if (one->strategy.name == name) chosen.push_back(one);
    }
  }
  return chosen.empty() ? ran : chosen;
}

// Error against smoothness: one mark per strategy.
NamedPlot ErrorAgainstSmoothness(const CompareResult& result) {
  Plot plot;
  plot.title =
      "Held-out error against smoothness (vertical bars: 95 % interval of the "
      "difference from the baseline)";
  plot.x.label = "acceleration [m/s^2]";
  plot.x.log = true;
  plot.y.label = kHeldOutLabel;
  for (const StrategyResult* one : result.Ran()) {
    PlotSeries series = {one->strategy.title, PlotStyle::kPoints};
    const Measure& error = *one->Find(kHeldOut);
    const Measure& acceleration = *one->Find("acceleration_m_s2");
    // The errors of the strategies are correlated, so the interval of the
    // difference is more informative than that of the error.
    Interval paired = error.difference_interval;
    paired.low += error.value - error.difference;
    paired.high += error.value - error.difference;
    series.Add(acceleration.value, error.value, paired);
    series.x_low = {acceleration.interval.low};
    series.x_high = {acceleration.interval.high};
    plot.series.push_back(std::move(series));
  }
  return {"held_out_smoothness.svg", {plot}, {1000, 640}};
}

// The difference from the baseline with its interval, which alone decides
// whether a strategy ranks as better, worse or neither.
NamedPlot Differences(const CompareResult& result) {
  Plot plot;
  plot.title = "Held-out error against " + result.baseline().strategy.title +
               " (95 % intervals of the paired difference)";
  plot.x.label = "difference of held-out error [px]; left of 0: better";
  const struct {
    Verdict verdict;
    const char* name;
    int colour;
  } kKinds[] = {{Verdict::kLess, "better", 0},
                {Verdict::kSame, "not significant", 6},
                {Verdict::kMore, "worse", 1},
                {Verdict::kNone, "baseline", 3}};
  const std::vector<const StrategyResult*> run = result.Ran();
  for (const StrategyResult* one : run) {
    plot.y.categories.push_back(one->strategy.title);
  }
  for (const auto& kind : kKinds) {
    PlotSeries series = {kind.name, PlotStyle::kPoints};
    series.colour = kind.colour;
    for (size_t i = 0; i < run.size(); ++i) {
      const Measure& error = *run[i]->Find(kHeldOut);
      if (error.verdict != kind.verdict) continue;
      series.Add(error.difference, static_cast<double>(i));
      series.x_low.push_back(error.difference_interval.low);
      series.x_high.push_back(error.difference_interval.high);
    }
    if (!series.x.empty()) plot.series.push_back(std::move(series));
  }
  PlotSeries zero = {"",
                     PlotStyle::kLine,
                     {0.0, 0.0},
                     {-0.6, static_cast<double>(run.size()) - 0.4}};
  zero.colour = 6;
  zero.dashed = true;
  plot.series.push_back(zero);
  return {"held_out_difference.svg",
          {plot},
          {1000, 120 + 26 * static_cast<int>(run.size())}};
}

NamedPlot ByJointClass(const CompareResult& result, const PlotChoice& choice) {
  Plot plot;
  plot.title = "Held-out error by joint class (95 % intervals)";
  plot.y.label = "mean of min(error, 30 px) [px]";
  std::vector<std::string> keys;
  for (int c = 0; c < kJointClassCount; ++c) {
    const std::string name = ToString(static_cast<JointClass>(c));
    const Measure* measure = result.baseline().Find("held_out_" + name + "_px");
    if (measure == nullptr || std::isnan(measure->value)) continue;
    keys.push_back(measure->key);
    plot.x.categories.push_back(name);
  }
  for (const StrategyResult* one : Chosen(result, choice)) {
    PlotSeries series = {one->strategy.title, PlotStyle::kBars};
    for (size_t c = 0; c < keys.size(); ++c) {
      const Measure& measure = *one->Find(keys[c]);
      series.Add(static_cast<double>(c), measure.value, measure.interval);
    }
    plot.series.push_back(std::move(series));
  }
  return {"error_by_joint_class.svg", {plot}, {1100, 520}};
}

// The position of one joint in all frames; NaN where missing.
struct Trajectory {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
};

Trajectory TrajectoryOf(const TrackSequence& tracks, TrackId id, int joint) {
  Trajectory trajectory;
  for (const TrackFrame& frame : tracks.frames) {
    trajectory.time_s.push_back(ToSeconds(frame.time));
    trajectory.position_m.push_back(Eigen::Vector3d::Constant(kNan));
    for (const PersonPose& person : frame.people) {
      if (person.id != id || !person.joints[joint].present()) continue;
      trajectory.position_m.back() = person.joints[joint].position_m;
    }
  }
  return trajectory;
}

// Indices [first, end) of the two seconds in which the joint's path is longest.
std::pair<size_t, size_t> LiveliestPart(const Trajectory& trajectory,
                                        double rate_hz) {
  const size_t count = trajectory.position_m.size();
  const size_t length =
      std::min(count, static_cast<size_t>(std::lround(2.0 * rate_hz)));
  size_t best = 0;
  double farthest = -1.0;
  for (size_t first = 0; first + length <= count; ++first) {
    double way = 0.0;
    for (size_t i = first + 1; i < first + length; ++i) {
      const double step =
          (trajectory.position_m[i] - trajectory.position_m[i - 1]).norm();
      if (std::isfinite(step)) way += step;
    }
    if (way > farthest) {
      farthest = way;
      best = first;
    }
  }
  return {best, best + length};
}

NamedPlot OneTrajectory(const CompareResult& result, const PlotChoice& choice) {
  const Comparison& comparison = result.comparison;
  const Skeleton& skeleton = comparison.scene().skeleton;
  const int joint = std::max(0, skeleton.IndexOf(choice.joint));
  const auto longest =
      std::max_element(comparison.people.begin(), comparison.people.end(),
                       [](const PersonFrames& a, const PersonFrames& b) {
                         return a.frames.size() < b.frames.size();
                       });
  const std::vector<const StrategyResult*> chosen = Chosen(result, choice);
  const Trajectory guide =
      TrajectoryOf(chosen.back()->scores.run.alike, longest->id, joint);
  const auto [first, last] = LiveliestPart(guide, comparison.rate_hz());
  NamedPlot named{"trajectory.svg", {}, {1000, 900, 1}};
  for (int axis = 0; axis < 3; ++axis) {
    Plot plot;
    plot.title = axis == 0 ? skeleton.joints()[joint] + " of person " +
                                 std::to_string(longest->id.value())
                           : "";
    plot.x.label = axis == 2 ? "time [s]" : "";
    plot.y.label = std::string(1, "xyz"[axis]) + " [m]";
    if (axis > 0) plot.legend = PlotLegend::kNone;
    for (const StrategyResult* one : chosen) {
      const Trajectory trajectory =
          TrajectoryOf(one->scores.run.alike, longest->id, joint);
      const bool raw = one->strategy.kind == OutputKind::kRawDlt;
      PlotSeries series = {one->strategy.title,
                           raw ? PlotStyle::kPoints : PlotStyle::kLine};
      for (size_t i = first; i < std::min(last, trajectory.time_s.size());
           ++i) {
        series.Add(trajectory.time_s[i], trajectory.position_m[i](axis));
      }
      plot.series.push_back(std::move(series));
    }
    named.panels.push_back(std::move(plot));
  }
  return named;
}

NamedPlot LagSweep(const CompareResult& result) {
  Plot error;
  error.title = "Window against batch: held-out error";
  error.x.label = "lag [frames]";
  error.y.label = kHeldOutLabel;
  error.legend = PlotLegend::kInside;
  Plot distance;
  distance.title = "Window against batch: distance";
  distance.x.label = "lag [frames]";
  distance.y.label = "distance [mm]";
  distance.y.log = true;
  distance.legend = PlotLegend::kInside;
  constexpr PlotStyle kStyle = PlotStyle::kLinePoints;
  PlotSeries window = {"window", kStyle};
  PlotSeries median = {"median", kStyle};
  PlotSeries p95 = {"95th percentile", kStyle};
  PlotSeries p99 = {"99th percentile", kStyle};
  for (const LagPoint& point : result.lag_sweep) {
    const Measure& mean = *result.strategies[point.result_idx].Find(kHeldOut);
    const auto lag = static_cast<double>(point.lag_frames);
    window.Add(lag, mean.value, mean.interval);
    median.Add(lag, 1000.0 * point.median_m);
    p95.Add(lag, 1000.0 * point.p95_m);
    p99.Add(lag, 1000.0 * point.p99_m);
  }
  error.series.push_back(window);
  for (const StrategyResult* one : result.Ran()) {
    if (one->strategy.name != kOfflineReference) continue;
    const double value = one->Find(kHeldOut)->value;
    PlotSeries batch = {"batch",
                        PlotStyle::kLine,
                        {window.x.front(), window.x.back()},
                        {value, value}};
    batch.dashed = true;
    error.series.push_back(batch);
  }
  distance.series = {median, p95, p99};
  return {"lag_sweep.svg", {error, distance}, {1000, 420, 2}};
}

// The median over people and axes, and the range, by joint and rule.
NamedPlot Cutoffs(const CompareResult& result,
                  const std::vector<ChosenCutoff>& cutoffs) {
  Plot plot;
  plot.title = "Cut-offs that rules choose (bars: minimum and maximum)";
  plot.y.label = "cut-off [Hz]";
  plot.x.categories = result.comparison.scene().skeleton.joints();
  for (size_t rule = 0; rule < CutoffRules().size(); ++rule) {
    PlotSeries series = {CutoffRules()[rule].first, PlotStyle::kPoints};
    std::map<int, std::vector<double>> by_joint_hz;
    for (const ChosenCutoff& one : cutoffs) {
      if (one.rule_idx != static_cast<int>(rule)) continue;
      auto& joint_hz = by_joint_hz[one.joint_idx];
      joint_hz.insert(joint_hz.end(), one.cutoffs_hz.begin(),
                      one.cutoffs_hz.begin() + 3);
    }
    for (const auto& [joint, of_joint_hz] : by_joint_hz) {
      Interval range;
      range.low = Quantile(of_joint_hz, 0.0);
      range.high = Quantile(of_joint_hz, 1.0);
      // The rules of a joint are drawn side by side.
      series.Add(joint + 0.1 * (static_cast<double>(rule) - 3.0),
                 Quantile(of_joint_hz, 0.5), range);
    }
    plot.series.push_back(std::move(series));
  }
  return {"cutoffs.svg", {plot}, {1200, 520}};
}

// One line per value of the second parameter, over the first.
Plot TuningPanel(const StrategyResult& one) {
  const std::vector<SmootherParameter>& parameters = one.strategy.parameters;
  const SmootherParameter& first = parameters.front();
  Plot plot;
  plot.title = one.strategy.title;
  plot.x.label =
      first.name + (first.unit.empty() ? "" : " [" + first.unit + "]");
  plot.x.log = first.log;
  plot.y.label = "held-out error [px]";
  plot.legend = parameters.size() > 1 ? PlotLegend::kBelow : PlotLegend::kNone;
  if (first.log) {
    plot.x.low = first.grid.front() / 1.2;
    plot.x.high = first.grid.back() * 1.2;
  }
  std::map<double, PlotSeries> lines;
  for (const TuningPoint& point : one.tuning->points) {
    PlotSeries& line = lines[point.values.size() > 1 ? point.values[1] : 0.0];
    line.Add(point.values[0], point.pooled_px);
  }
  for (auto& [value, line] : lines) {
    line.style = PlotStyle::kLinePoints;
    if (parameters.size() > 1) {
      line.name = fmt::format("{} {:.4g}", parameters[1].name, value);
    }
    plot.series.push_back(std::move(line));
  }
  return plot;
}

NamedPlot TuningCurves(const CompareResult& result) {
  NamedPlot named{"tuning.svg", {}, {1200, 0, 3}};
  for (const StrategyResult* one : result.Ran()) {
    if (!one->tuning.has_value() || one->strategy.parameters.empty()) continue;
    if (!one->strategy.tuned_as.empty()) continue;
    named.panels.push_back(TuningPanel(*one));
  }
  const int rows = (static_cast<int>(named.panels.size()) + 2) / 3;
  named.size.height_px = 320 * std::max(1, rows);
  return named;
}

}  // namespace

std::vector<std::string> WriteComparePlots(
    const CompareResult& result, const std::vector<ChosenCutoff>& cutoffs,
    const PlotChoice& choice, const std::string& folder) {
  std::vector<NamedPlot> plots = {
      ErrorAgainstSmoothness(result), Differences(result),
      ByJointClass(result, choice), OneTrajectory(result, choice)};
  if (!result.lag_sweep.empty()) plots.push_back(LagSweep(result));
  if (!cutoffs.empty()) plots.push_back(Cutoffs(result, cutoffs));
  NamedPlot tuning = TuningCurves(result);
  if (!tuning.panels.empty()) plots.push_back(std::move(tuning));
  std::vector<std::string> names;
  for (const NamedPlot& plot : plots) {
    WritePlot(plot.panels, folder + "/" + plot.name, plot.size);
    names.push_back(plot.name);
  }
  return names;
}

}  // namespace kinegraph
