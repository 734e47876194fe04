#include "core/synthetic/noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/base/constants.h"
#include "core/base/random.h"
#include "core/synthetic/noise_process.h"

namespace kinegraph {
namespace {

using Eigen::Vector2d;

// A separate seed for each kind of randomness and each pair of indices (view,
// person, ...), so that random numbers of one do not affect another.
enum class Stream {
  kPixels,
  kOutliers,
  kMissing,
  kConfidence,
  kPeople,
  kFalsePeople,
  kOrder,
  kFrames,
  kJitter
};

// SplitMix64's finaliser (Steele, Lea and Flood 2014) over the four numbers.
uint64_t StreamSeed(int64_t seed, Stream stream, int a, int b) {
  uint64_t state = static_cast<uint64_t>(seed);
  for (const uint64_t part :
       {static_cast<uint64_t>(stream), static_cast<uint64_t>(a),
        static_cast<uint64_t>(b)}) {
    state += 0x9e3779b97f4a7c15ULL * (part + 1);
    state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9ULL;
    state = (state ^ (state >> 27)) * 0x94d049bb133111ebULL;
    state ^= state >> 31;
  }
  return state;
}

struct LabelledDetection {
  Detection detection;
  DetectionTruth truth;
};

// ---- Detections of a person ----

constexpr double kLeastConfidence = 0.05;
// Factors on the confidence of hidden joints and of outliers.
constexpr double kHiddenConfidence = 0.9;
constexpr double kOutlierConfidence = 0.8;

double Correlation(double time_s, double frame_rate_hz) {
  return time_s > 0.0 ? std::exp(-1.0 / (frame_rate_hz * time_s)) : 0.0;
}

bool IsArm(JointClass c) {
  return c == JointClass::kElbow || c == JointClass::kWrist;
}

bool IsBelowHips(JointClass c) {
  return c == JointClass::kKnee || c == JointClass::kAnkle ||
         c == JointClass::kFoot;
}

bool InSwap(Swap swap, JointClass c) {
  return swap == Swap::kWhole || (swap == Swap::kArm && IsArm(c)) ||
         (swap == Swap::kLeg && IsBelowHips(c));
}

// Joints that are not found do not count as outliers.
void DropLostOutliers(LabelledDetection* labelled) {
  auto& outliers = labelled->truth.outliers;
  outliers.erase(std::remove_if(outliers.begin(), outliers.end(),
                                [&](int j) {
                                  return !labelled->detection.joints[j].found;
                                }),
                 outliers.end());
}

// Turns exact projections of one person into detections with all modelled
// errors.
class PersonObserver {
 public:
  // `seed` returns the seed of each kind of randomness. References must outlive
  // the observer.
  PersonObserver(const NoiseOptions& options, const Scene& scene,
                 const Camera& camera, int person_idx,
                 const std::function<uint64_t(Stream)>& seed)
      : options_(options),
        skeleton_(scene.skeleton),
        camera_(camera),
        frame_rate_hz_(scene.frame_rate_hz),
        person_(person_idx),
        pixels_(seed(Stream::kPixels)),
        outliers_(seed(Stream::kOutliers)),
        missing_(seed(Stream::kMissing)),
        confidence_(seed(Stream::kConfidence)),
        people_(seed(Stream::kPeople)),
        joints_(skeleton_.joints().size()) {
    for (size_t j = 0; j < joints_.size(); ++j) {
      joints_[j].noise =
          &options.Of(skeleton_.joint_class(static_cast<int>(j)));
    }
  }

