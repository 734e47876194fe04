#include "solvers/session/survey.h"

#include <algorithm>
#include <array>
#include <deque>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/format.h"
#include "core/io/detections/view_pairing.h"
#include "core/skeleton/body_joints.h"
#include "core/tracking/options.h"
#include "solvers/scene/plausible.h"
#include "solvers/session/ready_recording.h"
#include "solvers/session/recording_warnings.h"
#include "solvers/session/run.h"

namespace kinegraph {
namespace {

constexpr size_t kFramesToTry = 250;

// Number of joints in the view with the second most joints, an upper bound on
// the number that two views can triangulate.
int JointsSeenTwice(const DetectionFrame& frame, int least_joints) {
  std::array<int, 2> most = {0, 0};
  for (const ViewDetections& view : frame.views) {
    int joints = 0;
    for (const Detection& detection : view.detections) {
      const int found = CountFound(detection);
      if (found >= least_joints) joints += found;
    }
    if (joints > most[0]) std::swap(joints, most[0]);
    most[1] = std::max(most[1], joints);
  }
  return most[1];
}

// Consecutive frames to try.
struct FramesToTry {
  DetectionSequence beginning;  // from the first with people in two views
  DetectionSequence fullest;    // with the most joints seen by two views
};

// Reads the whole recording.
FramesToTry ReadFramesToTry(DetectionSource* source, RecordingSurvey* survey) {
  FramesToTry frames;
  const int least_joints = LeastJoints(source->header().skeleton);
  std::deque<DetectionFrame> last;
  std::deque<int> joints;
  int64_t sum = 0;
  int64_t most = 0;
  DetectionFrame frame;
  while (source->Next(&frame)) {
    if (survey->frames++ == 0) survey->first_frame = frame.frame;
    survey->last_frame = frame.frame;
    joints.push_back(JointsSeenTwice(frame, least_joints));
    sum += joints.back();
    const bool begun = !frames.beginning.frames.empty() || joints.back() > 0;
    if (begun && frames.beginning.frames.size() < kFramesToTry) {
      frames.beginning.frames.push_back(frame);
    }
    last.push_back(frame);
    if (last.size() > kFramesToTry) {
      sum -= joints.front();
      joints.pop_front();
      last.pop_front();
    }
    // Copies only clearly fuller segments, to keep this cheap.
    constexpr double kMore = 1.1;
    if (static_cast<double>(sum) <= kMore * static_cast<double>(most)) continue;
    most = sum;
    frames.fullest.frames.assign(last.begin(), last.end());
  }
  frames.beginning.header = source->header();
  frames.fullest.header = source->header();
  survey->detections = source->header();
  return frames;
}

// The doctor's kind of finding for clocks that are off by whole frames.
constexpr const char* kClockOffset = "clock_offset";

bool HasCamera(const RecordingReport& report, CameraWarning::Kind kind) {
  return std::any_of(
      report.cameras_off.begin(), report.cameras_off.end(),
      [&](const CameraWarning& camera) { return camera.kind == kind; });
}

// Whether only camera poses and clocks seem wrong. False with two cameras,
// because either of them may be the wrong one.
bool MayBeRefined(const RecordingReport& report) {
  return report.cameras.size() > 2 &&
         !HasCamera(report, CameraWarning::Kind::kHardlySeen) &&
         std::all_of(report.warnings.begin(), report.warnings.end(),
                     [](const Finding& warning) {
                       return warning.kind == "camera" ||
                              warning.kind == "error" ||
                              warning.kind == "unfollowed" ||
                              warning.kind == kClockOffset;
                     });
}

// Tracks the frames, with the clocks recorded in the calibration, as in a run.
SurveyTrial Try(const SurveyRequest& asked, RunOptions options,
                const CameraRig& cameras,
                const DetectionSequence& as_recorded) {
  RunRequest request;
  request.cameras = cameras;
  request.without_cameras = asked.without_cameras;
  request.kept_matches = KeptMatches::kDetections;
  options.refine = RefineOptions();  // refinement needs the whole recording
  // As configured, but with backfill, without which a dozen frames are too few
  // to measure people, and with linking, which the written configuration
  // enables.
  options.tracker.life.backfill = true;
  options.identity.link = true;
  const auto record = ReadRefinementRecord(asked.cameras);
  const ReadyRecording ready =
      MakeRecordingReady(options, request, record, [&] { return as_recorded; });
  const DetectionSequence& beginning =
      ready.detections.has_value() ? *ready.detections : as_recorded;
  Session session(options, request, beginning.header,
                  [&] { return std::make_unique<MemorySource>(beginning); });
  RecordingReporter reporter(session.scene(), beginning.header.skeleton);
  reporter.set_has_clocks(record.has_value() && record->has_clocks());
  reporter.set_empty_frames_left_out(
      LeavesOutEmptyFrames(asked.detections, options.detections));
  UsedFrames used(session.scene(),
                  [&] { return std::make_unique<MemorySource>(beginning); });
  MemorySource source(beginning);
  const Skeleton& skeleton = session.scene().header.skeleton;
  const bool is_human = IsHuman(skeleton);
  Stance stance(skeleton);
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    if (const DetectionFrame* seen = used.At(frame.frame)) {
      reporter.See(*seen, frame);
    }
    if (!is_human) return;
    for (const PersonPose& person : frame.people) stance.See(person);
  });
  reporter.set_scale(session.scale());
  SurveyTrial trial;
  trial.report = reporter.Report();
  trial.stance = std::move(stance);
  // A refined calibration is not refined again.
  if (!record.has_value() && MayBeRefined(trial.report)) {
    trial.cameras_are_off =
        HasCamera(trial.report, CameraWarning::Kind::kElsewhere);
    trial.clocks_are_off =
        HasCamera(trial.report, CameraWarning::Kind::kOffBeat) ||
        std::any_of(trial.report.warnings.begin(), trial.report.warnings.end(),
                    [](const Finding& warning) {
                      return warning.kind == kClockOffset;
                    });
  }
  return trial;
}

