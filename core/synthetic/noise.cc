#include "core/synthetic/noise.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/synthetic/false_people.h"
#include "core/synthetic/noise_process.h"
#include "core/synthetic/person_observer.h"
#include "core/synthetic/sight.h"

namespace kinegraph {
namespace {

constexpr double kMaxOffset = 1.0;  // of a clock [s]; kSceneMargin covers it

void CheckJointNoise(const std::string& key, const JointNoise& noise) {
  CheckOptions(noise);
  if (noise.static_share + noise.white_share > 1.0) {
    throw OptionError(key + "static_share",
                      "the static and the white share are more than 1");
  }
  if (noise.outlier_min_px > noise.outlier_max_px) {
    throw OptionError(key + "outlier_min", "is above outlier_max");
  }
  if (noise.student_dof != 0.0 && noise.student_dof <= 2.0) {
    throw OptionError(key + "student_dof",
                      "found " + std::to_string(noise.student_dof) +
                          ", expected 0 (Gaussian) or more than 2");
  }
}

void CheckNoise(const NoiseOptions& options, size_t cameras) {
  CheckOptions(options);
  CheckJointNoise("", options.joints);
  for (const auto& [joint_class, noise] : options.by_class) {
    CheckJointNoise(std::string(ToString(joint_class)) + ".", noise);
  }
  for (const auto& [joint, found] : options.found_by_azimuth) {
    if (found.empty()) throw OptionError(joint, "no bins");
  }
  if (options.clock_offset_s.size() > cameras) {
    throw OptionError("clock_offset",
                      "found " + std::to_string(options.clock_offset_s.size()) +
                          " numbers for " + std::to_string(cameras) +
                          " cameras");
  }
}

bool HiddenMatters(const JointNoise& noise) {
  return noise.hidden_missing_rate > 0.0 || noise.hidden_noise_factor != 1.0;
}

// Whether any option depends on occlusion, which is slow to compute.
bool HiddenMatters(const NoiseOptions& options) {
  return options.hidden_missed_rate > 0.0 || HiddenMatters(options.joints) ||
         std::any_of(
             options.by_class.begin(), options.by_class.end(),
             [](const auto& entry) { return HiddenMatters(entry.second); });
}

// One camera over the whole recording.
class ViewObserver {
 public:
  ViewObserver(const NoiseOptions& options, const Scene& scene, int view_idx)
      : options_(options),
        scene_(scene),
        camera_(scene.cameras[view_idx]),
        false_people_(options, scene, camera_, view_idx),
        order_(StreamSeed(options.seed, Stream::kOrder, view_idx, 0)),
        drops_(StreamSeed(options.seed, Stream::kFrames, view_idx, 1)) {
    for (int i = 0; i < static_cast<int>(scene.people.size()); ++i) {
      people_.emplace_back(options, scene.skeleton, SizeOf(camera_),
                           scene.frame_rate_hz, view_idx, i);
    }
  }

  std::vector<LabelledDetection> Step(const SceneMoment& moment) {
    const std::vector<PersonSight> sights =
        Sights(camera_, moment, scene_.skeleton.joint_count());
    std::vector<LabelledDetection> detections;
    for (PersonObserver& person : people_) person.Step(sights, &detections);
    false_people_.Step(&detections);
    Shuffle(&detections);
    const bool dropped =
        drop_.Step(options_.dropped_view_rate,
                   options_.drop_burst_s * scene_.frame_rate_hz, &drops_);
    if (dropped) detections.clear();
    return detections;
  }

 private:
  void Shuffle(std::vector<LabelledDetection>* detections) {
    for (size_t i = detections->size(); i > 1; --i) {
      const auto other =
          static_cast<size_t>(order_.Index(static_cast<int64_t>(i)));
      std::swap((*detections)[i - 1], (*detections)[other]);
    }
    for (size_t i = 0; i < detections->size(); ++i) {
      (*detections)[i].detection.index_in_file = static_cast<int>(i);
    }
  }

  const NoiseOptions& options_;
  const Scene& scene_;
  const Camera& camera_;
  std::vector<PersonObserver> people_;
  FalsePeople false_people_;
  Random order_;
  Random drops_;
  MarkovBursts drop_;
};

// When the frames were taken, and which were lost.
class FrameTimes {
 public:
  FrameTimes(const NoiseOptions& options, double frame_rate_hz)
      : options_(options),
        frame_rate_hz_(frame_rate_hz),
        drops_(StreamSeed(options.seed, Stream::kFrames, 0, 0)),
        jitter_(StreamSeed(options.seed, Stream::kJitter, 0, 0)) {}

  bool NextIsDropped() {
    return drop_.Step(options_.dropped_frame_rate,
                      options_.drop_burst_s * frame_rate_hz_, &drops_);
  }

