#include "apps/common/synthesis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/configuration/config.h"
#include "core/io/configuration/noise_model.h"
#include "core/io/detections/writer.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"

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

double Scaled(double rate, double factor) {
  return std::min(1.0, rate * factor);
}

// Mean length of a run that goes on with chance `stays`.
double RunSeconds(double stays) {
  constexpr double kLongest = 1000.0;  // frames
  return std::min(kLongest, 1.0 / std::max(1.0 - stays, 1e-9)) /
         kNoiseModelFrameRate;
}

// The model's sigma is the scale of a Student core. Its static share is taken
// as Gaussian, the rest as Student of that scale, whose variance is larger by
// dof / (dof - 2).
JointNoise NoiseOf(const NoiseModelGroup& group, const NoiseModel& model,
                   const NoiseModelOptions& options, double focal_px) {
  JointNoise noise;
  const double tails = group.student_dof / (group.student_dof - 2.0);
  const double variance =
      group.static_share + (1.0 - group.static_share) * tails;
  const double scale_px = options.noise * group.sigma_m * focal_px;
  noise.sigma_px = scale_px * std::sqrt(variance);
  noise.reference_depth_m = 1.0;  // metres times focal length: px at 1 m
  noise.floor_px = options.floor_px;
  noise.student_dof = group.student_dof;
  noise.static_share = group.static_share / variance;
  const double white =
      std::max(0.0, 1.0 - group.static_share - group.slow_share);
  noise.white_share = white * tails / variance;
  noise.correlation_time_s =
      group.slow_rho > 0.0 && group.slow_rho < 1.0
          ? -1.0 / (kNoiseModelFrameRate * std::log(group.slow_rho))
          : 0.0;
  noise.outlier_rate = Scaled(group.outlier_rate, options.outliers);
  noise.outlier_burst_s = RunSeconds(group.outlier_stays);
  // Beyond 4 sigma, with the measured median.
  noise.outlier_min_px = 4.0 * scale_px;
  noise.outlier_max_px = (2.0 * group.outlier_median_sigma - 4.0) * scale_px;
  noise.outlier_on_other = model.outlier_on_other;
  noise.missing_rate = Scaled(group.missing_rate, options.missing);
  noise.missing_burst_s = RunSeconds(group.missing_stays);
  noise.hidden_missing_rate =
      Scaled(group.hidden_missing_rate, options.missing);
  noise.hidden_noise_factor =
      group.sigma_m > 0.0 ? group.hidden_sigma_m / group.sigma_m : 1.0;
  return noise;
}

// Which measured group stands for a class.
const char* GroupOf(JointClass joint_class) {
  switch (joint_class) {
    case JointClass::kHead:
    case JointClass::kOther:
      return "face";
    case JointClass::kShoulder:
      return "shoulder";
    case JointClass::kElbow:
      return "elbow";
    case JointClass::kWrist:
      return "wrist";
    case JointClass::kTrunk:
    case JointClass::kHip:
      return "hip";
    case JointClass::kKnee:
      return "knee";
    case JointClass::kAnkle:
    case JointClass::kFoot:
      break;
  }
  return "ankle";
}

void ApplyModel(const NoiseModel& model, const std::string& path,
                const NoiseModelOptions& options, double focal_px,
                NoiseOptions* noise) {
  for (int c = 0; c < kJointClassCount; ++c) {
    const auto joint_class = static_cast<JointClass>(c);
    const auto group = model.groups.find(GroupOf(joint_class));
    if (group == model.groups.end()) {
      throw InputError(path, "noise",
                       std::string("no group '") + GroupOf(joint_class) + "'");
    }
    noise->by_class[joint_class] =
        NoiseOf(group->second, model, options, focal_px);
  }
  noise->found_by_azimuth = model.found_by_azimuth;
  for (auto& [joint, shares] : noise->found_by_azimuth) {
    for (double& share : shares) {
      share = 1.0 - Scaled(1.0 - share, options.missing);
    }
  }
  const auto seconds = [](double frames) {
    return frames / kNoiseModelFrameRate;
  };
  noise->confidence = model.confidence;
  noise->confidence_sigma = model.confidence_sigma;
  if (model.confidence > 0.0) {
    noise->hidden_confidence_factor =
        std::min(1.0, model.hidden_confidence / model.confidence);
    noise->outlier_confidence_factor =
        std::min(1.0, model.outlier_confidence / model.confidence);
  }
  noise->missed_rate = Scaled(model.missed_person.rate, options.missed);
  noise->missed_burst_s = seconds(model.missed_person.mean_frames);
  noise->hidden_missed_rate = Scaled(model.hidden_missed_rate, options.missed);
  noise->min_joints = 4;  // as in the detections modelled with these figures
  noise->false_people = model.false_people * options.false_people;
  noise->swap_whole_rate = Scaled(model.swap_whole.rate, options.swaps);
  noise->swap_arm_rate = Scaled(model.swap_arm.rate, options.swaps);
  noise->swap_leg_rate = Scaled(model.swap_leg.rate, options.swaps);
  noise->swap_burst_s = seconds(model.swap_whole.mean_frames);
  noise->fragment_rate = Scaled(model.fragment_rate, options.fragments);
}