// Pairs views with cameras as in a run; a pairing based only on the order of
// the names is recorded as a map.
void PairViews(const std::vector<std::string>& views,
               const CameraReadOptions& options,
               const std::vector<std::string>& without,
               RecordingSurvey* survey) {
  const ViewPairing pairing = PairViewsWithCameras(
      views, survey->cameras, options.map,
      options.use.empty() ? UnpairedViews::kRefuse : UnpairedViews::kLeaveOut,
      without);
  survey->map = options.map;
  survey->paired_by = pairing.paired_by;
  if (pairing.paired_by != PairedBy::kOrder) return;
  for (size_t v = 0; v < views.size(); ++v) {
    const int camera = pairing.camera_of_view[v];
    if (camera < 0) continue;
    survey->map[views[v]] = survey->cameras[camera].name();
  }
}

// Tries the file's own unit, then the others.
void SettleUnit(const SurveyRequest& request,
                const DetectionSequence& beginning, RecordingSurvey* survey) {
  struct Unit {
    const char* name;
    LengthUnit unit;
  };
  const std::vector<Unit> units = {{"auto", request.options.cameras.unit},
                                   {"m", LengthUnit::kMetre},
                                   {"cm", LengthUnit::kCentimetre},
                                   {"mm", LengthUnit::kMillimetre}};
  bool first = true;
  for (const Unit& unit : units) {
    RunOptions options = request.options;
    options.cameras.unit = unit.unit;
    options.cameras.map = survey->map;
    CameraRig cameras;
    try {
      cameras = ReadCameras(request.cameras, options.cameras);
    } catch (const InputError&) {
      // A format that specifies its unit permits no other.
      if (first) throw;
      continue;
    }
    if (!first && !IsWorkingDistance(WorkingDistance(cameras))) continue;
    SurveyTrial trial = Try(request, options, cameras, beginning);
    if (first || IsStature(trial.report.height_m)) {
      survey->cameras = cameras;
      survey->unit = unit.name;
      static_cast<SurveyTrial&>(*survey) = std::move(trial);
    }
    // The height of non-human subjects carries no information on the unit.
    if (IsStature(survey->report.height_m) ||
        !IsHuman(beginning.header.skeleton)) {
      return;
    }
    first = false;
  }
}

// Number of detections matched with a person.
double MatchedOf(const RecordingReport& report) {
  int64_t sum = 0;
  for (const CameraReport& camera : report.cameras) sum += camera.matched;
  return static_cast<double>(sum);
}

