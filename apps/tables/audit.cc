#include "apps/tables/audit.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"
#include "core/io/detections/view_pairing.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

// The audit says something of these, in this order.
constexpr std::array<AuditVerdict, 5> kVerdicts = {
    AuditVerdict::kContradicted, AuditVerdict::kEstimateWrong,
    AuditVerdict::kDisputed, AuditVerdict::kUndecided,
    AuditVerdict::kNotAuditable};

int64_t HeadlineCount(const std::set<PartKey>& parts, const PcpResult& pcp) {
  const std::vector<int64_t> actors = pcp.HeadlineActors();
  return std::count_if(parts.begin(), parts.end(), [&](const PartKey& key) {
    return std::find(actors.begin(), actors.end(), std::get<0>(key)) !=
           actors.end();
  });
}

std::string MeanCell(const PcpResult& pcp) {
  return Fixed(MeanOfActors(pcp, PcpGroup::kTotal), 2) + " " +
         IntervalCell(MeanOfActorsInterval(pcp, PcpGroup::kTotal), 2) + " (" +
         std::to_string(PooledParts(pcp, PcpGroup::kTotal).count) + "/" +
         std::to_string(PooledParts(pcp, PcpGroup::kTotal).total) + ")";
}

Json MeanJson(const PcpResult& pcp) {
  const Share pooled = PooledParts(pcp, PcpGroup::kTotal);
  return {{"mean_of_actors", MeanOfActors(pcp, PcpGroup::kTotal)},
          {"interval", ToJson(MeanOfActorsInterval(pcp, PcpGroup::kTotal))},
          {"right", pooled.count},
          {"parts", pooled.total}};
}

std::set<int> ViewIndices(const std::vector<std::string>& view_names,
                          const std::vector<std::string>& named) {
  std::set<int> indices;
  for (size_t v = 0; v < view_names.size(); ++v) {
    if (std::find(named.begin(), named.end(), view_names[v]) != named.end()) {
      indices.insert(static_cast<int>(v));
    }
  }
  return indices;
}

struct NamedOptions {
  std::string changed;
  AuditOptions options;
};

// The thresholds, one changed at a time.
std::vector<NamedOptions> Variations() {
  std::vector<NamedOptions> variations;
  const auto add = [&](const std::string& name, double AuditOptions::*field,
                       double value) {
    AuditOptions options;
    options.*field = value;
    variations.push_back({name + " " + Fixed(value, 3), options});
  };
  add("min_confidence", &AuditOptions::min_confidence, 0.3);
  add("min_confidence", &AuditOptions::min_confidence, 0.7);
  add("agree_share", &AuditOptions::agree_share, 0.15);
  add("agree_share", &AuditOptions::agree_share, 0.3);
  add("disagree_share", &AuditOptions::disagree_share, 0.3);
  add("disagree_share", &AuditOptions::disagree_share, 0.5);
  return variations;
}

std::string Described(const AuditOptions& options) {
  return "Rules. In each view the detection of the annotated person is the one "
         "nearest to their projected annotation over the body joints that are "
         "not the part's ends (at least " +
         std::to_string(options.min_other_joints) + ", mean at most " +
         Fixed(100.0 * options.max_person_share, 0) +
         " % of the image width, nearer to nobody else). A view counts when "
         "both detected ends have a confidence of " +
         Fixed(options.min_confidence, 2) +
         " or more. It agrees with a pose when the ends lie on average "
         "within " +
         Fixed(options.agree_share, 3) +
         " of the part's length from the rays through the detected ends, and "
         "does not agree beyond " +
         Fixed(options.disagree_share, 3) +
         " (what an error at PCP's limit, half the length, shows on average in "
         "one view: sqrt(2/3) of it; agreement asks for half of that). "
         "*Contradicted*: at least " +
         std::to_string(options.min_views) +
         " views agree with the estimate and not with the annotation, none the "
         "other way round. *Held-out confirmed*: that many of them also agree "
         "with the estimate made without them. *Refuted by the views alone*: "
         "the ends triangulated from all views that count agree with each of "
         "them, and PCP would count the annotation wrong against them; no "
         "estimate takes part. Heads and torsos are not auditable: no detector "
         "finds their ends.\n\n";
}

