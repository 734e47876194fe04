#include "apps/tables/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"

namespace kinegraph {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr int kStepsPerOctave = 4;
// Between the error bars of two recordings, so that none hides another.
constexpr double kBarShift = 0.012;

PcpResult ScoreOf(const LoadedDataset& loaded, const RunOptions& options) {
  return EvaluatePcp(loaded.truth, TracksOf(loaded, options),
                     loaded.dataset.protocol);
}

Sweep RunSweep(const LoadedDataset& loaded, const SweptParameter& parameter) {
  Sweep sweep;
  sweep.recording = loaded.dataset.name;
  sweep.detections_note = loaded.dataset.detections_note;
  sweep.parameter = parameter.name;
  sweep.unit = parameter.unit;
  sweep.paper_value = parameter.get(loaded.options.tracker);
  const PcpResult paper = ScoreOf(loaded, loaded.options);
  const double paper_mean = MeanOfActors(paper, PcpGroup::kTotal);
  for (const double value : SweepValues(sweep.paper_value, parameter.largest)) {
    RunOptions options = loaded.options;
    parameter.set(value, &options.tracker);
    const PcpResult pcp = ScoreOf(loaded, options);
    SweptValue swept;
    swept.value = value;
    swept.mean_of_actors = MeanOfActors(pcp, PcpGroup::kTotal);
    swept.interval = MeanOfActorsInterval(pcp, PcpGroup::kTotal);
    swept.difference = swept.mean_of_actors - paper_mean;
    swept.difference_interval =
        MeanOfActorsDifference(pcp, paper, PcpGroup::kTotal);
    sweep.values.push_back(swept);
  }
  return sweep;
}

bool Told(const SweptValue& value) {
  return value.difference_interval.low > 0.0 ||
         value.difference_interval.high < 0.0;
}

// The values that are told from the published one, with their differences.
std::string ToldValues(const Sweep& sweep) {
  std::string told;
  for (const SweptValue& value : sweep.values) {
    if (!Told(value)) continue;
    told += (told.empty() ? "" : ", ") + Fixed(value.value, 1) + " (" +
            Fixed(value.difference, 2) + ")";
  }
  return told;
}

Json SweepJson(const Sweep& sweep) {
  Json json = {{"detections", sweep.recording},
               {"detections_note", sweep.detections_note},
               {"parameter", sweep.parameter},
               {"unit", sweep.unit},
               {"published", sweep.paper_value}};
  for (const SweptValue& value : sweep.values) {
    json["values"].push_back(
        {{"value", value.value},
         {"mean_of_actors", value.mean_of_actors},
         {"interval", ToJson(value.interval)},
         {"difference", value.difference},
         {"difference_interval", ToJson(value.difference_interval)}});
  }
  return json;
}

}  // namespace

