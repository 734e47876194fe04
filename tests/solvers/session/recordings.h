// Shared by the tests of this folder: short synthetic recordings and the
// comparison of their tracks.
#ifndef KINEGRAPH_TESTS_SOLVERS_SESSION_RECORDINGS_H_
#define KINEGRAPH_TESTS_SOLVERS_SESSION_RECORDINGS_H_

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/recording_report.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {

struct Recording {
  RunRequest request;
  DetectionSequence detections;
  TrackSequence truth;

  std::vector<DetectionFrame>& frames() { return detections.frames; }
};

// People present from the first frame to the last.
inline SceneOptions Staying(int64_t seed, int people, int cameras,
                            double duration_s) {
  SceneOptions options;
  options.seed = seed;
  options.people = people;
  options.duration_s = duration_s;
  options.motion.visitors = 0.0;
  options.cameras.count = cameras;
  return options;
}

inline Recording Record(const Scene& scene, const NoiseOptions& noise = {}) {
  Recording recording;
  recording.request.cameras = scene.cameras;
  recording.detections = Observe(scene, noise, nullptr);
  recording.truth = TruthFor(scene, recording.detections);
  return recording;
}

inline RunOptions GraphMode() {
  RunOptions options;
  options.estimators.mode = Mode::kGraph;
  return options;
}

inline TrackSequence Track(const Recording& recording,
                           const RunOptions& options) {
  return TrackSequenceOf(options, recording.request, recording.detections);
}

inline std::set<TrackId> IdsOf(const TrackSequence& tracks) {
  std::set<TrackId> ids;
  for (const TrackFrame& frame : tracks.frames) {
    for (const PersonPose& person : frame.people) ids.insert(person.id);
  }
  return ids;
}

inline size_t PoseCount(const TrackSequence& tracks) {
  size_t poses = 0;
  for (const TrackFrame& frame : tracks.frames) poses += frame.people.size();
  return poses;
}

// Frame numbers, identities, statuses, positions and traces of covariances,
// frame by frame.
inline std::vector<double> NumbersOf(const TrackSequence& tracks) {
  std::vector<double> numbers;
  for (const TrackFrame& frame : tracks.frames) {
    numbers.push_back(static_cast<double>(frame.frame));
    for (const PersonPose& person : frame.people) {
      numbers.push_back(static_cast<double>(person.id.value()));
      for (const Joint3d& joint : person.joints) {
        numbers.push_back(static_cast<double>(joint.status));
        if (!joint.present()) continue;
        for (int i = 0; i < 3; ++i) numbers.push_back(joint.position_m[i]);
      }
      for (const auto& covariance : person.covariances) {
        numbers.push_back(covariance.has_value() ? covariance->trace() : 0.0);
      }
    }
  }
  return numbers;
}

// The tracks of a session that receives all frames one by one.
inline TrackSequence FrameByFrame(const Recording& recording,
                                  Session* session) {
  TrackSequence tracks;
  const auto append = [&](std::vector<TrackFrame> frames) {
    for (TrackFrame& one : frames) tracks.frames.push_back(std::move(one));
  };
  for (const DetectionFrame& frame : recording.detections.frames) {
    append(session->Process(frame));
  }
  append(session->Finish());
  return tracks;
}

// The report at the end of a run.
inline RecordingReport ReportOf(const Recording& recording,
                                const RunOptions& options,
                                bool has_clocks = false) {
  RunRequest request = recording.request;
  request.kept_matches = KeptMatches::kDetections;
  Session session(options, request, recording.detections.header);
  RecordingReporter reporter(session.scene(),
                             recording.detections.header.skeleton);
  UsedFrames used(session.scene(), [&] {
    return std::make_unique<MemorySource>(recording.detections);
  });
  MemorySource source(recording.detections);
  TrackAll(&source, &session, [&](TrackFrame&& frame) {
    reporter.See(*used.At(frame.frame), frame);
  });
  reporter.set_scale(session.scale());
  reporter.set_has_clocks(has_clocks);
  return reporter.Report();
}

inline std::vector<std::string> KindsOf(const std::vector<Finding>& findings) {
  std::vector<std::string> kinds;
  for (const Finding& one : findings) kinds.push_back(one.kind);
  return kinds;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SOLVERS_SESSION_RECORDINGS_H_