std::string EndsText(const ViewEvidence& view) {
  std::string text = ToString(view.verdict);
  if (view.verdict == ViewVerdict::kNoDetection) return text;
  text += ", confidence " + Fixed(view.confidence[0], 2) + " and " +
          Fixed(view.confidence[1], 2);
  if (!view.confident()) return text;
  text += ", estimate " + Fixed(view.estimate_mean_px, 1) + " px, annotation " +
          Fixed(view.annotation_mean_px, 1) + " px";
  if (view.held_out_mean_px) {
    text += ", estimate without it " + Fixed(*view.held_out_mean_px, 1) + " px";
  }
  return text;
}

Json PixelJson(const std::optional<Eigen::Vector2d>& px) {
  return px ? Json{px->x(), px->y()} : Json(nullptr);
}

template <typename T>
Json OptionalJson(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json ViewJson(const ViewEvidence& view, const std::string& name) {
  Json json = {{"view", name}, {"verdict", ToString(view.verdict)}};
  if (view.verdict == ViewVerdict::kNoDetection) return json;
  json["detection"] = view.detection_idx;
  json["confidence"] = {view.confidence[0], view.confidence[1]};
  const auto pair = [](const Ends<std::optional<Eigen::Vector2d>>& px) {
    return Json{PixelJson(px[0]), PixelJson(px[1])};
  };
  json["detected_px"] = pair(view.detected_px);
  json["estimate_px"] = pair(view.estimate_px);
  json["annotation_px"] = pair(view.annotation_px);
  if (!view.confident()) return json;
  json["estimate_mean_px"] = view.estimate_mean_px;
  json["annotation_mean_px"] = view.annotation_mean_px;
  json["estimate_m"] = view.estimate_m;
  json["annotation_m"] = view.annotation_m;
  json["estimate_without_it_mean_px"] = OptionalJson(view.held_out_mean_px);
  json["estimate_without_it_m"] = OptionalJson(view.held_out_m);
  return json;
}

// What the views say without any estimate.
void AddViewsAlone(const AuditResult& audit, const PcpResult& pcp,
                   TableOutput* output) {
  const std::set<PartKey>& refuted = audit.refuted_by_views;
  output->markdown +=
      "Views alone, no estimate: of " + std::to_string(audit.limbs) +
      " annotated limbs " + std::to_string(audit.limbs_seen) +
      " were seen by enough confident views; in " +
      std::to_string(audit.limbs_agreed) + " these agree on one limb; in " +
      std::to_string(refuted.size()) + " that limb refutes the annotation (" +
      std::to_string(HeadlineCount(refuted, pcp)) +
      " of the headline's actors; in " +
      std::to_string(audit.refuted_by_three_views.size()) +
      " three or more views took part).\n\n";
  output->json["views_alone"] = {
      {"limbs", audit.limbs},
      {"seen", audit.limbs_seen},
      {"agreed", audit.limbs_agreed},
      {"refuted", refuted.size()},
      {"refuted_by_three_or_more", audit.refuted_by_three_views.size()}};
}

// Adds a row with the number of lost parts by verdict; returns it as JSON.
Json AddVerdictRow(const std::string& name, const AuditResult& audit,
                   Table* table) {
  std::vector<std::string> cells = {name, std::to_string(audit.cases.size())};
  Json json = {{"estimate", name}, {"lost", audit.cases.size()}};
  for (const AuditVerdict verdict : kVerdicts) {
    cells.push_back(std::to_string(audit.Count(verdict)));
    json[ToString(verdict)] = audit.Count(verdict);
  }
  const auto by_views =
      std::count_if(audit.cases.begin(), audit.cases.end(),
                    [](const AuditCase& one) { return one.refuted_by_views; });
  cells.push_back(std::to_string(audit.HeldOutConfirmed().size()));
  cells.push_back(std::to_string(by_views));
  json["held_out_confirmed"] = audit.HeldOutConfirmed().size();
  json["refuted_by_views"] = by_views;
  table->AddRow(std::move(cells));
  return json;
}

void AddVerdicts(const AuditedBenchmark& audited, TableOutput* output) {
  std::vector<std::string> header = {"estimate", "lost parts"};
  for (const AuditVerdict verdict : kVerdicts) {
    header.emplace_back(ToString(verdict));
  }
  header.insert(header.end(),
                {"held-out confirmed", "refuted by the views alone"});
  Table table(header);
  for (const AuditedEstimate& estimate : audited.estimates) {
    output->json["estimates"].push_back(
        AddVerdictRow(estimate.method, estimate.audit, &table));
  }
  for (const auto& variation : audited.variations) {
    output->json["variations"].push_back(AddVerdictRow(
        audited.estimates.front().method + ", " + variation.changed,
        variation.audit, &table));
  }
  output->markdown +=
      "Lost parts of all annotated actors by verdict; below, one threshold "
      "changed at a time:\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
}

// An audited estimate's PCP with its annotations and without some.
Json AddOwnScores(const AuditedEstimate& estimate, const AuditResult& first,
                  Table* table) {
  const PcpResult contradicted =
      WithoutParts(estimate.pcp, estimate.audit.Contradicted());
  const PcpResult confirmed =
      WithoutParts(estimate.pcp, estimate.audit.HeldOutConfirmed());
  const PcpResult alone = WithoutParts(estimate.pcp, first.refuted_by_views);
  const PcpResult by_three =
      WithoutParts(estimate.pcp, first.refuted_by_three_views);
  table->AddRow({estimate.method, MeanCell(estimate.pcp),
                 MeanCell(contradicted), MeanCell(confirmed), MeanCell(alone),
                 MeanCell(by_three)});
  return {{"estimate", estimate.method},
          {"as_scored", MeanJson(estimate.pcp)},
          {"without_contradicted_annotations", MeanJson(contradicted)},
          {"without_held_out_confirmed", MeanJson(confirmed)},
          {"without_refuted_by_views_alone", MeanJson(alone)},
          {"without_refuted_by_three_views", MeanJson(by_three)}};
}

// The same of tracks that were not audited: without what the views refute.
Json AddTrackedScores(const TrackedRow& row, const PcpResult& pcp,
                      const AuditResult& first, Table* table) {
  const PcpResult alone = WithoutParts(pcp, first.refuted_by_views);
  const PcpResult by_three = WithoutParts(pcp, first.refuted_by_three_views);
  const std::string name =
      row.take.empty() ? row.method : row.method + " (" + row.take + ")";
  table->AddRow(
      {name, MeanCell(pcp), "-", "-", MeanCell(alone), MeanCell(by_three)});
  return {{"estimate", name},
          {"as_scored", MeanJson(pcp)},
          {"without_refuted_by_views_alone", MeanJson(alone)},
          {"without_refuted_by_three_views", MeanJson(by_three)}};
}

void AddScores(const AuditedBenchmark& audited,
               const std::vector<TrackedRow>& rows, const TrackSequence& truth,
               TableOutput* output) {
  const AuditedEstimate& first = audited.estimates.front();
  Table table({"estimate", "PCP as scored", "without contradicted annotations",
               "without those held-out confirmed",
               "without those the views alone refute", "three or more views"});
  std::set<std::string> shown;
  for (const AuditedEstimate& estimate : audited.estimates) {
    output->json["scores"].push_back(
        AddOwnScores(estimate, first.audit, &table));
    shown.insert(estimate.method);
  }
  for (const TrackedRow& row : rows) {
    if (row.ours && shown.count(row.method) > 0 &&
        row.detections_note == audited.detections_note) {
      continue;
    }
    output->json["scores"].push_back(AddTrackedScores(
        row, EvaluatePcp(truth, row.tracks, first.pcp.protocol), first.audit,
        &table));
  }
  output->markdown +=
      "**PCP with annotations left out** (mean of actors, 95 % interval, "
      "pooled counts): separate figures, not to be set beside published ones. "
      "The second and third leave out annotations that speak against this very "
      "estimate, so they can only rise, and differ from row to row; the last "
      "two leave out the same parts, lost or right, for everybody.\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
}

// The runs of a take without each of its views in turn.
std::vector<TrackSequence> RunsWithoutEachView(LoadedDataset* loaded) {
  std::vector<TrackSequence> runs;
  for (const std::string& view : loaded->detections.header.view_names) {
    loaded->request.without_cameras = {view};
    runs.push_back(TracksOf(*loaded));
  }
  return runs;
}

}  // namespace