  // The next frame; `sights` has all people of the scene in this view.
  void Step(const std::vector<PersonSight>& sights,
            std::vector<LabelledDetection>* detections) {
    const PersonSight& person = sights[person_];
    LabelledDetection whole;
    whole.truth.person = person_;
    int in_image = 0;
    int hidden = 0;
    for (int j = 0; j < skeleton_.joint_count(); ++j) {
      bool outlier = false;
      whole.detection.joints.push_back(Measure(j, sights, &outlier));
      if (outlier) whole.truth.outliers.push_back(j);
      in_image += person.joints[j].in_image ? 1 : 0;
      hidden += person.joints[j].in_image && person.joints[j].hidden ? 1 : 0;
    }
    const bool mostly_hidden = 2 * hidden > in_image;
    const double missed_rate =
        mostly_hidden
            ? std::max(options_.missed_rate, options_.hidden_missed_rate)
            : options_.missed_rate;
    const bool missed =
        missed_.Step(missed_rate, Frames(options_.missed_burst_s), &people_);
    const Swap swap = ChooseSwap();
    const double length = Frames(options_.fragment_burst_s);
    const bool split = fragment_.Step(options_.fragment_rate, length, &people_);
    const bool twice = double_.Step(options_.double_rate, length, &people_);

    auto enough = [&](const LabelledDetection& labelled) {
      return CountFound(labelled.detection) >=
             std::max<int64_t>(1, options_.min_joints);
    };
    if (!person.present || missed || !enough(whole)) return;
    if (swap != Swap::kNone) ExchangeSides(swap, &whole);
    if (split) {
      LabelledDetection upper = PartOf(whole, DetectionKind::kUpperPart);
      LabelledDetection lower = PartOf(whole, DetectionKind::kLowerPart);
      if (enough(upper) && enough(lower)) {
        detections->push_back(std::move(upper));
        detections->push_back(std::move(lower));
        return;
      }
    }
    if (twice) {
      LabelledDetection second = SecondOf(whole);
      if (enough(second)) detections->push_back(std::move(second));
    }
    detections->push_back(std::move(whole));
  }

 private:
  struct JointState {
    const JointNoise* noise = nullptr;
    Vector2d fixed = Vector2d::Zero();
    SlowGaussian slow;
    SlowGaussian spread;
    SlowStudentScale tails;
    MarkovBursts missing;
    FixedBursts outlier;
    Vector2d displacement = Vector2d::Zero();
    int other = -1;  // person onto whom the outlier falls
    bool started = false;
  };
  struct Displacement {
    Vector2d px = Vector2d::Zero();
    double sigma_factor = 1.0;  // reflected in the confidence
  };

  double Frames(double seconds) const { return seconds * frame_rate_hz_; }
  double DepthScale(const JointNoise& noise, const JointSight& sight) const {
    if (noise.reference_depth_m <= 0.0) return 1.0;
    constexpr double kLeastDepth = 0.1;  // [m]
    return noise.reference_depth_m / std::max(sight.depth_m, kLeastDepth);
  }

  bool Misses(int joint, const PersonSight& person) {
    JointState& state = joints_[joint];
    const JointNoise& noise = *state.noise;
    double rate = noise.missing_rate;
    if (person.joints[joint].hidden) {
      rate = std::max(rate, noise.hidden_missing_rate);
    }
    return state.missing.Step(rate, Frames(noise.missing_burst_s), &missing_);
  }

  Displacement PixelNoise(int joint, const JointSight& sight) {
    JointState& state = joints_[joint];
    const JointNoise& noise = *state.noise;
    const double rho = Correlation(noise.correlation_time_s, frame_rate_hz_);
    const auto normal = [&] { return NormalVector(&pixels_); };
    if (!state.started) {
      state.started = true;
      state.fixed = normal();
    }
    const double slow_share =
        std::max(0.0, 1.0 - noise.static_share - noise.white_share);
    const Vector2d slow = state.slow.Step(rho, &pixels_);
    const Vector2d changing =
        std::sqrt(slow_share) * slow + std::sqrt(noise.white_share) * normal();
    const double tails =
        noise.student_dof > 0.0
            ? state.tails.Step(rho, noise.student_dof, &pixels_)
            : 1.0;
    const Vector2d unit =
        std::sqrt(noise.static_share) * state.fixed + tails * changing;

    // exp(s g - s^2) has unit mean square.
    const double s = options_.noise_spread;
    Displacement displacement;
    if (s > 0.0) {
      const double g = state.spread.Step(rho, &confidence_).x();
      displacement.sigma_factor = std::exp(s * g - s * s);
    }
    const double sigma_px = noise.sigma_px * DepthScale(noise, sight) *
                            displacement.sigma_factor *
                            (sight.hidden ? noise.hidden_noise_factor : 1.0);
    displacement.px = sigma_px * unit + noise.floor_px * normal();
    return displacement;
  }

