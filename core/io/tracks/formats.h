// What readers of track formats share. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_TRACKS_FORMATS_H_
#define KINEGRAPH_CORE_IO_TRACKS_FORMATS_H_

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/io/tracks/tracks.h"

namespace kinegraph {

// Of CMU Panoptic's high-definition cameras.
inline constexpr double kHdFrameRateHz = 29.97;

// The skeleton of a file that names its joints, and perhaps bones: the
// option's, else SkeletonOfLabels'. Throws InputError without a file when the
// option's has other joints.
Skeleton SkeletonOfNames(const std::vector<std::string>& joints,
                         const TrackReadOptions& options,
                         const std::vector<Bone>& bones = {});

// Skeleton that a {"poses"} file with so many joints is taken to have, or null.
const Skeleton* SkeletonOfPoses(size_t joint_count);

// What a file gives as a position; missing where a number is none.
inline Joint3d ObservedJoint(double x_m, double y_m, double z_m) {
  if (!std::isfinite(x_m + y_m + z_m)) return {};
  return {{x_m, y_m, z_m}, JointStatus::kObserved};
}

// Collects people in any order of frames.
class TrackCollector {
 public:
  explicit TrackCollector(TrackHeader header) : header_(std::move(header)) {}
  const TrackHeader& header() const { return header_; }
  // Makes sure that the frame is there even if nobody is in it.
  TrackFrame* Touch(int64_t frame);
  // Throws InputError without a file when the frame has this person already.
  PersonPose* Add(int64_t frame, TrackId id);
  TrackSequence Finish();

 private:
  TrackHeader header_;
  std::map<int64_t, TrackFrame> frames_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_TRACKS_FORMATS_H_
