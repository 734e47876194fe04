#include "apps/common/track_run.h"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/io/view_pairing.h"
#include "core/tracking/second_pass.h"

namespace kinegraph {
namespace {

bool IsNamed(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The views of a run, each with its camera: those named in `without` (by the
// name of the view or of its camera) are left out, and where `cameras.use`
// chose cameras, the views of the others.
struct UsedViews {
  std::vector<int> views;  // indices into the detections' views
  CameraRig cameras;
};

UsedViews ChooseViews(const RunOptions& options, const RunRequest& request,
                      const std::vector<std::string>& view_names) {
  const std::vector<std::string>& without = request.without_cameras;
  std::vector<int> candidates;
  std::vector<std::string> names;
  std::map<std::string, std::string> map = options.cameras.map;
  for (size_t v = 0; v < view_names.size(); ++v) {
    if (IsNamed(without, view_names[v])) {
      map.erase(view_names[v]);
      continue;
    }
    candidates.push_back(static_cast<int>(v));
    names.push_back(view_names[v]);
  }
  const std::vector<int> cameras = PairViewsWithCameras(
      names, request.cameras, map,
      options.cameras.use.empty() ? UnpairedViews::kRefuse
                                  : UnpairedViews::kLeaveOut);
  UsedViews used;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i] < 0) continue;
    const Camera& camera = request.cameras[static_cast<size_t>(cameras[i])];
    if (IsNamed(without, camera.name())) continue;
    used.views.push_back(candidates[i]);
    used.cameras.push_back(camera);
  }
  for (const std::string& name : without) {
    const bool known =
        IsNamed(view_names, name) ||
        std::any_of(request.cameras.begin(), request.cameras.end(),
                    [&](const Camera& c) { return c.name() == name; });
    if (!known) {
      throw InputError("--without_cameras: no view or camera is named '" +
                       Printable(name) + "'");
    }
  }
  if (used.views.empty()) {
    throw InputError("no view is left that has a camera");
  }
  return used;
}

// `frame` with the used views alone; moves them.
void KeepViews(const std::vector<int>& used, DetectionFrame* frame,
               DetectionFrame* kept) {
  kept->frame = frame->frame;
  kept->time = frame->time;
  kept->views.resize(used.size());
  for (size_t v = 0; v < used.size(); ++v) {
    std::swap(kept->views[v], frame->views[used[v]]);
  }
}

// `frame` as it would have been seen `frames_earlier` frames ago.
DetectionFrame Earlier(const DetectionFrame& frame, int64_t frames_earlier,
                       const FrameClock& clock) {
  DetectionFrame earlier = frame;
  const TimeNs shift = clock.TimeOf(frames_earlier);
  earlier.frame -= frames_earlier;
  earlier.time -= shift;
  for (ViewDetections& view : earlier.views) view.capture_time -= shift;
  return earlier;
}

}  // namespace

void InputOptions::Describe(OptionVisitor& visitor) {
  visitor.Number("frame_rate", &frame_rate_hz, NonNegative(), "Hz",
                 "nominal frame rate; 0: the files tell it");
  visitor.Integer("repeat_first_frame", &repeat_first_frame, Between(0, 1000),
                  "frames", "feeds the first frame so often before the take");
}

void OutputOptions::Describe(OptionVisitor& visitor) {
  visitor.Boolean("observations", &observations,
                  "write each person's matches and weights too");
}

void RunOptions::Describe(OptionVisitor& visitor) {
  visitor.Text("skeleton", &skeleton, "of the tracks; empty: the detections'");
  estimators.Describe(visitor);
  visitor.Enter("input");
  input.Describe(visitor);
  visitor.Leave();
  visitor.Enter("cameras");
  cameras.Describe(visitor);
  visitor.Leave();
  visitor.Enter("detections");
  detections.Describe(visitor);
  visitor.Leave();
  tracker.Describe(visitor);
  visitor.Enter("output");
  output.Describe(visitor);
  visitor.Leave();
}

RunOptions ReadRunOptions(const std::string& config_path,
                          const std::string& set, const std::string& mode) {
  ConfigFile config = ConfigFile::Read(config_path);
  if (!set.empty()) config.Override(set, "--set");
  if (!mode.empty()) config.Override("mode=" + mode, "--mode");
  RunOptions options;
  config.Apply(&options);
  options.user_skeletons = config.ReadSkeletons();
  config.RejectUnknown();
  if (options.estimators.mode == Mode::kPaper) {
    // Paper mode never backfills, re-associates or extrapolates.
    options.tracker.life.backfill = false;
    options.tracker.life.max_gap_frames = 0.0;
    options.tracker.life.second_pass = false;
  }
  if (!options.detections.skeleton_name.empty()) {
    options.detections.skeleton = ResolveSkeleton(
        options.detections.skeleton_name, options.user_skeletons);
  }
  return options;
}

