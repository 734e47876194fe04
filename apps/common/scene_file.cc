#include "apps/common/scene_file.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "core/io/configuration/config.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/json.h"

namespace kinegraph {
namespace {

// The figures of classes measured apart, for scene.json.
struct ClassFigures {
  std::map<JointClass, JointNoise> by_class;

  void Describe(OptionVisitor& visitor) {
    for (auto& [joint_class, noise] : by_class) {
      visitor.Enter(ToString(joint_class));
      noise.Describe(visitor);
      visitor.Leave();
    }
  }
};

std::string Quoted(const std::string& text) { return "\"" + text + "\""; }

std::string Seconds(double value) {
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
    json += (json.size() > 1 ? ", [" : "[") + Seconds(begin) + ", " +
            Seconds(end) + "]";
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
  return json + ", \"stature\": " + Seconds(facts.stature_m) +
         ", \"present\": " + SpansJson(facts.present, end_s) +
         ", \"seated\": " + SpansJson(facts.seated, end_s) + "}";
}

// [person or -1, note, [joints that are outliers]] of one detection.
std::string LabelJson(const DetectionTruth& truth) {
  std::string json =
      "[" + std::to_string(truth.person) + ", " + Quoted(NoteOf(truth)) + ", [";
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
    json += (v > 0 ? ", " : "") + Quoted(header.view_names[v]) + ": [";
    for (size_t d = 0; d < truth[v].size(); ++d) {
      json += (d > 0 ? ", " : "") + LabelJson(truth[v][d]);
    }
    json += "]";
  }
  return json + "}}";
}

}  // namespace

void WriteSceneFile(const std::string& path,
                    const SyntheticRecording& recording) {
  AtomicFile file(path);
  file.Write(
      "{\"kinegraph_scene\": 1,\n\"config\": " +
      EffectiveConfigJson(recording.options) + ",\n\"noise_by_class\": " +
      EffectiveConfigJson(ClassFigures{recording.options.noise.by_class}) +
      ",\n\"people\": [");
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

}  // namespace kinegraph
