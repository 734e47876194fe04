// kinegraph-track: 2D detections to 3D tracks.
#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/common/app.h"
#include "apps/common/progress.h"
#include "core/base/error.h"
#include "core/io/calibration.h"
#include "core/io/detection_source.h"
#include "core/io/identity_edits.h"
#include "core/io/track_writer.h"
#include "solvers/session/run.h"

DEFINE_string(cameras, "", "calibration file or folder");
DEFINE_string(detections, "", "2D detections: a file or a folder");
DEFINE_string(config, "", "configuration (TOML, see configs/)");
DEFINE_string(mode, "", "paper or graph; overrides the key mode");
DEFINE_string(set, "", "keys to change: key=value;key=value");
DEFINE_string(frames, "", "frames to use: A:B includes A and excludes B");
DEFINE_string(without_cameras, "", "names of cameras to leave out: a,b");
DEFINE_int32(threads, 1, "threads for the estimators; the result is the same");
DEFINE_string(out, "", "tracks to write (JSON Lines)");
DEFINE_string(corrections, "",
              "edits of identities to replay after automatic linking "
              "(JSON Lines, as NAME.identity.jsonl)");
DEFINE_bool(keys, false, "list the keys of a configuration and leave");

namespace kinegraph {
namespace {

void RunTrack() {
  if (FLAGS_keys) {
    std::fputs(ConfigReference<RunOptions>().c_str(), stdout);
    return;
  }
  RequireFlag("cameras", FLAGS_cameras);
  RequireFlag("detections", FLAGS_detections);
  RequireFlag("config", FLAGS_config);
  RequireFlag("out", FLAGS_out);
  if (FLAGS_threads < 1) {
    throw InputError("--threads: found " + std::to_string(FLAGS_threads) +
                     ", expected at least 1");
  }
  const RunOptions options =
      ReadRunOptions(FLAGS_config, FLAGS_set, FLAGS_mode);
  RunRequest request;
  request.frames = ParseFrameRanges(FLAGS_frames);
  request.without_cameras = ParseList(FLAGS_without_cameras, "without_cameras");
  request.threads = FLAGS_threads;
  if (!FLAGS_corrections.empty()) {
    request.corrections = ReadIdentityEdits(FLAGS_corrections);
  }
  request.cameras = ReadCameras(FLAGS_cameras, options.cameras);
  const auto open = [&] {
    return OpenDetections(FLAGS_detections, DetectionOptionsOf(options));
  };
  const std::unique_ptr<DetectionSource> source = open();
  const int64_t frame_count = std::max<int64_t>(0, source->frame_count());
  Session session(options, request, source->header(), open);
  if (session.scene().used_views.size() < 2) {
    std::fputs(
        "kinegraph-track: warning: one view alone cannot be "
        "triangulated; nobody will be found\n",
        stderr);
  }

  TrackWriter writer(FLAGS_out, session.scene().header,
                     {options.output.observations});
  {
    Progress progress("tracking", frame_count * PassCount(options));
    session.set_progress(
        [&](int64_t frames_read) { progress.Set(frames_read); });
    TrackAll(source.get(), &session,
             [&](TrackFrame&& frame) { writer.Write(frame); });
  }
  const RunSummary& summary = session.summary();
  if (summary.frames == 0) {
    throw InputError(
        FLAGS_detections, "",
        "no frame to track" + (FLAGS_frames.empty()
                                   ? std::string()
                                   : " in --frames=" + FLAGS_frames));
  }
  if (options.identity.link || !FLAGS_corrections.empty()) {
    WriteIdentityEdits(IdentityPathOf(FLAGS_out), session.identity_edits());
  }
  writer.Commit();
  std::printf("%lld frames, %lld people, %lld poses -> %s\n",
              static_cast<long long>(summary.frames),
              static_cast<long long>(summary.people),
              static_cast<long long>(summary.person_frames), FLAGS_out.c_str());
}

}  // namespace
}  // namespace kinegraph

int main(int argc, char** argv) {
  return kinegraph::RunApp(
      argc, argv,
      {"track", "2D detections to 3D tracks",
       "--cameras=F --detections=PATH --config=F.toml --out=F.jsonl"},
      kinegraph::RunTrack);
}
