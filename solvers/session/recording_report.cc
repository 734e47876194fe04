#include "solvers/session/recording_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/random.h"
#include "core/base/text.h"
#include "core/data/box.h"
#include "core/io/text/json_value.h"
#include "core/skeleton/body_joints.h"
#include "core/tracking/options.h"
#include "core/tracking/track.h"
#include "solvers/cameras/segments.h"
#include "solvers/scene/plausible.h"
#include "solvers/session/diagnose.h"
#include "solvers/session/recording_warnings.h"
#include "solvers/session/subject_gauge.h"
#include "solvers/session/unfollowed.h"

namespace kinegraph {
namespace {

constexpr size_t kErrorSample = 4096;  // sample size of errors for quantiles
// People in a view are counted up to kMaxCounted - 1.
constexpr size_t kMaxCounted = 64;

// A uniform sample of a stream of numbers of any length (Vitter's reservoir
// sampling), reproducible for the same stream.
class StreamSample {
 public:
  explicit StreamSample(size_t size = 256) : size_(size) {}
  void Add(double value) {
    ++count_;
    if (values_.size() < size_) {
      values_.push_back(value);
      return;
    }
    const auto place = static_cast<size_t>(random_.Index(count_));
    if (place < size_) values_[place] = value;
  }
  int64_t count() const { return count_; }  // all numbers, not the sample
  // 0 without values.
  double Quantile(double share) const {
    if (values_.empty()) return 0.0;
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<size_t>(place);
    const size_t above = std::min(below + 1, sorted.size() - 1);
    const double part = place - static_cast<double>(below);
    return (1.0 - part) * sorted[below] + part * sorted[above];
  }

 private:
  size_t size_;
  std::vector<double> values_;
  Random random_{1};
  int64_t count_ = 0;
};

struct PersonStatistics {
  PersonReport counts;
  TimeNs last_time = 0;
  std::array<StreamSample, Limbs::kCount> limbs_m;
};

struct CameraStatistics {
  CameraReport counts;
  StreamSample error_px{kErrorSample};
  StreamSample person_px;
  std::vector<int64_t> frames_with;  // by number of people
};

CameraReport ReportOf(const CameraStatistics& camera) {
  CameraReport report = camera.counts;
  report.median_px = camera.error_px.Quantile(0.5);
  report.p90_px = camera.error_px.Quantile(0.9);
  report.person_px = camera.person_px.Quantile(0.5);
  return report;
}

// Results from a person's limbs: stature, variation of lengths, and difference
// between left and right.
PersonReport ReportOf(const PersonStatistics& person) {
  // Bones with fewer measured lengths are ignored.
  constexpr int64_t kEnough = 10;
  PersonReport report = person.counts;
  double length_m = 0.0;
  double share = 0.0;
  std::vector<double> spreads;
  std::vector<double> differences;
  double left_m = 0.0;  // length of the left limb of a pair
  for (size_t i = 0; i < Limbs::kCount; ++i) {
    const StreamSample& sample = person.limbs_m[i];
    double median_m = 0.0;
    if (sample.count() >= kEnough) {
      median_m = sample.Quantile(0.5);
      length_m += median_m;
      share += Limbs::ShareOf(i);
      if (i < Limbs::kSided) {
        spreads.push_back((sample.Quantile(0.9) - sample.Quantile(0.1)) /
                          median_m);
      }
    }
    if (i % 2 == 0) {
      left_m = median_m;
    } else if (left_m > 0.0 && median_m > 0.0) {
      differences.push_back(std::abs(left_m - median_m) /
                            (0.5 * (left_m + median_m)));
    }
  }
  if (share > Limbs::kLeastShare) report.height_m = length_m / share;
  report.bone_spread = Median(std::move(spreads));
  for (const double difference : differences) {
    report.side_difference +=
        difference / static_cast<double>(differences.size());
  }
  return report;
}

}  // namespace

double CameraReport::matched_share() const {
  return detections > 0
             ? static_cast<double>(matched) / static_cast<double>(detections)
             : 0.0;
}

double CameraReport::error_share() const {
  return person_px > 0.0 ? median_px / person_px : 0.0;
}

// Implementation; only `RecordingReporter` below uses it.
struct RecordingReporter::Impl {
  Impl(const RunScene& scene, const Skeleton& detection_skeleton,
       bool is_stream)
      : scene_(scene),
        is_stream_(is_stream),
        detection_skeleton_(detection_skeleton),
        least_joints_(LeastJoints(detection_skeleton)),
        map_(MapByName(detection_skeleton, scene.model.skeleton)),
        limbs_(scene.model.skeleton),
        candidates_(SkeletonsLike(detection_skeleton_)),
        fit_(candidates_),
        check_(scene.model.cameras, detection_skeleton, scene.model.skeleton),
        unfollowed_(scene.model.cameras, map_, least_joints_),
        cameras_(scene.view_names.size()) {
    for (size_t v = 0; v < cameras_.size(); ++v) {
      cameras_[v].counts.view = scene.view_names[v];
      cameras_[v].counts.camera = scene.model.cameras[v].name();
      cameras_[v].frames_with.assign(kMaxCounted, 0);
    }
  }