// If detections have few joints, requires fewer of a new person, and keeps the
// setting if clearly more detections are then matched with similar residuals.
// Otherwise the recommendation is also removed from the report.
void SettleJoints(SurveyRequest request, const DetectionSequence& beginning,
                  RecordingSurvey* survey) {
  constexpr double kClearlyMore = 1.05;
  constexpr double kWorse = 1.25;
  const double usual = survey->report.joints_of_17;
  InitialisationOptions& new_people = request.options.tracker.initialisation;
  request.options.cameras.map = survey->map;
  while (const auto joints = FewerJoints(usual, new_people.min_joints)) {
    new_people.min_joints = new_people.min_common_joints = *joints;
    const RecordingReport before = survey->report;
    RecordingSurvey tried = *survey;
    if (before.poses == 0) {
      SettleUnit(request, beginning, &tried);  // undetermined so far
    } else {
      static_cast<SurveyTrial&>(tried) =
          Try(request, request.options, survey->cameras, beginning);
    }
    const bool better =
        MatchedOf(tried.report) > kClearlyMore * MatchedOf(before) &&
        (before.poses == 0 ||
         tried.report.median_px < kWorse * before.median_px);
    if (!better) {
      auto& warnings = survey->report.warnings;
      warnings.erase(std::remove_if(warnings.begin(), warnings.end(),
                                    [](const Finding& one) {
                                      return one.kind == "joints";
                                    }),
                     warnings.end());
      return;
    }
    *survey = std::move(tried);
    survey->min_joints = joints;
  }
}

// Offers refinement of cameras with errors if a fit of these frames accepts it
// and views excluded from the fit improve. Clocks are left to the run, which
// tests them on the whole recording.
void SettleRefinement(const SurveyRequest& request,
                      const DetectionSequence& beginning,
                      RecordingSurvey* survey) {
  if (!survey->cameras_are_off) return;
  RunOptions options = request.options;
  options.cameras.map = survey->map;
  if (survey->min_joints.has_value()) {
    InitialisationOptions& new_people = options.tracker.initialisation;
    new_people.min_joints = new_people.min_common_joints = *survey->min_joints;
  }
  options.refine.refine = RefineKind::kPose;
  options.refine.refine_clock = survey->clocks_are_off;
  RunRequest run;
  run.cameras = survey->cameras;
  run.without_cameras = request.without_cameras;
  const ReadyRecording ready = RefineRecording(options, run, beginning);
  survey->cameras_are_off = false;
  for (const RefineStep& step : ready.refinement->steps) {
    if (step.what == "clock") continue;
    if (step.taken && step.left_out.has_value()) {
      survey->cameras_are_off = true;
      continue;
    }
    survey->left += (survey->left.empty() ? "" : "; ") +
                    (step.taken ? "with fewer than four views no camera can be "
                                  "left out of the fit as a test"
                                : step.reason);
  }
}

}  // namespace

RecordingSurvey SurveyRecording(const SurveyRequest& request) {
  RecordingSurvey survey;
  survey.cameras = ReadCameras(request.cameras, request.options.cameras);
  const std::unique_ptr<DetectionSource> source =
      OpenDetections(request.detections, DetectionOptionsOf(request.options));
  if (!(source->header().frame_rate_hz > 0.0)) {
    throw InputError(
        request.detections, "",
        "does not specify its frame rate, which is never guessed: give it with "
        "--frame_rate=HZ");
  }
  PairViews(source->header().view_names, request.options.cameras,
            request.without_cameras, &survey);
  const FramesToTry frames = ReadFramesToTry(source.get(), &survey);
  if (survey.frames == 0) {
    throw InputError(request.detections, "", "contains no frames");
  }
  const DetectionSequence* tried = &frames.beginning;
  SettleUnit(request, *tried, &survey);
  // The first people may be far away or partly occluded.
  if (survey.report.height_m == 0.0 && IsHuman(survey.detections.skeleton) &&
      !frames.fullest.frames.empty() &&
      frames.fullest.frames.front().frame != tried->frames.front().frame) {
    RecordingSurvey fullest = survey;
    SettleUnit(request, frames.fullest, &fullest);
    if (fullest.report.height_m > 0.0) {
      survey = std::move(fullest);
      tried = &frames.fullest;
    }
  }
  SettleJoints(request, *tried, &survey);
  SettleRefinement(request, *tried, &survey);
  survey.frames_tried = static_cast<int64_t>(tried->frames.size());
  if (!request.without_cameras.empty()) {
    for (const CameraReport& camera : survey.report.cameras) {
      survey.use.push_back(camera.camera);
    }
    // `track` refuses a map to cameras that are not used.
    for (auto at = survey.map.begin(); at != survey.map.end();) {
      const bool is_used =
          std::count(survey.use.begin(), survey.use.end(), at->second) > 0;
      at = is_used ? std::next(at) : survey.map.erase(at);
    }
  }
  return survey;
}

}  // namespace kinegraph
