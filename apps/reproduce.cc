// kinegraph-reproduce: prints the paper's tables beside new measurements.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/machine.h"
#include "apps/common/plot.h"
#include "apps/common/progress.h"
#include "apps/common/table.h"
#include "apps/tables/dataset.h"
#include "apps/tables/pcp_tables.h"
#include "apps/tables/variants.h"
#include "core/base/error.h"
#include "core/io/files/atomic_file.h"

DEFINE_string(data, "",
              "folder of the datasets: the developers' (data/README.md) or "
              "official downloads (docs/official_data.md)");
DEFINE_string(table, "",
              "campus, campus_extended, shelf, parts, ablation, runtime or "
              "sensitivity; empty: every table");
DEFINE_string(set, "", "keys to change in every configuration: key=value;...");
DEFINE_string(out, "",
              "folder for reproduce.json, reproduce.md, details.md and plots");

namespace kinegraph {
namespace {

constexpr const char* kTables[] = {"campus",     "campus_extended", "shelf",
                                   "parts",      "ablation",        "runtime",
                                   "sensitivity"};

constexpr const char* kDetailsHeading =
    "# Details of the tables\n\nAll counts behind `reproduce.md`, for every "
    "conversion of nose, ears and shoulders to the bottom and top of the head "
    "(head), and by the mean error of a part's two ends or by each end "
    "(endpoints: mean, each); and the incorrect parts of each actor.\n\n";

bool Wanted(const std::string& table) {
  return FLAGS_table.empty() || FLAGS_table == table;
}

void CheckTable() {
  if (FLAGS_table.empty() ||
      std::count(std::begin(kTables), std::end(kTables), FLAGS_table) > 0) {
    return;
  }
  throw InputError(fmt::format("--table: found '{}', expected one of {}",
                               Printable(FLAGS_table),
                               fmt::join(kTables, ", ")));
}

// Checks that the data contain the set that --table is about.
void CheckSet(const BenchmarkData& data) {
  const bool of_shelf = FLAGS_table == "shelf";
  if (!of_shelf && FLAGS_table.rfind("campus", 0) != 0) return;
  const BenchmarkSet set =
      of_shelf ? BenchmarkSet::kShelf : BenchmarkSet::kCampus;
  for (const Benchmark& benchmark : data.benchmarks) {
    if (benchmark.set == set) return;
  }
  throw InputError(FLAGS_data, "",
                   fmt::format("has no {}, which --table={} needs",
                               of_shelf ? "Shelf" : "Campus", FLAGS_table));
}

// " --set='...'" as the user gave it; empty without --set.
std::string SetFlag() {
  return FLAGS_set.empty() ? "" : " --set=" + ShellQuoted(FLAGS_set);
}

// Collects the tables.
struct Report {
  std::string markdown;
  std::string details;
  Json json;