  // The other person whose same joint is nearest in the image, if it is nearer
  // than the observed person's own farthest joint, else -1: detectors confuse
  // people who overlap or stand side by side.
  int NearestOther(int joint, const std::vector<PersonSight>& sights) const {
    const std::vector<JointSight>& own = sights[person_].joints;
    if (!own[joint].in_image) return -1;
    double nearest = 0.0;
    for (const JointSight& other : own) {
      if (!other.in_image) continue;
      nearest = std::max(nearest, (other.px - own[joint].px).norm());
    }
    int person = -1;
    for (int i = 0; i < static_cast<int>(sights.size()); ++i) {
      if (i == person_ || !sights[i].present) continue;
      const JointSight& other = sights[i].joints[joint];
      if (!other.in_image) continue;
      const double distance = (other.px - own[joint].px).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      person = i;
    }
    return person;
  }

  // Whether the joint is an outlier; if so, moves `px`.
  bool Outlier(int joint, const std::vector<PersonSight>& sights,
               Vector2d* px) {
    JointState& state = joints_[joint];
    const JointNoise& noise = *state.noise;
    const JointSight& sight = sights[person_].joints[joint];
    const int frames = std::max(
        1, static_cast<int>(std::lround(Frames(noise.outlier_burst_s))));
    bool began = false;
    const bool on =
        state.outlier.Step(noise.outlier_rate, frames, &outliers_, &began);
    if (began) {
      const double angle = outliers_.Uniform(-kPi, kPi);
      state.displacement =
          outliers_.Uniform(noise.outlier_min_px, noise.outlier_max_px) *
          Vector2d(std::cos(angle), std::sin(angle));
      const bool on_other = outliers_.Chance(noise.outlier_on_other);
      state.other = on_other ? NearestOther(joint, sights) : -1;
    }
    if (!on) return false;
    if (state.other >= 0) {
      const PersonSight& other = sights[state.other];
      if (other.present && other.joints[joint].in_image) {
        *px += other.joints[joint].px - sight.px;
        return true;
      }
    }
    Vector2d displacement = DepthScale(noise, sight) * state.displacement;
    // Detectors find nothing outside the image.
    if (!IsInImage(camera_, *px + displacement)) displacement = -displacement;
    *px += displacement;
    return true;
  }

  Keypoint Measure(int joint, const std::vector<PersonSight>& sights,
                   bool* outlier) {
    const PersonSight& person = sights[person_];
    const JointSight& sight = person.joints[joint];
    // All processes advance, whether the person is visible or not.
    const bool misses = Misses(joint, person);
    const Displacement noise = PixelNoise(joint, sight);
    Keypoint keypoint;
    keypoint.px = sight.px + noise.px;
    *outlier = Outlier(joint, sights, &keypoint.px);
    const double chance = confidence_.Normal();
    keypoint.found = person.present && sight.in_image && !misses;
    *outlier = *outlier && keypoint.found;
    if (!keypoint.found) return Keypoint();
    double mean = options_.confidence;
    if (sight.hidden) mean *= kHiddenConfidence;
    if (*outlier) mean *= kOutlierConfidence;
    mean /= noise.sigma_factor * noise.sigma_factor;
    keypoint.confidence = std::clamp(mean + options_.confidence_sigma * chance,
                                     kLeastConfidence, 1.0);
    return keypoint;
  }

