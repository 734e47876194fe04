// A recording as a comparison is asked for it, read and frozen.
#ifndef KINEGRAPH_APPS_COMPARE_RECORDING_INPUT_H_
#define KINEGRAPH_APPS_COMPARE_RECORDING_INPUT_H_

#include <string>
#include <vector>

#include "core/io/configuration/manifest.h"
#include "solvers/session/run.h"

namespace kinegraph {

// Empty texts are not given.
struct RecordingInput {
  std::string name;  // of a recording among several
  std::string cameras;
  std::string detections;
  std::string config;
  std::string mode;
  std::string set;
  std::string frames;
};

// Recordings of a manifest with its one configuration; `config`, `mode` and
// `set` win over, or are added to, the manifest's. Throws InputError where
// there are fewer than two recordings, or not one configuration.
std::vector<RecordingInput> RecordingsOf(const Manifest& manifest,
                                         const std::string& path,
                                         const std::string& config,
                                         const std::string& mode,
                                         const std::string& set);

struct FrozenRecording {
  RunOptions options;
  FrozenRun run;
};

// Throws InputError.
FrozenRecording FreezeRecording(const RecordingInput& input, int threads);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMPARE_RECORDING_INPUT_H_
