// Makes a synthetic recording from a configuration and writes its files; shared
// by the commands that create one.
#ifndef KINEGRAPH_APPS_COMMON_SYNTHESIS_H_
#define KINEGRAPH_APPS_COMMON_SYNTHESIS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/recorded_people.h"
#include "core/synthetic/scene.h"

namespace kinegraph {

// The options of a whole configuration file.
struct SynthesisOptions {
  SceneOptions scene;
  RecordedPeopleOptions motion;
  NoiseOptions noise;

  void Describe(OptionVisitor& visitor);
};

// A scene, its simulated detections, and the truth about both.
struct SyntheticRecording {
  SynthesisOptions options;
  Scene scene;
  DetectionSequence detections;
  ObservationTruth labels;
  TrackSequence truth;  // at the frames and times of the detections
};

// Makes the recording of a configuration (TOML; empty: all defaults) with the
// command line's changes (`set`: the value of --set). `motion`: tracks files
// that replace the configuration's motion.clips. Clips determine frame rate,
// duration and joints unless these are set. Throws InputError naming file, line
// and key.
SyntheticRecording MakeRecording(const std::string& config_path,
                                 const std::string& set,
                                 const std::vector<std::string>& motion = {});

// The files of a recording in its folder.
struct RecordingFiles {
  std::string cameras;     // cameras.json
  std::string detections;  // detections.jsonl
  std::string truth;       // truth.jsonl: tracks
  // scene.json: the configuration, the people, and the truth of each detection.
  std::string scene;
};

// Writes the four files and returns their paths; creates the folder if missing.
RecordingFiles WriteRecording(const SyntheticRecording& recording,
                              const std::string& folder);

int64_t CountDetections(const DetectionSequence& sequence);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_SYNTHESIS_H_
