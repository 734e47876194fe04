#include "apps/tables/rows.h"

#include <utility>

#include "core/base/error.h"
#include "core/io/tracks/tracks.h"

namespace kinegraph {
namespace {

std::string MadeBy(const Method& method) {
  std::string text = "`configs/" + method.config + "`";
  if (!method.set.empty()) text += " with `" + method.set + "`";
  return text;
}

TrackedRow Read(const ResultFile& result, const std::string& data_folder,
                double frame_rate_hz) {
  TrackReadOptions options;
  options.frame_rate_hz = frame_rate_hz;
  TrackedRow row;
  row.method = result.method;
  row.recording = result.same_recording.value_or("");
  row.detections_note = result.detections_note;
  row.made_by = "`" + result.path + "`";
  row.remark = result.remark;
  row.tracks = ReadTracks(data_folder + "/" + result.path, options);
  return row;
}

// A file of other frames shall not pass for a bad score.
void RequireScoredFrames(const TrackSequence& truth,
                         const DetectionSequence& detections,
                         const Dataset& dataset) {
  for (const DetectionFrame& frame : detections.frames) {
    if (!ContainsFrame(dataset.protocol.frames, frame.frame)) continue;
    const TrackFrame* annotated = FindFrame(truth, frame.frame);
    if (annotated != nullptr && !annotated->people.empty()) return;
  }
  throw InputError(dataset.detections, "",
                   "no detection in any annotated frame that is scored; frame "
                   "numbers count from 0 as in actorsGT.mat");
}

}  // namespace

std::vector<HeadConversion> HeadConversionsOf(BenchmarkSet set) {
  return {HeadConversion::kChu, HeadConversion::kMvpose,
          set == BenchmarkSet::kCampus ? HeadConversion::kVoxelposeCampus
                                       : HeadConversion::kVoxelposeShelf,
          HeadConversion::k4d, HeadConversion::kRaw};
}

int64_t RowCount(const Benchmark& benchmark) {
  size_t count = benchmark.results.size() + benchmark.single_person.size();
  for (const BenchmarkRecording& recording : benchmark.recordings)
    count += recording.methods.size();
  return static_cast<int64_t>(count);
}

TrackedBenchmark TrackBenchmark(const Benchmark& benchmark,
                                const std::string& data_folder,
                                const std::string& extra_set,
                                const std::function<void()>& progress) {
  TrackedBenchmark tracked;
  tracked.benchmark = benchmark;
  double frame_rate_hz = 0.0;
  for (const BenchmarkRecording& recording : benchmark.recordings) {
    for (const Method& method : recording.methods) {
      Dataset dataset = recording.dataset;
      dataset.config = method.config;
      dataset.set = JoinSets(method.set, extra_set);
      LoadedDataset loaded = LoadDataset(dataset, data_folder);
      frame_rate_hz = loaded.options.input.frame_rate_hz;
      TrackedRow row;
      row.method = method.name;
      row.recording = dataset.name;
      row.detections_note = dataset.detections_note;
      row.made_by = MadeBy(method);
      row.ours = true;
      row.baseline = &method == &recording.methods.front();
      if (row.baseline) {
        RequireScoredFrames(loaded.truth, loaded.detections, dataset);
      }
      row.tracks = TracksOf(loaded);
      tracked.rows.push_back(std::move(row));
      tracked.truth = std::move(loaded.truth);
      progress();
    }
  }
  for (const ResultFile& result : benchmark.results) {
    tracked.rows.push_back(Read(result, data_folder, frame_rate_hz));
    progress();
  }
  for (const ResultFile& result : benchmark.single_person) {
    tracked.single_person.push_back(Read(result, data_folder, frame_rate_hz));
    progress();
  }
  for (const OwnRules& own : benchmark.own_rules) {
    TrackReadOptions options;
    if (own.protocol.stored_zeros_are_positions) {
      options.stored_zeros = StoredZeros::kKeep;
    }
    tracked.own_rules.push_back(
        EvaluatePcp(ReadTracks(data_folder + "/" + own.ground_truth, options),
                    ReadTracks(data_folder + "/" + own.result.path, options),
                    own.protocol));
  }
  return tracked;
}

}  // namespace kinegraph
