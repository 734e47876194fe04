#include "solvers/session/run.h"

#include <optional>
#include <utility>

#include "core/io/configuration/config.h"
#include "solvers/session/ready_recording.h"

namespace kinegraph {

bool MemorySource::Next(DetectionFrame* frame) {
  if (next_ == sequence_->frames.size()) return false;
  *frame = sequence_->frames[next_++];
  return true;
}

UsedFrames::UsedFrames(const RunScene& scene, SourceOpener reopen)
    : scene_(&scene), reopen_(std::move(reopen)) {}

void UsedFrames::Feed(const DetectionFrame& used) {
  if (!reopen_) waiting_.push_back(used);
}

const DetectionFrame* UsedFrames::At(int64_t frame) {
  if (reopen_ && source_ == nullptr) source_ = reopen_();
  while (source_ != nullptr ? source_->Next(&read_) : !waiting_.empty()) {
    if (source_ == nullptr) {
      current_ = std::move(waiting_.front());
      waiting_.pop_front();
    } else {
      if (read_.frame < frame) continue;
      KeepUsedViews(*scene_, &read_, &current_);
    }
    if (current_.frame == frame) return &current_;
    if (current_.frame > frame) return nullptr;
  }
  return nullptr;
}

void TrackAll(DetectionSource* source, Session* session,
              const std::function<void(TrackFrame&&)>& write) {
  DetectionFrame frame;
  while (source->Next(&frame) && !session->IsPastEnd(frame.frame)) {
    for (TrackFrame& done : session->Process(std::move(frame))) {
      write(std::move(done));
    }
  }
  for (TrackFrame& done : session->Finish()) write(std::move(done));
}

TrackSequence TrackSequenceOf(const RunOptions& options,
                              const RunRequest& request,
                              const DetectionSequence& detections,
                              ViewBias* view_bias,
                              const std::function<void(int64_t)>& progress) {
  const ReadyRecording ready = MakeRecordingReady(
      options, request, std::nullopt, [&] { return detections; });
  const DetectionSequence& recorded =
      ready.detections.has_value() ? *ready.detections : detections;
  RunRequest asked = request;
  asked.cameras = ready.cameras;
  if (ready.record.has_value()) asked.kept_matches = KeptMatches::kWeights;
  MemorySource source(recorded);
  const SourceOpener reopen = [&] {
    return std::make_unique<MemorySource>(recorded);
  };
  Session session(options, asked, recorded.header, reopen);
  if (progress) session.set_progress(progress);
  // Adds the effect of the cameras' uncertainty to the covariances, which
  // requires the matches.
  const std::unique_ptr<CameraUncertainty> uncertainty =
      ready.record.has_value() ? UncertaintyOf(*ready.record, session.scene(),
                                               recorded.header.skeleton)
                               : nullptr;
  const bool keeps_matches =
      options.output.observations || request.kept_matches != KeptMatches::kNone;
  UsedFrames used(session.scene(), reopen);
  TrackSequence tracks;
  tracks.header = session.scene().header;
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    if (uncertainty != nullptr) {
      uncertainty->AddTo(*used.At(frame.frame), &frame);
    }
    for (PersonPose& person : frame.people) {
      if (!keeps_matches) person.matches.clear();
    }
    tracks.frames.push_back(std::move(frame));
  });
  if (view_bias != nullptr) *view_bias = session.view_bias();
  return tracks;
}

FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections) {
  RunRequest asked = request;
  ReadyRecording ready;
  if (options.refine.any()) {
    ready = RefineRecording(options, request, detections);
    asked.cameras = ready.cameras;
  }
  const DetectionSequence& recorded =
      ready.detections.has_value() ? *ready.detections : detections;
  RunOptions one_pass = options;
  one_pass.tracker.life.second_pass = false;
  one_pass.identity.link = false;
  MatchFreezer freezer;
  EstimatorPair estimators = MakeEstimators(options.estimators);
  // The output estimator receives every frame of a track.
  EstimatorFactory& written =
      estimators.output ? estimators.output : estimators.feedback;
  written = freezer.Wrap(std::move(written));
  Session session(one_pass, asked, recorded.header, std::move(estimators));
  FrozenRun run;
  run.scene = session.scene();
  // The tracks record the requested options, not the changes above.
  run.scene.header.config_json = EffectiveConfigJson(options);
  run.tracks.header = run.scene.header;
  run.detections.header = recorded.header;
  run.detections.header.view_names = run.scene.view_names;
  session.set_frame_listener([&](const DetectionFrame& frame) {
    run.detections.frames.push_back(frame);
  });
  MemorySource source(recorded);
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    run.tracks.frames.push_back(std::move(frame));
  });
  run.scale = session.scale();
  run.scene.model.cameras = run.scale.IntoRun(run.scene.model.cameras);
  if (!run.tracks.frames.empty()) {
    run.first_frame = run.tracks.frames.front().frame;
  }
  run.matches = freezer.Matches(run.tracks.frames);
  return run;
}

}  // namespace kinegraph