int64_t AuditStepCount(const Benchmark& benchmark) {
  return static_cast<int64_t>(benchmark.audit.methods.size() +
                              benchmark.audit.results.size());
}

AuditedBenchmark RunAudit(const std::string& title, const Benchmark& benchmark,
                          const std::string& data_folder,
                          const std::string& extra_set,
                          const std::function<void()>& progress) {
  const AuditPlan& plan = benchmark.audit;
  AuditedBenchmark audited;
  audited.title = title;
  audited.detections_note = plan.dataset.detections_note;
  audited.caution = plan.caution;
  Dataset dataset = plan.dataset;
  dataset.set = JoinSets(dataset.set, extra_set);
  const LoadedDataset witnesses = LoadDataset(dataset, data_folder);
  audited.detections = witnesses.detections;
  audited.view_names = audited.detections.header.view_names;
  audited.cameras =
      CamerasOfViews(audited.view_names, witnesses.request.cameras,
                     witnesses.options.cameras.map);
  AuditInput input;
  input.truth = &witnesses.truth;
  input.detections = &audited.detections;
  input.cameras = &audited.cameras;
  input.without_views = ViewIndices(audited.view_names, plan.without_views);
  const auto audit = [&](const std::string& method, const std::string& made_by,
                         const TrackSequence& tracks) {
    AuditedEstimate estimate;
    estimate.method = method;
    estimate.made_by = made_by;
    estimate.pcp = EvaluatePcp(witnesses.truth, tracks, plan.dataset.protocol);
    input.tracks = &tracks;
    input.pcp = &estimate.pcp;
    estimate.audit = AuditAnnotation(input);
    if (audited.estimates.empty()) {
      for (const NamedOptions& variation : Variations()) {
        audited.variations.push_back(
            {variation.changed, AuditAnnotation(input, variation.options)});
      }
    }
    audited.estimates.push_back(std::move(estimate));
    progress();
  };
  for (const Method& method : plan.methods) {
    dataset.config = method.config;
    dataset.set = JoinSets(method.set, extra_set);
    LoadedDataset loaded = LoadDataset(dataset, data_folder);
    const TrackSequence tracks = TracksOf(loaded);
    const std::vector<TrackSequence> held_out = RunsWithoutEachView(&loaded);
    input.held_out.clear();
    for (const TrackSequence& run : held_out) input.held_out.push_back(&run);
    audit(method.name, "configs/" + method.config, tracks);
    input.held_out.clear();
  }
  for (const ResultFile& result : plan.results) {
    TrackReadOptions options;
    options.frame_rate_hz = witnesses.options.input.frame_rate_hz;
    audit(result.method, result.path,
          ReadTracks(data_folder + "/" + result.path, options));
  }
  return audited;
}

