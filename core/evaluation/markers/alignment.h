// Brings two recordings of the same motion onto one clock and into one world.
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {

// One person's joints over time. A gap stays a gap.
class JointPaths {
 public:
  // Of the joints given, in their order; the frames in which the person is.
  JointPaths(const TrackSequence& tracks, TrackId person,
             const std::vector<int>& joints);

  // By the cubic through the four samples around, near the ends and gaps the
  // straight line; nullopt where one of the two samples next to it is missing
  // or they are more than one and a half frames apart.
  std::optional<Eigen::Vector3d> At(double time_s, size_t joint) const;
  // Over `half_s` to each side [m/s].
  std::optional<double> Speed(double time_s, size_t joint, double half_s) const;

  const std::vector<double>& times_s() const { return times_s_; }
  size_t joint_count() const { return joint_count_; }
  double frame_s() const { return frame_s_; }  // the median step

 private:
  const Joint3d& Sample(size_t frame, size_t joint) const {
    return samples_[frame * joint_count_ + joint];
  }

  size_t joint_count_ = 0;
  double frame_s_ = 0.0;
  std::vector<double> times_s_;
  std::vector<Joint3d> samples_;
};

// time of the truth = time of the tracks + offset + drift (time - middle)
struct ClockFit {
  double offset_s = 0.0;
  double drift = 0.0;
  double middle_s = 0.0;
  double offset_sigma_s = 0.0;
  double drift_sigma = 0.0;

  double Map(double time_s) const {
    return time_s + offset_s + drift * (time_s - middle_s);
  }
};

struct WorldFit {
  Eigen::Isometry3d truth_from_tracks = Eigen::Isometry3d::Identity();
  // One standard deviation, by how joints disagree.
  double rotation_sigma_deg = 0.0;
  double translation_sigma_m = 0.0;  // at the middle of the motion

  double rotation_deg() const;
};

enum class Align { kNone, kClock, kWorld, kBoth };

struct Alignment {
  TrackId person;     // of the tracks
  JointPairs joints;  // a: truth, b: tracks
  ClockFit clock;     // as asked for, else none
  WorldFit world;
  // Median distance of all joints [m] as they stand, on one clock, and in one
  // world, too; NaN where it cannot be said.
  double median_none_m = 0.0;
  double median_clock_m = 0.0;
  double median_both_m = 0.0;
};

struct AlignRequest {
  Align align = Align::kBoth;
  bool with_drift = false;
  std::optional<TrackId> person;  // of the tracks; nullopt: who fits best
};

// The clock: speeds of all joints, which no turn of the world changes, are laid
// over each other, by their correlation at any shift, then by robust least
// squares. Uncertain by how its gradient varies from second to second. The
// world: rigid, by least squares with Huber's loss at one and a half median
// residuals.
//
// `truth` is of one person. `is_centre`, one a joint of the truth: the world is
// fitted to these where they are three or more. Throws InputError without a
// file when nobody moves or the motions are not alike, when the points fix no
// rotation, when units differ, or when a mirror image fits far better.
Alignment AlignRecordings(const TrackSequence& truth,
                          const std::vector<bool>& is_centre,
                          const TrackSequence& tracks,
                          const AlignRequest& request);

// The only person of it. Throws InputError without a file for none or several.
TrackId OnlyPerson(const TrackSequence& tracks);

// A joint of the pairs each.
JointPaths TruthPaths(const TrackSequence& truth, const JointPairs& joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_
