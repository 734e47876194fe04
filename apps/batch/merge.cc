#include "apps/batch/merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "apps/common/table.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/text.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"

namespace kinegraph {
namespace {

constexpr double kMmPerM = 1000.0;
constexpr int kResamples = 2000;

// A value in the results of tasks, and its location in their files.
struct BatchMeasure {
  const char* key;
  const char* title;
  const char* file;            // in the folder of a task
  const char* path;            // JSON pointer of the value
  const char* standard_error;  // JSON pointer, over frames; may be empty
  double scale = 1.0;          // from the file's unit to the title's
  int decimals = 1;
};
const BatchMeasure kMeasures[] = {
    {"mpjpe_mm", "Mean joint error (MPJPE), mm", "evaluation.json",
     "/result/raw_m", "/result/raw_interval_m/standard_error", kMmPerM, 2},
    {"mpjpe_bias_removed_mm", "MPJPE with each joint's bias removed, mm",
     "evaluation.json", "/result/bias_removed_m",
     "/result/bias_removed_interval_m/standard_error", kMmPerM, 2},
    {"pcp_percent", "PCP, total, mean of actors, %", "evaluation.json",
     "/result/mean_of_actors/total/percent",
     "/result/mean_of_actors/total/interval/standard_error", 1.0, 2},
    {"ap25_percent", "Average precision at 25 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/0/average_precision", "", 100.0, 2},
    {"ap50_percent", "Average precision at 50 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/1/average_precision", "", 100.0, 2},
    {"ap75_percent", "Average precision at 75 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/2/average_precision", "", 100.0, 2},
    {"ap100_percent", "Average precision at 100 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/3/average_precision", "", 100.0, 2},
    {"ap125_percent", "Average precision at 125 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/4/average_precision", "", 100.0, 2},
    {"ap150_percent", "Average precision at 150 mm (Panoptic), %",
     "evaluation.json", "/result/thresholds/5/average_precision", "", 100.0, 2},
    {"panoptic_mpjpe_mm", "MPJPE of the people found (Panoptic), mm",
     "evaluation.json", "/result/mpjpe_m", "", kMmPerM, 2},
    {"coverage_percent", "People found, %", "evaluation.json",
     "/result/coverage/percent", "", 1.0, 2},
    {"acceleration_m_s2", "Acceleration, m/s^2", "evaluation.json",
     "/result/motion/acceleration_m_s2",
     "/result/motion/acceleration_interval_m_s2/standard_error", 1.0, 2},
    {"mota_percent", "MOTA, %", "identity.json", "/result/mota", "", 100.0, 2},
    {"idf1_percent", "IDF1, %", "identity.json", "/result/idf1", "", 100.0, 2},
    {"switches", "Identity switches", "identity.json", "/result/switches", "",
     1.0, 0},
    {"held_out_mean_px", "Held-out cameras: mean of min(error, 30 px), px",
     "held_out.json", "/result/rows/0/mean_truncated_px/value",
     "/result/rows/0/mean_truncated_px/interval/standard_error", 1.0, 2},
    {"held_out_p90_px", "Held-out cameras: 90th percentile, px",
     "held_out.json", "/result/rows/0/p90_px/value",
     "/result/rows/0/p90_px/interval/standard_error", 1.0, 2}};

// Recordings and configurations in the order of the tasks, and their results.
struct Results {
  std::vector<std::string> recordings;
  std::vector<std::string> configurations;
  std::vector<const Task*> missing;
  std::set<std::string> processors;
  std::set<std::string> commits;
  // By key of the measure and configuration; absent if no task has the value.
  std::map<std::pair<std::string, std::string>, BatchColumn> columns;