TableOutput AuditTable(const AuditedBenchmark& audited,
                       const std::vector<TrackedRow>& rows,
                       const TrackSequence& truth, const std::string& page) {
  const AuditedEstimate& first = audited.estimates.front();
  TableOutput output;
  output.json["detections"] = audited.detections_note;
  output.json["caution"] = audited.caution;
  output.markdown = "### " + audited.title +
                    "\n\nWitnesses: " + audited.detections_note + ". " +
                    audited.caution + ".\n\nCases, drawn in each view: `" +
                    page + "`.\n\n";
  AddViewsAlone(first.audit, first.pcp, &output);
  AddVerdicts(audited, &output);
  AddScores(audited, rows, truth, &output);
  return output;
}

std::string AuditCasesMarkdown(const AuditedBenchmark& audited) {
  std::string text = "# Annotation audit, " + audited.title +
                     "\n\nWitnesses: " + audited.detections_note + ". " +
                     audited.caution + ".\n\n" +
                     Described(audited.estimates.front().audit.options);
  for (const AuditedEstimate& estimate : audited.estimates) {
    text += "## " + estimate.method + "\n\n";
    std::vector<std::string> header = {"part", "frame", "actor", "verdict"};
    header.insert(header.end(), audited.view_names.begin(),
                  audited.view_names.end());
    Table table(std::move(header));
    for (const AuditCase& one : estimate.audit.cases) {
      std::string verdict = ToString(one.verdict);
      if (one.held_out_confirmed) verdict += ", held-out confirmed";
      if (one.refuted_by_views) verdict += ", refuted by the views alone";
      std::vector<std::string> cells = {
          PcpPartName(one.lost.part), std::to_string(one.lost.frame),
          std::to_string(one.lost.actor), verdict};
      for (size_t v = 0; v < audited.view_names.size(); ++v) {
        const auto view = std::find_if(
            one.views.begin(), one.views.end(), [&](const ViewEvidence& seen) {
              return seen.view_idx == static_cast<int>(v);
            });
        cells.push_back(view == one.views.end() ? "-" : EndsText(*view));
      }
      table.AddRow(std::move(cells));
    }
    text += table.ToString(TableStyle::kMarkdown) + "\n";
  }
  return text;
}