  // Distance of the next frame from the beat; frames keep their order.
  TimeNs NextJitter() {
    const double limit = 0.45 / frame_rate_hz_;
    const double jitter = jitter_.Normal(0.0, options_.time_jitter_s);
    return FromSeconds(std::clamp(jitter, -limit, limit));
  }

  TimeNs OffsetOf(int view_idx) const {
    const auto view = static_cast<size_t>(view_idx);
    return view < options_.clock_offset_s.size()
               ? FromSeconds(options_.clock_offset_s[view])
               : 0;
  }

 private:
  const NoiseOptions& options_;
  double frame_rate_hz_;
  Random drops_;
  Random jitter_;
  MarkovBursts drop_;
};

DetectionHeader HeaderFor(const Scene& scene) {
  DetectionHeader header;
  header.skeleton = scene.skeleton;
  header.frame_rate_hz = scene.frame_rate_hz;
  for (const Camera& camera : scene.cameras) {
    header.view_names.push_back(camera.name());
  }
  return header;
}

}  // namespace

void JointNoise::Describe(OptionVisitor& visitor) {
  visitor.Number("sigma", &sigma_px, NonNegative(), "px",
                 "standard deviation of each pixel coordinate");
  visitor.Number("reference_depth", &reference_depth_m, NonNegative(), "m",
                 "pixel figures hold there and fall with 1/depth; 0: they "
                 "hold at every depth");
  visitor.Number("floor", &floor_px, NonNegative(), "px",
                 "white noise added at every depth");
  visitor.Number("student_dof", &student_dof, Between(0.0, 1e6), "",
                 "degrees of freedom of Student-t tails, above 2; 0: Gaussian");
  visitor.Number("static_share", &static_share, Between(0.0, 1.0), "",
                 "of the variance: constant over the recording");
  visitor.Number("white_share", &white_share, Between(0.0, 1.0), "",
                 "of the variance: independent from frame to frame");
  visitor.Number("correlation_time", &correlation_time_s, Between(0.0, 1e6),
                 "s", "of the rest of the variance; 0: white too");
  visitor.Number("outlier_rate", &outlier_rate, Between(0.0, 1.0), "",
                 "share of joints that lie far off");
  visitor.Number("outlier_burst", &outlier_burst_s, Between(0.0, 1e6), "s",
                 "exact length of a run of outliers; 0: each by itself");
  visitor.Number("outlier_min", &outlier_min_px, NonNegative(), "px",
                 "least distance of an outlier");
  visitor.Number("outlier_max", &outlier_max_px, NonNegative(), "px",
                 "greatest distance of an outlier");
  visitor.Number("outlier_on_other", &outlier_on_other, Between(0.0, 1.0), "",
                 "share of outliers on the same joint of a person nearby");
  visitor.Number("missing_rate", &missing_rate, Between(0.0, 1.0), "",
                 "share of joints that are not found");
  visitor.Number("missing_burst", &missing_burst_s, Between(0.0, 1e6), "s",
                 "mean length of a gap; 0: each frame by itself");
  visitor.Number("hidden_missing_rate", &hidden_missing_rate, Between(0.0, 1.0),
                 "", "share not found where another body is in front");
  visitor.Number("hidden_noise_factor", &hidden_noise_factor,
                 Between(0.0, 100.0), "",
                 "on sigma where another body is in front");
}

const JointNoise& NoiseOptions::Of(JointClass joint_class) const {
  const auto at = by_class.find(joint_class);
  return at == by_class.end() ? joints : at->second;
}

void NoiseOptions::Describe(OptionVisitor& visitor) {
  const Limits share = Between(0.0, 1.0);
  const Limits length = Between(0.0, 1e6);
  visitor.Integer("seed", &seed, Between(0, 9e15), "", "same seed, same noise");
  joints.Describe(visitor);
  visitor.Number("confidence", &confidence, share, "",
                 "mean confidence of a plain joint");
  visitor.Number("confidence_sigma", &confidence_sigma, share, "",
                 "random part of the confidence");
  visitor.Number("hidden_confidence_factor", &hidden_confidence_factor, share,
                 "", "on the confidence where another body is in front");
  visitor.Number("outlier_confidence_factor", &outlier_confidence_factor, share,
                 "", "on the confidence of an outlier");
  visitor.Number("noise_spread", &noise_spread, Between(0.0, 2.0), "",
                 "spread of log sigma over observations; confidence tells it");
  visitor.Number("missed_rate", &missed_rate, share, "",
                 "share of people not found in a view");
  visitor.Number("missed_burst", &missed_burst_s, length, "s",
                 "mean length; 0: each frame by itself");
  visitor.Number("hidden_missed_rate", &hidden_missed_rate, share, "",
                 "share not found when most joints are hidden");
  visitor.Integer("min_joints", &min_joints, Between(1, 1000), "",
                  "fewer joints make no detection");
  visitor.Number("false_people", &false_people, Between(0.0, 50.0), "",
                 "mean number of detections of nobody in an image");
  visitor.Number("false_life", &false_life_s, length, "s", "their mean life");
  visitor.Number("swap_whole_rate", &swap_whole_rate, share, "",
                 "share of detections with left and right exchanged");
  visitor.Number("swap_arm_rate", &swap_arm_rate, share, "",
                 "the same of elbows and wrists alone");
  visitor.Number("swap_leg_rate", &swap_leg_rate, share, "",
                 "the same of knees and feet alone");
  visitor.Number("swap_burst", &swap_burst_s, length, "s",
                 "mean length; 0: each frame by itself");
  visitor.Number("fragment_rate", &fragment_rate, share, "",
                 "share of people split at the hips into two detections");
  visitor.Number("double_rate", &double_rate, share, "",
                 "share of people found twice");
  visitor.Number("fragment_burst", &fragment_burst_s, length, "s",
                 "mean length of both; 0: each frame by itself");
  visitor.Number("dropped_frame_rate", &dropped_frame_rate, Between(0.0, 0.99),
                 "", "share of frames that are not there");
  visitor.Number("dropped_view_rate", &dropped_view_rate, share, "",
                 "share of images without any detection");
  visitor.Number("drop_burst", &drop_burst_s, length, "s",
                 "mean length of both; 0: each by itself");
  visitor.NumberList("clock_offset", &clock_offset_s,
                     Between(-kMaxOffset, kMaxOffset), "s",
                     "how much later each camera looks; the rest 0");
  visitor.Number("time_jitter", &time_jitter_s, Between(0.0, 0.1), "s",
                 "how far frames come off the beat");
  visitor.Boolean("tell_times", &tell_times,
                  "times tell offset and jitter; else they tell the beat");
}

std::string NoteOf(const DetectionTruth& truth) {
  std::string note;
  switch (truth.swap) {
    case Swap::kNone:
      break;
    case Swap::kWhole:
      note = "swap_whole";
      break;
    case Swap::kArm:
      note = "swap_arm";
      break;
    case Swap::kLeg:
      note = "swap_leg";
      break;
  }
  const auto append = [&](const char* text) {
    note += note.empty() ? text : std::string("+") + text;
  };
  switch (truth.kind) {
    case DetectionKind::kPerson:
      break;
    case DetectionKind::kUpperPart:
      append("fragment_upper");
      break;
    case DetectionKind::kLowerPart:
      append("fragment_lower");
      break;
    case DetectionKind::kDouble:
      append("double");
      break;
    case DetectionKind::kFalse:
      append("false_positive");
      break;
  }
  return note;
}

DetectionSequence Observe(const Scene& scene, const NoiseOptions& options,
                          ObservationTruth* truth) {
  CheckNoise(options, scene.cameras.size());
  const int view_count = static_cast<int>(scene.cameras.size());
  const bool with_obstacles = HiddenMatters(options);
  std::vector<ViewObserver> views;
  views.reserve(scene.cameras.size());
  for (int v = 0; v < view_count; ++v) views.emplace_back(options, scene, v);
  FrameTimes times(options, scene.frame_rate_hz);

  DetectionSequence sequence;
  sequence.header = HeaderFor(scene);
  if (truth != nullptr) truth->frames.clear();
  for (size_t i = 0; i < scene.times.size(); ++i) {
    const bool dropped = times.NextIsDropped();
    const TimeNs beat = scene.times[i];
    const TimeNs taken = beat + times.NextJitter();
    DetectionFrame frame;
    frame.frame = static_cast<int64_t>(i);
    frame.time = options.tell_times ? taken : beat;
    std::vector<std::vector<DetectionTruth>> frame_truth;
    std::optional<SceneMoment> moment;
    for (int v = 0; v < view_count; ++v) {
      const TimeNs capture = taken + times.OffsetOf(v);
      if (!moment.has_value() || moment->time != capture) {
        moment = LookAtScene(scene, capture, with_obstacles);
      }
      ViewDetections view;
      view.capture_time = options.tell_times ? capture : beat;
      frame_truth.emplace_back();
      for (LabelledDetection& labelled : views[v].Step(*moment)) {
        view.detections.push_back(std::move(labelled.detection));
        frame_truth.back().push_back(std::move(labelled.truth));
      }
      frame.views.push_back(std::move(view));
    }
    if (dropped) continue;
    sequence.frames.push_back(std::move(frame));
    if (truth != nullptr) truth->frames.push_back(std::move(frame_truth));
  }
  return sequence;
}

TrackSequence TruthFor(const Scene& scene,
                       const DetectionSequence& detections) {
  std::vector<FrameTime> frames;
  for (const DetectionFrame& frame : detections.frames) {
    frames.push_back({frame.frame, frame.time});
  }
  return TruthAt(scene, frames);
}

}  // namespace kinegraph
