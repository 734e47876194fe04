#include "solvers/session/run.h"

#include <utility>
#include <vector>

namespace kinegraph {
bool MemorySource::Next(DetectionFrame* frame) {
  if (next_ == sequence_->frames.size()) return false;
  *frame = sequence_->frames[next_++];
  return true;
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
                              ViewBias* view_bias) {
  MemorySource source(detections);
  Session session(options, request, detections.header,
                  [&] { return std::make_unique<MemorySource>(detections); });
  TrackSequence tracks;
  tracks.header = session.scene().header;
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    tracks.frames.push_back(std::move(frame));
  });
  if (view_bias != nullptr) *view_bias = session.view_bias();
  return tracks;
}

FrozenRun FreezeTracking(const RunOptions& options, const RunRequest& request,
                         const DetectionSequence& detections) {
  RunOptions one_pass = options;
  one_pass.tracker.life.second_pass = false;
  one_pass.identity.link = false;
  EstimatorPair estimators = MakeEstimators(options.estimators);
  MatchFreezer freezer;
  // The estimator that is written sees every frame of a life.
  EstimatorFactory& written =
      estimators.output ? estimators.output : estimators.feedback;
  written = freezer.Wrap(std::move(written));
  Session session(one_pass, request, detections.header, std::move(estimators));
  FrozenRun run;
  run.scene = session.scene();
  // The tracks say what was asked for, not what was left out.
  run.scene.header.config_json = EffectiveConfigJson(options);
  run.tracks.header = run.scene.header;
  run.detections.header = detections.header;
  run.detections.header.view_names = run.scene.view_names;
  session.set_frame_listener([&](const DetectionFrame& frame) {
    run.detections.frames.push_back(frame);
  });
  MemorySource source(detections);
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    run.tracks.frames.push_back(std::move(frame));
  });
  if (!run.tracks.frames.empty()) {
    run.first_frame = run.tracks.frames.front().frame;
  }
  run.matches = freezer.Matches(WithRulesOfMode(options).tracker.life,
                                run.scene.model.frame_rate_hz);
  return run;
}

}  // namespace kinegraph
