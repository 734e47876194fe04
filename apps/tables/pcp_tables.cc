#include "apps/tables/pcp_tables.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"
#include "core/base/error.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

constexpr const char* kPrinted = "as printed in the paper";
constexpr size_t kMaxFrameRuns = 12;
constexpr PcpGroup kAllParts = PcpGroup::kTotal;
constexpr EndpointRule kEndpointRules[] = {EndpointRule::kMean,
                                           EndpointRule::kEach};

// ---- Tracks

TrackedRow ReadResult(const ResultFile& result, const std::string& data_folder,
                      double frame_rate_hz) {
  TrackReadOptions options;
  options.frame_rate_hz = frame_rate_hz;
  TrackedRow row;
  row.method = result.method;
  row.recording = result.same_recording;
  row.detections_note = result.detections_note;
  row.made_by = "`" + result.path + "`";
  row.remark = result.remark;
  row.tracks = ReadTracks(data_folder + "/" + result.path, options);
  return row;
}

// Detections with other frame numbers would otherwise only cause a bad score.
void RequireScoredFrames(const LoadedDataset& loaded) {
  const Dataset& dataset = loaded.dataset;
  for (const DetectionFrame& frame : loaded.detections.frames) {
    if (!ContainsFrame(dataset.protocol.frames, frame.frame)) continue;
    if (!PeopleOf(FindFrame(loaded.truth, frame.frame)).empty()) return;
  }
  throw InputError(dataset.detections, "",
                   "no detection in any annotated frame that is scored; frame "
                   "numbers count from 0 as in actorsGT.mat");
}

TrackedRow TrackMethod(const LoadedDataset& loaded, const Method& method) {
  TrackedRow row;
  row.method = method.name;
  row.recording = loaded.dataset.name;
  row.detections_note = loaded.dataset.detections_note;
  row.made_by = "`configs/" + method.config + "`";
  if (!method.set.empty()) row.made_by += " with `" + method.set + "`";
  row.ours = true;
  row.tracks = TracksOf(loaded);
  return row;
}

PcpResult ScoreByOwnRules(const OwnRules& own, const std::string& folder) {
  TrackReadOptions options;
  if (own.protocol.stored_zeros_are_positions) {
    options.stored_zeros = StoredZeros::kKeep;
  }
  return EvaluatePcp(ReadTracks(folder + "/" + own.ground_truth, options),
                     ReadTracks(folder + "/" + own.result.path, options),
                     own.protocol);
}

// ---- Scores

// All head conversions, the paper's first; VoxelPose's in the form for the
// benchmark's data set.
std::vector<HeadConversion> HeadConversionsOf(const Benchmark& benchmark) {
  return {HeadConversion::kChu, HeadConversion::kMvpose,
          benchmark.is_shelf() ? HeadConversion::kVoxelposeShelf
                               : HeadConversion::kVoxelposeCampus,
          HeadConversion::k4d, HeadConversion::kRaw};
}

// The score of a row under the head conversion and endpoint rule of
// pcp.protocol.
struct Score {
  PcpResult pcp;
  Interval mean;  // of the mean of actors
  // Difference from the first method on the same detections; nullopt for that
  // method itself and for results on other detections.
  std::optional<PcpDifference> difference;

  std::string MeanCell() const {
    return WithInterval(MeanOfActors(pcp, kAllParts), mean, 2);
  }
};

struct ScoredRow {
  const TrackedRow* row = nullptr;
  std::vector<Score> scores;  // by conversion, then by rule

  const Score& Find(HeadConversion head, EndpointRule rule) const {
    return *std::find_if(scores.begin(), scores.end(), [&](const Score& score) {
      return score.pcp.protocol.head == head &&
             score.pcp.protocol.endpoints == rule;
    });
  }
};

