#include "apps/tables/runtime.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "apps/common/table.h"
#include "core/evaluation/statistics.h"
#include "core/system/process.h"
#include "core/tracking/tracker.h"

namespace kinegraph {
namespace {

constexpr double kNsPerMs = 1e6;

struct TimedMethod {
  std::string name;
  std::string recording;
  Dataset dataset;
};

void AddTimedMethods(const Benchmark& benchmark,
                     std::vector<TimedMethod>* timed) {
  const size_t recordings = std::min<size_t>(2, benchmark.recordings.size());
  for (size_t t = 0; t < recordings; ++t) {
    const BenchmarkRecording& recording = benchmark.recordings[t];
    for (const Method& method : recording.methods) {
      TimedMethod one{method.name, recording.dataset.name, recording.dataset};
      one.dataset.config = method.config;
      one.dataset.set = method.set;
      timed->push_back(one);
      if (method.name.rfind("paper mode", 0) != 0) continue;
      one.name += ", no joints filter";
      one.dataset.set =
          JoinSets(method.set, "reconstruction.joints_filter=false");
      timed->push_back(std::move(one));
    }
  }
}

std::vector<TimedMethod> TimedMethods(
    const std::vector<Benchmark>& benchmarks) {
  std::vector<TimedMethod> timed;
  for (const Benchmark& benchmark : benchmarks) {
    AddTimedMethods(benchmark, &timed);
  }
  return timed;
}

// Milliseconds a frame.
struct Timing {
  double preparation = 0.0;
  double association = 0.0;
  double reconstruction = 0.0;
  double estimation = 0.0;
  double initialisation = 0.0;
  double whole = 0.0;
  int repetitions = 0;

  // The stages of the paper's table, by which it computes its frame rate.
  double PaperStages() const {
    return association + reconstruction + initialisation;
  }
};

Timing Measure(const LoadedDataset& loaded, const RuntimeOptions& options) {
  std::array<std::vector<double>, 6> samples;
  const int64_t start_ns = ThreadCpuNs();
  int done = 0;
  while (done < options.repetitions) {
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
    const std::array<int64_t, 6> values_ns = {
        stages.preparation_ns,    stages.association_ns,
        stages.reconstruction_ns, stages.estimation_ns,
        stages.initialisation_ns, whole_ns};
    for (size_t i = 0; i < samples.size(); ++i) {
      samples[i].push_back(static_cast<double>(values_ns[i]) / kNsPerMs /
                           frames);
    }
    ++done;
    const double spent_s = static_cast<double>(ThreadCpuNs() - start_ns) * 1e-9;
    if (done >= 2 && spent_s > options.max_seconds) break;
  }
  const auto median = [&](size_t i) { return Quantile(samples[i], 0.5); };
  return {median(0), median(1), median(2), median(3),
          median(4), median(5), done};
}

}  // namespace

int64_t RuntimeRowCount(const std::vector<Benchmark>& benchmarks) {
  return static_cast<int64_t>(TimedMethods(benchmarks).size());
}

TableOutput RuntimeTable(const std::vector<Benchmark>& benchmarks,
                         const std::string& data_folder,
                         const std::string& extra_set,
                         const RuntimeOptions& options,
                         const std::function<void()>& progress) {
  Table table({"measured, ms a frame", "detections", "preparation",
               "affinity and association", "reconstruction", "initialisation",
               "fps of these three", "estimation", "whole",
               "fps of the whole"});
  TableOutput output;
  const TableOutput printed = PrintedTable(PublishedRuntime());
  output.json["printed"] = printed.json;
  output.json["measured"] = Json::array();
  for (const TimedMethod& method : TimedMethods(benchmarks)) {
    Dataset dataset = method.dataset;
    dataset.set = JoinSets(dataset.set, extra_set);
    const Timing timing = Measure(LoadDataset(dataset, data_folder), options);
    table.AddRow({method.name, method.recording, Fixed(timing.preparation, 4),
                  Fixed(timing.association, 4), Fixed(timing.reconstruction, 4),
                  Fixed(timing.initialisation, 4),
                  Fixed(1000.0 / timing.PaperStages(), 0),
                  Fixed(timing.estimation, 4), Fixed(timing.whole, 4),
                  Fixed(1000.0 / timing.whole, 0)});
    output.json["measured"].push_back(
        {{"method", method.name},
         {"detections", method.recording},
         {"config", dataset.config},
         {"set", dataset.set},
         {"repetitions", timing.repetitions},
         {"preparation_ms", timing.preparation},
         {"association_ms", timing.association},
         {"reconstruction_ms", timing.reconstruction},
         {"estimation_ms", timing.estimation},
         {"initialisation_ms", timing.initialisation},
         {"whole_ms", timing.whole}});
    progress();
  }
  output.markdown =
      "## Runtime by stage\n\nPrinted: " + PublishedRuntime().caption +
      ".\n\n" + printed.markdown +
      "\nMeasured here: processor time of one thread, detections in memory, "
      "median of up to " +
      std::to_string(options.repetitions) +
      " runs over the recording. Languages, machines and detections differ, so "
      "only "
      "orders of magnitude compare. `preparation`: joint sets, lens; "
      "`estimation`: the smoothing (paper mode) or the window's solver; the "
      "batch solves when the recording has ended, so its solver is in `whole` "
      "alone, as are second passes.\n\n" +
      table.ToString(TableStyle::kMarkdown) + "\n";
  return output;
}

}  // namespace kinegraph