  Swap ChooseSwap() {
    const double length = Frames(options_.swap_burst_s);
    const bool whole =
        swap_whole_.Step(options_.swap_whole_rate, length, &people_);
    const bool arm = swap_arm_.Step(options_.swap_arm_rate, length, &people_);
    const bool leg = swap_leg_.Step(options_.swap_leg_rate, length, &people_);
    if (whole) return Swap::kWhole;
    if (arm) return Swap::kArm;
    return leg ? Swap::kLeg : Swap::kNone;
  }

  void ExchangeSides(Swap swap, LabelledDetection* labelled) const {
    const auto source = [&](int j) {
      return InSwap(swap, skeleton_.joint_class(j)) ? skeleton_.mirror(j) : j;
    };
    std::vector<Keypoint>& joints = labelled->detection.joints;
    const std::vector<Keypoint> before = joints;
    bool changed = false;
    for (int j = 0; j < skeleton_.joint_count(); ++j) {
      joints[j] = before[source(j)];
      changed = changed || (source(j) != j && joints[j].found);
    }
    // Swapping joints that were not found has no effect.
    labelled->truth.swap = changed ? swap : Swap::kNone;
    for (int& joint : labelled->truth.outliers) joint = source(joint);
  }

  // The part above or below the hips; the hips belong to the lower part.
  LabelledDetection PartOf(const LabelledDetection& whole,
                           DetectionKind kind) const {
    LabelledDetection part = whole;
    part.truth.kind = kind;
    for (int j = 0; j < skeleton_.joint_count(); ++j) {
      const JointClass c = skeleton_.joint_class(j);
      const bool is_lower = IsBelowHips(c) || c == JointClass::kHip;
      if (is_lower != (kind == DetectionKind::kLowerPart)) {
        part.detection.joints[j] = Keypoint();
      }
    }
    DropLostOutliers(&part);
    return part;
  }

  // A duplicate of the same person, slightly displaced and less complete.
  LabelledDetection SecondOf(const LabelledDetection& first) {
    constexpr double kSigmaPx = 3.0;
    constexpr double kKept = 0.7;
    LabelledDetection second = first;
    second.truth.kind = DetectionKind::kDouble;
    for (Keypoint& joint : second.detection.joints) {
      const Vector2d shift = kSigmaPx * NormalVector(&people_);
      if (people_.Chance(kKept)) {
        joint.px += shift;
      } else {
        joint = Keypoint();
      }
    }
    DropLostOutliers(&second);
    return second;
  }

  const NoiseOptions& options_;
  const Skeleton& skeleton_;
  const Camera& camera_;
  double frame_rate_hz_;
  int person_;
  Random pixels_;
  Random outliers_;
  Random missing_;
  Random confidence_;
  Random people_;
  MarkovBursts missed_;
  MarkovBursts swap_whole_;
  MarkovBursts swap_arm_;
  MarkovBursts swap_leg_;
  MarkovBursts fragment_;
  MarkovBursts double_;
  std::vector<JointState> joints_;
};

// ---- False positives ----

// Each false positive is a part of a person's pose at a random position and
// size, and lives for some frames.
class FalsePeople {
 public:
  // References must outlive the object.
  FalsePeople(const NoiseOptions& options, const Scene& scene,
              const Camera& camera, int view_idx)
      : options_(options),
        scene_(scene),
        camera_(camera),
        random_(StreamSeed(options.seed, Stream::kFalsePeople, view_idx, 0)) {}

  // Appends the false positives of the next frame.
  void Step(std::vector<LabelledDetection>* detections) {
    if (options_.false_people <= 0.0) return;
    constexpr double kMeanLife_s = 0.24;
    const double life = std::max(1.0, kMeanLife_s * scene_.frame_rate_hz);
    alive_.erase(
        std::remove_if(alive_.begin(), alive_.end(),
                       [&](const auto&) { return random_.Chance(1.0 / life); }),
        alive_.end());
    // On average as many appear as disappear.
    const double born =
        started_ ? options_.false_people / life : options_.false_people;
    started_ = true;
    for (int64_t n = Poisson(born); n > 0; --n) {
      if (auto figure = Make()) alive_.push_back(std::move(*figure));
    }
    for (const Detection& figure : alive_) {
      LabelledDetection labelled;
      labelled.truth.kind = DetectionKind::kFalse;
      labelled.detection = figure;
      constexpr double kSigmaPx = 1.5;
      for (Keypoint& joint : labelled.detection.joints) {
        const Vector2d shake = kSigmaPx * NormalVector(&random_);
        if (joint.found) joint.px += shake;
      }
      detections->push_back(std::move(labelled));
    }
  }