PcpResult ScoreUnder(const TrackedBenchmark& tracked, const TrackedRow& row,
                     PcpProtocol protocol, EndpointRule rule) {
  protocol.endpoints = rule;
  return EvaluatePcp(tracked.truth, row.tracks, protocol);
}

std::vector<ScoredRow> ScoreAll(const TrackedBenchmark& tracked,
                                PcpProtocol protocol) {
  std::vector<ScoredRow> scored;
  std::map<std::string, size_t> baseline_of_recording;
  for (const TrackedRow& row : tracked.rows) {
    if (row.baseline) baseline_of_recording[row.recording] = scored.size();
    const auto baseline = baseline_of_recording.find(row.recording);
    ScoredRow& one = scored.emplace_back();
    one.row = &row;
    for (const HeadConversion head : HeadConversionsOf(tracked.benchmark)) {
      protocol.head = head;
      for (const EndpointRule rule : kEndpointRules) {
        Score score;
        score.pcp = ScoreUnder(tracked, row, protocol, rule);
        score.mean = MeanOfActorsInterval(score.pcp, kAllParts);
        if (!row.baseline && baseline != baseline_of_recording.end()) {
          score.difference = DifferenceOf(
              score.pcp,
              scored[baseline->second].scores[one.scores.size()].pcp);
        }
        one.scores.push_back(std::move(score));
      }
    }
  }
  return scored;
}

// ---- Text

// Method and detections.
Cells NameCells(const TrackedRow& row) {
  return {row.method, row.ours ? row.recording : row.detections_note};
}

std::string DifferenceCell(const ScoredRow& row, const Score& score) {
  if (row.row->baseline) return "(base)";
  if (!score.difference) return "-";
  return WithInterval(score.difference->value, score.difference->interval, 2) +
         (score.difference->is_significant() ? "" : ", not significant");
}

// Counts and intervals of every row under one conversion and rule.
std::string CountsTable(const std::vector<ScoredRow>& rows, HeadConversion head,
                        EndpointRule rule, const PublishedTable* published) {
  // The actors of the printed columns, whether or not they are annotated.
  const std::vector<int64_t>& actors =
      rows.front().scores.front().pcp.protocol.headline_actors;
  Table table(RowOf("method", "detections", CellsOf(actors, ActorName),
                    "mean of actors", "difference from (base)", "source"));
  if (published != nullptr) {
    for (const PublishedRow& row : published->rows) {
      table.AddRow(RowOf(row.method, "their own", row.cells, "-", kPrinted));
    }
  }
  for (const ScoredRow& row : rows) {
    const Score& score = row.Find(head, rule);
    const auto count = [&](int64_t actor) {
      const Share share = CountParts(score.pcp, actor, kAllParts);
      return share.total == 0 ? "-" : PercentCell(share);
    };
    table.AddRow(RowOf(NameCells(*row.row), CellsOf(actors, count),
                       score.MeanCell(), DifferenceCell(row, score),
                       "measured: " + row.row->made_by));
  }
  return table.ToString(TableStyle::kMarkdown);
}

// Mean of actors under every conversion, for one rule.
std::string ConversionsTable(const std::vector<ScoredRow>& rows,
                             const std::vector<HeadConversion>& heads,
                             EndpointRule rule) {
  const auto name = [](HeadConversion head) { return ToString(head); };
  Table table(RowOf("method", "detections", CellsOf(heads, name)));
  for (const ScoredRow& row : rows) {
    const auto mean = [&](HeadConversion head) {
      return row.Find(head, rule).MeanCell();
    };
    table.AddRow(RowOf(NameCells(*row.row), CellsOf(heads, mean)));
  }
  return table.ToString(TableStyle::kMarkdown);
}

// All groups but the total, in the order of the enum.
constexpr PcpGroup kLossGroups[] = {PcpGroup::kHead,      PcpGroup::kTorso,
                                    PcpGroup::kUpperArms, PcpGroup::kLowerArms,
                                    PcpGroup::kUpperLegs, PcpGroup::kLowerLegs};