  void Add(const std::string& key, TableOutput table) {
    markdown += table.markdown + "Reproduced by `" + DriverName() +
                " reproduce --data=DATA --table=" + key + SetFlag() +
                " --out=DIR`.\n\n";
    details += table.details;
    json["tables"][key] = std::move(table.json);
  }
};

void AddActorTables(const std::vector<TrackedBenchmark>& all, Report* report) {
  const struct {
    const char* key;
    const char* title;
    BenchmarkSet set;
    PublishedTable published;
    PcpProtocol protocol;
  } kActorTables[] = {
      {"campus", "Campus", BenchmarkSet::kCampus, PublishedCampus(),
       CampusProtocol()},
      {"campus_extended", "Campus extended", BenchmarkSet::kCampus,
       PublishedCampusExtended(), CampusExtendedProtocol()},
      {"shelf", "Shelf", BenchmarkSet::kShelf, PublishedShelf(),
       ShelfProtocol()}};
  for (const auto& table : kActorTables) {  // in the paper's order
    if (!Wanted(table.key)) continue;
    for (const TrackedBenchmark& tracked : all) {
      if (tracked.benchmark.set != table.set) continue;
      report->Add(table.key, ActorTable(table.title, table.published, tracked,
                                        table.protocol));
    }
  }
}

void AddParts(const std::vector<TrackedBenchmark>& all, Report* report) {
  TableOutput parts;
  parts.markdown = "## Body parts\n\n";
  for (const TrackedBenchmark& tracked : all) {
    const bool shelf = tracked.benchmark.is_shelf();
    TableOutput one = shelf ? PartsTable("Shelf", PublishedShelfParts(),
                                         tracked, ShelfProtocol())
                            : PartsTable("Campus", PublishedCampusParts(),
                                         tracked, CampusProtocol());
    parts.markdown += one.markdown;
    parts.json[shelf ? "shelf" : "campus"] = std::move(one.json);
  }
  report->Add("parts", std::move(parts));
}

// Whether a table needs the tracks of a benchmark.
bool NeedsTracks(const Benchmark& benchmark) {
  if (Wanted("parts")) return true;
  return benchmark.is_shelf() ? Wanted("shelf")
                              : Wanted("campus") || Wanted("campus_extended");
}

std::string Heading(const Machine& machine, double processor_s, double wall_s) {
  return "# The paper's tables beside new measurements\n\nMade by "
         "`kinegraph-reproduce` of commit " +
         machine.commit + " on " + machine.processor + " (" +
         std::to_string(machine.threads) + " processors), " + machine.system +
         ", " + machine.compiler + ", in " + Fixed(processor_s, 0) +
         " s of processor time (" + Fixed(wall_s, 0) +
         " s of wall time, one thread). Rows \"as printed in the paper\" are "
         "Chu et al. (2021), "
         "Part-aware Measurement for Robust Multi-View Multi-Human 3D Pose "
         "Estimation and Tracking; every other row was measured by this "
         "command. The detections behind the printed rows are not public, so a "
         "difference from them is not a difference of methods. A difference "
         "whose interval includes zero is not significant.\n\n" +
         (FLAGS_set.empty() ? ""
                            : "Every configuration of this report, also where "
                              "it is called published, was changed by `" +
                                  SetFlag().substr(1) + "`.\n\n");
}

void RunReproduce() {
  RequireFlag("data", FLAGS_data);
  RequireFlag("out", FLAGS_out);
  CheckTable();
  if (Wanted("sensitivity") || Wanted("ablation")) RequirePlotTool();
  // Created before the work, so that a wrong path fails early.
  const OutputFolder folder(FLAGS_out);
  const BenchmarkData data = FindBenchmarks(FLAGS_data, FLAGS_set);
  CheckSet(data);
  const Machine machine = ThisMachine();
  Report report;
  const auto start = std::chrono::steady_clock::now();
  report.json["machine"] = {{"commit", machine.commit},
                            {"processor", machine.processor},
                            {"processors", machine.threads},
                            {"system", machine.system},
                            {"compiler", machine.compiler}};
  if (!FLAGS_set.empty()) report.json["set"] = FLAGS_set;
  std::vector<TrackedBenchmark> tracked;
  {
    int64_t rows = 0;
    for (const Benchmark& benchmark : data.benchmarks) {
      if (NeedsTracks(benchmark)) rows += RowCount(benchmark);
    }
    Progress progress("tracking", rows);
    for (const Benchmark& benchmark : data.benchmarks) {
      if (!NeedsTracks(benchmark)) continue;
      tracked.push_back(TrackBenchmark(data, benchmark, &progress));
    }
  }
  AddActorTables(tracked, &report);
  if (Wanted("parts")) AddParts(tracked, &report);
  if (Wanted("ablation")) {
    report.Add("ablation", AblationTable(data, FLAGS_out));
  }
  if (Wanted("runtime")) report.Add("runtime", RuntimeTable(data));
  if (Wanted("sensitivity")) {
    report.Add("sensitivity", SensitivityTable(data, FLAGS_out));
  }
  const double processor_s = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const std::chrono::duration<double> wall =
      std::chrono::steady_clock::now() - start;
  report.json["machine"]["processor_s"] = processor_s;
  report.json["machine"]["wall_s"] = wall.count();
  report.markdown =
      Heading(machine, processor_s, wall.count()) + report.markdown;
  WriteTextFile(FLAGS_out + "/reproduce.json", DumpJson(report.json, 1) + "\n");
  WriteTextFile(FLAGS_out + "/reproduce.md", report.markdown);
  if (!report.details.empty()) {
    WriteTextFile(FLAGS_out + "/details.md", kDetailsHeading + report.details);
  }
  const std::string where = FLAGS_out + "/reproduce.md";
  std::fputs(ForTerminal(report.markdown, kTerminalColumns, where).c_str(),
             stdout);
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
