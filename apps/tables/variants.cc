#include "apps/tables/variants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "apps/common/config_folder.h"
#include "apps/common/evaluation_output.h"
#include "apps/common/progress.h"
#include "apps/common/table.h"
#include "core/evaluation/statistics.h"
#include "core/io/files/atomic_file.h"
#include "core/system/process.h"
#include "core/tracking/tracker.h"

namespace kinegraph {
namespace {

int64_t RecordingCount(const BenchmarkData& data) {
  int64_t count = 0;
  for (const Benchmark& benchmark : data.benchmarks) {
    count += static_cast<int64_t>(benchmark.recordings.size());
  }
  return count;
}

PcpResult ScoreOf(const LoadedDataset& loaded, const TrackSequence& tracks) {
  return EvaluatePcp(loaded.truth, tracks, loaded.dataset.protocol);
}

// ---- Ablation

std::string NameOf(const AblationCell& cell) {
  const std::string affinity =
      cell.affinity == AffinityKind::kPart ? "part-aware" : "body-aware";
  return affinity + (cell.joints_filter ? ", joints filter" : ", no filter");
}

std::string AblationMarkdown(const Dataset& dataset,
                             const std::vector<AblationCell>& cells) {
  const std::vector<int64_t> actors = cells.front().pcp.HeadlineActors();
  Table table(
      RowOf("front end", CellsOf(actors, ActorName), "mean", "95 % interval",
            "lower arms", "torso", "difference from the baseline",
            "95 % interval of the difference", "identities", "switches"));
  for (const AblationCell& cell : cells) {
    const PcpResult& pcp = cell.pcp;
    const auto count = [&](int64_t actor) {
      return PercentCell(CountParts(pcp, actor, PcpGroup::kTotal));
    };
    const auto mean = [&](PcpGroup group) {
      return Fixed(MeanOfActors(pcp, group), 2);
    };
    const bool baseline = &cell == &cells.front();
    table.AddRow(
        RowOf(NameOf(cell), CellsOf(actors, count), mean(PcpGroup::kTotal),
              IntervalCell(MeanOfActorsInterval(pcp, PcpGroup::kTotal), 2),
              mean(PcpGroup::kLowerArms), mean(PcpGroup::kTorso),
              baseline ? "-" : Fixed(cell.difference.value, 2),
              baseline ? "-" : IntervalCell(cell.difference.interval, 2),
              std::to_string(cell.identity.identities),
              std::to_string(cell.identity.switches)));
  }
  return "### " + dataset.name + "\n\nDetections: " + dataset.detections_note +
         ". Configuration: `configs/" + dataset.config +
         "`. PCP in %, head conversion `" + ToString(dataset.protocol.head) +
         "`, mean rule, with counts.\n\n" +
         table.ToString(TableStyle::kMarkdown) + "\n";
}

Json AblationJson(const Dataset& dataset,
                  const std::vector<AblationCell>& cells) {
  Json out = {{"dataset", dataset.name},
              {"detections", dataset.detections_note},
              {"config", dataset.config}};
  for (const AblationCell& cell : cells) {
    Json row = {
        {"affinity", cell.affinity == AffinityKind::kPart ? "part" : "body"},
        {"joints_filter", cell.joints_filter}};
    for (const int64_t actor : cell.pcp.Actors()) {
      row["actors"][std::to_string(actor)] =
          PartsJson(CountParts(cell.pcp, actor, PcpGroup::kTotal));
    }
    for (const PcpGroup group : kPcpGroups) {
      row["mean_of_actors"][ToString(group)] = MeanOfActors(cell.pcp, group);
    }
    const Interval mean = MeanOfActorsInterval(cell.pcp, PcpGroup::kTotal);
    row["mean_interval"] = {mean.low, mean.high};
    row["difference"] = cell.difference.value;
    row["difference_interval"] = {cell.difference.interval.low,
                                  cell.difference.interval.high};
    row["identities"] = cell.identity.identities;
    row["switches"] = cell.identity.switches;
    out["cells"].push_back(std::move(row));
  }
  return out;
}

// Adds a row for all parts and one for the lower arms if the recording is
// tracked by the front end of Chen et al. with and without the joints filter.
void AddFilterInChen(const BenchmarkData& data,
                     const BenchmarkRecording& recording, Table* table,
                     Json* json) {
  std::vector<PcpResult> pair;  // without, with
  for (const char* name : {kChen, kChenWithFilter}) {
    for (const Method& method : recording.methods) {
      if (method.name != name) continue;
      const LoadedDataset loaded = LoadDataset(data, recording, method);
      pair.push_back(ScoreOf(loaded, TracksOf(loaded)));
    }
  }
  if (pair.size() != 2) return;
  for (const PcpGroup group : {PcpGroup::kTotal, PcpGroup::kLowerArms}) {
    const double without = MeanOfActors(pair[0], group);
    const double with = MeanOfActors(pair[1], group);
    const auto [difference, interval] = DifferenceOf(pair[1], pair[0], group);
    table->AddRow({recording.dataset.name, ToString(group), Fixed(without, 2),
                   Fixed(with, 2), WithInterval(difference, interval, 2)});
    json->push_back({{"detections", recording.dataset.name},
                     {"part", ToString(group)},
                     {"without", without},
                     {"with", with},
                     {"difference", difference},
                     {"interval", ToJson(interval)}});
  }
}

// ---- Sensitivity

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr int kStepsPerOctave = 4;
// Offset between the error bars of two recordings, to avoid overlaps, in units
// of the published value.
constexpr double kBarShift = 0.012;

Json SweepJson(const Sweep& sweep) {
  Json json = {{"detections", sweep.dataset.name},
               {"detections_note", sweep.dataset.detections_note},
               {"parameter", sweep.parameter},
               {"unit", sweep.unit},
               {"published", sweep.paper_value}};
  for (const SweptValue& value : sweep.values) {
    json["values"].push_back(
        {{"value", value.value},
         {"mean_of_actors", value.mean_of_actors},
         {"interval", ToJson(value.interval)},
         {"difference", value.difference.value},
         {"difference_interval", ToJson(value.difference.interval)}});
  }
  return json;
}

Cells SweepCells(const Sweep& sweep) {
  const std::vector<SweptValue>& values = sweep.values;
  const auto [least, greatest] =
      std::minmax_element(values.begin(), values.end(),
                          [](const SweptValue& a, const SweptValue& b) {
                            return a.mean_of_actors < b.mean_of_actors;
                          });
  const bool flat = least->mean_of_actors == greatest->mean_of_actors;
  // The values whose score differs significantly from that of the published
  // value, with the differences.
  std::string significant;
  for (const SweptValue& value : values) {
    if (!value.difference.is_significant()) continue;
    significant += (significant.empty() ? "" : ", ") + Fixed(value.value, 1) +
                   " (" + Fixed(value.difference.value, 2) + ")";
  }
  return {
      sweep.dataset.name,
      sweep.parameter + ", " + sweep.unit,
      Fixed(sweep.paper_value, 1),
      Fixed(values.front().value, 1) + " to " + Fixed(values.back().value, 1),
      Fixed(least->mean_of_actors, 2),
      flat ? "-" : Fixed(least->value, 1),
      Fixed(greatest->mean_of_actors, 2),
      flat ? "-" : Fixed(greatest->value, 1),
      significant.empty() ? "no value" : significant};
}

// The sensitivity of one benchmark's recordings.
TableOutput SweepTable(const std::string& title,
                       const std::vector<Sweep>& sweeps,
                       const std::string& figure) {
  Table table({"detections", "parameter", "published", "swept", "least PCP",
               "at", "greatest PCP", "at", "significant difference at"});
  TableOutput output;
  output.json = Json::array();
  std::string notes;
  std::string noted;
  for (const Sweep& sweep : sweeps) {
    table.AddRow(SweepCells(sweep));
    output.json.push_back(SweepJson(sweep));
    const Dataset& dataset = sweep.dataset;
    if (dataset.name == noted) continue;
    notes += "- " + dataset.name + ": " + dataset.detections_note + ".\n";
    noted = dataset.name;
  }
  output.markdown =
      "### " + title +
      "\n\nOne parameter at a time is varied from half to twice its published "
      "value (epsilon up to 17); head `chu`, mean rule. A difference is "
      "significant if its paired 95 % interval excludes 0; of this many "
      "values, some are significant by chance alone. No value was chosen from "
      "these results.\n\n" +
      notes + "\n" + table.ToString(TableStyle::kMarkdown) +
      "\n![PCP over each parameter](" + figure + ")\n\n";
  return output;
}

// ---- Runtime

constexpr int kRepetitions = 11;     // at most; the median is reported
constexpr double kMaxSeconds = 5.0;  // per method; at least two repetitions

struct TimedMethod {
  const BenchmarkRecording* recording;
  Method method;
};

std::vector<TimedMethod> TimedMethods(const BenchmarkData& data) {
  std::vector<TimedMethod> timed;
  for (const Benchmark& benchmark : data.benchmarks) {
    for (size_t r = 0; r < std::min<size_t>(2, benchmark.recordings.size());
         ++r) {
      const BenchmarkRecording& recording = benchmark.recordings[r];
      for (Method method : recording.methods) {
        timed.push_back({&recording, method});
        if (method.name.rfind("paper mode", 0) != 0) continue;
        method.name += ", no joints filter";
        method.set = JoinSets(method.set, "reconstruction.joints_filter=false");
        timed.push_back({&recording, method});
      }
    }
  }
  return timed;
}

// What is timed: the stages of StageTimes except output, then the whole.
constexpr const char* kTimed[] = {"preparation",    "association",
                                  "reconstruction", "estimation",
                                  "initialisation", "whole"};

struct Timing {
  std::map<std::string, double> ms;  // per frame; by kTimed
  int repetitions = 0;

