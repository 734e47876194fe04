// The report at the end of a run: residuals of its poses, stature of people,
// and warnings.
//
//   RecordingReporter reporter(session.scene(), source->header().skeleton);
//   UsedFrames used(session.scene(), reopen);
//   ... for each written frame: reporter.See(*used.At(frame.frame), frame);
//   const RecordingReport report = reporter.Report();
#ifndef KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_
#define KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_

#include <cstdint>
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
  int64_t detections = 0;  // detections with enough joints
  int64_t matched = 0;     // of these, detections of written people
  // Found joints of the matched detections that have a position in the pose.
  int64_t joints = 0;
  // Distance [px] of matched joints from the projections of the poses.
  double median_px = 0.0;
  double p90_px = 0.0;
  double person_px = 0.0;  // median diagonal of the box around a person

  double matched_share() const;
  double error_share() const;  // median_px relative to person_px
};

struct PersonReport {
  TrackId id;
  int64_t frames = 0;
  int64_t first_frame = 0;
  int64_t last_frame = 0;
  double height_m = 0.0;  // 0: too few limbs were seen
  // Median over the limbs, without the trunk, of (p90 - p10) / median of their
  // lengths.
  double bone_spread = 0.0;
  // Mean relative difference of left and right limbs.
  double side_difference = 0.0;
};

struct RecordingReport {
  int64_t frames = 0;
  int64_t poses = 0;
  double frame_rate_hz = 0.0;
  double working_distance_m = 0.0;
  bool is_human = true;    // judged by the names of the joints
  double subject_m = 0.0;  // size of a non-human subject; 0: unknown
  std::string skeleton;
  double median_px = 0.0;  // over all cameras
  double p90_px = 0.0;
  // The largest n such that some view shows n or more people in at least 5 % of
  // the frames; at most 63.
  int most_people_in_a_view = 0;
  // Joints with a lower confidence were treated as absent (presence.h); 0: all
  // joints were used.
  double least_confidence = 0.0;
  double height_m = 0.0;  // median over people, weighted by their frames
  // Median over detections of the number of found joints, scaled to a skeleton
  // of 17 (JointsOf17); 0: unknown.
  double joints_of_17 = 0.0;
  PairedBy paired_by = PairedBy::kMap;  // how views were paired with cameras
  std::vector<CameraReport> cameras;
  std::vector<PersonReport> people;  // ascending ids
  std::vector<CameraWarning> cameras_off;
  // The doctor's findings without tracking, and, unless these explain them,
  // implausible results and problems of individual cameras.
  std::vector<Finding> warnings;
};

// Collects data frame by frame; memory grows only with the number of people, by
// 40 KB per person or, for a stream, by the size of a PersonReport.
class RecordingReporter {
 public:
  // `is_stream`: summarises the data of people who have been away for a minute,
  // because they do not return under the same identity.
  RecordingReporter(const RunScene& scene, const Skeleton& detection_skeleton,
                    bool is_stream = false);
  // Sets the scale of the run (Session::scale); to be called before Report.
  void set_scale(const SubjectScale& scale);
  // Whether the calibration contains clocks (RefinementRecord::has_clocks).
  void set_has_clocks(bool has_clocks);
  // If true, frames that are not passed are empty frames, not gaps.
  void set_empty_frames_left_out(bool left_out);
  ~RecordingReporter();
  RecordingReporter(const RecordingReporter&) = delete;
  RecordingReporter& operator=(const RecordingReporter&) = delete;

  // `seen` has the used views of the frame; `tracked` is the written frame with
  // its matches (RunRequest::kept_matches).
  void See(const DetectionFrame& seen, const TrackFrame& tracked);
  RecordingReport Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_SESSION_RECORDING_REPORT_H_
