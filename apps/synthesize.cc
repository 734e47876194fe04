// kinegraph-synthesize: a seeded scene with its detections and its truth.
#include <gflags/gflags.h>

#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/app.h"
#include "apps/common/synthesis.h"
#include "core/io/config.h"

DEFINE_string(config, "", "scene and noise (TOML, see configs/synthetic)");
DEFINE_string(motion, "",
              "tracks files F[,F2]: recorded people in place of simulated "
              "ones; frame rate and duration are then theirs where nothing "
              "sets them");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(out, "", "folder for the four files; made if missing");
DEFINE_bool(keys, false, "list the keys of a configuration and leave");

namespace kinegraph {
namespace {

void RunSynthesize() {
  if (FLAGS_keys) {
    std::fputs(ConfigReference<SynthesisOptions>().c_str(), stdout);
    return;
  }
  const std::vector<std::string> motion = ParseList(FLAGS_motion, "motion");
  if (motion.empty()) RequireFlag("config", FLAGS_config);
  RequireFlag("out", FLAGS_out);
  const SyntheticTake take = MakeTake(FLAGS_config, FLAGS_set, motion);
  WriteTake(take, FLAGS_out);
  std::printf("%zu frames, %zu cameras, %zu people, %lld detections -> %s\n",
              take.detections.frames.size(), take.scene.cameras.size(),
              take.scene.people.size(),
              static_cast<long long>(CountDetections(take.detections)),
              FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"synthesize", "a seeded scene: cameras, detections and their truth",
       "--config=F.toml [--motion=F[,F2]] --out=DIR"},
      kinegraph::RunSynthesize);
}
