// What a run says of itself at its end: how well its poses fit what the cameras
// saw, how tall people are, and what looks wrong.
//
//   RecordingReporter reporter(session.scene(), source->header().skeleton);
//   UsedFrames used(session.scene(), reopen);
//   ... for each written frame: reporter.See(*used.At(frame.frame), frame);
//   const RecordingReport report = reporter.Report();
#ifndef KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_
#define KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/data/detection.h"
#include "core/data/pose.h"
#include "core/io/detections/skeleton_fit.h"
#include "core/io/detections/view_pairing.h"
#include "solvers/scene/camera_check.h"
#include "solvers/scene/doctor.h"
#include "solvers/session/scene.h"
#include "solvers/session/subject_scale.h"

namespace kinegraph {

struct CameraReport {
  std::string view;
  std::string camera;
  int64_t detections = 0;  // with enough joints to be looked at
  int64_t matched = 0;     // of them, to a person who was written
  int64_t joints = 0;      // of them, with a position
  // Distance [px] of matched joints from the projected ones.
  double median_px = 0.0;
  double p90_px = 0.0;
  double person_px = 0.0;  // median diagonal of the box around a person

  double matched_share() const;
  double error_share() const;  // median_px of person_px
};

struct PersonReport {
  TrackId id;
  int64_t frames = 0;
  int64_t first_frame = 0;
  int64_t last_frame = 0;
  double height_m = 0.0;         // 0: too few limbs were seen
  double bone_spread = 0.0;      // median over limbs of (p90 - p10) / median
  double side_difference = 0.0;  // of left and right limbs, relative, mean
};

struct RecordingReport {
  int64_t frames = 0;
  int64_t poses = 0;
  double frame_rate_hz = 0.0;
  double working_distance_m = 0.0;
  bool is_human = true;    // by the names of the joints
  double subject_m = 0.0;  // size of who is no human; 0: not known
  std::string skeleton;
  double median_px = 0.0;  // over all cameras
  double p90_px = 0.0;
  // As many people as some view shows in one frame of twenty.
  int most_people_in_a_view = 0;
  // Joints with less confidence were not there (presence.h); 0: all were.
  double least_confidence = 0.0;
  double height_m = 0.0;  // median over people, weighed by their frames
  PairedBy paired_by = PairedBy::kMap;  // views with cameras
  std::vector<CameraReport> cameras;
  std::vector<PersonReport> people;  // ascending ids
  std::vector<CameraWarning> cameras_off;
  // What is implausible, what the doctor finds without tracking, and, where
  // that is no cause, the cameras that are off.
  std::vector<Finding> warnings;
};

// Collects while frames go by; memory grows with the number of people alone,
// by 40 KB each, or, in a stream, by what is reported of them.
class RecordingReporter {
 public:
  // `is_stream`: who has been away for a minute does not come back under the
  // same identity, and what was collected of them is summed up.
  RecordingReporter(const RunScene& scene, const Skeleton& detection_skeleton,
                    bool is_stream = false);
  // Before Report: of what was tracked (Session::scale).
  void set_scale(const SubjectScale& scale);
  // Frames that do not come are frames in which nobody was found: no holes.
  void set_empty_frames_left_out(bool left_out);
  ~RecordingReporter();
  RecordingReporter(const RecordingReporter&) = delete;
  RecordingReporter& operator=(const RecordingReporter&) = delete;

  // `seen` has the used views of the frame; `tracked` what was written of it,
  // with its matches (RunRequest::kept_matches).
  void See(const DetectionFrame& seen, const TrackFrame& tracked);
  RecordingReport Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_