  // The stages of the paper's table, from which its frame rate is computed.
  double PaperStages() const {
    return ms.at("association") + ms.at("reconstruction") +
           ms.at("initialisation");
  }
};

Timing TimeOf(const LoadedDataset& loaded) {
  std::array<std::vector<double>, std::size(kTimed)> samples_ms;
  const int64_t start_ns = ThreadCpuNs();
  Timing timing;
  while (timing.repetitions < kRepetitions) {
    StageTimes stages;
    Session session(
        loaded.options, loaded.request, loaded.detections.header,
        [&] { return std::make_unique<MemorySource>(loaded.detections); });
    session.set_stage_times(&stages);
    MemorySource source(loaded.detections);
    const int64_t begin_ns = ThreadCpuNs();
    TrackAll(&source, &session, [](TrackFrame&&) {});
    const int64_t whole_ns = ThreadCpuNs() - begin_ns;
    const double frames =
        static_cast<double>(std::max<int64_t>(1, session.summary().frames));
    const int64_t values_ns[] = {
        stages.preparation_ns,    stages.association_ns,
        stages.reconstruction_ns, stages.estimation_ns,
        stages.initialisation_ns, whole_ns};
    for (size_t i = 0; i < samples_ms.size(); ++i) {
      samples_ms[i].push_back(static_cast<double>(values_ns[i]) / 1e6 / frames);
    }
    ++timing.repetitions;
    const double spent_s = static_cast<double>(ThreadCpuNs() - start_ns) * 1e-9;
    if (timing.repetitions >= 2 && spent_s > kMaxSeconds) break;
  }
  for (size_t i = 0; i < samples_ms.size(); ++i) {
    timing.ms[kTimed[i]] = Quantile(samples_ms[i], 0.5);
  }
  return timing;
}

}  // namespace

std::vector<AblationCell> RunAblation(const LoadedDataset& loaded) {
  std::vector<AblationCell> cells;
  for (const AffinityKind affinity :
       {AffinityKind::kBody, AffinityKind::kPart}) {
    for (const bool joints_filter : {false, true}) {
      RunOptions options = loaded.options;
      options.tracker.association.affinity = affinity;
      options.tracker.reconstruction.joints_filter = joints_filter;
      const TrackSequence tracks = TracksOf(loaded, options);
      AblationCell cell;
      cell.affinity = affinity;
      cell.joints_filter = joints_filter;
      cell.pcp = ScoreOf(loaded, tracks);
      IdentityOptions identity;
      identity.frames = loaded.dataset.protocol.frames;
      cell.identity = EvaluateIdentity(loaded.truth, tracks, identity);
      if (!cells.empty()) {
        cell.difference = DifferenceOf(cell.pcp, cells.front().pcp);
      }
      cells.push_back(std::move(cell));
    }
  }
  return cells;
}

std::vector<Plot> AblationPlots(
    const std::vector<AblatedRecording>& recordings) {
  std::vector<Plot> panels;
  for (const PcpGroup group : {PcpGroup::kTotal, PcpGroup::kLowerArms}) {
    Plot& panel = panels.emplace_back();
    panel.title =
        group == PcpGroup::kTotal
            ? "PCP, mean of actors: difference from body-aware, no filter"
            : "Lower arms";
    panel.y.label = "difference [percentage points of PCP]";
    panel.legend = PlotLegend::kBelow;
    for (size_t r = 0; r < recordings.size(); ++r) {
      const std::vector<AblationCell>& cells = recordings[r].cells;
      panel.x.categories.push_back(recordings[r].name);
      panel.series.resize(cells.size() - 1);
      for (size_t i = 1; i < cells.size(); ++i) {
        const PcpDifference difference =
            DifferenceOf(cells[i].pcp, cells.front().pcp, group);
        PlotSeries& bars = panel.series[i - 1];
        bars.name = NameOf(cells[i]);
        bars.style = PlotStyle::kBars;
        bars.Add(static_cast<double>(r), difference.value, difference.interval);
      }
    }
  }
  return panels;
}

TableOutput AblationTable(const BenchmarkData& data, const std::string& out) {
  const PublishedTable published = PublishedAblation();
  TableOutput output = PrintedTable(published);
  output.markdown =
      "## Ablation\n\nPrinted: " + published.caption + ".\n\n" +
      output.markdown +
      "\nTheir detections (HRNet) are not public; the tables below use other "
      "detections, so absolute figures are expected to differ. Differences "
      "from "
      "the baseline are paired on the same frames; intervals use moving blocks "
      "of 25 frames within an actor.\n\n";
  output.json = {{"printed", std::move(output.json)}};
  const std::string figure = "images/ablation.svg";
  const OutputFolder images(out + "/images");
  Progress progress("ablation", RecordingCount(data));
  std::vector<AblatedRecording> ablated;
  Table in_chen({"detections", "part", "without filter", "with filter",
                 "difference, paired"});
  Json in_chen_json;
  for (const Benchmark& benchmark : data.benchmarks) {
    for (const BenchmarkRecording& recording : benchmark.recordings) {
      const LoadedDataset loaded =
          LoadDataset(data, recording, recording.methods.front());
      std::vector<AblationCell> cells = RunAblation(loaded);
      output.markdown += AblationMarkdown(loaded.dataset, cells);
      output.json["measured"].push_back(AblationJson(loaded.dataset, cells));
      ablated.push_back({recording.dataset.name, std::move(cells)});
      AddFilterInChen(data, recording, &in_chen, &in_chen_json);
      progress.Advance();
    }
  }
  WritePlot(AblationPlots(ablated), out + "/" + figure, {1350, 520, 2});
  output.markdown +=
      "![Gain of each component over the baseline](" + figure + ")\n\n";
  if (!in_chen_json.empty()) {
    output.markdown +=
        "### The joints filter in the front end of Chen et al.\n\n"
        "Mean of actors, PCP in %, head `chu`, mean rule:\n\n" +
        in_chen.ToString(TableStyle::kMarkdown) + "\n";
    output.json["filter_in_chen"] = std::move(in_chen_json);
  }
  return output;
}

const std::vector<SweptParameter>& SweptParameters() {
  using Options = TrackerOptions*;
  static const std::vector<SweptParameter> kParameters = {
      {"alpha_2d",
       "px per frame",
       {[](Options o) -> double& {
         return o->association.alpha_2d_px_per_frame;
       }},
       kNoLimit},
      {"alpha_epi",
       "px",
       {[](Options o) -> double& { return o->reconstruction.alpha_epi_px; },
        [](Options o) -> double& { return o->initialisation.alpha_group_px; },
        [](Options o) -> double& { return o->initialisation.alpha_filter_px; }},
       kNoLimit},
      {"tau",
       "frames",
       {[](Options o) -> double& { return o->reconstruction.tau_frames; }},
       kNoLimit},
      {"epsilon",
       "joints of 17",
       {[](Options o) -> double& { return o->association.epsilon_joints; }},
       17.0},
      {"lambda_a",
       "1/frame",
       {[](Options o) -> double& { return o->association.lambda_a_per_frame; }},
       kNoLimit},
  };
  return kParameters;
}

std::vector<double> SweepValues(double value, double largest) {
  std::vector<double> values;
  for (int step = -kStepsPerOctave; step <= kStepsPerOctave; ++step) {
    const double swept =
        value * std::exp2(static_cast<double>(step) / kStepsPerOctave);
    if (swept > largest) {
      if (values.back() < largest) values.push_back(largest);
      break;
    }
    values.push_back(swept);
  }
  return values;
}

Sweep RunSweep(const LoadedDataset& loaded, const SweptParameter& parameter) {
  const TrackerOptions& published = loaded.options.tracker;
  Sweep sweep = {loaded.dataset,
                 parameter.name,
                 parameter.unit,
                 parameter.ValueIn(published),
                 {}};
  const PcpResult paper = ScoreOf(loaded, TracksOf(loaded));
  for (const double value : SweepValues(sweep.paper_value, parameter.largest)) {
    RunOptions options = loaded.options;
    parameter.Set(value, &options.tracker);
    const PcpResult pcp = ScoreOf(loaded, TracksOf(loaded, options));
    sweep.values.push_back({value, MeanOfActors(pcp, PcpGroup::kTotal),
                            MeanOfActorsInterval(pcp, PcpGroup::kTotal),
                            DifferenceOf(pcp, paper)});
  }
  return sweep;
}

std::vector<Plot> SensitivityPlots(const std::vector<Sweep>& sweeps) {
  std::vector<Plot> panels;
  for (const SweptParameter& parameter : SweptParameters()) {
    Plot& panel = panels.emplace_back();
    panel.title = parameter.name;
    panel.x.label = parameter.name + " / published value";
    panel.x.low = 0.45;
    panel.x.high = 2.1;
    panel.y.label = "PCP, mean of actors [%]";
    panel.legend = PlotLegend::kNone;
    double shift = -kBarShift;
    for (const Sweep& sweep : sweeps) {
      if (sweep.parameter != parameter.name) continue;
      // The section's heading names the benchmark, so the legend shows only the
      // rest: "modelled hard" for "Campus, modelled hard".
      const std::string& name = sweep.dataset.name;
      const size_t comma = name.find(", ");
      PlotSeries line = {
          comma == std::string::npos ? name : name.substr(comma + 2),
          PlotStyle::kLinePoints};
      for (const SweptValue& value : sweep.values) {
        line.Add(value.value / sweep.paper_value + shift, value.mean_of_actors,
                 value.interval);
      }
      panel.series.push_back(std::move(line));
      shift += kBarShift;
    }
  }
  panels.back().legend = PlotLegend::kOutside;
  return panels;
}

TableOutput SensitivityTable(const BenchmarkData& data,
                             const std::string& out) {
  TableOutput all;
  all.markdown = "## Sensitivity\n\n";
  const OutputFolder images(out + "/images");
  Progress progress(
      "sensitivity",
      RecordingCount(data) * static_cast<int64_t>(SweptParameters().size()));
  for (const Benchmark& benchmark : data.benchmarks) {
    const std::string name = benchmark.is_shelf() ? "shelf" : "campus";
    const std::string figure = "images/sensitivity_" + name + ".svg";
    std::vector<Sweep> sweeps;
    for (const BenchmarkRecording& recording : benchmark.recordings) {
      const LoadedDataset loaded =
          LoadDataset(data, recording, recording.methods.front());
      for (const SweptParameter& parameter : SweptParameters()) {
        sweeps.push_back(RunSweep(loaded, parameter));
        progress.Advance();
      }
    }
    WritePlot(SensitivityPlots(sweeps), out + "/" + figure, {1350, 760, 3});
    TableOutput one =
        SweepTable(benchmark.is_shelf() ? "Shelf" : "Campus", sweeps, figure);
    all.markdown += one.markdown;
    all.json[name] = std::move(one.json);
  }
  return all;
}

TableOutput RuntimeTable(const BenchmarkData& data) {
  Table table({"measured, ms per frame", "detections", "preparation",
               "affinity and association", "reconstruction", "initialisation",
               "fps of the paper's stages", "estimation", "total",
               "fps, total"});
  const PublishedTable published = PublishedRuntime();
  TableOutput output = PrintedTable(published);
  output.json = {{"printed", std::move(output.json)},
                 {"measured", Json::array()}};
  const std::vector<TimedMethod> methods = TimedMethods(data);
  Progress progress("runtime", static_cast<int64_t>(methods.size()));
  for (const auto& [recording, method] : methods) {
    const LoadedDataset loaded = LoadDataset(data, *recording, method);
    const Timing timing = TimeOf(loaded);
    const auto ms = [&](const char* stage) {
      return Fixed(timing.ms.at(stage), 4);
    };
    const auto fps = [](double frame_ms) {
      return Fixed(1000.0 / frame_ms, 0);
    };
    table.AddRow({method.name, recording->dataset.name, ms("preparation"),
                  ms("association"), ms("reconstruction"), ms("initialisation"),
                  fps(timing.PaperStages()), ms("estimation"), ms("whole"),
                  fps(timing.ms.at("whole"))});
    Json row = {{"method", method.name},
                {"detections", recording->dataset.name},
                {"config", method.config},
                {"set", loaded.dataset.set},
                {"repetitions", timing.repetitions}};
    for (const char* stage : kTimed) {
      row[std::string(stage) + "_ms"] = timing.ms.at(stage);
    }
    output.json["measured"].push_back(std::move(row));
    progress.Advance();
  }
  output.markdown =
      "## Runtime by stage\n\nPrinted: " + published.caption + ".\n\n" +
      output.markdown +
      "\nMeasured here: processor time of one thread, detections in memory, "
      "median of up to " +
      std::to_string(kRepetitions) +
      " runs over the recording. Languages, machines and detections differ, so "
      "only orders of magnitude are comparable. The paper's stages: affinity, "
      "association, reconstruction and initialisation. `preparation`: "
      "conversion of skeletons and undistortion; `estimation`: the smoothing "
      "(paper mode) or the "
      "window's solver. The batch solves when the recording has ended, so its "
      "solver is only in `total`, as are second passes.\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace kinegraph
