// Reading 2D detections of any detector frame by frame, in memory that does not
// depend on the length of the recording.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_SOURCE_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_SOURCE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/base/options.h"
#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Meaning of a joint with confidence 0 or at exactly (0, 0): detectors such as
// YOLO write the latter, with any confidence, for joints they do not see.
enum class ZeroConfidence {
  kMissing,   // not a measurement
  kPosition,  // an ordinary position (e.g. interpolated)
};

struct DetectionReadOptions {
  // "auto": by content; else a name of DetectionFormats (format.h).
  std::string format = "auto";
  ZeroConfidence zero_confidence = ZeroConfidence::kMissing;
  // Name of a built-in skeleton if the file does not specify it uniquely
  // (BODY_25B looks like BODY_25). Empty: by the file.
  std::string skeleton_name;
  // A user-defined skeleton; overrides the name.
  std::optional<Skeleton> skeleton;
  // Overrides the file's rate. 0: the file's, if any.
  double frame_rate_hz = 0.0;
  // Views whose files have their own frame rate [Hz].
  std::map<std::string, double> view_frame_rate_hz;
  // Subtracted from the frame numbers of a view's files.
  std::map<std::string, int64_t> view_frame_offset;
  // Views whose detector exchanges left and right.
  std::vector<std::string> exchange_sides;
  // Views with mirrored images: "x1279" maps x to 1279 - x, "y719" y to 719 - y
  // [px].
  std::map<std::string, std::string> mirror_px;
  // First frame number for files without numbers (FreeMoCap).
  int64_t first_frame = 0;
  // Association compares all people and all joints: input beyond these limits
  // is rejected before it takes minutes per frame.
  int64_t max_per_view = 300;    // detections per view and frame
  int64_t max_per_frame = 1000;  // over all views
  int64_t max_joints = 1000;     // of the detections' skeleton
  // Times of our own format may repeat or decrease, for readers that allow it
  // (Session).
  bool any_clock = false;
  // Frames of our own format that cannot be read are skipped and counted.
  bool skip_bad_frames = false;

  // Keys of the table "detections", which the caller enters.
  void Describe(OptionVisitor& visitor);
};

// Skipped frames (DetectionReadOptions::skip_bad_frames).
struct BadFrames {
  int64_t count = 0;
  std::string last;  // error of the last one
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;

  virtual const DetectionHeader& header() const = 0;
  // The next frame, in ascending order; false at the end. Every view has an
  // entry, which may be empty. Frames missing in all views are omitted. Times
  // are the file's, else frame / frame rate, else 0. Throws InputError.
  // Overwrites `frame`; reusing the same one saves allocations.
  virtual bool Next(DetectionFrame* frame) = 0;
  // Total number of frames, for progress; -1 if unknown. May read the whole
  // file (our own format): call it once.
  virtual int64_t frame_count() const { return -1; }
  // Frames skipped so far, and the error of the last one.
  virtual BadFrames bad_frames() const { return {}; }
};

// Opens detections and reads what applies to the whole recording. Throws
// InputError naming the file; OptionError if `options` are invalid.
std::unique_ptr<DetectionSource> OpenDetections(
    const std::string& path, const DetectionReadOptions& options = {});

// All frames at once.
DetectionSequence ReadDetections(const std::string& path,
                                 const DetectionReadOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SOURCE_H_
