// kinegraph-reproduce: the paper's tables beside what is measured here.
#include <gflags/gflags.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/machine.h"
#include "apps/common/plot.h"
#include "apps/common/progress.h"
#include "apps/common/table.h"
#include "apps/common/terminal_markdown.h"
#include "apps/tables/ablation.h"
#include "apps/tables/benchmark.h"
#include "apps/tables/pcp_tables.h"
#include "apps/tables/rows.h"
#include "apps/tables/runtime.h"
#include "apps/tables/sensitivity.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"

DEFINE_string(data, "",
              "folder of the datasets: the developers' (data/README.md) or "
              "official downloads (docs/official_data.md)");
DEFINE_string(table, "",
              "campus, campus_extended, shelf, parts, ablation, runtime or "
              "sensitivity; empty: every table");
DEFINE_string(set, "", "keys to change in every configuration: key=value;...");
DEFINE_string(out, "", "folder for reproduce.json, reproduce.md and plots");

namespace kinegraph {
namespace {

constexpr const char* kTables[] = {"campus",     "campus_extended", "shelf",
                                   "parts",      "ablation",        "runtime",
                                   "sensitivity"};

constexpr const char* kDetailsHeading =
    "# Details of the tables\n\nEvery count behind `reproduce.md`, under every "
    "head conversion and endpoint rule, and what each actor lost.\n\n";

bool Wanted(const std::string& table) {
  return FLAGS_table.empty() || FLAGS_table == table;
}

void CheckTable() {
  if (FLAGS_table.empty()) return;
  std::string known;
  for (const char* table : kTables) {
    if (FLAGS_table == table) return;
    known += (known.empty() ? "" : ", ") + std::string(table);
  }
  throw InputError("--table: found '" + Printable(FLAGS_table) +
                   "', expected one of " + known);
}

// The report as it grows.
struct Report {
  std::string markdown;
  std::string details;
  Json json;