bool MemorySource::Next(DetectionFrame* frame) {
  if (next_ == sequence_->frames.size()) return false;
  *frame = sequence_->frames[next_++];
  return true;
}

DetectionReadOptions DetectionOptionsOf(const RunOptions& options) {
  DetectionReadOptions read = options.detections;
  read.frame_rate_hz = options.input.frame_rate_hz;
  return read;
}

RunScene PrepareScene(const RunOptions& options, const RunRequest& request,
                      const DetectionHeader& detections) {
  RunScene scene;
  UsedViews used = ChooseViews(options, request, detections.view_names);
  scene.used_views = std::move(used.views);
  scene.model.cameras = std::move(used.cameras);
  for (const int v : scene.used_views) {
    scene.view_names.push_back(detections.view_names[v]);
  }
  scene.model.skeleton =
      options.skeleton.empty()
          ? detections.skeleton
          : ResolveSkeleton(options.skeleton, options.user_skeletons);
  scene.model.frame_rate_hz = detections.frame_rate_hz;
  if (!(scene.model.frame_rate_hz > 0.0)) {
    throw OptionError("input.frame_rate",
                      "not given, and the detections do not tell it [Hz]");
  }
  scene.model.keep_observations = options.output.observations;
  const std::vector<int> map =
      MapByName(detections.skeleton, scene.model.skeleton);
  if (std::all_of(map.begin(), map.end(), [](int j) { return j < 0; })) {
    throw OptionError("skeleton",
                      "'" + scene.model.skeleton.name() +
                          "' shares no joint with the detections' '" +
                          detections.skeleton.name() + "'");
  }
  scene.header.skeleton = scene.model.skeleton;
  scene.header.mode = ToString(options.estimators.mode);
  scene.header.frame_rate_hz = scene.model.frame_rate_hz;
  scene.header.view_names = scene.view_names;
  scene.header.config_json = EffectiveConfigJson(options);
  return scene;
}

int PassCount(const RunOptions& options) {
  return options.tracker.life.second_pass ? 2 : 1;
}

namespace {

// Reads the frames of a run: wanted ones, with the used views alone.
class RunFrames {
 public:
  RunFrames(const RunRequest& request, const RunScene& scene,
            const SourceOpener& open_source,
            const std::function<void(int64_t)>& progress, int64_t* frames_read)
      : request_(request),
        scene_(scene),
        source_(open_source()),
        progress_(progress),
        frames_read_(frames_read) {}

  bool Next(DetectionFrame* frame) {
    while (source_->Next(&all_views_)) {
      // Frames ascend: nothing that is asked for can follow.
      if (!request_.frames.empty() &&
          all_views_.frame >= request_.frames.back().end) {
        return false;
      }
      ++*frames_read_;
      if (progress_) progress_(*frames_read_);
      if (!ContainsFrame(request_.frames, all_views_.frame)) continue;
      KeepViews(scene_.used_views, &all_views_, frame);
      return true;
    }
    return false;
  }
  const Skeleton& skeleton() const { return source_->header().skeleton; }

 private:
  const RunRequest& request_;
  const RunScene& scene_;
  std::unique_ptr<DetectionSource> source_;
  const std::function<void(int64_t)>& progress_;
  int64_t* frames_read_;
  DetectionFrame all_views_;
};

using FrameSink = std::function<void(TrackFrame&&)>;

// Sees each frame that the tracker is fed, in order (may be null).
using FedFrames = std::function<void(const DetectionFrame&)>;

// The tracker over the whole take, its warm-up left out of what is written.
void FirstPass(const RunOptions& options, const RunRequest& request,
               const RunScene& scene, EstimatorPair estimators,
               RunFrames* frames, StageTimes* times, const FrameSink& write,
               const FedFrames& fed = nullptr) {
  Tracker tracker(scene.model, frames->skeleton(), options.tracker,
                  std::move(estimators.feedback), std::move(estimators.output));
  tracker.set_threads(request.threads);
  tracker.set_stage_times(times);
  const FrameClock clock(scene.model.frame_rate_hz);
  bool first = true;
  int64_t first_frame = 0;
  std::vector<TrackFrame> finished;
  const auto flush = [&] {
    for (TrackFrame& frame : finished) {
      if (frame.frame >= first_frame) write(std::move(frame));
    }
    finished.clear();
  };
  const auto process = [&](const DetectionFrame& one) {
    if (fed) fed(one);
    tracker.Process(one, &finished);
  };
  DetectionFrame frame;
  while (frames->Next(&frame)) {
    if (first) {
      first = false;
      first_frame = frame.frame;
      for (int64_t k = options.input.repeat_first_frame; k > 0; --k) {
        process(Earlier(frame, k, clock));
      }
    }
    process(frame);
    flush();
  }
  tracker.Finish(&finished);
  flush();
}

}  // namespace

