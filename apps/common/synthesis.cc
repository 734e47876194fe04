#include "apps/common/synthesis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/evaluation/markers/marker_sets.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/config.h"
#include "core/io/detections/writer.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"

namespace kinegraph {
namespace {

// A path in a file: absolute, or relative to the file's folder.
std::string Beside(const std::string& file, const std::string& path) {
  const size_t slash = file.rfind('/');
  if (path[0] == '/' || slash == std::string::npos) return path;
  return file.substr(0, slash + 1) + path;
}

struct Configuration {
  ConfigFile file;  // to locate a key in messages
  SynthesisOptions options;
  Skeleton skeleton;
};

Configuration ReadConfiguration(const std::string& path,
                                const std::string& set) {
  Configuration read = {
      path.empty() ? ConfigFile::Empty() : ConfigFile::Read(path), {}, {}};
  ConfigFile& config = read.file;
  if (!set.empty()) config.Override(set, "--set");
  SynthesisOptions& options = read.options;
  config.Apply(&options);
  const std::vector<Skeleton> skeletons = config.ReadSkeletons();
  config.RejectUnknown();
  try {
    read.skeleton = ResolveSkeleton(options.scene.skeleton, skeletons);
  } catch (const InputError& error) {
    throw config.Locate(OptionError("scene.skeleton", error.what()));
  }
  return read;
}

// Reads the clips of the command line, else of the configuration, and sets
// options->clips to the paths that were read.
std::vector<MotionClip> ReadClips(const std::string& config_path,
                                  const std::vector<std::string>& motion,
                                  RecordedPeopleOptions* options) {
  if (!motion.empty()) {
    options->clips = motion;
  } else {
    for (std::string& clip : options->clips) {
      if (clip.empty()) {
        throw InputError(config_path, "motion.clips", "an empty file name");
      }
      clip = Beside(config_path, clip);
    }
  }
  std::vector<MotionClip> clips;
  for (const std::string& clip : options->clips) {
    TrackSequence tracks = ReadTracks(clip);
    const MarkerSet* markers =
        RecogniseMarkerSet(tracks.header.skeleton.joints());
    if (markers != nullptr) {
      tracks = JointsOfMarkers(tracks, *markers).tracks;
    }
    clips.push_back({clip, std::move(tracks)});
  }
  return clips;
}

// Unless set, takes the frame rate from the first clip, and as duration the
// time until the last person has left.
void FitToClips(const ConfigFile& config, const std::vector<MotionClip>& clips,
                const std::vector<std::shared_ptr<const Actor>>& people,
                SceneOptions* scene) {
  const double rate = clips.front().tracks.header.frame_rate_hz;
  if (!config.Has("scene.frame_rate") && rate > 0.0) {
    scene->frame_rate_hz = rate;
  }
  if (config.Has("scene.duration")) return;
  constexpr double kSlack = 1e-3;  // frames: rounding of the clip's times
  const double frames =
      std::floor(EndOf(people) * scene->frame_rate_hz + kSlack) + 1.0;
  scene->duration_s = frames / scene->frame_rate_hz;
}

// ---- scene.json: configuration, people, and the truth of each detection ----

std::string SixDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string SpansJson(const std::vector<TimeSpan>& spans, double end_s) {
  std::string json = "[";
  for (const TimeSpan& span : spans) {
    const double begin = std::max(0.0, span.begin_s);
    const double end = std::min(end_s, span.end_s);
    if (begin >= end) continue;
    json += (json.size() > 1 ? ", [" : "[") + SixDigits(begin) + ", " +
            SixDigits(end) + "]";
  }
  return json + "]";
}

std::string PersonJson(const Actor& person, size_t id, double end_s) {
  const ActorFacts facts = person.Facts();
  std::string json = "{\"id\": " + std::to_string(id);
  if (!facts.clip.empty()) {
    json += ", \"clip\": " + JsonText(facts.clip) +
            ", \"clip_id\": " + std::to_string(facts.clip_id.value());
  }
  return json + ", \"stature\": " + SixDigits(facts.stature_m) +
         ", \"present\": " + SpansJson(facts.present, end_s) +
         ", \"seated\": " + SpansJson(facts.seated, end_s) + "}";
}

// [person or -1, note, [joints that are outliers]] of one detection.
std::string LabelJson(const DetectionTruth& truth) {
  std::string json = "[" + std::to_string(truth.person) + ", " +
                     JsonText(NoteOf(truth)) + ", [";
  for (size_t i = 0; i < truth.outliers.size(); ++i) {
    json += (i > 0 ? ", " : "") + std::to_string(truth.outliers[i]);
  }
  return json + "]]";
}

std::string FrameJson(const DetectionHeader& header,
                      const DetectionFrame& frame,
                      const std::vector<std::vector<DetectionTruth>>& truth) {
  std::string json =
      "{\"frame\": " + std::to_string(frame.frame) + ", \"views\": {";
  for (size_t v = 0; v < truth.size(); ++v) {
    json += (v > 0 ? ", " : "") + JsonText(header.view_names[v]) + ": [";
    for (size_t d = 0; d < truth[v].size(); ++d) {
      json += (d > 0 ? ", " : "") + LabelJson(truth[v][d]);
    }
    json += "]";
  }
  return json + "}}";
}

void WriteSceneFile(const std::string& path,
                    const SyntheticRecording& recording) {
  AtomicFile file(path);
  file.Write("{\"kinegraph_scene\": 1,\n\"config\": " +
             EffectiveConfigJson(recording.options) + ",\n\"people\": [");
  for (size_t i = 0; i < recording.scene.people.size(); ++i) {
    file.Write((i > 0 ? ",\n " : "\n ") +
               PersonJson(*recording.scene.people[i], i,
                          recording.options.scene.duration_s));
  }
  file.Write("],\n\"detections\": [");
  for (size_t f = 0; f < recording.detections.frames.size(); ++f) {
    file.Write((f > 0 ? ",\n " : "\n ") +
               FrameJson(recording.detections.header,
                         recording.detections.frames[f],
                         recording.labels.frames[f]));
  }
  file.Write("]}\n");
  file.Commit();
}

}  // namespace

void SynthesisOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("scene");
  scene.Describe(visitor);
  visitor.Leave();
  visitor.Enter("motion");
  motion.Describe(visitor);
  visitor.Leave();
  visitor.Enter("noise");
  noise.Describe(visitor);
  visitor.Leave();
}

