// Warnings if the results of a run indicate a problem of the set-up. For
// solvers/session only.
#ifndef KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_
#define KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"
#include "solvers/scene/doctor.h"
#include "solvers/session/recording_report.h"
#include "solvers/session/unfollowed.h"

namespace kinegraph {

// Input of the warnings besides the report.
struct RecordingFacts {
  double stature_m = 0.0;       // of untracked people matched between views
  double body_speed_mps = 0.0;  // 95th percentile, mid-hip
  // Greatest speed covered by gates in metres; 0: gates in other units, or
  // association predicts motion.
  double followed_mps = 0.0;
  // Frame intervals longer than kHole (solvers/scene/plausible.h), in order.
  std::vector<double> holes_s;
  // Number of times the clock stopped or stepped back.
  int64_t steps_back = 0;
  // Number of frames without detections in any view.
  int64_t empty_frames = 0;
  // Whether the doctor could examine the views; if so, it reports their
  // problems.
  bool views_examined = false;
  bool independent_frames = false;  // input.independent_frames
  // Updates after which a track is confirmed and written.
  int64_t confirm_hits = 1;
  bool in_seconds = false;  // graph mode
  bool links = false;       // identity.link
  // Whether the calibration contains clocks, which a run does not refine again.
  bool has_clocks = false;
  // Number of joints, of 17, required of a new person
  // (initialisation.min_joints); 0: unknown.
  double least_joints_of_17 = 0.0;
  std::vector<UnfollowedPerson> unfollowed;
};

// Joints required for a detection to count as a person: five, or all of a
// smaller skeleton.
int LeastJoints(const Skeleton& skeleton);

// Number of found association joints, scaled to 17.
double JointsOf17(const Detection& detection, const Skeleton& skeleton);

// The number of joints, of 17, that should be required of a new person if
// detections typically have `joints_of_17`; nullopt if `least`, the current
// requirement, is low enough or detections are unknown (0). Two views that each
// miss a third of the joints may have only half of their joints in common.
std::optional<int> FewerJoints(double joints_of_17, double least);

// Recommended gates.speed_mps [m/s] for people who move at `body_speed_mps`, if
// gates cover speeds up to `followed_mps`; nullopt if `followed_mps` exceeds
// the body's speed by a quarter or more or is 0 (unknown), or if the body's
// speed is implausible. Gates must cover the distance moved between two frames,
// and limbs are faster than the body.
std::optional<double> FasterGate(double body_speed_mps, double followed_mps);

// Median height of the people, weighted by their frames; 0 if unknown.
double TypicalHeight(const std::vector<PersonReport>& people);

// Other units of the calibration's lengths with which `length_m` would be in
// the range, as flags joined by " or "; empty if there are none.
std::string UnitsThatFit(double length_m, double least_m, double most_m);

// Adds the significant findings of the doctor (made without DoctorInput::match,
// so without examinations that need matches; without the unit if the results
// already give a warning of it), warnings of implausible results of the run,
// and one warning for each of RecordingReport::cameras_off. If a finding of
// confidence above 0.5 has a fix other than a full run of the doctor, the
// warnings for cameras_off and those of implausible results whose only fix is
// such a run are omitted.
void AddWarnings(const RecordingFacts& facts, const Diagnosis& diagnosis,
                 RecordingReport* report);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_
