#include "apps/tables/pcp_tables.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "apps/common/evaluation_output.h"
#include "apps/common/table.h"

namespace kinegraph {
namespace {

constexpr const char* kPrinted = "as printed in the paper";
constexpr size_t kMaxFrameRuns = 12;

// The printed order of body parts.
constexpr std::array<PcpGroup, 4> kLimbGroups = {
    PcpGroup::kUpperArms, PcpGroup::kLowerArms, PcpGroup::kUpperLegs,
    PcpGroup::kLowerLegs};

// One row under one conversion and rule.
struct Score {
  HeadConversion head = HeadConversion::kChu;
  EndpointRule endpoints = EndpointRule::kMean;
  PcpResult pcp;
  Interval mean;  // of the mean of actors
  // Against the first method on the same detections; none for that one and for
  // results on other detections.
  std::optional<double> difference;
  Interval difference_interval;
};

struct ScoredRow {
  const TrackedRow* row = nullptr;
  std::vector<Score> scores;  // by conversion, then by rule
};

std::vector<ScoredRow> ScoreAll(const std::vector<TrackedRow>& rows,
                                const TrackSequence& truth, BenchmarkSet set,
                                const PcpProtocol& protocol) {
  std::vector<ScoredRow> scored;
  std::map<std::string, size_t> baseline_of_recording;
  for (const TrackedRow& row : rows) {
    if (row.baseline) baseline_of_recording[row.recording] = scored.size();
    ScoredRow& one = scored.emplace_back();
    one.row = &row;
    for (const HeadConversion head : HeadConversionsOf(set)) {
      for (const EndpointRule rule : kEndpointRules) {
        Score score;
        score.head = head;
        score.endpoints = rule;
        PcpProtocol variant = protocol;
        variant.head = head;
        variant.endpoints = rule;
        score.pcp = EvaluatePcp(truth, row.tracks, variant);
        score.mean = MeanOfActorsInterval(score.pcp, PcpGroup::kTotal);
        const auto baseline = baseline_of_recording.find(row.recording);
        if (!row.baseline && baseline != baseline_of_recording.end()) {
          const PcpResult& base =
              scored[baseline->second].scores[one.scores.size()].pcp;
          score.difference = MeanOfActors(score.pcp, PcpGroup::kTotal) -
                             MeanOfActors(base, PcpGroup::kTotal);
          score.difference_interval =
              MeanOfActorsDifference(score.pcp, base, PcpGroup::kTotal);
        }
        one.scores.push_back(std::move(score));
      }
    }
  }
  return scored;
}

std::string DetectionsOf(const TrackedRow& row) {
  return row.ours ? row.recording : row.detections_note;
}

std::string MeanCell(const Score& score) {
  return Fixed(MeanOfActors(score.pcp, PcpGroup::kTotal), 2) + " " +
         IntervalCell(score.mean, 2);
}

std::string DifferenceCell(const ScoredRow& row, const Score& score) {
  if (row.row->baseline) return "(base)";
  if (!score.difference) return "-";
  const bool told =
      score.difference_interval.low > 0.0 || score.difference_interval.high < 0;
  return Fixed(*score.difference, 2) + " " +
         IntervalCell(score.difference_interval, 2) +
         (told ? "" : ", not told from 0");
}

const Score& Find(const ScoredRow& row, HeadConversion head,
                  EndpointRule rule) {
  return *std::find_if(row.scores.begin(), row.scores.end(),
                       [&](const Score& score) {
                         return score.head == head && score.endpoints == rule;
                       });
}

// Those of the printed columns, also where nobody annotated one of them.
const std::vector<int64_t>& HeadlineActors(const std::vector<ScoredRow>& rows) {
  return rows.front().scores.front().pcp.protocol.headline_actors;
}

std::string ActorName(int64_t actor) {
  return "actor " + std::to_string(actor);
}

// Counts and intervals of every row under one conversion and rule.
std::string CountsTable(const std::vector<ScoredRow>& rows, HeadConversion head,
                        EndpointRule rule, const PublishedTable* published) {
  const std::vector<int64_t> actors = HeadlineActors(rows);
  std::vector<std::string> header = {"method", "detections"};
  for (const int64_t actor : actors) header.push_back(ActorName(actor));
  header.insert(header.end(), {"mean of actors", "against (base)", "source"});
  Table table(std::move(header));
  if (published != nullptr) {
    for (const PublishedRow& row : published->rows) {
      std::vector<std::string> cells = {row.method, "their own"};
      cells.insert(cells.end(), row.cells.begin(), row.cells.end());
      cells.insert(cells.end(), {"-", kPrinted});
      table.AddRow(std::move(cells));
    }
  }
  for (const ScoredRow& row : rows) {
    const Score& score = Find(row, head, rule);
    std::vector<std::string> cells = {row.row->method, DetectionsOf(*row.row)};
    for (const int64_t actor : actors) {
      const Share share = CountParts(score.pcp, actor, PcpGroup::kTotal);
      cells.push_back(share.total == 0 ? "-" : PercentCell(share));
    }
    cells.push_back(MeanCell(score));
    cells.push_back(DifferenceCell(row, score));
    cells.push_back("measured: " + row.row->made_by);
    table.AddRow(std::move(cells));
  }
  return table.ToString(TableStyle::kMarkdown);
}

// Mean of actors under every conversion, for one rule.
std::string ConversionsTable(const std::vector<ScoredRow>& rows,
                             const std::vector<HeadConversion>& heads,
                             EndpointRule rule) {
  std::vector<std::string> header = {"method", "detections"};
  for (const HeadConversion head : heads) header.emplace_back(ToString(head));
  Table table(std::move(header));
  for (const ScoredRow& row : rows) {
    std::vector<std::string> cells = {row.row->method, DetectionsOf(*row.row)};
    for (const HeadConversion head : heads) {
      cells.push_back(MeanCell(Find(row, head, rule)));
    }
    table.AddRow(std::move(cells));
  }
  return table.ToString(TableStyle::kMarkdown);
}

// What one actor lost in one row.
struct Loss {
  int64_t parts = 0;
  std::map<PcpGroup, int64_t> by_group;
  std::array<int64_t, kLossReasonCount> by_reason{};
  std::vector<int64_t> frames;  // ascending, each once
};

constexpr std::array<PcpGroup, 6> kLossGroups = {
    PcpGroup::kHead,      PcpGroup::kTorso,     PcpGroup::kUpperArms,
    PcpGroup::kLowerArms, PcpGroup::kUpperLegs, PcpGroup::kLowerLegs};

std::map<int64_t, Loss> LostFieldsOf(const PcpResult& pcp) {
  std::map<int64_t, Loss> lost_fields;
  for (const int64_t actor : pcp.Actors()) lost_fields[actor];
  for (const LostPart& lost : pcp.lost) {
    Loss& loss = lost_fields[lost.actor];
    ++loss.parts;
    ++loss.by_group[PcpGroupOf(lost.part)];
    ++loss.by_reason[static_cast<size_t>(lost.reason())];
    if (loss.frames.empty() || loss.frames.back() != lost.frame) {
      loss.frames.push_back(lost.frame);
    }
  }
  return lost_fields;
}

std::string LossTable(const std::vector<ScoredRow>& rows, HeadConversion head) {
  std::vector<std::string> header = {"method", "detections", "actor", "lost"};
  for (const PcpGroup group : kLossGroups) header.emplace_back(ToString(group));
  for (int i = 0; i < kLossReasonCount; ++i) {
    header.emplace_back(ToString(static_cast<LossReason>(i)));
  }
  header.emplace_back("in frames");
  Table table(std::move(header));
  for (const ScoredRow& row : rows) {
    for (auto& [actor, loss] :
         LostFieldsOf(Find(row, head, EndpointRule::kMean).pcp)) {
      std::vector<std::string> cells = {row.row->method, DetectionsOf(*row.row),
                                        std::to_string(actor),
                                        std::to_string(loss.parts)};
      for (const PcpGroup group : kLossGroups) {
        const auto at = loss.by_group.find(group);
        cells.push_back(
            std::to_string(at == loss.by_group.end() ? 0 : at->second));
      }
      for (const int64_t count : loss.by_reason) {
        cells.push_back(std::to_string(count));
      }
      cells.push_back(FrameRuns(loss.frames, kMaxFrameRuns));
      table.AddRow(std::move(cells));
    }
  }
  return table.ToString(TableStyle::kMarkdown);
}

// Every remark and every note on detections, once.
std::string Notes(const std::vector<ScoredRow>& rows) {
  std::string text = "Detections:\n";
  std::set<std::string> told;
  for (const ScoredRow& row : rows) {
    if (!row.row->ours || !told.insert(row.row->recording).second) continue;
    text += "- " + row.row->recording + ": " + row.row->detections_note + ".\n";
  }
  for (const ScoredRow& row : rows) {
    if (row.row->remark.empty()) continue;
    text += "- " + row.row->method + ": " + row.row->remark + ".\n";
  }
  return text;
}

Json ShareJson(const Share& share) {
  return {{"right", share.count},
          {"parts", share.total},
          {"percent", share.percent()}};
}

Json ScoreJson(const ScoredRow& row, const Score& score) {
  Json json = {{"head", ToString(score.head)},
               {"endpoints", ToString(score.endpoints)},
               {"mean_of_actors", MeanOfActors(score.pcp, PcpGroup::kTotal)},
               {"mean_interval", ToJson(score.mean)}};
  if (score.difference) {
    json["difference"] = *score.difference;
    json["difference_interval"] = ToJson(score.difference_interval);
  } else if (row.row->baseline) {
    json["base_of_differences"] = true;
  }
  const std::map<int64_t, Loss> lost_fields = LostFieldsOf(score.pcp);
  for (const int64_t actor : score.pcp.Actors()) {
    Json& out = json["actors"][std::to_string(actor)];
    out = ShareJson(CountParts(score.pcp, actor, PcpGroup::kTotal));
    out["interval"] = ToJson(ActorInterval(score.pcp, actor, PcpGroup::kTotal));
    for (const PcpGroup group : kLossGroups) {
      out["by_part"][ToString(group)] =
          ShareJson(CountParts(score.pcp, actor, group));
    }
    const Loss& loss = lost_fields.at(actor);
    for (int i = 0; i < kLossReasonCount; ++i) {
      out["lost_because"][ToString(static_cast<LossReason>(i))] =
          loss.by_reason[static_cast<size_t>(i)];
    }
    out["lost_in_frames"] = loss.frames;
  }
  return json;
}

Json RowJson(const TrackedRow& row) {
  return {{"method", row.method},
          {"detections", row.recording},
          {"detections_note", row.detections_note},
          {"source", row.made_by},
          {"remark", row.remark},
          {"measured", true}};
}

// Actor 0 alone: what single-person tools made of their input.
TableOutput SinglePersonTable(const TrackedBenchmark& tracked,
                              const PcpProtocol& protocol) {
  Table table({"method", "mean rule", "each", "detections", "source"});
  TableOutput output;
  output.json = Json::array();
  const auto add = [&](const TrackedRow& row) {
    std::vector<std::string> cells = {row.method};
    Json json = RowJson(row);
    for (const EndpointRule rule : kEndpointRules) {
      PcpProtocol variant = protocol;
      variant.endpoints = rule;
      const PcpResult pcp = EvaluatePcp(tracked.truth, row.tracks, variant);
      const Share share = CountParts(pcp, 0, PcpGroup::kTotal);
      const Interval interval = ActorInterval(pcp, 0, PcpGroup::kTotal);
      cells.push_back(PercentCell(share) + " " + IntervalCell(interval, 2));
      json[ToString(rule)] = ShareJson(share);
      json[ToString(rule)]["interval"] = ToJson(interval);
    }
    cells.push_back(DetectionsOf(row));
    cells.push_back("measured: " + row.made_by);
    table.AddRow(std::move(cells));
    output.json.push_back(std::move(json));
  };
  for (const TrackedRow& row : tracked.single_person) add(row);
  for (const TrackedRow& row : tracked.rows) {
    if (row.ours &&
        row.recording == tracked.benchmark.recordings.front().dataset.name) {
      add(row);
    }
  }
  output.markdown = table.ToString(TableStyle::kMarkdown);
  return output;
}

// Results under the rules of their own programs.
TableOutput OwnRulesTable(const TrackedBenchmark& tracked) {
  Table table(
      {"method", "actor 0", "actor 1", "actor 2", "mean of actors", "source"});
  TableOutput output;
  output.json = Json::array();
  for (size_t i = 0; i < tracked.own_rules.size(); ++i) {
    const OwnRules& own = tracked.benchmark.own_rules[i];
    const PcpResult& pcp = tracked.own_rules[i];
    std::vector<std::string> cells = {own.result.method};
    Json json = {{"method", own.result.method},
                 {"source", own.result.path},
                 {"rules", own.rules}};
    for (const int64_t actor : {0, 1, 2}) {
      const Share share = CountParts(pcp, actor, PcpGroup::kTotal);
      cells.push_back(PercentCell(share));
      json["actors"].push_back(ShareJson(share));
    }
    const Interval interval = MeanOfActorsInterval(pcp, PcpGroup::kTotal);
    cells.push_back(Fixed(MeanOfActors(pcp, PcpGroup::kTotal), 2) + " " +
                    IntervalCell(interval, 2));
    cells.push_back("measured: `" + own.result.path + "`");
    json["mean_of_actors"] = MeanOfActors(pcp, PcpGroup::kTotal);
    json["mean_interval"] = ToJson(interval);
    table.AddRow(std::move(cells));
    output.json.push_back(std::move(json));
  }
  output.markdown = "Under the rules of its own program (" +
                    tracked.benchmark.own_rules.front().rules + "):\n\n" +
                    table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace

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
  std::vector<std::string> header = {"as printed in the paper"};
  header.insert(header.end(), published.columns.begin(),
                published.columns.end());
  Table table(std::move(header));
  TableOutput output;
  output.json = {{"caption", published.caption},
                 {"columns", published.columns},
                 {"rows", Json::array()}};
  for (const PublishedRow& row : published.rows) {
    std::vector<std::string> cells = {row.method};
    cells.insert(cells.end(), row.cells.begin(), row.cells.end());
    table.AddRow(std::move(cells));
    output.json["rows"].push_back(
        {{"method", row.method}, {"cells", row.cells}, {"source", kPrinted}});
  }
  output.markdown = table.ToString(TableStyle::kMarkdown);
  return output;
}

// Every head conversion and rule, and what was lost where.
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
  details +=
      "What each actor lost and where (head `" +
      std::string(ToString(heads.front())) +
      "`, mean rule). `nobody`: no pose in the frame; `elsewhere`: the nearest "
      "pose is more than 0.5 m off; `no joint`: an end is missing; `too far`: "
      "it is there but beyond half the part's length.\n\n" +
      LossTable(rows, heads.front()) + "\n";
  return details;
}

TableOutput ActorTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol) {
  const BenchmarkSet set = tracked.benchmark.set;
  const std::vector<HeadConversion> heads = HeadConversionsOf(set);
  const std::vector<ScoredRow> rows =
      ScoreAll(tracked.rows, tracked.truth, set, protocol);
  TableOutput output;
  std::string& text = output.markdown;
  text = "## " + title + "\n\nPrinted rows: " + published.caption +
         ". The paper's Actor1 is actor 0. Measured rows: PCP in % (right/all "
         "parts), 95 % intervals from moving blocks of 25 frames within an "
         "actor; `against (base)`: paired on the same frames with the first "
         "method on the same detections.\n\n" +
         Notes(rows) + "\nHead conversion `" + ToString(heads.front()) +
         "` (the paper's code), mean of both ends:\n\n" +
         CountsTable(rows, heads.front(), EndpointRule::kMean, &published) +
         "\n";
  for (const EndpointRule rule : kEndpointRules) {
    text += "Mean of actors under every head conversion, " +
            std::string(rule == EndpointRule::kMean ? "mean of both ends"
                                                    : "each end within") +
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
    text += "Single-person tools, actor 0 alone (`" +
            std::string(ToString(heads.front())) +
            "`; their input was chosen with a given track, ours was "
            "associated):\n\n" +
            single.markdown + "\n";
    output.json["single_person"] = std::move(single.json);
  }
  return output;
}

