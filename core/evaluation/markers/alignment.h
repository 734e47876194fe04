// Brings two recordings of the same motion to one clock and into one world.
#ifndef KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_
#define KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/data/pose.h"
#include "core/evaluation/correspondence.h"

namespace kinegraph {

// One person's joints over time. Gaps remain gaps.
class JointPaths {
 public:
  // Takes the given joints, in their order, from the frames in which the person
  // is present.
  JointPaths(const TrackSequence& tracks, TrackId person,
             const std::vector<int>& joints);

  // The sample at this time (within 2 ns), otherwise the value of a cubic
  // Hermite spline with central differences as tangents, near ends and gaps
  // linear. nullopt where that sample or one of the two adjacent ones is
  // missing, where the two are more than one and a half frames apart, and
  // before the first and after the last sample.
  std::optional<Eigen::Vector3d> At(double time_s, size_t joint) const;
  // Distance between the positions `half_s` before and after the time, divided
  // by 2 `half_s` [m/s]; nullopt where one of them is.
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
  // One standard deviation, from the disagreement of joints.
  double rotation_sigma_deg = 0.0;
  double translation_sigma_m = 0.0;  // at the middle of the motion

  double rotation_deg() const;
};

enum class Align { kNone, kClock, kWorld, kBoth };

struct Alignment {
  TrackId person;     // of the tracks
  JointPairs joints;  // a: truth, b: tracks
  ClockFit clock;     // as requested, else identity
  WorldFit world;
  // Median distance of all joints [m] without any alignment, on one clock, and
  // also in one world; NaN where undefined.
  double median_none_m = 0.0;
  double median_clock_m = 0.0;
  double median_both_m = 0.0;
};

struct AlignRequest {
  Align align = Align::kBoth;
  bool with_drift = false;
  std::optional<TrackId> person;  // of the tracks; nullopt: the best fit
};

// The clocks are aligned by the speeds of the common body joints
// (CommonBodyJoints), which do not depend on the world's orientation: by their
// correlation at any shift (in long recordings, up to a shift that bounds the
// computing time), then by robust least squares. The uncertainty follows from
// the variation of the gradient between seconds and between joints. The worlds
// are aligned by a rigid motion: least squares with Huber's loss at one and a
// half median residuals.
//
// `truth` has one person. `is_centre`, one per joint of the truth: whether
// markers enclose the joint's centre; the world is fitted to these joints if at
// least three are common to both, else to all common joints. Throws InputError,
// which does not name the file, when a person is missing or the truth has
// several, when no joint is common to both, when there is no motion or the
// motions do not agree, when the times do not overlap (if the clocks are not
// aligned), when the points do not determine a rotation, when units differ, or
// when a mirror image fits far better.
Alignment AlignRecordings(const TrackSequence& truth,
                          const std::vector<bool>& is_centre,
                          const TrackSequence& tracks,
                          const AlignRequest& request);

// The only person of `tracks`. Throws InputError, which does not name the
// file, for none or several.
TrackId OnlyPerson(const TrackSequence& tracks);

// Paths of the truth's joints, one for each pair. Throws as OnlyPerson does.
JointPaths TruthPaths(const TrackSequence& truth, const JointPairs& joints);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_EVALUATION_MARKERS_ALIGNMENT_H_
