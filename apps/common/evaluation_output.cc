#include "apps/common/evaluation_output.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <utility>

#include "apps/common/table.h"
#include "core/base/text.h"
#include "core/kinematics/ground.h"

namespace kinegraph {
namespace {

constexpr double kMmPerM = 1000.0;

std::string Count(int64_t value) { return std::to_string(value); }

Json ToJson(const Share& share) {
  return {{"count", share.count},
          {"total", share.total},
          {"percent", share.percent()}};
}

template <typename Number>
Json ToJson(const std::optional<Number>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json IdToJson(const std::optional<TrackId>& id) {
  return id ? Json(id->value()) : Json(nullptr);
}

// ---- PCP

Json ToJson(const PcpProtocol& protocol) {
  Json frames = Json::array();
  for (const FrameRange& range : protocol.frames) {
    frames.push_back({range.begin, range.end});
  }
  return {{"name", protocol.name},
          {"frames", frames},
          {"head", ToString(protocol.head)},
          {"endpoints", ToString(protocol.endpoints)},
          {"matching", ToString(protocol.matching)},
          {"tolerance", protocol.tolerance},
          {"strictly_less", protocol.strictly_less},
          {"headline_actors", protocol.headline_actors}};
}

std::string PcpHeading(const PcpProtocol& protocol) {
  const Cells frames = CellsOf(protocol.frames, [](const FrameRange& range) {
    return fmt::format("{}:{}", range.begin, range.end);
  });
  return fmt::format(
      "PCP, protocol {}: head {}, endpoints {}{}, matching {}, frames {}\n",
      protocol.name, ToString(protocol.head), ToString(protocol.endpoints),
      protocol.strictly_less ? " (strictly less)" : "",
      ToString(protocol.matching),
      frames.empty() ? "all" : fmt::format("{}", fmt::join(frames, ",")));
}

std::string PcpTable(const PcpResult& result,
                     const std::map<PcpGroup, Interval>& mean_intervals,
                     const std::map<int64_t, Interval>& actor_intervals) {
  const std::vector<int64_t> actors = result.Actors();
  const std::string headline =
      fmt::format("{}", fmt::join(result.HeadlineActors(), ", "));
  Table table(RowOf("part, % (correct/all)", CellsOf(actors, ActorName),
                    "mean of " + headline + " [interval]",
                    "pooled " + headline));
  for (const PcpGroup group : kPcpGroups) {
    const auto count = [&](int64_t actor) {
      return PercentCell(CountParts(result, actor, group));
    };
    table.AddRow(RowOf(
        ToString(group), CellsOf(actors, count),
        WithInterval(MeanOfActors(result, group), mean_intervals.at(group), 2),
        PercentCell(PooledParts(result, group))));
  }
  const auto interval = [&](int64_t actor) {
    return IntervalCell(actor_intervals.at(actor), 2);
  };
  table.AddRow(RowOf("interval of total", CellsOf(actors, interval)));
  return table.ToString();
}

// For each actor, the number of incorrect parts of each kind.
std::string LostTally(const PcpResult& result) {
  const std::vector<int64_t> actors = result.Actors();
  std::map<std::pair<int, int64_t>, int64_t> lost;
  std::map<int64_t, int64_t> without_prediction;
  for (const LostPart& part : result.lost) {
    ++lost[{part.part, part.actor}];
    if (!part.predicted) ++without_prediction[part.actor];
  }
  Table table(RowOf("lost parts", CellsOf(actors, ActorName)));
  for (int part = 0; part < kPcpPartCount; ++part) {
    const auto count = [&](int64_t actor) {
      return Count(lost[{part, actor}]);
    };
    table.AddRow(RowOf(PcpPartName(part), CellsOf(actors, count)));
  }
  const auto nobody = [&](int64_t actor) {
    return Count(without_prediction[actor]);
  };
  table.AddRow(RowOf("of these, person not found", CellsOf(actors, nobody)));
  return table.ToString();
}

std::string LostList(const PcpResult& result) {
  Table table({"part", "actor", "frame", "found as", "length, m", "limit, m",
               "error of first end, m", "error of second end, m"});
  const auto error = [](const std::optional<double>& value) {
    return value ? Fixed(*value, 3) : std::string("-");
  };
  for (const LostPart& lost : result.lost) {
    table.AddRow({PcpPartName(lost.part), Count(lost.actor), Count(lost.frame),
                  lost.predicted ? Count(lost.predicted->value()) : "nobody",
                  Fixed(lost.length_m, 3),
                  Fixed(result.protocol.tolerance * lost.length_m, 3),
                  error(lost.first_error_m), error(lost.second_error_m)});
  }
  return table.ToString();
}

Json PcpJson(const PcpResult& result,
             const std::map<PcpGroup, Interval>& mean_intervals,
             const std::map<int64_t, Interval>& actor_intervals) {
  Json json = {{"protocol", ToJson(result.protocol)}};
  json["actors"] = Json::array();
  for (const int64_t actor : result.Actors()) {
    Json parts = Json::object();
    for (const PcpGroup group : kPcpGroups) {
      parts[ToString(group)] = ToJson(CountParts(result, actor, group));
    }
    json["actors"].push_back(
        {{"actor", actor},
         {"parts", parts},
         {"interval_of_total", ToJson(actor_intervals.at(actor))}});
  }
  for (const PcpGroup group : kPcpGroups) {
    json["mean_of_actors"][ToString(group)] = {
        {"percent", MeanOfActors(result, group)},
        {"interval", ToJson(mean_intervals.at(group))}};
    json["pooled"][ToString(group)] = ToJson(PooledParts(result, group));
  }
  json["lost"] = Json::array();
  for (const LostPart& lost : result.lost) {
    json["lost"].push_back({{"frame", lost.frame},
                            {"actor", lost.actor},
                            {"part", PcpPartName(lost.part)},
                            {"found", IdToJson(lost.predicted)},
                            {"length_m", lost.length_m},
                            {"first_error_m", ToJson(lost.first_error_m)},
                            {"second_error_m", ToJson(lost.second_error_m)}});
  }
  json["person_frames"] = Json::array();
  for (const PcpPersonFrame& person : result.person_frames) {
    const Share share = person.Count(PcpGroup::kTotal);
    json["person_frames"].push_back({{"frame", person.frame},
                                     {"actor", person.actor},
                                     {"found", IdToJson(person.predicted)},
                                     {"right", share.count},
                                     {"total", share.total}});
  }
  return json;
}

// ---- Held-out cameras

constexpr std::array<const char*, kHeldOutFigureCount> kFigureKeys = {
    "median_px", "p90_px", "p97_px", "mean_truncated_px"};

struct HeldOutRow {
  std::string kind;  // "all", "without_face", "class", "view"
  std::string name;
  HeldOutFilter filter;
};

std::vector<HeldOutRow> HeldOutRows(
    const std::vector<std::string>& view_names) {
  std::vector<HeldOutRow> rows = {
      {"all", "all joints", AllJoints()},
      {"without_face", "without the face", JointsWithoutFace()}};
  for (int i = 0; i < kJointClassCount; ++i) {
    const auto joint_class = static_cast<JointClass>(i);
    rows.push_back(
        {"class", ToString(joint_class), JointsOfClass(joint_class)});
  }
  for (size_t view = 0; view < view_names.size(); ++view) {
    rows.push_back(
        {"view", view_names[view], JointsOfView(static_cast<int>(view))});
  }
  return rows;
}

Json ToJson(const HeldOutRow& row, const HeldOutSummary& summary) {
  Json json = {{"kind", row.kind}, {"name", row.name}};
  for (int i = 0; i < kHeldOutFigureCount; ++i) {
    json[kFigureKeys[i]] = {{"value", summary.figures_px[i]},
                            {"interval", ToJson(summary.intervals_px[i])}};
  }
  json["joints_predicted"] = ToJson(summary.predicted);
  json["detections_paired"] = ToJson(summary.paired);
  return json;
}

}  // namespace

Eigen::Vector3d UpOfTruth(const TrackSequence& truth, const UpEvidence& known) {
  const std::string& skeleton = truth.header.skeleton.name();
  const bool is_panoptic =
      skeleton == Panoptic19().name() || skeleton == Panoptic15().name();
  if (is_panoptic) return -Eigen::Vector3d::UnitY();
  return UpDirection(truth, known).value_or(Eigen::Vector3d::UnitZ());
}

std::string ActorName(int64_t actor) { return "actor " + Count(actor); }

std::string PercentCell(const Share& share) {
  return fmt::format("{} ({}/{})", Fixed(share.percent(), 2), share.count,
                     share.total);
}

Json ToJson(const Interval& interval) {
  return {{"low", interval.low},
          {"high", interval.high},
          {"standard_error", interval.standard_error}};
}

EvaluationOutput DescribePcp(const PcpResult& result, bool list_lost) {
  std::map<PcpGroup, Interval> mean_intervals;
  for (const PcpGroup group : kPcpGroups) {
    mean_intervals[group] = MeanOfActorsInterval(result, group);
  }
  std::map<int64_t, Interval> actor_intervals;
  for (const int64_t actor : result.Actors()) {
    actor_intervals[actor] = ActorInterval(result, actor, PcpGroup::kTotal);
  }
  EvaluationOutput output;
  output.text = PcpHeading(result.protocol) +
                PcpTable(result, mean_intervals, actor_intervals) + "\n" +
                LostTally(result);
  if (list_lost) {
    output.text += "\n" + LostList(result);
  } else if (!result.lost.empty()) {
    output.text += "(--lost lists them)\n";
  }
  output.json = PcpJson(result, mean_intervals, actor_intervals);
  return output;
}

EvaluationOutput DescribeParity(const ParityResult& result,
                                const ParityOptions& options,
                                const Skeleton& reference_skeleton) {
  Table table({"parity", "value"});
  const auto within = [](double distance_m) {
    return "joints within " + Fixed(distance_m * kMmPerM, 2) + " mm, %";
  };
  // Four decimals, so that a few wrong joints of many do not round to 100.
  const auto exactly = [](const Share& share) {
    return fmt::format("{} ({}/{})", Fixed(share.percent(), 4), share.count,
                       share.total);
  };
  table.AddRow({within(options.near_m), exactly(result.near)});
  table.AddRow({within(options.very_near_m), exactly(result.very_near)});
  table.AddRow({"missing joints", Count(result.joints_missing)});
  table.AddRow({"extra joints", Count(result.joints_extra)});
  std::string worst_cell = Fixed(result.worst.distance_m * kMmPerM, 4);
  Json worst = {{"distance_m", result.worst.distance_m}};
  if (result.worst.distance_m > 0.0) {
    const std::string& joint = reference_skeleton.joints()[result.worst.joint];
    worst_cell += fmt::format(" ({}, person {}, frame {})", joint,
                              result.worst.id.value(), result.worst.frame);
    worst["joint"] = joint;
    worst["person"] = result.worst.id.value();
    worst["frame"] = result.worst.frame;
  }
  table.AddRow({"worst distance, mm", worst_cell});
  table.AddRow(
      {"identities one-to-one", result.identities_one_to_one ? "yes" : "no"});
  table.AddRow({"identities", fmt::format("{} against {}", result.identities,
                                          result.reference_identities)});
  table.AddRow({"person-frames",
                fmt::format("{} against {}, paired {}", result.person_frames,
                            result.reference_person_frames,
                            result.paired_person_frames)});
  return {table.ToString(),
          {{"near_m", options.near_m},
           {"near", ToJson(result.near)},
           {"very_near_m", options.very_near_m},
           {"very_near", ToJson(result.very_near)},
           {"joints_missing", result.joints_missing},
           {"joints_extra", result.joints_extra},
           {"worst", worst},
           {"identities_one_to_one", result.identities_one_to_one},
           {"identities", result.identities},
           {"reference_identities", result.reference_identities},
           {"person_frames", result.person_frames},
           {"reference_person_frames", result.reference_person_frames},
           {"paired_person_frames", result.paired_person_frames}}};
}

EvaluationOutput DescribePck(const MpjpeResult& result) {
  std::string text =
      "PA-MPJPE, mm: " + Fixed(result.aligned_m * kMmPerM, 1) + "\n";
  Json pck = Json::object();
  for (size_t i = 0; i < result.pck.size(); ++i) {
    const std::string limit = Fixed(result.pck_m[i] * kMmPerM, 0) + "mm";
    text += "PCK@" + limit + ", %: " + PercentCell(result.pck[i]) + "\n";
    pck[limit] = ToJson(result.pck[i]);
  }
  return {std::move(text), {{"pa_m", result.aligned_m}, {"pck", pck}}};
}

EvaluationOutput DescribeCameras(const CameraResult& result) {
  const auto mm = [](double metres) { return Fixed(metres * kMmPerM, 1); };
  Table table({"camera", "position, mm", "scale-aligned, mm", "rotation, deg"});
  Json cameras = Json::array();
  for (const CameraError& camera : result.cameras) {
    table.AddRow({camera.name, mm(camera.position_m),
                  mm(camera.scaled_position_m), Fixed(camera.rotation_deg, 3)});
    cameras.push_back({{"name", camera.name},
                       {"position_m", camera.position_m},
                       {"scaled_position_m", camera.scaled_position_m},
                       {"rotation_deg", camera.rotation_deg}});
  }
  table.AddRow({"mean (TE, s-TE, AE)", mm(result.te_m), mm(result.scaled_te_m),
                Fixed(result.ae_deg, 3)});
  std::string text = table.ToString() +
                     "scale, true / estimated: " + Fixed(result.scale, 4) +
                     "\n";
  const auto shares = [&text](const std::string& name, const std::string& unit,
                              const std::vector<double>& limits,
                              const std::vector<Share>& of) {
    Json json = Json::object();
    for (size_t i = 0; i < limits.size(); ++i) {
      const std::string limit = Fixed(limits[i], 0);
      text += name + "@" + limit + unit + ", %: " + PercentCell(of[i]) + "\n";
      json[limit] = ToJson(of[i]);
    }
    return json;
  };
  Json json = {{"te_m", result.te_m},     {"scaled_te_m", result.scaled_te_m},
               {"ae_deg", result.ae_deg}, {"scale", result.scale},
               {"cameras", cameras},      {"missing", result.missing}};
  json["rra_deg"] = shares("RRA", " deg", result.rra_deg, result.rra);
  json["scaled_cca_percent"] =
      shares("s-CCA", " %", result.cca_percent, result.scaled_cca);
  json["cca_percent"] = shares("CCA", " %", result.cca_percent, result.cca);
  return {std::move(text), std::move(json)};
}

EvaluationOutput DescribeMpjpe(const MpjpeResult& result) {
  const auto mm = [](double metres) { return Fixed(metres * kMmPerM, 1); };
  const auto scaled = [](Interval interval) {
    interval.low *= kMmPerM;
    interval.high *= kMmPerM;
    return IntervalCell(interval, 1);
  };
  Table table({"MPJPE, mm", "joints", "raw", "bias removed", "offset right",
               "forward", "up"});
  Json joints = Json::array();
  for (const JointError& joint : result.joints) {
    table.AddRow({joint.joint, Count(joint.count), mm(joint.raw_m),
                  mm(joint.bias_removed_m), mm(joint.offset_m.x()),
                  mm(joint.offset_m.y()), mm(joint.offset_m.z())});
    joints.push_back(
        {{"joint", joint.joint},
         {"count", joint.count},
         {"raw_m", joint.raw_m},
         {"bias_removed_m", joint.bias_removed_m},
         {"offset_m",
          {joint.offset_m.x(), joint.offset_m.y(), joint.offset_m.z()}}});
  }
  table.AddRow({"all", Count(result.joints_found.count), mm(result.raw_m),
                mm(result.bias_removed_m)});
  table.AddRow({"interval", "", scaled(result.raw_interval),
                scaled(result.bias_removed_interval)});
  EvaluationOutput aligned = DescribePck(result);
  EvaluationOutput output = {
      table.ToString() + aligned.text + "people found, %: " +
          PercentCell(result.found) + "\njoints of these people found, %: " +
          PercentCell(result.joints_found) + "\n",
      {{"raw_m", result.raw_m},
       {"raw_interval_m", ToJson(result.raw_interval)},
       {"bias_removed_m", result.bias_removed_m},
       {"bias_removed_interval_m", ToJson(result.bias_removed_interval)},
       {"joints", joints},
       {"people_found", ToJson(result.found)},
       {"joints_found", ToJson(result.joints_found)}}};
  output.json.update(aligned.json);
  return output;
}

EvaluationOutput DescribeIdentity(const IdentityResult& result) {
  const HotaScores hota = result.Hota();
  Table table({"identity", "value"});
  const auto percent = [&](const char* label, double share) {
    table.AddRow({label, Fixed(100.0 * share, 2)});
  };
  const auto count = [&](const char* label, int64_t value) {
    table.AddRow({label, Count(value)});
  };
  count("switches", result.switches);
  count("fragments", result.fragments);
  percent("MOTA, %", result.Mota());
  percent("IDF1, %", result.Idf1());
  percent("HOTA, %", hota.hota);
  percent("  DetA, %", hota.detection);
  percent("  AssA, %", hota.association);
  percent("  LocA, %", hota.localisation);
  count("misses", result.misses);
  count("false positives", result.false_positives);
  count("matches", result.matches);
  table.AddRow({"identities",
                fmt::format("{} for {}", result.identities,
                            Counted(result.true_people, "person", "people"))});
  table.AddRow(
      {"person-frames", fmt::format("{} for {}", result.found_person_frames,
                                    result.true_person_frames)});
  if (result.hidden_person_frames > 0) {
    count("hidden in the ground truth, person-frames",
          result.hidden_person_frames);
    count("  poses on hidden people, not counted", result.on_hidden_people);
  }
  if (result.beside_annotations > 0) {
    count("found near no annotated person, not counted",
          result.beside_annotations);
  }
  return {table.ToString(),
          {{"hota", hota.hota},
           {"hota_detection", hota.detection},
           {"hota_association", hota.association},
           {"hota_localisation", hota.localisation},
           {"hidden_person_frames", result.hidden_person_frames},
           {"on_hidden_people", result.on_hidden_people},
           {"beside_annotations", result.beside_annotations},
           {"switches", result.switches},
           {"fragments", result.fragments},
           {"mota", result.Mota()},
           {"idf1", result.Idf1()},
           {"misses", result.misses},
           {"false_positives", result.false_positives},
           {"matches", result.matches},
           {"identity_true_positives", result.identity_true_positives},
           {"identities", result.identities},
           {"true_people", result.true_people},
           {"found_person_frames", result.found_person_frames},
           {"true_person_frames", result.true_person_frames}}};
}

EvaluationOutput DescribePanoptic(const PanopticResult& result,
                                  const PanopticOptions& options) {
  Table table({"threshold, mm", "AP, %", "recall, %"});
  Json thresholds = Json::array();
  for (size_t i = 0; i < options.thresholds_m.size(); ++i) {
    const double threshold_m = options.thresholds_m[i];
    table.AddRow({Fixed(threshold_m * kMmPerM, 0),
                  Fixed(100.0 * result.average_precision[i], 2),
                  PercentCell(result.recall[i])});
    thresholds.push_back({{"threshold_m", threshold_m},
                          {"average_precision", result.average_precision[i]},
                          {"recall", ToJson(result.recall[i])}});
  }
  table.AddRow({Fixed(options.recall_threshold_m * kMmPerM, 0), "",
                PercentCell(result.recall_at_limit)});
  return {
      table.ToString() + "MPJPE, mm: " + Fixed(result.mpjpe_m * kMmPerM, 2) +
          "\njoints compared, %: " + PercentCell(result.joints_compared) + "\n",
      {{"thresholds", thresholds},
       {"recall_at_limit", ToJson(result.recall_at_limit)},
       {"mpjpe_m", result.mpjpe_m},
       {"joints_compared", ToJson(result.joints_compared)},
       {"found_person_frames", result.found_person_frames}}};
}

EvaluationOutput DescribeMotion(const MotionResult& result) {
  return {"acceleration, m/s^2: " +
              WithInterval(result.acceleration_m_s2,
                           result.acceleration_interval, 2) +
              " (" + Count(result.acceleration_count) + " joints)\n" +
              "bone-length spread, mm: " +
              Fixed(result.bone_length_spread_m * kMmPerM, 2) + " (" +
              Count(result.bone_count) + " bones)\n",
          {{"acceleration_m_s2", result.acceleration_m_s2},
           {"acceleration_interval_m_s2", ToJson(result.acceleration_interval)},
           {"acceleration_count", result.acceleration_count},
           {"bone_length_spread_m", result.bone_length_spread_m},
           {"bone_count", result.bone_count}}};
}

EvaluationOutput DescribeConsistency(const ConsistencyResult& result) {
  if (result.all.covered.total == 0) {
    return {"", nullptr};
  }
  Table table({"joint status", "joints", "RMSE, mm", "RMS by covariance, mm",
               "in 95 % ellipsoid, %", "NEES / 3"});
  Json json = Json::object();
  for (const ConsistencyRow* row : {&result.observed, &result.inferred}) {
    table.AddRow(
        {ToString(row->status), Count(row->count),
         Fixed(row->rmse_m * kMmPerM, 1), Fixed(row->stated_rms_m * kMmPerM, 1),
         PercentCell(row->stated.covered), Fixed(row->stated.nees_per_dof, 2)});
    json[ToString(row->status)] = {
        {"count", row->count},
        {"rmse_m", row->rmse_m},
        {"stated_rms_m", row->stated_rms_m},
        {"inside_95", ToJson(row->stated.covered)},
        {"nees_per_degree_of_freedom", row->stated.nees_per_dof}};
  }
  return {table.ToString(), json};
}

EvaluationOutput DescribeCoverage(const Share& covered) {
  return {"true person-frames covered, %: " + PercentCell(covered) + "\n",
          ToJson(covered)};
}

EvaluationOutput DescribeHeldOut(const HeldOutScores& scores,
                                 const std::vector<std::string>& view_names) {
  Table table({"held-out error, px", "median", "p90", "p97",
               "mean of min(error, " + Fixed(kHeldOutTruncationPx, 0) + ")",
               "joints predicted, %", "detections paired, %"});
  Json rows = Json::array();
  for (const HeldOutRow& row : HeldOutRows(view_names)) {
    const HeldOutSummary summary = SummariseHeldOut(scores, row.filter, {});
    if (summary.predicted.total == 0) continue;
    std::vector<std::string> cells = {row.name};
    for (int i = 0; i < kHeldOutFigureCount; ++i) {
      cells.push_back(
          WithInterval(summary.figures_px[i], summary.intervals_px[i], 2));
    }
    cells.push_back(PercentCell(summary.predicted));
    cells.push_back(PercentCell(summary.paired));
    table.AddRow(cells);
    rows.push_back(ToJson(row, summary));
  }
  return {table.ToString(), {{"rows", rows}}};
}

}  // namespace kinegraph
