// kinegraph-synthesize: makes a scene from a seed, with detections and ground
// truth.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <cstdio>
#include <string>
#include <vector>

#include "apps/common/adapter_flag.h"
#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "apps/common/synthesis.h"
#include "apps/common/track_files.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/configuration/config.h"
#include "core/io/detections/format.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "solvers/session/run.h"

DEFINE_string(config, "",
              "scene and noise (TOML, see configs/synthetic); required without "
              "--motion");
DEFINE_string(motion, "",
              "tracks files F[,F2] whose people replace the simulated ones; "
              "frame rate and duration also come from these files unless the "
              "configuration sets them");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(format, "",
              "also writes the detections as another program would, to "
              "OUT/detections_FORMAT (`convert --formats` lists them)");
DEFINE_string(out, "",
              "folder for cameras.json, detections.jsonl, truth.jsonl and "
              "scene.json; created if missing");
DEFINE_bool(keys, false, "print the keys of a configuration and exit");

namespace kinegraph {
namespace {

// The format of --format; nullptr without it.
const DetectionFormat* WantedFormat() {
  if (FLAGS_format.empty()) return nullptr;
  const DetectionFormat* format = FindDetectionFormat(FLAGS_format);
  if (format != nullptr && format->write != nullptr) return format;
  std::string names;
  for (const DetectionFormat& known : DetectionFormats()) {
    if (known.write == nullptr) continue;
    names += (names.empty() ? "" : ", ") + known.name;
  }
  throw InputError(
      "--format: '" + Printable(FLAGS_format) +
      "' is not a detection format that can be written, expected one of " +
      names);
}

bool IsOneFile(const DetectionFormat& format) {
  return format.files == DetectionFormat::Files::kOne;
}

std::string PathOf(const DetectionFormat& format) {
  return FLAGS_out + "/detections_" + format.name +
         (IsOneFile(format) ? format.extension : std::string());
}

// Throws if the detections cannot be written, before files of another scene are
// replaced.
void CheckDetectionsPath(const DetectionFormat& format) {
  if (!IsFolder(FLAGS_out)) return;
  AtomicFiles files;
  if (IsOneFile(format)) {
    files.Aside(PathOf(format));
  } else if (IsFolder(PathOf(format))) {
    files.FolderAside(PathOf(format));
  }
}

void WriteDetectionsAs(const DetectionFormat& format,
                       const SyntheticRecording& recording) {
  const std::string path = PathOf(format);
  DetectionWriteOptions options;
  const Camera& camera = recording.scene.cameras.front();
  options.image_size = {camera.width_px(), camera.height_px()};
  MemorySource source(recording.detections);
  LostFields lost_fields;
  format.write(path, options, &source, &lost_fields);
  SayNotes(lost_fields, "kinegraph-synthesize: ");
  std::printf("detections as %s -> %s\n", format.name.c_str(), path.c_str());
}

void RunSynthesize() {
  UseAdapterFlag();
  if (FLAGS_keys) {
    std::fputs(KeyTable(KeysOf<SynthesisOptions>()).c_str(), stdout);
    return;
  }
  const std::vector<std::string> motion = ParseList(FLAGS_motion, "motion");
  if (motion.empty()) RequireFlag("config", FLAGS_config);
  RequireFlag("out", FLAGS_out);
  const DetectionFormat* format = WantedFormat();
  if (format != nullptr) CheckDetectionsPath(*format);
  const SyntheticRecording recording =
      MakeRecording(FindConfig(FLAGS_config), FLAGS_set, motion);
  WriteRecording(recording, FLAGS_out);
  if (format != nullptr) WriteDetectionsAs(*format, recording);
  const Scene& scene = recording.scene;
  const std::string text = fmt::format(
      "{}, {}, {}, {} -> {}\n",
      Counted(static_cast<int64_t>(recording.detections.frames.size()), "frame",
              "frames"),
      Counted(static_cast<int64_t>(scene.cameras.size()), "camera", "cameras"),
      Counted(static_cast<int64_t>(scene.people.size()), "person", "people"),
      Counted(CountDetections(recording.detections), "detection", "detections"),
      FLAGS_out);
  std::fputs(text.c_str(), stdout);
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"synthesize",
       "makes a scene from a seed: cameras, detections and ground truth",
       "[--config=F.toml] [--motion=F[,F2]] --out=DIR",
       {"--config=configs/synthetic/demo.toml --out=out/scene",
        "--config=configs/synthetic/hard.toml --set=scene.people=8 "
        "--out=out/crowd"}},
      kinegraph::RunSynthesize);
}
