#include "apps/common/flag_examples.h"

#include <cctype>
#include <map>

namespace kinegraph {
namespace {

const std::map<std::string, std::string>& Examples() {
  static const std::map<std::string, std::string> kExamples = {
      {"align", "none"},
      {"annotated", "everybody"},
      {"axes", "x,-z,y"},
      {"baseline", "butterworth"},
      {"calibrate.to", "opencv"},
      {"cameras", "calibration.toml"},
      {"cameras_apart", "cam1,cam2,3.42"},
      {"compare.markers", "walk.c3d"},
      {"config", "my.toml"},
      {"convert.set", "'cameras.unit=mm'"},
      {"corrections", "take.identity.jsonl"},
      {"data", "data"},
      {"demo.config", "configs/synthetic/hard.toml"},
      {"demo.set", "scene.people=3"},
      {"detections", "openpose/"},
      {"distance", "l_hip,l_knee,0.44"},
      {"doctor", "out/doctor"},
      {"embed_megabytes", "20"},
      {"endpoints", "each"},
      {"focal", "1150"},
      {"focal_error", "5"},
      {"folds", "300:438,463:601"},
      {"format", "openpose"},
      {"frame_rate", "60"},
      {"frames", "300:600"},
      {"frames_out", "out/annotated"},
      {"from", "pose2sim"},
      {"ground_truth", "truth.jsonl"},
      {"head", "mvpose"},
      {"held_out_set", "held_out_set.json"},
      {"image_size", "1920,1080"},
      {"images", "'cam1=video/cam1/%06d.jpg;cam2=video/cam2/%06d.jpg'"},
      {"in", "take.jsonl"},
      {"jobs", "2"},
      {"joint", "l_wrist"},
      {"joints", "joints.toml"},
      {"json", "out/scores.json"},
      {"manifest", "takes.toml"},
      {"markers", "pose2sim"},
      {"matching", "one_to_one"},
      {"mode", "paper"},
      {"motion", "walk.jsonl"},
      {"parameters", "out/compare/parameters.toml"},
      {"person", "3"},
      {"plot_strategies", "butterworth,batch"},
      {"protocol", "mpjpe"},
      {"reference", "paper.jsonl"},
      {"reproduce.set", "detections.skeleton=body25b"},
      {"runs", "without_cam0.jsonl,without_cam1.jsonl"},
      {"scale", "1.78"},
      {"set", "'input.frame_rate=60;cameras.unit=mm'"},
      {"skeleton", "body25b"},
      {"strategies", "butterworth,batch"},
      {"synthesize.config", "configs/synthetic/demo.toml"},
      {"synthesize.set", "'scene.people=8;noise.sigma=4'"},
      {"table", "shelf"},
      {"task", "walk/default"},
      {"threads", "2"},
      {"title", "'Walk, first try'"},
      {"to", "trc"},
      {"tracks", "out/take.jsonl"},
      {"unit", "mm"},
      {"up", "-y"},
      {"without_cameras", "cam2"}};
  return kExamples;
}

const std::map<std::string, std::string>& Results() {
  static const std::map<std::string, std::string> kResults = {
      {"track", "out/take.jsonl"},     {"init", "my.toml"},
      {"report", "out/take.html"},     {"convert", "out/take.csv"},
      {"batch", "out/batch"},          {"calibrate", "out/cameras.json"},
      {"compare", "out/compare"},      {"demo", "out/demo"},
      {"evaluate", "out/markers"},     {"doctor", "out/doctor"},
      {"reproduce", "out/tables"},     {"synthesize", "out/scene"},
      {"kinematics", "out/angles.csv"}};
  return kResults;
}

}  // namespace

std::string FlagExample(const std::string& command, const std::string& flag,
                        const std::string& type,
                        const std::string& default_value) {
  const std::string name = "--" + flag;
  if (type == "bool") {
    return default_value == "true" ? "--no" + flag : name;
  }
  const auto& examples = flag == "out" ? Results() : Examples();
  auto at = examples.find(flag == "out" ? command : command + "." + flag);
  if (at == examples.end()) at = examples.find(flag);
  if (at != examples.end()) return name + "=" + at->second;
  return name + "=" + (default_value.empty() ? "VALUE" : default_value);
}

std::set<std::string> RequiredFlags(const std::string& usage) {
  const std::string first = usage.substr(0, usage.find("kinegraph-"));
  std::set<std::string> flags;
  int depth = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (first[i] == '[') ++depth;
    if (first[i] == ']') --depth;
    if (depth > 0 || first.compare(i, 2, "--") != 0) continue;
    size_t end = i + 2;
    while (end < first.size() &&
           (std::isalnum(static_cast<unsigned char>(first[end])) != 0 ||
            first[end] == '_')) {
      ++end;
    }
    flags.insert(first.substr(i + 2, end - i - 2));
    i = end - 1;
  }
  return flags;
}

}  // namespace kinegraph