const std::vector<SweptParameter>& SweptParameters() {
  static const std::vector<SweptParameter> kParameters = {
      {"alpha_2d", "px per frame",
       [](const TrackerOptions& o) {
         return o.association.alpha_2d_px_per_frame;
       },
       [](double value, TrackerOptions* o) {
         o->association.alpha_2d_px_per_frame = value;
       },
       kNoLimit},
      // One parameter in the paper; where the authors' code has three, all are
      // scaled alike.
      {"alpha_epi", "px",
       [](const TrackerOptions& o) { return o.reconstruction.alpha_epi_px; },
       [](double value, TrackerOptions* o) {
         const double factor = value / o->reconstruction.alpha_epi_px;
         o->reconstruction.alpha_epi_px = value;
         o->initialisation.alpha_group_px *= factor;
         o->initialisation.alpha_filter_px *= factor;
       },
       kNoLimit},
      {"tau", "frames",
       [](const TrackerOptions& o) { return o.reconstruction.tau_frames; },
       [](double value, TrackerOptions* o) {
         o->reconstruction.tau_frames = value;
       },
       kNoLimit},
      {"epsilon", "joints of 17",
       [](const TrackerOptions& o) { return o.association.epsilon_joints; },
       [](double value, TrackerOptions* o) {
         o->association.epsilon_joints = value;
       },
       17.0},
      {"lambda_a", "1/frame",
       [](const TrackerOptions& o) { return o.association.lambda_a_per_frame; },
       [](double value, TrackerOptions* o) {
         o->association.lambda_a_per_frame = value;
       },
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

int64_t SweepCount(const Benchmark& benchmark) {
  return static_cast<int64_t>(benchmark.recordings.size() *
                              SweptParameters().size());
}

std::vector<Sweep> RunSensitivity(const Benchmark& benchmark,
                                  const std::string& data_folder,
                                  const std::string& extra_set,
                                  const std::function<void()>& progress) {
  std::vector<Sweep> sweeps;
  for (const BenchmarkRecording& recording : benchmark.recordings) {
    Dataset dataset = recording.dataset;
    dataset.set = JoinSets(dataset.set, extra_set);
    const LoadedDataset loaded = LoadDataset(dataset, data_folder);
    for (const SweptParameter& parameter : SweptParameters()) {
      sweeps.push_back(RunSweep(loaded, parameter));
      progress();
    }
  }
  return sweeps;
}

std::vector<Plot> SensitivityPlots(const std::vector<Sweep>& sweeps) {
  std::vector<Plot> panels;
  for (const SweptParameter& parameter : SweptParameters()) {
    Plot panel;
    panel.title = parameter.name;
    panel.x.label = parameter.name + ", times its published value";
    panel.x.low = 0.45;
    panel.x.high = 2.1;
    panel.y.label = "PCP, mean of actors [%]";
    double shift = -kBarShift;
    for (const Sweep& sweep : sweeps) {
      if (sweep.parameter != parameter.name) continue;
      PlotSeries line;
      // The set is the figure's: "modelled hard" of "Campus, modelled hard".
      const size_t comma = sweep.recording.find(", ");
      line.name = comma == std::string::npos
                      ? sweep.recording
                      : sweep.recording.substr(comma + 2);
      line.style = PlotStyle::kLinePoints;
      for (const SweptValue& value : sweep.values) {
        line.x.push_back(value.value / sweep.paper_value + shift);
        line.y.push_back(value.mean_of_actors);
        line.y_low.push_back(value.interval.low);
        line.y_high.push_back(value.interval.high);
      }
      shift += kBarShift;
      panel.series.push_back(std::move(line));
    }
    panel.legend = panels.size() + 1 == SweptParameters().size()
                       ? PlotLegend::kOutside
                       : PlotLegend::kNone;
    panels.push_back(std::move(panel));
  }
  return panels;
}

TableOutput SensitivityTable(const std::string& title,
                             const std::vector<Sweep>& sweeps,
                             const std::string& figure) {
  Table table({"detections", "parameter", "published", "swept", "least PCP",
               "at", "greatest PCP", "at", "told from the published value at"});
  TableOutput output;
  output.json = Json::array();
  for (const Sweep& sweep : sweeps) {
    const auto by_mean = [](const SweptValue& a, const SweptValue& b) {
      return a.mean_of_actors < b.mean_of_actors;
    };
    const auto [least, greatest] =
        std::minmax_element(sweep.values.begin(), sweep.values.end(), by_mean);
    const bool flat = least->mean_of_actors == greatest->mean_of_actors;
    const std::string told = ToldValues(sweep);
    table.AddRow({sweep.recording, sweep.parameter + ", " + sweep.unit,
                  Fixed(sweep.paper_value, 1),
                  Fixed(sweep.values.front().value, 1) + " to " +
                      Fixed(sweep.values.back().value, 1),
                  Fixed(least->mean_of_actors, 2),
                  flat ? "-" : Fixed(least->value, 1),
                  Fixed(greatest->mean_of_actors, 2),
                  flat ? "-" : Fixed(greatest->value, 1),
                  told.empty() ? "no value" : told});
    output.json.push_back(SweepJson(sweep));
  }
  std::string notes;
  for (size_t i = 0; i < sweeps.size(); ++i) {
    if (i > 0 && sweeps[i].recording == sweeps[i - 1].recording) continue;
    notes +=
        "- " + sweeps[i].recording + ": " + sweeps[i].detections_note + ".\n";
  }
  output.markdown =
      "### " + title +
      "\n\nEach parameter alone from half to twice its value, the others as "
      "published; head `chu`, mean rule. A difference is told when its paired "
      "95 % interval leaves out 0; of so many values "
      "some would be told by chance alone. No value was chosen by "
      "this.\n\n" +
      notes + "\n" + table.ToString(TableStyle::kMarkdown) +
      "\n![PCP over each "
      "parameter](" +
      figure + ")\n\n";
  return output;
}

}  // namespace kinegraph