// Keys of the joints that stand in [noise] beside a model would have no effect.
class JointKeyChecker : public OptionChecker {
 public:
  explicit JointKeyChecker(const ConfigFile& config) : config_(config) {}
  void Number(const std::string& key, double*, const Limits&,
              const std::string&, const std::string&) override {
    if (!config_.Has("noise." + key)) return;
    throw config_.Locate(
        OptionError("noise." + key,
                    "has no effect beside noise.model.file, which tells the "
                    "figures of joints; scale them in [noise.model]"));
  }

 private:
  const ConfigFile& config_;
};

// A path as a file names it: absolute, or from the file's own folder.
std::string Beside(const std::string& file, const std::string& path) {
  const size_t slash = file.rfind('/');
  if (path[0] == '/' || slash == std::string::npos) return path;
  return file.substr(0, slash + 1) + path;
}

struct Configuration {
  ConfigFile file;  // says where a key is set
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
  if (!options.model.file.empty()) {
    JointKeyChecker checker(config);
    options.noise.joints.Describe(checker);
    const std::string model = Beside(path, options.model.file);
    ApplyModel(ReadNoiseModel(model), model, options.model,
               options.scene.cameras.focal_px, &options.noise);
    config.Apply(&options);  // keys of the file win
  }
  try {
    read.skeleton = ResolveSkeleton(options.scene.skeleton, skeletons);
  } catch (const InputError& error) {
    throw InputError(path, "scene.skeleton", error.what());
  }
  return read;
}

// Reads the clips: those of the command line, else the configuration's. The
// options then name the files as they were opened.
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
    clips.push_back({clip, ReadTracks(clip)});
  }
  return clips;
}

// Frame rate and duration of the clips where nothing sets them: the first
// clip's rate, and until the last of the people has left.
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

// A name of a file may hold anything.
std::string JsonText(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
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

// What was asked for and what stands behind each detection.
void WriteSceneFile(const std::string& path, const SyntheticTake& take) {
  AtomicFile file(path);
  file.Write("{\"kinegraph_scene\": 1,\n\"config\": " +
             EffectiveConfigJson(take.options) + ",\n\"noise_by_class\": " +
             EffectiveConfigJson(ClassFigures{take.options.noise.by_class}) +
             ",\n\"people\": [");
  for (size_t i = 0; i < take.scene.people.size(); ++i) {
    file.Write(
        (i > 0 ? ",\n " : "\n ") +
        PersonJson(*take.scene.people[i], i, take.options.scene.duration_s));
  }
  file.Write("],\n\"detections\": [");
  for (size_t f = 0; f < take.detections.frames.size(); ++f) {
    file.Write((f > 0 ? ",\n " : "\n ") + FrameJson(take.detections.header,
                                                    take.detections.frames[f],
                                                    take.labels.frames[f]));
  }
  file.Write("]}\n");
  file.Commit();
}

}  // namespace

void NoiseModelOptions::Describe(OptionVisitor& visitor) {
  const Limits factor = Between(0.0, 100.0);
  visitor.Text("file", &file,
               "noise_model.json with measured figures, relative to this "
               "file's folder");
  visitor.Number("noise", &noise, factor, "", "factor on pixel noise");
  visitor.Number("floor", &floor_px, NonNegative(), "px",
                 "white noise added at every depth");
  visitor.Number("outliers", &outliers, factor, "", "factor on their rate");
  visitor.Number("missing", &missing, factor, "",
                 "factor on the rate of missing joints");
  visitor.Number("missed", &missed, factor, "",
                 "factor on the rate of missed people");
  visitor.Number("swaps", &swaps, factor, "", "factor on their rate");
  visitor.Number("false_people", &false_people, factor, "",
                 "factor on their number");
  visitor.Number("fragments", &fragments, factor, "", "factor on their rate");
}

void SynthesisOptions::Describe(OptionVisitor& visitor) {
  visitor.Enter("scene");
  scene.Describe(visitor);
  visitor.Leave();
  visitor.Enter("motion");
  motion.Describe(visitor);
  visitor.Leave();
  visitor.Enter("noise");
  noise.Describe(visitor);
  visitor.Enter("model");
  model.Describe(visitor);
  visitor.Leave();
  visitor.Leave();
}

SyntheticTake MakeTake(const std::string& config_path, const std::string& set,
                       const std::vector<std::string>& motion) {
  Configuration read = ReadConfiguration(config_path, set);
  const std::vector<MotionClip> clips =
      ReadClips(config_path, motion, &read.options.motion);
  // Errors of the stages name keys of their own table.
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
  SyntheticTake take;
  take.options = read.options;
  located("scene", [&] {
    take.scene = clips.empty()
                     ? MakeScene(read.options.scene, read.skeleton)
                     : MakeScene(read.options.scene, read.skeleton, people);
  });
  located("noise", [&] {
    take.detections = Observe(take.scene, read.options.noise, &take.labels);
  });
  take.truth = TruthFor(take.scene, take.detections);
  take.truth.header.config_json = EffectiveConfigJson(take.options);
  return take;
}

TakeFiles WriteTake(const SyntheticTake& take, const std::string& folder) {
  const OutputFolder made(folder);
  const auto in_folder = [&folder](const char* name) {
    return folder + "/" + name;
  };
  const TakeFiles files = {in_folder("cameras.json"),
                           in_folder("detections.jsonl"),
                           in_folder("truth.jsonl"), in_folder("scene.json")};
  WriteCameras(files.cameras, take.scene.cameras);
  WriteDetections(files.detections, take.detections);
  WriteTracks(files.truth, take.truth);
  WriteSceneFile(files.scene, take);
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