// The incorrect parts of one actor in one row.
struct Loss {
  int64_t parts = 0;
  std::array<int64_t, std::size(kLossGroups)> by_group{};
  std::array<int64_t, kLossReasonCount> by_reason{};
  std::vector<int64_t> frames;  // ascending, unique
};

std::map<int64_t, Loss> LossesOf(const PcpResult& pcp) {
  std::map<int64_t, Loss> losses;
  for (const int64_t actor : pcp.Actors()) losses[actor];
  for (const LostPart& lost : pcp.lost) {
    Loss& loss = losses[lost.actor];
    ++loss.parts;
    ++loss.by_group[static_cast<size_t>(PcpGroupOf(lost.part))];
    ++loss.by_reason[static_cast<size_t>(lost.reason())];
    if (loss.frames.empty() || loss.frames.back() != lost.frame) {
      loss.frames.push_back(lost.frame);
    }
  }
  return losses;
}

std::string LossTable(const std::vector<ScoredRow>& rows, HeadConversion head) {
  const auto text = [](int64_t count) { return std::to_string(count); };
  Cells reasons;
  for (int i = 0; i < kLossReasonCount; ++i) {
    reasons.emplace_back(ToString(static_cast<LossReason>(i)));
  }
  Table table(RowOf(
      "method", "detections", "actor", "parts lost",
      CellsOf(kLossGroups, [](PcpGroup group) { return ToString(group); }),
      reasons, "frames"));
  for (const ScoredRow& row : rows) {
    for (const auto& [actor, loss] :
         LossesOf(row.Find(head, EndpointRule::kMean).pcp)) {
      table.AddRow(RowOf(NameCells(*row.row), text(actor), text(loss.parts),
                         CellsOf(loss.by_group, text),
                         CellsOf(loss.by_reason, text),
                         FrameRuns(loss.frames, kMaxFrameRuns)));
    }
  }
  return table.ToString(TableStyle::kMarkdown);
}

// Every note on detections that are tracked here, once, and every remark.
std::string Notes(const std::vector<ScoredRow>& rows) {
  std::string text = "Detections:\n";
  std::set<std::string> listed;
  for (const ScoredRow& row : rows) {
    if (!row.row->ours || !listed.insert(row.row->recording).second) continue;
    text += "- " + row.row->recording + ": " + row.row->detections_note + ".\n";
  }
  for (const ScoredRow& row : rows) {
    if (row.row->remark.empty()) continue;
    text += "- " + row.row->method + ": " + row.row->remark + ".\n";
  }
  return text;
}

// Every head conversion and rule, and the incorrect parts with their frames.
std::string ActorDetails(const std::string& title,
                         const std::vector<ScoredRow>& rows,
                         const std::vector<HeadConversion>& heads) {
  std::string details = "## " + title + "\n\n" + Notes(rows) + "\n";
  for (const HeadConversion head : heads) {
    for (const EndpointRule rule : kEndpointRules) {
      details += "Head `" + std::string(ToString(head)) + "`, endpoints `" +
                 ToString(rule) + "`:\n\n" +
                 CountsTable(rows, head, rule, nullptr) + "\n";
    }
  }
  return details + "Lost parts of each actor, with reasons and frames (head `" +
         ToString(heads.front()) +
         "`, mean rule). `nobody`: no pose in the frame; `elsewhere`: the "
         "nearest pose is more than 0.5 m away; `no joint`: an end is missing; "
         "`too far`: the error exceeds half the part's length.\n\n" +
         LossTable(rows, heads.front()) + "\n";
}

// ---- JSON

Json RowJson(const TrackedRow& row) {
  return {{"method", row.method},
          {"detections", row.recording},
          {"detections_note", row.detections_note},
          {"source", row.made_by},
          {"remark", row.remark},
          {"measured", true}};
}

