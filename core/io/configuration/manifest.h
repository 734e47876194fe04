// A manifest lists recordings and configurations; each recording is run with
// each configuration.
//
//   held_out = true                   # also score held-out cameras
//   compare = true                    # compare the smoothing strategies
//   report = true                     # write an HTML report of each run
//   [[takes]]                         # a recording
//   name = "walk"                     # also the name of its output folder
//   cameras = "walk/cameras.json"     # relative to the manifest's folder
//   detections = "walk/poses"
//   ground_truth = "walk/truth.jsonl" # optional; requires protocol
//   protocol = "mpjpe"                # of the evaluation, with ground_truth
//   frames = "0:500"                  # optional
//   set = "input.frame_rate=25"       # optional: keys of this recording
//   [[configurations]]
//   name = "window"
//   config = "window.toml"
//   set = "graph.lag_s=0.6"           # optional
//   mode = "graph"                    # optional
#ifndef KINEGRAPH_CORE_IO_CONFIGURATION_MANIFEST_H_
#define KINEGRAPH_CORE_IO_CONFIGURATION_MANIFEST_H_

#include <functional>
#include <string>
#include <vector>

namespace kinegraph {

// Absent texts are empty; paths are absolute.
struct ManifestRecording {
  std::string name;
  std::string cameras;
  std::string detections;
  std::string ground_truth;
  std::string protocol;
  std::string frames;
  std::string set;
};

struct ManifestConfiguration {
  std::string name;
  std::string config;
  std::string set;
  std::string mode;
};

struct Manifest {
  bool held_out = false;
  bool compare = false;
  bool report = false;
  std::vector<ManifestRecording> recordings;
  std::vector<ManifestConfiguration> configurations;
};

// Returns the path of a configuration that comes with kinegraph
// ("configs/default.toml"); empty if there is none of this name. Used for
// configurations that do not exist relative to the manifest's folder.
using FindShipped = std::function<std::string(const std::string& name)>;

// Throws InputError naming file and key for anything missing, unknown, of the
// wrong type, or duplicate. A manifest without configurations is accepted,
// because `kinegraph compare` can get one from --config.
Manifest ReadManifest(const std::string& path,
                      const FindShipped& shipped = nullptr);

// Text of a manifest. It reads back as the same manifest from any folder, since
// paths are absolute.
std::string ManifestText(const Manifest& manifest);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_CONFIGURATION_MANIFEST_H_
