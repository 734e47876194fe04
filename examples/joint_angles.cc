// Prints a joint angle with its 95 % interval, and the speed of the pelvis,
// every second for every person.
#include <kinegraph/kinegraph.h>

#include <cstdio>

#include "example_take.h"

int main() {
  const ExampleRecording recording = MakeExampleRecording();

  kinegraph::RunOptions options;
  options.estimators.mode = kinegraph::Mode::kGraph;
  kinegraph::RunRequest request;
  request.cameras = recording.scene.cameras;
  const kinegraph::TrackSequence tracks =
      kinegraph::TrackSequenceOf(options, request, recording.detections);

  const kinegraph::KinematicsTable table = kinegraph::MeasureKinematics(tracks);
  const int knee = table.IndexOf("l_knee_flexion_deg");
  const int speed = table.IndexOf("pelvis_speed_m_s");
  int count = 0;
  for (const kinegraph::KinematicsRow& row : table.rows) {
    if (row.frame % 25 != 0) continue;
    std::printf(
        "%.2f s person %lld: left knee %.0f (%.0f .. %.0f) degrees, "
        "%.2f m/s\n",
        kinegraph::ToSeconds(row.time), static_cast<long long>(row.id.value()),
        row.values[knee], row.values[knee + 1], row.values[knee + 2],
        row.values[speed]);
    ++count;
  }
  return count > 0 ? 0 : 1;
}