  void Add(const std::string& key, TableOutput table) {
    markdown += table.markdown +
                "Remade by `./kinegraph reproduce --data=DATA --table=" + key +
                " --out=DIR`.\n\n";
    details += table.details;
    json["tables"][key] = std::move(table.json);
  }
};

void AddActorTables(const TrackedBenchmark& tracked, Report* report) {
  if (tracked.benchmark.set == BenchmarkSet::kShelf) {
    if (Wanted("shelf")) {
      report->Add("shelf", ActorTable("Shelf", PublishedShelf(), tracked,
                                      ShelfProtocol()));
    }
    return;
  }
  if (Wanted("campus")) {
    report->Add("campus", ActorTable("Campus", PublishedCampus(), tracked,
                                     CampusProtocol()));
  }
  if (Wanted("campus_extended")) {
    report->Add("campus_extended",
                ActorTable("Campus extended", PublishedCampusExtended(),
                           tracked, CampusExtendedProtocol()));
  }
}

void AddParts(const std::vector<TrackedBenchmark>& all, Report* report) {
  TableOutput parts;
  parts.markdown = "## Body parts\n\n";
  for (const TrackedBenchmark& tracked : all) {
    const bool shelf = tracked.benchmark.set == BenchmarkSet::kShelf;
    TableOutput one = shelf ? PartsTable("Shelf", PublishedShelfParts(),
                                         tracked, ShelfProtocol())
                            : PartsTable("Campus", PublishedCampusParts(),
                                         tracked, CampusProtocol());
    parts.markdown += one.markdown;
    parts.json[shelf ? "shelf" : "campus"] = std::move(one.json);
  }
  report->Add("parts", std::move(parts));
}

void AddAblation(const BenchmarkData& data, Report* report) {
  const TableOutput printed = PrintedTable(PublishedAblation());
  TableOutput ablation;
  ablation.markdown =
      "## Ablation\n\nPrinted: " + PublishedAblation().caption + ".\n\n" +
      printed.markdown +
      "\nTheir detections (HRNet) are not public; those below are other "
      "detections, so absolute figures are expected to differ. `against the "
      "baseline`: paired on the same frames, moving blocks of 25 frames within "
      "an actor.\n\n";
  ablation.json["printed"] = printed.json;
  int64_t recordings = 0;
  for (const Benchmark& benchmark : data.benchmarks) {
    recordings += static_cast<int64_t>(benchmark.recordings.size());
  }
  Progress progress("ablation", recordings);
  const OutputFolder images(FLAGS_out + "/images");
  const std::string figure = "images/ablation.svg";
  std::vector<AblatedRecording> ablated;
  std::vector<FilterInChen> in_chen;
  for (const Benchmark& benchmark : data.benchmarks) {
    for (const BenchmarkRecording& recording : benchmark.recordings) {
      Dataset dataset = recording.dataset;
      dataset.set = JoinSets(dataset.set, FLAGS_set);
      const LoadedDataset loaded = LoadDataset(dataset, data.folder);
      std::vector<AblationCell> cells = RunAblation(loaded);
      ablation.markdown += AblationMarkdown(loaded, cells);
      ablation.json["measured"].push_back(AblationJson(loaded, cells));
      ablated.push_back({recording.dataset.name, std::move(cells)});
      if (auto pair = RunFilterInChen(recording, data.folder, FLAGS_set)) {
        in_chen.push_back(*std::move(pair));
      }
      progress.Advance();
    }
  }
  WritePlot(AblationPlots(ablated), FLAGS_out + "/" + figure, {1350, 520, 2});
  ablation.markdown +=
      "![What each ingredient adds to the baseline](" + figure + ")\n\n";
  if (!in_chen.empty()) {
    TableOutput table = FilterInChenTable(in_chen);
    ablation.markdown += table.markdown;
    ablation.json["filter_in_chen"] = std::move(table.json);
  }
  report->Add("ablation", std::move(ablation));
}

void AddRuntime(const BenchmarkData& data, Report* report) {
  Progress progress("runtime", RuntimeRowCount(data.benchmarks));
  report->Add("runtime", RuntimeTable(data.benchmarks, data.folder, FLAGS_set,
                                      {}, [&progress] { progress.Advance(); }));
}

void AddSensitivity(const BenchmarkData& data, Report* report) {
  TableOutput all;
  all.markdown = "## Sensitivity\n\n";
  const OutputFolder images(FLAGS_out + "/images");
  int64_t sweeps = 0;
  for (const Benchmark& benchmark : data.benchmarks) {
    sweeps += SweepCount(benchmark);
  }
  Progress progress("sensitivity", sweeps);
  for (const Benchmark& benchmark : data.benchmarks) {
    const bool shelf = benchmark.set == BenchmarkSet::kShelf;
    const std::string name = shelf ? "shelf" : "campus";
    const std::string figure = "images/sensitivity_" + name + ".svg";
    const std::vector<Sweep> swept = RunSensitivity(
        benchmark, data.folder, FLAGS_set, [&progress] { progress.Advance(); });
    WritePlot(SensitivityPlots(swept), FLAGS_out + "/" + figure,
              {1350, 760, 3});
    TableOutput one =
        SensitivityTable(shelf ? "Shelf" : "Campus", swept, figure);
    all.markdown += one.markdown;
    all.json[name] = std::move(one.json);
  }
  report->Add("sensitivity", std::move(all));
}

// Whether a table wants the tracks of a benchmark.
bool NeedsTracks(const Benchmark& benchmark) {
  if (Wanted("parts")) return true;
  return benchmark.set == BenchmarkSet::kShelf
             ? Wanted("shelf")
             : Wanted("campus") || Wanted("campus_extended");
}

// What the whole run took.
struct Spent {
  double wall_s = 0.0;
  double processor_s = 0.0;
};

class Stopwatch {
 public:
  Spent Read() const {
    const std::chrono::duration<double> wall =
        std::chrono::steady_clock::now() - start_;
    return {wall.count(),
            static_cast<double>(std::clock() - start_clock_) / CLOCKS_PER_SEC};
  }