 private:
  using MaybePixels = std::vector<std::optional<Vector2d>>;

  // Knuth's method; sufficient for the small means here.
  int64_t Poisson(double mean) {
    const double limit = std::exp(-mean);
    int64_t count = 0;
    for (double product = random_.Uniform(); product > limit;
         product *= random_.Uniform()) {
      ++count;
    }
    return count;
  }

  // A random person's projection at a random time; empty if there is none.
  MaybePixels SomePose() {
    MaybePixels joints;
    const auto frame = static_cast<size_t>(
        random_.Index(static_cast<int64_t>(scene_.poses.size())));
    const auto person = static_cast<size_t>(
        random_.Index(static_cast<int64_t>(scene_.people.size())));
    for (const Joint3d& joint : scene_.poses[frame][person]) {
      joints.push_back(camera_.Project(joint.position_m));
    }
    return joints;
  }

  // 3 to 14 neighbouring joints (as found among false people of Shelf).
  std::optional<Detection> Make() {
    constexpr int kAttempts = 20;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const auto joints = SomePose();
      const auto wanted = static_cast<size_t>(3 + random_.Index(12));
      std::vector<size_t> order;
      for (size_t j = 0; j < joints.size(); ++j) {
        if (joints[j].has_value()) order.push_back(j);
      }
      if (order.size() < 3) continue;
      const Vector2d anchor = *joints[order[static_cast<size_t>(
          random_.Index(static_cast<int64_t>(order.size())))]];
      std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
        return (*joints[a] - anchor).squaredNorm() <
               (*joints[b] - anchor).squaredNorm();
      });
      order.resize(std::min(order.size(), wanted));
      Detection figure = Placed(joints, order, anchor);
      if (CountFound(figure) >= 3) return figure;
    }
    return std::nullopt;
  }

  Detection Placed(const MaybePixels& joints, const std::vector<size_t>& chosen,
                   const Vector2d& anchor) {
    const double scale = std::exp(random_.Uniform(-0.7, 0.7));
    const double x = random_.Uniform(0.0, camera_.width_px());
    const double y = random_.Uniform(0.0, camera_.height_px());
    Detection figure;
    figure.joints.resize(joints.size());
    for (const size_t j : chosen) {
      Keypoint& joint = figure.joints[j];
      joint.px = Vector2d(x, y) + scale * (*joints[j] - anchor);
      joint.found = IsInImage(camera_, joint.px);
      constexpr double kConfidence = 0.8;  // relative to true people, on Shelf
      joint.confidence =
          std::clamp(kConfidence * options_.confidence +
                         options_.confidence_sigma * random_.Normal(),
                     0.05, 1.0);
      if (!joint.found) joint = Keypoint();
    }
    return figure;
  }

  const NoiseOptions& options_;
  const Scene& scene_;
  const Camera& camera_;
  Random random_;
  bool started_ = false;
  std::vector<Detection> alive_;
};

class View {
 public:
  View(const NoiseOptions& options, const Scene& scene, int view_idx)
      : options_(options),
        scene_(scene),
        camera_(scene.cameras[view_idx]),
        false_people_(options, scene, camera_, view_idx),
        order_(StreamSeed(options.seed, Stream::kOrder, view_idx, 0)),
        drops_(StreamSeed(options.seed, Stream::kFrames, view_idx, 1)) {
    for (int i = 0; i < static_cast<int>(scene.people.size()); ++i) {
      people_.emplace_back(options, scene, camera_, i, [&](Stream stream) {
        return StreamSeed(options.seed, stream, view_idx, i);
      });
    }
  }