  // Without values if the configuration has no finished recording.
  BatchColumn ColumnOf(const BatchMeasure& measure,
                       const std::string& configuration) const {
    const auto at = columns.find({measure.key, configuration});
    return at == columns.end() ? BatchColumn(recordings.size()) : at->second;
  }
  // The measures that at least one task has.
  std::vector<BatchMeasure> Measures() const {
    std::vector<BatchMeasure> found;
    for (const BatchMeasure& measure : kMeasures) {
      const auto at = columns.lower_bound({measure.key, ""});
      if (at == columns.end() || at->first.first != measure.key) continue;
      found.push_back(measure);
    }
    return found;
  }
};

void AddName(const std::string& name, std::vector<std::string>* names) {
  if (std::find(names->begin(), names->end(), name) == names->end()) {
    names->push_back(name);
  }
}

std::optional<double> NumberAt(const Json& json, const std::string& path) {
  if (path.empty()) return std::nullopt;
  const Json::json_pointer pointer(path);
  if (!json.contains(pointer) || !json.at(pointer).is_number()) {
    return std::nullopt;
  }
  return json.at(pointer).get<double>();
}

Json ReadJson(const std::string& path) {
  return ParseJson(ReadTextFile(path, kMaxSmallFileBytes), path);
}

void AddFigures(const Task& task, const std::string& folder, Results* results) {
  const auto recording =
      static_cast<size_t>(std::find(results->recordings.begin(),
                                    results->recordings.end(), task.recording) -
                          results->recordings.begin());
  std::map<std::string, Json> files;  // each read once; null: missing
  for (const BatchMeasure& measure : kMeasures) {
    const auto [file, is_new] = files.try_emplace(measure.file);
    const std::string path = folder + "/" + measure.file;
    if (is_new && IsFile(path)) file->second = ReadJson(path);
    const auto value = NumberAt(file->second, measure.path);
    if (!value.has_value() || !std::isfinite(*value)) continue;
    const auto error = NumberAt(file->second, measure.standard_error);
    BatchColumn& column = results->columns[{measure.key, task.configuration}];
    column.resize(results->recordings.size());
    column[recording] =
        BatchValue{*value * measure.scale, error.value_or(0.0) * measure.scale};
  }
}

Results ReadResults(const std::vector<Task>& tasks, const std::string& out) {
  Results results;
  for (const Task& task : tasks) {
    AddName(task.recording, &results.recordings);
    AddName(task.configuration, &results.configurations);
  }
  for (const Task& task : tasks) {
    if (StateOf(task, out) != TaskState::kDone) {
      results.missing.push_back(&task);
      continue;
    }
    const std::string folder = FolderOf(task, out);
    if (!IsFile(folder + "/task.json")) {
      throw InputError(folder + "/task.json", "",
                       "was removed while the results were read");
    }
    const Json made = ReadJson(folder + "/task.json");
    results.processors.insert(made.value("processor", "unknown"));
    results.commits.insert(made.value("commit", "unknown"));
    AddFigures(task, folder, &results);
  }
  return results;
}

std::string MeasureTable(const Results& results, const BatchMeasure& measure) {
  const std::string& first = results.configurations.front();
  Table table(RowOf("configuration", results.recordings, "mean [95 %]",
                    "minus " + first + " [95 %]"));
  const BatchColumn base = results.ColumnOf(measure, first);
  for (const std::string& configuration : results.configurations) {
    const BatchColumn column = results.ColumnOf(measure, configuration);
    const auto cell = [&](const std::optional<BatchValue>& value) {
      return value ? Fixed(value->value, measure.decimals) : "-";
    };
    table.AddRow(RowOf(configuration, CellsOf(column, cell),
                       SummaryCell(Summarise(column), measure.decimals),
                       configuration == first
                           ? ""
                           : SummaryCell(SummariseDifference(column, base),
                                         measure.decimals)));
  }
  return table.ToString(TableStyle::kMarkdown);
}

std::string MissingText(const Results& results, const std::string& out) {
  std::string text;
  for (const Task* task : results.missing) {
    const std::string file = FailureFile(*task, out);
    std::string why = "not done yet";
    if (IsFile(file)) why = ReadTextFile(file);
    while (!why.empty() && why.back() == '\n') why.pop_back();
    text += "- " + task->Name() + ": " + why + "\n";
  }
  return text;
}

std::string Markdown(const Results& results, const std::string& out,
                     size_t task_count) {
  std::string text = fmt::format(
      "# Batch\n\n{} recordings, {} configurations; {} of {} tasks done. Made "
      "on {}, commit {}.\n\n95 % intervals come from a two-level bootstrap: "
      "recordings are drawn with replacement (2000 times), and each drawn "
      "value is perturbed by the standard error of its recording's block "
      "bootstrap over frames. Differences are formed for each recording.\n",
      results.recordings.size(), results.configurations.size(),
      task_count - results.missing.size(), task_count,
      fmt::join(results.processors, "; "), fmt::join(results.commits, "; "));
  if (results.processors.size() > 1) {
    text +=
        "\n**More than one kind of processor:** the last digits of a result "
        "may depend on it.\n";
  }
  if (results.commits.size() > 1) {
    text +=
        "\n**These results were made by more than one version of the "
        "program.**\n";
  }
  for (const BatchMeasure& measure : results.Measures()) {
    text += fmt::format("\n## {}\n\n{}", measure.title,
                        MeasureTable(results, measure));
  }
  if (!results.missing.empty()) {
    text += "\n## Not done\n\n" + MissingText(results, out);
  }
  return text;
}

std::string Csv(const Results& results) {
  Table table({"take", "configuration", "measure", "value", "standard_error"});
  for (const BatchMeasure& measure : kMeasures) {
    for (const std::string& configuration : results.configurations) {
      const BatchColumn column = results.ColumnOf(measure, configuration);
      for (size_t t = 0; t < column.size(); ++t) {
        if (!column[t].has_value()) continue;
        table.AddRow({results.recordings[t], configuration, measure.key,
                      DumpJson(column[t]->value),
                      DumpJson(column[t]->standard_error)});
      }
    }
  }
  return table.ToString(TableStyle::kCsv);
}

Json ResultsJson(const Results& results) {
  Json json = {{"kinegraph_batch", 1},
               {"takes", results.recordings},
               {"configurations", results.configurations},
               {"processors", results.processors},
               {"commits", results.commits}};
  json["missing"] = Json::array();
  for (const Task* task : results.missing) {
    json["missing"].push_back(task->Name());
  }
  const std::string& first = results.configurations.front();
  for (const BatchMeasure& measure : results.Measures()) {
    const BatchColumn base = results.ColumnOf(measure, first);
    for (const std::string& configuration : results.configurations) {
      const BatchColumn column = results.ColumnOf(measure, configuration);
      Json& entry = json["measures"][measure.key][configuration];
      entry["summary"] = SummaryJson(Summarise(column));
      entry["less_first"] = SummaryJson(SummariseDifference(column, base));
    }
  }
  return json;
}

// Percent-encodes bytes of a path that a link cannot contain.
std::string UrlOf(const std::string& path) {
  std::string url;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        std::isalnum(byte) != 0 || c == '/' || c == '-' || c == '_' || c == '.';
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return url;
}

std::string IndexPage(const std::vector<Task>& tasks, const Results& results,
                      const std::string& out) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
      "<title>Batch</title>\n<style>body{font-family:sans-serif;margin:2em}"
      "td,th{padding:.2em .8em;text-align:left}</style>\n<h1>Batch</h1>\n"
      "<p><a href=\"batch.md\">Tables</a>, <a href=\"batch.csv\">CSV</a>, "
      "<a href=\"batch.json\">JSON</a></p>\n<table>\n<tr><th>recording</th>"
      "<th>configuration</th><th>results</th></tr>\n";
  for (const Task& task : tasks) {
    page += "<tr><td>" + HtmlText(task.recording) + "</td><td>" +
            HtmlText(task.configuration) + "</td><td>";
    const bool missing =
        std::find(results.missing.begin(), results.missing.end(), &task) !=
        results.missing.end();
    for (const TaskStep& step : task.steps) {
      if (missing) break;
      const bool is_folder = IsFolder(FolderOf(task, out) + "/" + step.output);
      const std::string file =
          task.Name() + "/" + step.output + (is_folder ? "/compare.md" : "");
      page +=
          "<a href=\"" + UrlOf(file) + "\">" + HtmlText(step.output) + "</a> ";
    }
    page += missing ? "not done</td></tr>\n" : "</td></tr>\n";
  }
  return page + "</table>\n</html>\n";
}

}  // namespace