Json AuditCasesJson(const AuditedBenchmark& audited) {
  const AuditOptions& options = audited.estimates.front().audit.options;
  Json json = {{"witnesses", audited.detections_note},
               {"caution", audited.caution},
               {"options",
                {{"min_confidence", options.min_confidence},
                 {"max_person_share", options.max_person_share},
                 {"min_other_joints", options.min_other_joints},
                 {"agree_share", options.agree_share},
                 {"disagree_share", options.disagree_share},
                 {"min_views", options.min_views}}}};
  for (const AuditedEstimate& estimate : audited.estimates) {
    Json cases = Json::array();
    for (const AuditCase& one : estimate.audit.cases) {
      Json out = {{"frame", one.lost.frame},
                  {"actor", one.lost.actor},
                  {"part", PcpPartName(one.lost.part)},
                  {"verdict", ToString(one.verdict)},
                  {"held_out_confirmed", one.held_out_confirmed},
                  {"refuted_by_views", one.refuted_by_views},
                  {"lost_because", ToString(one.lost.reason())},
                  {"length_m", one.lost.length_m},
                  {"first_error_m", OptionalJson(one.lost.first_error_m)},
                  {"second_error_m", OptionalJson(one.lost.second_error_m)},
                  {"views", Json::array()}};
      for (const ViewEvidence& view : one.views) {
        out["views"].push_back(
            ViewJson(view, audited.view_names[view.view_idx]));
      }
      cases.push_back(std::move(out));
    }
    Json refuted = Json::array();
    for (const auto& [actor, frame, part] : estimate.audit.refuted_by_views) {
      refuted.push_back(
          {{"actor", actor}, {"frame", frame}, {"part", PcpPartName(part)}});
    }
    json["estimates"].push_back(
        {{"method", estimate.method},
         {"source", estimate.made_by},
         {"cases", std::move(cases)},
         {"refuted_by_views_alone", std::move(refuted)}});
  }
  return json;
}

}  // namespace kinegraph
