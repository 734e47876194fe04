// Tracks a recording from its files: track_take CAMERAS DETECTIONS OUT
#include <kinegraph/kinegraph.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  try {
    kinegraph::RunOptions options;
    options.estimators.mode = kinegraph::Mode::kGraph;
    kinegraph::RunRequest request;
    request.cameras = kinegraph::ReadCameras(argv[1]);
    const kinegraph::TrackSequence tracks = kinegraph::TrackSequenceOf(
        options, request, kinegraph::ReadDetections(argv[2]));
    kinegraph::WriteTracks(argv[3], tracks);
    std::printf("%zu frames -> %s\n", tracks.frames.size(), argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}
