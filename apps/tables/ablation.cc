#include "apps/tables/ablation.h"

#include <string>
#include <utility>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"

namespace kinegraph {
namespace {

std::string NameOf(const AblationCell& cell) {
  const std::string affinity =
      cell.affinity == AffinityKind::kPart ? "part-aware" : "body-aware";
  return affinity + (cell.joints_filter ? ", joints filter" : ", no filter");
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
      cell.pcp = EvaluatePcp(loaded.truth, tracks, loaded.dataset.protocol);
      IdentityOptions identity;
      identity.frames = loaded.dataset.protocol.frames;
      cell.identity = EvaluateIdentity(loaded.truth, tracks, identity);
      if (!cells.empty()) {
        const PcpResult& baseline = cells.front().pcp;
        cell.difference = MeanOfActors(cell.pcp, PcpGroup::kTotal) -
                          MeanOfActors(baseline, PcpGroup::kTotal);
        cell.difference_interval =
            MeanOfActorsDifference(cell.pcp, baseline, PcpGroup::kTotal);
      }
      cells.push_back(std::move(cell));
    }
  }
  return cells;
}

std::optional<FilterInChen> RunFilterInChen(const BenchmarkRecording& recording,
                                            const std::string& data_folder,
                                            const std::string& extra_set) {
  FilterInChen pair;
  pair.recording = recording.dataset.name;
  int found = 0;
  for (const Method& method : recording.methods) {
    const bool with = method.name == kChenWithFilter;
    if (!with && method.name != kChen) continue;
    Dataset dataset = recording.dataset;
    dataset.config = method.config;
    dataset.set = JoinSets(method.set, extra_set);
    const LoadedDataset loaded = LoadDataset(dataset, data_folder);
    (with ? pair.with : pair.without) =
        EvaluatePcp(loaded.truth, TracksOf(loaded), dataset.protocol);
    ++found;
  }
  if (found != 2) return std::nullopt;
  return pair;
}