 private:
  std::chrono::steady_clock::time_point start_ =
      std::chrono::steady_clock::now();
  std::clock_t start_clock_ = std::clock();
};

std::string Heading(const Machine& machine, const Spent& spent) {
  return "# The paper's tables beside what was measured\n\nMade by "
         "`kinegraph-reproduce` of commit " +
         machine.commit + " on " + machine.processor + " (" +
         std::to_string(machine.threads) + " processors), " + machine.system +
         ", " + machine.compiler + ", in " + Fixed(spent.processor_s, 0) +
         " s of processor time (" + Fixed(spent.wall_s, 0) +
         " s on the clock, one thread). Rows \"as printed in the paper\" are "
         "Chu et al. (2021), "
         "Part-aware Measurement for Robust Multi-View Multi-Human 3D Pose "
         "Estimation and Tracking; every other row was measured by this "
         "command. The detections behind the printed rows are not public, so a "
         "difference from them is not a difference of methods. A figure that "
         "an interval cannot tell from another is not a win.\n\n";
}

void RunReproduce() {
  RequireFlag("data", FLAGS_data);
  RequireFlag("out", FLAGS_out);
  CheckTable();
  if (Wanted("sensitivity") || Wanted("ablation")) RequirePlotTool();
  // Before the work, so that a wrong place costs none.
  const OutputFolder folder(FLAGS_out);
  const BenchmarkData data = FindBenchmarks(FLAGS_data);
  const Machine machine = ThisMachine();
  Report report;
  const Stopwatch stopwatch;
  report.json["machine"] = {{"commit", machine.commit},
                            {"processor", machine.processor},
                            {"processors", machine.threads},
                            {"system", machine.system},
                            {"compiler", machine.compiler}};
  std::vector<TrackedBenchmark> tracked;
  {
    int64_t rows = 0;
    for (const Benchmark& benchmark : data.benchmarks) {
      if (NeedsTracks(benchmark)) rows += RowCount(benchmark);
    }
    Progress progress("tracking", rows);
    for (const Benchmark& benchmark : data.benchmarks) {
      if (!NeedsTracks(benchmark)) continue;
      tracked.push_back(TrackBenchmark(benchmark, data.folder, FLAGS_set,
                                       [&progress] { progress.Advance(); }));
    }
  }
  // The paper's order.
  for (const BenchmarkSet set : {BenchmarkSet::kCampus, BenchmarkSet::kShelf}) {
    for (const TrackedBenchmark& one : tracked) {
      if (one.benchmark.set == set) AddActorTables(one, &report);
    }
  }
  if (Wanted("parts")) AddParts(tracked, &report);
  if (Wanted("ablation")) AddAblation(data, &report);
  if (Wanted("runtime")) AddRuntime(data, &report);
  if (Wanted("sensitivity")) AddSensitivity(data, &report);
  const Spent spent = stopwatch.Read();
  report.json["machine"]["processor_s"] = spent.processor_s;
  report.json["machine"]["wall_s"] = spent.wall_s;
  report.markdown = Heading(machine, spent) + report.markdown;
  WriteTextFile(FLAGS_out + "/reproduce.json", DumpJson(report.json, 1) + "\n");
  WriteTextFile(FLAGS_out + "/reproduce.md", report.markdown);
  if (!report.details.empty()) {
    WriteTextFile(FLAGS_out + "/details.md", kDetailsHeading + report.details);
  }
  constexpr size_t kColumns = 100;
  const std::string where = FLAGS_out + "/reproduce.md";
  std::fputs(ForTerminal(report.markdown, kColumns, where).c_str(), stdout);
  std::printf("\nall columns and intervals: %s\n", where.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(argc, argv,
                           {"reproduce",
                            "the paper's tables beside results measured here",
                            "--data=DIR [--table=NAME] --out=DIR",
                            {"--data=data --out=out/tables",
                             "--data=data --table=shelf --out=out/tables"}},
                           kinegraph::RunReproduce);
}
