// A new user's way with a recording of their own: synthesize, init, track,
// report, without any configuration written by hand. The recordings are
// synthetic, their detector is modelled noise.
#ifndef KINEGRAPH_TESTS_SUPPORT_OWN_RECORDING_H_
#define KINEGRAPH_TESTS_SUPPORT_OWN_RECORDING_H_

#include <string>
#include <vector>

#include "core/evaluation/identity.h"

namespace kinegraph::testing {

struct OwnRecording {
  std::string format;
  std::string skeleton;
  double frame_rate_hz = 25.0;
  double focal_px = 800.0;
  double unit_per_m = 1.0;  // of the calibration's lengths
  int people = 2;
  double duration_s = 2.5;

  // Of the cameras' ring: the longer the lens, the farther.
  double radius_m() const;
  std::string unit() const;  // that init must find
  std::string name() const;  // "body25_25hz_800px_m"
};

// Every detector with every other value at least once, and every two values of
// two of the four: formats, rates, units, focal lengths of 500 to 3000 px.
std::vector<OwnRecording> CoveringRecordings();
// All of them with each other.
std::vector<OwnRecording> AllRecordings();

// The scene in the folder: detections in the detector's format, and
// calibration.json, a format that states no unit.
void MakeOwnRecording(const OwnRecording& recording, const std::string& folder);

// "--cameras=... --detections=... " of that folder.
std::string InputsOf(const OwnRecording& recording, const std::string& folder);

// Changes of a hand-made configuration: gates in pixels by the rule of
// configs/paper/pose2sim.toml, with the focal length over the distance; 310
// px/m are Shelf's.
std::string HandMadeKeys(const OwnRecording& recording);

struct OwnRecordingOutcome {
  std::string failed;  // command and its error; empty: all came to their end
  std::string init;    // what was said
  std::string track;
  double error_m = 0.0;  // mean over joints
  double by_hand_error_m = 0.0;
  IdentityResult identity;
};

// The five steps, and once more with the hand-made gates.
OwnRecordingOutcome WalkFiveSteps(const OwnRecording& recording,
                                  const std::string& folder);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_OWN_RECORDING_H_
