// Reading detections from files that the system holds in memory, and writing
// tracks. Needs the real data (KINEGRAPH_DATA).
#include <benchmark/benchmark.h>

#include <string>

#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

void ReadTake(benchmark::State& state, const std::string& path) {
  int64_t frames = 0;
  for (auto _ : state) {
    const auto source = OpenDetections(path);
    DetectionFrame frame;
    while (source->Next(&frame)) ++frames;
  }
  state.counters["frames/s"] = benchmark::Counter(static_cast<double>(frames),
                                                  benchmark::Counter::kIsRate);
}

// 1505 files.
void ReadOpenPose(benchmark::State& state) {
  const auto path = testing::FindData("shelf/detections/openpose");
  if (!path) return state.SkipWithError("needs the data");
  ReadTake(state, path->string());
}
BENCHMARK(ReadOpenPose)->Unit(benchmark::kMillisecond)->UseRealTime();

// The same detections as one file of our own.
void ReadOurs(benchmark::State& state) {
  const auto path = testing::FindData("shelf/detections/openpose");
  if (!path) return state.SkipWithError("needs the data");
  const testing::TemporaryFolder folder;
  const std::string ours = folder.path() / "shelf.jsonl";
  WriteDetections(ours, ReadDetections(path->string()));
  ReadTake(state, ours);
}
BENCHMARK(ReadOurs)->Unit(benchmark::kMillisecond)->UseRealTime();

// 820 poses of 17 joints, with a covariance each when the argument is 1.
void WriteShelfTracks(benchmark::State& state) {
  const auto path =
      testing::FindData("shelf/reference/paper_code_shelf_warm3.json");
  if (!path) return state.SkipWithError("needs the data");
  TrackSequence tracks = ReadTracks(path->string());
  if (state.range(0) == 1) {
    for (TrackFrame& frame : tracks.frames) {
      for (PersonPose& person : frame.people) {
        for (const Joint3d& joint : person.joints) {
          person.covariances.emplace_back(joint.position_m *
                                          joint.position_m.transpose());
        }
      }
    }
  }
  const testing::TemporaryFolder folder;
  for (auto _ : state) {
    WriteTracks((folder.path() / "tracks.jsonl").string(), tracks);
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(tracks.frames.size()),
                         benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(WriteShelfTracks)
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace kinegraph

BENCHMARK_MAIN();