  std::vector<LabelledDetection> operator()(const SceneMoment& moment) {
    const std::vector<PersonSight> sights =
        Sights(camera_, moment, scene_.skeleton.joint_count());
    std::vector<LabelledDetection> detections;
    for (PersonObserver& person : people_) person.Step(sights, &detections);
    false_people_.Step(&detections);
    for (size_t i = detections.size(); i > 1; --i) {
      std::swap(detections[i - 1],
                detections[order_.Index(static_cast<int64_t>(i))]);
    }
    for (size_t i = 0; i < detections.size(); ++i) {
      detections[i].detection.index_in_file = static_cast<int>(i);
    }
    const bool dropped =
        drop_.Step(options_.dropped_view_rate,
                   options_.drop_burst_s * scene_.frame_rate_hz, &drops_);
    if (dropped) detections.clear();
    return detections;
  }

 private:
  const NoiseOptions& options_;
  const Scene& scene_;
  const Camera& camera_;
  std::vector<PersonObserver> people_;
  FalsePeople false_people_;
  Random order_;
  Random drops_;
  MarkovBursts drop_;
};

bool HiddenMatters(const JointNoise& noise) {
  return noise.hidden_missing_rate > 0.0 || noise.hidden_noise_factor != 1.0;
}

// Whether any option models occlusion. Its computation is expensive, so no
// joint counts as hidden otherwise.
bool HiddenMatters(const NoiseOptions& options) {
  return options.hidden_missed_rate > 0.0 || HiddenMatters(options.joints) ||
         std::any_of(
             options.by_class.begin(), options.by_class.end(),
             [](const auto& entry) { return HiddenMatters(entry.second); });
}

}  // namespace

DetectionSequence Observe(const Scene& scene, const NoiseOptions& options,
                          ObservationTruth* truth) {
  options.Check(scene.cameras.size());
  const int view_count = static_cast<int>(scene.cameras.size());
  const bool with_obstacles = HiddenMatters(options);
  DetectionSequence sequence;
  sequence.header.skeleton = scene.skeleton;
  sequence.header.frame_rate_hz = scene.frame_rate_hz;
  std::vector<View> views;
  for (int v = 0; v < view_count; ++v) {
    sequence.header.view_names.push_back(scene.cameras[v].name());
    views.emplace_back(options, scene, v);
  }
  // Random numbers for dropped frames and for the jitter of times.
  Random drops(StreamSeed(options.seed, Stream::kFrames, 0, 0));
  Random jitters(StreamSeed(options.seed, Stream::kJitter, 0, 0));
  MarkovBursts drop;
  if (truth != nullptr) truth->frames.clear();
  for (size_t i = 0; i < scene.times.size(); ++i) {
    const bool dropped =
        drop.Step(options.dropped_frame_rate,
                  options.drop_burst_s * scene.frame_rate_hz, &drops);
    // Frames keep their order.
    const double limit = 0.45 / scene.frame_rate_hz;
    const double jitter = jitters.Normal(0.0, options.time_jitter_s);
    const TimeNs nominal = scene.times[i];
    const TimeNs actual =
        nominal + FromSeconds(std::clamp(jitter, -limit, limit));
    DetectionFrame frame;
    frame.frame = static_cast<int64_t>(i);
    frame.time = options.tell_times ? actual : nominal;
    std::vector<std::vector<DetectionTruth>> frame_truth;
    std::optional<SceneMoment> moment;
    for (int v = 0; v < view_count; ++v) {
      const auto& offsets = options.clock_offset_s;
      const TimeNs capture = v < static_cast<int>(offsets.size())
                                 ? actual + FromSeconds(offsets[v])
                                 : actual;
      if (!moment.has_value() || moment->time != capture) {
        moment = LookAtScene(scene, capture, with_obstacles);
      }
      ViewDetections view;
      view.capture_time = options.tell_times ? capture : nominal;
      frame_truth.emplace_back();
      for (LabelledDetection& labelled : views[v](*moment)) {
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

}  // namespace kinegraph