Json ScoreJson(const ScoredRow& row, const Score& score) {
  const PcpResult& pcp = score.pcp;
  Json json = {{"head", ToString(pcp.protocol.head)},
               {"endpoints", ToString(pcp.protocol.endpoints)},
               {"mean_of_actors", MeanOfActors(pcp, kAllParts)},
               {"mean_interval", ToJson(score.mean)}};
  if (score.difference) {
    json["difference"] = score.difference->value;
    json["difference_interval"] = ToJson(score.difference->interval);
  } else if (row.row->baseline) {
    json["base_of_differences"] = true;
  }
  for (const auto& [actor, loss] : LossesOf(pcp)) {
    Json& out = json["actors"][std::to_string(actor)];
    out = PartsJson(CountParts(pcp, actor, kAllParts));
    out["interval"] = ToJson(ActorInterval(pcp, actor, kAllParts));
    for (const PcpGroup group : kLossGroups) {
      out["by_part"][ToString(group)] =
          PartsJson(CountParts(pcp, actor, group));
    }
    for (int i = 0; i < kLossReasonCount; ++i) {
      out["lost_because"][ToString(static_cast<LossReason>(i))] =
          loss.by_reason[static_cast<size_t>(i)];
    }
    out["lost_in_frames"] = loss.frames;
  }
  return json;
}

// ---- Smaller tables

// Results of single-person tools for actor 0, and of the methods run here on
// the first recording.
TableOutput SinglePersonTable(const TrackedBenchmark& tracked,
                              const PcpProtocol& protocol) {
  Table table({"method", "mean rule", "each", "detections", "source"});
  TableOutput output;
  output.json = Json::array();
  const auto add = [&](const TrackedRow& row) {
    Json json = RowJson(row);
    const auto score = [&](EndpointRule rule) {
      const PcpResult pcp = ScoreUnder(tracked, row, protocol, rule);
      const Share share = CountParts(pcp, 0, kAllParts);
      const Interval interval = ActorInterval(pcp, 0, kAllParts);
      json[ToString(rule)] = PartsJson(share);
      json[ToString(rule)]["interval"] = ToJson(interval);
      return PercentCell(share) + " " + IntervalCell(interval, 2);
    };
    table.AddRow(RowOf(row.method, CellsOf(kEndpointRules, score),
                       NameCells(row)[1], "measured: " + row.made_by));
    output.json.push_back(std::move(json));
  };
  for (const TrackedRow& row : tracked.single_person) add(row);
  const std::string& first = tracked.benchmark.recordings.front().dataset.name;
  for (const TrackedRow& row : tracked.rows) {
    if (row.ours && row.recording == first) add(row);
  }
  output.markdown = table.ToString(TableStyle::kMarkdown);
  return output;
}