BatchSummary Summarise(const BatchColumn& column) {
  std::vector<BatchValue> values;
  for (const std::optional<BatchValue>& value : column) {
    if (value.has_value()) values.push_back(*value);
  }
  BatchSummary summary;
  summary.recordings = static_cast<int>(values.size());
  if (values.empty()) return summary;
  const auto count = static_cast<double>(values.size());
  for (const BatchValue& value : values) summary.mean += value.value / count;
  Random random(1);
  std::vector<double> means(kResamples);
  for (double& mean : means) {
    for (size_t i = 0; i < values.size(); ++i) {
      const BatchValue& drawn = values[static_cast<size_t>(
          random.Index(static_cast<int64_t>(values.size())))];
      mean += random.Normal(drawn.value, drawn.standard_error) / count;
    }
  }
  std::sort(means.begin(), means.end());
  const auto at = [&](double share) {
    return means[static_cast<size_t>(share * (kResamples - 1) + 0.5)];
  };
  summary.interval.low = at(0.025);
  summary.interval.high = at(0.975);
  return summary;
}

BatchSummary SummariseDifference(const BatchColumn& a, const BatchColumn& b) {
  BatchColumn differences;
  for (size_t t = 0; t < std::min(a.size(), b.size()); ++t) {
    if (!a[t].has_value() || !b[t].has_value()) continue;
    // Assumes independent errors. On the same frames they are positively
    // correlated, so the interval is too wide.
    differences.push_back(
        BatchValue{a[t]->value - b[t]->value,
                   std::hypot(a[t]->standard_error, b[t]->standard_error)});
  }
  return Summarise(differences);
}

std::string SummaryCell(const BatchSummary& summary, int decimals) {
  if (summary.recordings == 0) return "-";
  return WithInterval(summary.mean, summary.interval, decimals);
}

Json SummaryJson(const BatchSummary& summary) {
  if (summary.recordings == 0) return nullptr;
  return {{"takes", summary.recordings},
          {"mean", summary.mean},
          {"low", summary.interval.low},
          {"high", summary.interval.high}};
}

int MergeBatch(const std::vector<Task>& tasks, const std::string& out) {
  const Results results = ReadResults(tasks, out);
  WriteTextFile(out + "/batch.csv", Csv(results));
  WriteTextFile(out + "/batch.json", DumpJson(ResultsJson(results), 1) + "\n");
  WriteTextFile(out + "/batch.md", Markdown(results, out, tasks.size()));
  WriteTextFile(out + "/index.html", IndexPage(tasks, results, out));
  return static_cast<int>(results.missing.size());
}

}  // namespace kinegraph