TableOutput FilterInChenTable(const std::vector<FilterInChen>& recordings) {
  TableOutput output;
  Table table({"detections", "part", "without", "with the filter",
               "difference, paired"});
  for (const FilterInChen& pair : recordings) {
    for (const PcpGroup group : {PcpGroup::kTotal, PcpGroup::kLowerArms}) {
      const double without = MeanOfActors(pair.without, group);
      const double with = MeanOfActors(pair.with, group);
      const Interval interval =
          MeanOfActorsDifference(pair.with, pair.without, group);
      table.AddRow(
          {pair.recording, ToString(group), Fixed(without, 2), Fixed(with, 2),
           Fixed(with - without, 2) + " " + IntervalCell(interval, 2)});
      output.json.push_back({{"detections", pair.recording},
                             {"part", ToString(group)},
                             {"without", without},
                             {"with", with},
                             {"difference", with - without},
                             {"interval", ToJson(interval)}});
    }
  }
  output.markdown =
      "### The joints filter in the front end of Chen et al.\n\n"
      "Mean of actors, PCP in %, head `chu`, mean rule:\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

std::vector<Plot> AblationPlots(
    const std::vector<AblatedRecording>& recordings) {
  std::vector<Plot> panels;
  for (const PcpGroup group : {PcpGroup::kTotal, PcpGroup::kLowerArms}) {
    Plot panel;
    panel.title = group == PcpGroup::kTotal
                      ? "PCP, mean of actors, against body-aware, no filter"
                      : "Lower arms";
    panel.y.label = "difference [points of PCP]";
    panel.legend = PlotLegend::kBelow;
    for (const AblatedRecording& recording : recordings) {
      panel.x.categories.push_back(recording.name);
      panel.series.resize(recording.cells.size() - 1);
      const PcpResult& baseline = recording.cells.front().pcp;
      for (size_t i = 1; i < recording.cells.size(); ++i) {
        const AblationCell& cell = recording.cells[i];
        const Interval interval =
            MeanOfActorsDifference(cell.pcp, baseline, group);
        PlotSeries& bars = panel.series[i - 1];
        bars.name = NameOf(cell);
        bars.style = PlotStyle::kBars;
        bars.x.push_back(static_cast<double>(panel.x.categories.size() - 1));
        bars.y.push_back(MeanOfActors(cell.pcp, group) -
                         MeanOfActors(baseline, group));
        bars.y_low.push_back(interval.low);
        bars.y_high.push_back(interval.high);
      }
    }
    panels.push_back(std::move(panel));
  }
  return panels;
}

std::string AblationMarkdown(const LoadedDataset& loaded,
                             const std::vector<AblationCell>& cells) {
  std::vector<std::string> header = {"front end"};
  for (const int64_t actor : cells.front().pcp.HeadlineActors()) {
    header.push_back("actor " + std::to_string(actor));
  }
  for (const char* column :
       {"mean", "95 % interval", "lower arms", "torso", "against the baseline",
        "95 % interval of the difference", "identities", "switches"}) {
    header.emplace_back(column);
  }
  Table table(std::move(header));
  for (const AblationCell& cell : cells) {
    std::vector<std::string> row = {NameOf(cell)};
    for (const int64_t actor : cell.pcp.HeadlineActors()) {
      row.push_back(PercentCell(CountParts(cell.pcp, actor, PcpGroup::kTotal)));
    }
    row.push_back(Fixed(MeanOfActors(cell.pcp, PcpGroup::kTotal), 2));
    row.push_back(
        IntervalCell(MeanOfActorsInterval(cell.pcp, PcpGroup::kTotal), 2));
    row.push_back(Fixed(MeanOfActors(cell.pcp, PcpGroup::kLowerArms), 2));
    row.push_back(Fixed(MeanOfActors(cell.pcp, PcpGroup::kTorso), 2));
    const bool baseline = &cell == &cells.front();
    row.push_back(baseline ? "-" : Fixed(cell.difference, 2));
    row.push_back(baseline ? "-" : IntervalCell(cell.difference_interval, 2));
    row.push_back(std::to_string(cell.identity.identities));
    row.push_back(std::to_string(cell.identity.switches));
    table.AddRow(std::move(row));
  }
  return "### " + loaded.dataset.name +
         "\n\nDetections: " + loaded.dataset.detections_note +
         ". Configuration: `configs/" + loaded.dataset.config +
         "`. PCP in %, head conversion `" +
         ToString(loaded.dataset.protocol.head) +
         "`, mean rule, counts beside.\n\n" +
         table.ToString(TableStyle::kMarkdown) + "\n";
}

Json AblationJson(const LoadedDataset& loaded,
                  const std::vector<AblationCell>& cells) {
  Json out;
  out["dataset"] = loaded.dataset.name;
  out["detections"] = loaded.dataset.detections_note;
  out["config"] = loaded.dataset.config;
  for (const AblationCell& cell : cells) {
    Json row;
    row["affinity"] = cell.affinity == AffinityKind::kPart ? "part" : "body";
    row["joints_filter"] = cell.joints_filter;
    for (const int64_t actor : cell.pcp.Actors()) {
      const Share share = CountParts(cell.pcp, actor, PcpGroup::kTotal);
      row["actors"][std::to_string(actor)] = {{"right", share.count},
                                              {"parts", share.total},
                                              {"percent", share.percent()}};
    }
    for (const PcpGroup group : kPcpGroups) {
      row["mean_of_actors"][ToString(group)] = MeanOfActors(cell.pcp, group);
    }
    const Interval mean = MeanOfActorsInterval(cell.pcp, PcpGroup::kTotal);
    row["mean_interval"] = {mean.low, mean.high};
    row["difference"] = cell.difference;
    row["difference_interval"] = {cell.difference_interval.low,
                                  cell.difference_interval.high};
    row["identities"] = cell.identity.identities;
    row["switches"] = cell.identity.switches;
    out["cells"].push_back(std::move(row));
  }
  return out;
}

}  // namespace kinegraph