RunSummary RunTracking(const RunOptions& options, const RunRequest& request,
                       const RunScene& scene, const SourceOpener& open_source,
                       const std::function<void(const TrackFrame&)>& write,
                       const std::function<void(int64_t)>& progress,
                       StageTimes* stage_times) {
  RunSummary summary;
  std::set<TrackId> people;
  const auto count_and_write = [&](const TrackFrame& frame) {
    ++summary.frames;
    summary.person_frames += static_cast<int64_t>(frame.people.size());
    for (const PersonPose& person : frame.people) people.insert(person.id);
    write(frame);
  };
  int64_t frames_read = 0;
  RunFrames frames(request, scene, open_source, progress, &frames_read);
  if (!options.tracker.life.second_pass) {
    FirstPass(options, request, scene, MakeEstimators(options.estimators),
              &frames, stage_times, count_and_write);
  } else {
    std::vector<TrackFrame> first_pass;
    FirstPass(options, request, scene, MakeEstimators(options.estimators),
              &frames, stage_times, [&](TrackFrame&& frame) {
                first_pass.push_back(std::move(frame));
              });
    RunFrames again(request, scene, open_source, progress, &frames_read);
    EstimatorPair estimators = MakeEstimators(options.estimators);
    SecondPass second(
        scene.model, again.skeleton(), options.tracker,
        estimators.output ? estimators.output : estimators.feedback);
    DetectionFrame frame;
    for (const TrackFrame& tracked : first_pass) {
      if (!again.Next(&frame) || frame.frame != tracked.frame) {
        throw std::runtime_error("the detections changed between two passes");
      }
      second.Process(frame, tracked);
    }
    for (const TrackFrame& done : second.Finish(request.threads)) {
      count_and_write(done);
    }
  }
  summary.people = static_cast<int64_t>(people.size());
  return summary;
}

TrackSequence TrackSequenceOf(const RunOptions& options,
                              const RunRequest& request,
                              const DetectionSequence& detections) {
  const RunScene scene = PrepareScene(options, request, detections.header);
  TrackSequence tracks;
  tracks.header = scene.header;
  RunTracking(
      options, request, scene,
      [&] { return std::make_unique<MemorySource>(detections); },
      [&](const TrackFrame& frame) { tracks.frames.push_back(frame); });
  return tracks;
}

FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections) {
  FrozenRun run;
  run.scene = PrepareScene(options, request, detections.header);
  run.tracks.header = run.scene.header;
  run.detections.header = detections.header;
  run.detections.header.view_names = run.scene.view_names;
  EstimatorPair estimators = MakeEstimators(options.estimators);
  MatchFreezer freezer;
  // The estimator that is written sees every frame of a life.
  EstimatorFactory& written =
      estimators.output ? estimators.output : estimators.feedback;
  written = freezer.Wrap(std::move(written));
  int64_t frames_read = 0;
  const std::function<void(int64_t)> no_progress;
  const SourceOpener open_source = [&] {
    return std::make_unique<MemorySource>(detections);
  };
  RunFrames frames(request, run.scene, open_source, no_progress, &frames_read);
  FirstPass(
      options, request, run.scene, std::move(estimators), &frames, nullptr,
      [&](TrackFrame&& frame) {
        run.tracks.frames.push_back(std::move(frame));
      },
      [&](const DetectionFrame& frame) {
        run.detections.frames.push_back(frame);
      });
  if (!run.tracks.frames.empty()) {
    run.first_frame = run.tracks.frames.front().frame;
  }
  run.matches =
      freezer.Matches(options.tracker.life, run.scene.model.frame_rate_hz);
  return run;
}

EstimatorFactory FeedbackOf(const RunOptions& options) {
  return MakeEstimators(options.estimators).feedback;
}

}  // namespace kinegraph