// Results under the rules of the programs that made them.
TableOutput OwnRulesTable(const TrackedBenchmark& tracked) {
  Table table(
      {"method", "actor 0", "actor 1", "actor 2", "mean of actors", "source"});
  TableOutput output;
  output.json = Json::array();
  for (size_t i = 0; i < tracked.own_rules.size(); ++i) {
    const OwnRules& own = tracked.benchmark.own_rules[i];
    const PcpResult& pcp = tracked.own_rules[i];
    Json json = {{"method", own.result.method},
                 {"source", own.result.path},
                 {"rules", own.rules}};
    const auto count = [&](int64_t actor) {
      const Share share = CountParts(pcp, actor, kAllParts);
      json["actors"].push_back(PartsJson(share));
      return PercentCell(share);
    };
    const double mean = MeanOfActors(pcp, kAllParts);
    const Interval interval = MeanOfActorsInterval(pcp, kAllParts);
    table.AddRow(RowOf(own.result.method,
                       CellsOf(std::array<int64_t, 3>{0, 1, 2}, count),
                       WithInterval(mean, interval, 2),
                       "measured: `" + own.result.path + "`"));
    json["mean_of_actors"] = mean;
    json["mean_interval"] = ToJson(interval);
    output.json.push_back(std::move(json));
  }
  output.markdown = "Under the rules of the program that made the result (" +
                    tracked.benchmark.own_rules.front().rules + "):\n\n" +
                    table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace

int64_t RowCount(const Benchmark& benchmark) {
  size_t count = benchmark.results.size() + benchmark.single_person.size();
  for (const BenchmarkRecording& recording : benchmark.recordings) {
    count += recording.methods.size();
  }
  return static_cast<int64_t>(count);
}

TrackedBenchmark TrackBenchmark(const BenchmarkData& data,
                                const Benchmark& benchmark,
                                Progress* progress) {
  TrackedBenchmark tracked;
  tracked.benchmark = benchmark;
  double frame_rate_hz = 0.0;
  for (const BenchmarkRecording& recording : benchmark.recordings) {
    for (const Method& method : recording.methods) {
      LoadedDataset loaded = LoadDataset(data, recording, method);
      const bool is_first = &method == &recording.methods.front();
      if (is_first) RequireScoredFrames(loaded);
      frame_rate_hz = loaded.options.input.frame_rate_hz;
      tracked.rows.push_back(TrackMethod(loaded, method));
      tracked.rows.back().baseline = is_first;
      tracked.truth = std::move(loaded.truth);
      progress->Advance();
    }
  }
  for (const auto& [results, rows] :
       {std::pair{&benchmark.results, &tracked.rows},
        {&benchmark.single_person, &tracked.single_person}}) {
    for (const ResultFile& result : *results) {
      rows->push_back(ReadResult(result, data.folder, frame_rate_hz));
      progress->Advance();
    }
  }
  for (const OwnRules& own : benchmark.own_rules) {
    tracked.own_rules.push_back(ScoreByOwnRules(own, data.folder));
  }
  return tracked;
}

PcpDifference DifferenceOf(const PcpResult& pcp, const PcpResult& baseline,
                           PcpGroup group) {
  return {MeanOfActors(pcp, group) - MeanOfActors(baseline, group),
          MeanOfActorsDifference(pcp, baseline, group)};
}

Json PartsJson(const Share& share) {
  return {{"right", share.count},
          {"parts", share.total},
          {"percent", share.percent()}};
}

std::string FrameRuns(const std::vector<int64_t>& frames, size_t max_runs) {
  std::string text;
  size_t runs = 0;
  for (size_t i = 0; i < frames.size(); ++runs) {
    if (runs == max_runs) {
      return text + " and " + std::to_string(frames.size() - i) + " more";
    }
    size_t last = i;
    while (last + 1 < frames.size() && frames[last + 1] == frames[last] + 1) {
      ++last;
    }
    if (!text.empty()) text += ", ";
    text += std::to_string(frames[i]);
    if (last > i) text += "-" + std::to_string(frames[last]);
    i = last + 1;
  }
  return text;
}

TableOutput PrintedTable(const PublishedTable& published) {
  Table table(RowOf(kPrinted, published.columns));
  TableOutput output;
  output.json = {{"caption", published.caption},
                 {"columns", published.columns},
                 {"rows", Json::array()}};
  for (const PublishedRow& row : published.rows) {
    table.AddRow(RowOf(row.method, row.cells));
    output.json["rows"].push_back(
        {{"method", row.method}, {"cells", row.cells}, {"source", kPrinted}});
  }
  output.markdown = table.ToString(TableStyle::kMarkdown);
  return output;
}

TableOutput ActorTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol) {
  const std::vector<HeadConversion> heads =
      HeadConversionsOf(tracked.benchmark);
  const std::vector<ScoredRow> rows = ScoreAll(tracked, protocol);
  const std::string head = ToString(heads.front());
  TableOutput output;
  std::string& text = output.markdown;
  text =
      "## " + title + "\n\nPrinted rows: " + published.caption +
      ". The paper's Actor1 is actor 0. Measured rows: PCP in % (correct/all "
      "parts), 95 % intervals from moving blocks of 25 frames within an "
      "actor; `difference from (base)`: from the first method on the same "
      "detections, paired on the same frames.\n\n" +
      Notes(rows) + "\nHead conversion `" + head +
      "` (the paper's code), mean of both ends:\n\n" +
      CountsTable(rows, heads.front(), EndpointRule::kMean, &published) + "\n";
  for (const EndpointRule rule : kEndpointRules) {
    text += "Mean of actors under every head conversion, " +
            std::string(rule == EndpointRule::kMean ? "mean of both ends"
                                                    : "each end separately") +
            ":\n\n" + ConversionsTable(rows, heads, rule) + "\n";
  }
  output.details = ActorDetails(title, rows, heads);
  output.json["printed"] = PrintedTable(published).json;
  output.json["measured"] = Json::array();
  for (const ScoredRow& row : rows) {
    Json json = RowJson(*row.row);
    for (const Score& score : row.scores) {
      json["scores"].push_back(ScoreJson(row, score));
    }
    output.json["measured"].push_back(std::move(json));
  }
  if (!tracked.own_rules.empty()) {
    TableOutput own = OwnRulesTable(tracked);
    text += own.markdown;
    output.json["own_rules"] = std::move(own.json);
  }
  if (!tracked.single_person.empty()) {
    TableOutput single = SinglePersonTable(tracked, protocol);
    text += "Single-person tools, actor 0 only (head `" + head +
            "`; their input was selected with a given track, whereas the input "
            "of the other rows was associated automatically):\n\n" +
            single.markdown + "\n";
    output.json["single_person"] = std::move(single.json);
  }
  return output;
}