TableOutput PartsTable(const std::string& title,
                       const PublishedTable& published,
                       const TrackedBenchmark& tracked,
                       const PcpProtocol& protocol) {
  std::vector<std::string> header = {"method", "detections", "actors"};
  for (const PcpGroup group : kLimbGroups) header.emplace_back(ToString(group));
  header.insert(header.end(), {"torso", "head", "source"});
  Table table(std::move(header));
  for (const PublishedRow& row : published.rows) {
    std::vector<std::string> cells = {row.method, "their own", "not said"};
    cells.insert(cells.end(), row.cells.begin(), row.cells.end());
    cells.insert(cells.end(), {"-", "-", kPrinted});
    table.AddRow(std::move(cells));
  }
  TableOutput output;
  output.json["printed"] = PrintedTable(published).json;
  output.json["measured"] = Json::array();
  std::vector<PcpGroup> groups(kLimbGroups.begin(), kLimbGroups.end());
  groups.insert(groups.end(), {PcpGroup::kTorso, PcpGroup::kHead});
  for (const TrackedRow& row : tracked.rows) {
    Json json = RowJson(row);
    for (const EndpointRule rule : kEndpointRules) {
      PcpProtocol variant = protocol;
      variant.endpoints = rule;
      const PcpResult pcp = EvaluatePcp(tracked.truth, row.tracks, variant);
      std::vector<std::string> pooled = {row.method, DetectionsOf(row),
                                         "pooled"};
      std::vector<std::string> mean = {row.method, DetectionsOf(row), "mean"};
      for (const PcpGroup group : groups) {
        const Share share = PooledParts(pcp, group);
        const Interval interval = MeanOfActorsInterval(pcp, group);
        pooled.push_back(PercentCell(share));
        mean.push_back(Fixed(MeanOfActors(pcp, group), 2) + " " +
                       IntervalCell(interval, 2));
        json[ToString(rule)][ToString(group)] = {
            {"pooled", ShareJson(share)},
            {"mean_of_actors", MeanOfActors(pcp, group)},
            {"mean_interval", ToJson(interval)}};
      }
      if (rule != EndpointRule::kMean) continue;
      pooled.push_back("measured: " + row.made_by);
      mean.push_back("measured");
      table.AddRow(std::move(pooled));
      table.AddRow(std::move(mean));
    }
    output.json["measured"].push_back(std::move(json));
  }
  output.markdown =
      "### " + title + "\n\nPrinted rows: " + published.caption +
      ". Mean rule, head `" + std::string(ToString(protocol.head)) +
      "` (limbs do not depend on it); `each` is in the JSON.\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace kinegraph
