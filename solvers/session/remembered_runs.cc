#include "solvers/session/remembered_runs.h"

#include "core/base/bytes.h"
#include "core/io/configuration/checkpoint_values.h"
#include "core/io/configuration/config.h"
#include "solvers/session/ready_take.h"

namespace kinegraph {

TrackSequence RememberedTracks(const RunOptions& options,
                               const RunRequest& request,
                               const DetectionSequence& detections,
                               Checkpoint* checkpoint) {
  if (checkpoint == nullptr || !checkpoint->keeps() ||
      !request.corrections.empty() || ChangesCameras(options)) {
    return TrackSequenceOf(options, request, detections);
  }
  ByteWriter depends;
  depends.PutText(EffectiveConfigJson(options));
  Put(request.cameras, &depends);
  depends.PutSize(request.without_cameras.size());
  for (const std::string& name : request.without_cameras) {
    depends.PutText(name);
  }
  depends.PutSize(request.frames.size());
  for (const FrameRange& range : request.frames) {
    depends.Put(range.begin);
    depends.Put(range.end);
  }
  depends.Put(request.kept_matches);
  depends.PutText(ContentOf(detections));
  const std::string key = FingerprintOf(depends.bytes());
  if (const auto kept = checkpoint->Find(key)) {
    ByteReader reader(*kept);
    TrackSequence tracks;
    // The header costs nothing to make.
    tracks.header = PrepareScene(options, request, detections.header).header;
    tracks.frames = GetTrackFrames(&reader);
    return tracks;
  }
  RunOptions remembering = options;
  remembering.estimators.graph.pieces = checkpoint;
  TrackSequence tracks = TrackSequenceOf(remembering, request, detections);
  ByteWriter kept;
  Put(tracks.frames, &kept);
  checkpoint->Add(key, kept.bytes());
  return tracks;
}

}  // namespace kinegraph