  void See(const DetectionFrame& seen, const TrackFrame& tracked) {
    ++frames_;
    poses_ += static_cast<int64_t>(tracked.people.size());
    empty_frames_ += HasDetections(seen) ? 0 : 1;
    for (size_t v = 0; v < cameras_.size(); ++v) SeeView(seen.views[v], v);
    Keep(seen);
    check_.See(seen, tracked);
    unfollowed_.See(seen, tracked);
    for (const PersonPose& person : tracked.people) {
      SeePerson(tracked, person);
      for (const ViewMatch& match : person.matches) {
        SeeMatch(seen, person, match);
      }
    }
    SeeStep(tracked);
    SeeSpeeds(tracked);
    if (is_stream_ && frames_ % 256 == 0) SumUpThoseGone(tracked.time);
  }

  RecordingReport Report() const {
    RecordingReport report;
    report.frames = frames_;
    report.poses = poses_;
    report.frame_rate_hz = scene_.model.frame_rate_hz;
    report.least_confidence = scene_.least_confidence;
    report.working_distance_m = WorkingDistance(scene_.model.cameras);
    report.skeleton = detection_skeleton_.name();
    report.is_human = IsHuman(detection_skeleton_);
    if (!report.is_human && !scale_.is_one()) {
      report.subject_m = scale_.size_m();
    }
    report.paired_by = scene_.paired_by;
    report.median_px = error_px_.Quantile(0.5);
    report.p90_px = error_px_.Quantile(0.9);
    for (const CameraStatistics& camera : cameras_) {
      report.cameras.push_back(ReportOf(camera));
      report.most_people_in_a_view =
          std::max(report.most_people_in_a_view, MostPeople(camera));
    }
    report.people = gone_;
    for (const auto& [id, person] : people_) {
      report.people.push_back(ReportOf(person));
    }
    std::sort(report.people.begin(), report.people.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
    report.height_m = TypicalHeight(report.people);
    report.joints_of_17 = joints_of_17_.Quantile(0.5);
    RecordingFacts facts;
    Diagnosis diagnosis = Diagnose(BeginningOf());
    if (auto skeleton = FindingOfSkeleton(fit_, candidates_)) {
      diagnosis.findings.insert(diagnosis.findings.begin(),
                                *std::move(skeleton));
    }
    if (report.height_m == 0.0) facts.stature_m = diagnosis.stature_m;
    facts.views_examined = diagnosis.verdict != DoctorVerdict::kNotExamined;
    facts.body_speed_mps = speed_mps_.Quantile(0.95);
    facts.followed_mps = FollowedSpeed();
    facts.holes_s = holes_s_;
    facts.steps_back = steps_back_;
    facts.empty_frames = empty_frames_;
    facts.in_seconds = scene_.header.mode == ToString(Mode::kGraph);
    facts.links = KeyOf("identity", "link", false);
    facts.has_clocks = has_clocks_;
    facts.independent_frames = IndependentFrames();
    facts.confirm_hits = ConfirmHits();
    facts.least_joints_of_17 = KeyOf("initialisation", "min_joints", 0.0);
    facts.unfollowed = unfollowed_.Often();
    report.cameras_off = check_.Warnings(scale_.metres());
    AddStrangers(&report);
    AddWarnings(facts, diagnosis, &report);
    return report;
  }

  // Adds cameras of whose detections hardly any are matched, although there are
  // at most 1.2 times as many detections as poses in the result. CameraCheck
  // misses such a camera if its detections lie at people's positions by chance.
  static void AddStrangers(RecordingReport* report) {
    constexpr double kOthers = 1.2;  // margin for other people in an image
    using Kind = CameraWarning::Kind;
    for (const CameraReport& camera : report->cameras) {
      const std::string name = "'" + Printable(camera.camera) + "'";
      const bool is_named = std::any_of(
          report->cameras_off.begin(), report->cameras_off.end(),
          [&](const CameraWarning& one) {
            return one.kind == Kind::kHardlySeen && one.text.find(name) == 0;
          });
      if (is_named || !HardlyAny(camera.matched, camera.detections) ||
          static_cast<double>(camera.detections) >
              kOthers * static_cast<double>(report->poses)) {
        continue;
      }
      report->cameras_off.push_back(
          {Kind::kHardlySeen, name + " has " +
                                  std::to_string(camera.detections) +
                                  " detections, of which only " +
                                  Counted(camera.matched, "is", "are") +
                                  " matched with a tracked person"});
    }
  }

  // Keeps the beginning of the recording, from the first frame in which two
  // views show people: three times the longest lag that the doctor searches,
  // with a bounded number of joints.
  void Keep(const DetectionFrame& seen) {
    constexpr int64_t kMostJoints = 400000;
    const double longest_s = 3.0 * DoctorOptions().longest_lag_s;
    if (joints_kept_ > kMostJoints ||
        static_cast<double>(beginning_.frames.size()) >
            longest_s * scene_.model.frame_rate_hz) {
      return;
    }
    int64_t joints = 0;
    int views = 0;
    for (const ViewDetections& view : seen.views) {
      views += view.detections.empty() ? 0 : 1;
      for (const Detection& one : view.detections) {
        joints += static_cast<int64_t>(one.joints.size());
      }
    }
    if (beginning_.frames.empty() && views < 2) return;
    joints_kept_ += joints;
    beginning_.frames.push_back(seen);
  }

  // The doctor's input for the beginning, without `match`: no tracking.
  DoctorInput BeginningOf() const {
    DoctorInput input;
    input.cameras = scene_.model.cameras;
    // In the run's metres, except for people, because the doctor checks their
    // statures.
    if (!IsHuman(detection_skeleton_)) {
      input.cameras = scale_.IntoRun(input.cameras);
    }
    input.detections = beginning_;
    input.detections.header.skeleton = detection_skeleton_;
    input.detections.header.view_names = scene_.view_names;
    input.detections.header.frame_rate_hz = scene_.model.frame_rate_hz;
    input.independent_frames = IndependentFrames();
    return input;
  }

  void SeeView(const ViewDetections& view, size_t v) {
    CameraStatistics& camera = cameras_[v];
    size_t people = 0;
    for (const Detection& detection : view.detections) {
      if (CountFound(detection) < least_joints_) continue;
      ++people;
      ++camera.counts.detections;
      camera.person_px.Add(DiagonalPx(BoxAround(detection.joints)));
      joints_of_17_.Add(JointsOf17(detection, detection_skeleton_));
      if (!fit_.full()) fit_.See(detection);
    }
    ++camera.frames_with[std::min(people, kMaxCounted - 1)];
  }

  void SeeMatch(const DetectionFrame& seen, const PersonPose& person,
                const ViewMatch& match) {
    const auto v = static_cast<size_t>(match.view_idx);
    const Detection* at = FindDetection(seen.views[v], match.detection_idx);
    if (at == nullptr) return;
    CameraStatistics& camera = cameras_[v];
    if (CountFound(*at) >= least_joints_) ++camera.counts.matched;
    for (size_t j = 0; j < person.joints.size(); ++j) {
      if (map_[j] < 0 || !person.joints[j].present()) continue;
      const Keypoint& joint = at->joints[map_[j]];
      if (!joint.found) continue;
      const std::optional<Eigen::Vector2d> px =
          scene_.model.cameras[v].Project(person.joints[j].position_m);
      if (!px.has_value()) continue;
      const double error_px = (*px - joint.px).norm();
      ++camera.counts.joints;
      camera.error_px.Add(error_px);
      error_px_.Add(error_px);
    }
  }

  void SeePerson(const TrackFrame& frame, const PersonPose& person) {
    const auto [at, is_new] = people_.try_emplace(person.id);
    PersonReport& counts = at->second.counts;
    counts.id = person.id;
    if (is_new) counts.first_frame = frame.frame;
    counts.last_frame = frame.frame;
    ++counts.frames;
    at->second.last_time = frame.time;
    const auto lengths_m = limbs_.LengthsOf(person.joints);
    for (size_t i = 0; i < Limbs::kCount; ++i) {
      if (lengths_m[i]) at->second.limbs_m[i].Add(*lengths_m[i]);
    }
  }

  void SumUpThoseGone(TimeNs now) {
    constexpr double kAway_s = 60.0;
    for (auto at = people_.begin(); at != people_.end();) {
      if (ToSeconds(now - at->second.last_time) > kAway_s) {
        gone_.push_back(ReportOf(at->second));
        at = people_.erase(at);
      } else {
        ++at;
      }
    }
  }

  // Value of a key of the configuration with which the recording was tracked;
  // `otherwise` if it is missing.
  template <typename Value>
  Value KeyOf(const char* table, const char* key, Value otherwise) const {
    const Json config = Json::parse(scene_.header.config_json, nullptr, false);
    const auto found = config.find(table);
    return found != config.end() ? found->value(key, otherwise) : otherwise;
  }

  bool IndependentFrames() const {
    return KeyOf("input", "independent_frames", false);
  }

  int64_t ConfirmHits() const {
    constexpr double kPaperHz = 25.0;
    TrackLifeOptions life;
    life.confirm_s = KeyOf("tracking", "confirm_s", life.confirm_s);
    life.max_age_s = KeyOf("tracking", "max_age_s", life.max_age_s);
    life.independent_frames = IndependentFrames();
    life.in_seconds = true;
    const bool is_paper = scene_.header.mode == ToString(Mode::kPaper);
    return LifeInFrames(life, is_paper ? kPaperHz : scene_.model.frame_rate_hz)
        .confirm_hits;
  }

  // Greatest speed covered by the gates [m/s]. 0 for gates in pixels, and if
  // association predicts that people continue their motion, because people are
  // then followed at any speed.
  double FollowedSpeed() const {
    if (KeyOf("gates", "units", std::string()) != "metres" ||
        KeyOf("association", "prediction_s", 0.0) > 0.0) {
      return 0.0;
    }
    const GateOptions usual;
    return usual.reach_m * scene_.model.frame_rate_hz +
           KeyOf("gates", "speed_mps", usual.speed_mps);
  }

  // Counts steps of the clock that are not forward, and stores intervals longer
  // than kHole unless empty frames are left out; to be called before SeeSpeeds,
  // which sets last_time_.
  void SeeStep(const TrackFrame& frame) {
    if (frames_ < 2) return;
    constexpr size_t kMostHoles = 100000;
    const double step_s = ToSeconds(frame.time - last_time_);
    steps_back_ += step_s > 0.0 ? 0 : 1;
    if (empty_frames_left_out_) return;
    if (step_s > kHole && holes_s_.size() < kMostHoles) {
      holes_s_.push_back(step_s);
    }
  }

  // Records the speed of each person's mid-hip since the previous frame.
  void SeeSpeeds(const TrackFrame& frame) {
    std::map<TrackId, Eigen::Vector3d> now;
    for (const PersonPose& person : frame.people) {
      const auto hips = limbs_.MiddleOfHips(person.joints);
      if (!hips) continue;
      now.emplace(person.id, *hips);
      const auto before = last_hips_.find(person.id);
      const double passed_s = ToSeconds(frame.time - last_time_);
      if (before == last_hips_.end() || !(passed_s > 0.0)) continue;
      speed_mps_.Add((*hips - before->second).norm() / passed_s);
    }
    last_hips_ = std::move(now);
    last_time_ = frame.time;
  }

  int MostPeople(const CameraStatistics& camera) const {
    int64_t frames = 0;
    for (size_t people = kMaxCounted; people-- > 1;) {
      frames += camera.frames_with[people];
      if (frames > 0 && 20 * frames >= frames_) return static_cast<int>(people);
    }
    return 0;
  }

  const RunScene& scene_;
  const bool is_stream_;
  const Skeleton detection_skeleton_;
  const int least_joints_;  // required for a detection to count
  const std::vector<int> map_;
  const Limbs limbs_;
  const std::vector<const Skeleton*> candidates_;
  SkeletonFit fit_;
  CameraCheck check_;
  UnfollowedPeople unfollowed_;
  SubjectScale scale_;
  std::vector<CameraStatistics> cameras_;
  std::map<TrackId, PersonStatistics> people_;
  std::vector<PersonReport> gone_;
  std::map<TrackId, Eigen::Vector3d> last_hips_;
  TimeNs last_time_ = 0;
  DetectionSequence beginning_;
  int64_t joints_kept_ = 0;
  StreamSample joints_of_17_;  // of a detection
  std::vector<double> holes_s_;
  StreamSample speed_mps_;
  StreamSample error_px_{kErrorSample};
  int64_t frames_ = 0;
  int64_t poses_ = 0;
  int64_t steps_back_ = 0;
  int64_t empty_frames_ = 0;
  bool empty_frames_left_out_ = false;
  bool has_clocks_ = false;
};

RecordingReporter::RecordingReporter(const RunScene& scene,
                                     const Skeleton& detection_skeleton,
                                     bool is_stream)
    : impl_(std::make_unique<Impl>(scene, detection_skeleton, is_stream)) {}
RecordingReporter::~RecordingReporter() = default;
void RecordingReporter::set_empty_frames_left_out(bool left_out) {
  impl_->empty_frames_left_out_ = left_out;
}
void RecordingReporter::set_has_clocks(bool has_clocks) {
  impl_->has_clocks_ = has_clocks;
}
void RecordingReporter::set_scale(const SubjectScale& scale) {
  impl_->scale_ = scale;
}
void RecordingReporter::See(const DetectionFrame& seen,
                            const TrackFrame& tracked) {
  impl_->See(seen, tracked);
}
RecordingReport RecordingReporter::Report() const { return impl_->Report(); }

}  // namespace kinegraph
