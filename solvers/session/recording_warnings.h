// When a recording's figures mean that something is wrong with its set-up. For
// solvers/session alone.
#ifndef KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_
#define KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_

#include <cstddef>
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

// What a report does not show but its warnings need.
struct RecordingFacts {
  double stature_m = 0.0;       // of people paired between views, untracked
  double body_speed_mps = 0.0;  // 95th percentile, middle of the hips
  double followed_mps = 0.0;    // as fast as gates in metres follow; 0: others
  bool implausible_bones = false;  // SkeletonFit::Implausible of the skeleton
  std::string better_skeleton;     // another that fits clearly better, or empty
  double frame_step_s = 0.0;       // median time from frame to frame
  std::vector<double> holes_s;     // longer steps than kHole, ascending in time
  int64_t steps_back = 0;          // how often the clock stood or stepped back
  int64_t empty_frames = 0;        // no view shows anybody; of report.frames
  // Whether the doctor could look at the views, and says what is wrong there.
  bool views_examined = false;
  bool independent_frames = false;  // as the options say
  bool in_seconds = false;          // graph mode
  bool links = false;               // identity.link
  // In joints of 17: what a detection usually shows, and what a new person
  // needs (initialisation.min_joints); 0: not known.
  double joints_of_17 = 0.0;
  double least_joints_of_17 = 0.0;
  std::vector<UnfollowedPerson> unfollowed;
};

// Joints of a detection that counts as somebody: five, or all that a smaller
// skeleton has.
int LeastJoints(const Skeleton& skeleton);

// How many of the joints that association compares were found, as if there were
// 17 of them.
double JointsOf17(const Detection& detection, const Skeleton& skeleton);

// Joints of 17 that a new person should need where detections usually show
// `joints_of_17`; nullopt where `least` of them are well within what they show.
// Of two views with a third of the joints missing in either, half is common.
std::optional<int> FewerJoints(double joints_of_17, double least);

// gates.speed_mps [m/s] for people who move at `body_speed_mps`, where gates
// follow them up to `followed_mps`; nullopt where that is enough. A gate is as
// wide as the way between two frames, and limbs are faster than the body.
std::optional<double> FasterGate(double body_speed_mps, double followed_mps);

// Median height of the people, each weighed by its frames; 0 when unknown.
double TypicalHeight(const std::vector<PersonReport>& people);

// Units in which the calibration's lengths may be instead, as flags joined by
// " or ": those that bring `length_m` between the two; empty: none.
std::string UnitsThatFit(double length_m, double least_m, double most_m);

// What the doctor found without tracking, then what merely looks odd; where the
// one explains the other, that goes, and with it RecordingReport::cameras_off.
void AddWarnings(const RecordingFacts& facts, const Diagnosis& diagnosis,
                 RecordingReport* report);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RECORDING_WARNINGS_H_