SyntheticRecording MakeRecording(const std::string& config_path,
                                 const std::string& set,
                                 const std::vector<std::string>& motion) {
  Configuration read = ReadConfiguration(config_path, set);
  const std::vector<MotionClip> clips =
      ReadClips(config_path, motion, &read.options.motion);
  if (!clips.empty() && !read.file.Has("scene.skeleton")) {
    const Skeleton part = JointsOfClips(clips, read.skeleton);
    // People need a trunk. If the clips lack it, the whole skeleton is kept, so
    // that MakeRecordedPeople reports the first missing joint.
    const auto has = [&part](const char* joint) {
      return part.IndexOf(joint) >= 0;
    };
    if (has("l_shoulder") && has("r_shoulder") && has("l_hip") &&
        has("r_hip")) {
      read.skeleton = part;
    }
  }
  // Adds the table to errors of `body`, which name only the key.
  const auto located = [&read](const char* table, const auto& body) {
    try {
      body();
    } catch (const OptionError& error) {
      throw read.file.Locate(
          OptionError(table + ("." + error.key()), error.message()));
    }
  };
  std::vector<std::shared_ptr<const Actor>> people;
  located("motion", [&] {
    people =
        MakeRecordedPeople(read.options.motion, clips, read.skeleton,
                           {read.options.scene.motion.area_radius_m,
                            read.options.scene.motion.min_distance_m,
                            static_cast<uint64_t>(read.options.scene.seed)});
  });
  if (!clips.empty()) {
    FitToClips(read.file, clips, people, &read.options.scene);
  }
  SyntheticRecording recording;
  recording.options = read.options;
  located("scene", [&] {
    recording.scene =
        clips.empty() ? MakeScene(read.options.scene, read.skeleton)
                      : MakeScene(read.options.scene, read.skeleton, people);
  });
  located("noise", [&] {
    recording.detections =
        Observe(recording.scene, read.options.noise, &recording.labels);
  });
  recording.truth = TruthFor(recording.scene, recording.detections);
  recording.truth.header.config_json = EffectiveConfigJson(recording.options);
  return recording;
}

RecordingFiles WriteRecording(const SyntheticRecording& recording,
                              const std::string& folder) {
  const OutputFolder made(folder);
  const auto in_folder = [&folder](const char* name) {
    return folder + "/" + name;
  };
  const RecordingFiles files = {
      in_folder("cameras.json"), in_folder("detections.jsonl"),
      in_folder("truth.jsonl"), in_folder("scene.json")};
  AtomicFiles aside;
  // Files are renamed one after another. Removing the old ones first prevents a
  // mixture of two recordings if the process is killed in between.
  for (const std::string& path :
       {files.scene, files.cameras, files.detections, files.truth}) {
    aside.Aside(path);
    aside.RemoveOld(path);
  }
  WriteCameras(aside.Aside(files.cameras), recording.scene.cameras);
  WriteDetections(aside.Aside(files.detections), recording.detections);
  WriteTracks(aside.Aside(files.truth), recording.truth);
  WriteSceneFile(aside.Aside(files.scene), recording);
  aside.Commit();
  return files;
}

int64_t CountDetections(const DetectionSequence& sequence) {
  int64_t count = 0;
  for (const DetectionFrame& frame : sequence.frames) {
    for (const ViewDetections& view : frame.views) {
      count += static_cast<int64_t>(view.detections.size());
    }
  }
  return count;
}

}  // namespace kinegraph