TableOutput PartsTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol) {
  // Body parts in the printed order, then those that the paper does not print.
  constexpr PcpGroup kGroups[] = {PcpGroup::kUpperArms, PcpGroup::kLowerArms,
                                  PcpGroup::kUpperLegs, PcpGroup::kLowerLegs,
                                  PcpGroup::kTorso,     PcpGroup::kHead};
  Table table(
      RowOf("method", "detections", "actors",
            CellsOf(kGroups, [](PcpGroup group) { return ToString(group); }),
            "source"));
  for (const PublishedRow& row : published.rows) {
    table.AddRow(RowOf(row.method, "their own", "not specified", row.cells, "-",
                       "-", kPrinted));
  }
  TableOutput output;
  output.json["printed"] = PrintedTable(published).json;
  output.json["measured"] = Json::array();
  for (const TrackedRow& row : tracked.rows) {
    Json json = RowJson(row);
    for (const EndpointRule rule : kEndpointRules) {
      const PcpResult pcp = ScoreUnder(tracked, row, protocol, rule);
      Cells pooled = RowOf(NameCells(row), "pooled");
      Cells means = RowOf(NameCells(row), "mean");
      for (const PcpGroup group : kGroups) {
        const Share share = PooledParts(pcp, group);
        const double mean = MeanOfActors(pcp, group);
        const Interval interval = MeanOfActorsInterval(pcp, group);
        pooled.push_back(PercentCell(share));
        means.push_back(WithInterval(mean, interval, 2));
        json[ToString(rule)][ToString(group)] = {
            {"pooled", PartsJson(share)},
            {"mean_of_actors", mean},
            {"mean_interval", ToJson(interval)}};
      }
      if (rule != EndpointRule::kMean) continue;
      table.AddRow(RowOf(pooled, "measured: " + row.made_by));
      table.AddRow(RowOf(means, "measured"));
    }
    output.json["measured"].push_back(std::move(json));
  }
  output.markdown =
      "### " + title + "\n\nPrinted rows: " + published.caption +
      ". Mean rule, head `" + ToString(protocol.head) +
      "` (limbs do not depend on it); the rule `each` is in the JSON.\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace kinegraph
