// Reading 2D detections of any detector frame by frame. In kinegraph's own
// format, in OpenPose's and in most formats of adapters, only one frame is in
// memory; files of other formats are read as a whole, since their frames may be
// in any order.
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

// Meaning of a joint with confidence 0 (or less) or at exactly (0, 0): for
// joints that they do not see, detectors such as YOLO write (0, 0) with any
// confidence.
enum class ZeroConfidence {
  kMissing,   // not a measurement
  kPosition,  // an ordinary position (e.g. interpolated)
};

struct DetectionReadOptions {
  // The name of one of DetectionFormats (format.h); "auto": recognised by
  // content.
  std::string format = "auto";
  ZeroConfidence zero_confidence = ZeroConfidence::kMissing;
  // Name of a built-in skeleton, for files that do not determine it uniquely
  // (BODY_25 and BODY_25B have the same number of joints). Empty: the file
  // determines it.
  std::string skeleton_name;
  // A user-defined skeleton; overrides the name.
  std::optional<Skeleton> skeleton;
  // Overrides the file's frame rate; 0: not given.
  double frame_rate_hz = 0.0;
  // Throws InputError if the file states a rate that differs from frame_rate_hz
  // by more than 1 %.
  bool refuse_other_rate = false;
  // By view: the rate [Hz] at which its files count frames, if it differs from
  // the recording's.
  std::map<std::string, double> view_frame_rate_hz;
  // By view: subtracted from the frame numbers in its files.
  std::map<std::string, int64_t> view_frame_offset;
  // Views whose detector exchanges left and right.
  std::vector<std::string> exchange_sides;
  // Views with mirrored images: "x1279" maps x to 1279 - x, "y719" y to 719 - y
  // [px].
  std::map<std::string, std::string> mirror_px;
  // First frame number for files without numbers (FreeMoCap, SLEAP).
  int64_t first_frame = 0;
  // Association compares all people and all joints. Input beyond these limits
  // would take minutes per frame and is rejected.
  int64_t max_per_view = 300;    // detections per view and frame
  int64_t max_per_frame = 1000;  // over all views
  int64_t max_joints = 1000;     // of the detections' skeleton
  // Allows times that repeat or decrease in kinegraph's own format, for callers
  // that can use them (Session).
  bool any_clock = false;
  // Skips and counts frames of kinegraph's own format that cannot be read or
  // are rejected, for example because of the limits above.
  bool skip_bad_frames = false;

  // The keys of the table "detections"; the caller enters the table.
  void Describe(OptionVisitor& visitor);
};

// Frames skipped because of DetectionReadOptions::skip_bad_frames.
struct BadFrames {
  int64_t count = 0;
  std::string last;  // error of the last skipped frame
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;

  virtual const DetectionHeader& header() const = 0;
  // The next frame, in ascending order; false at the end. Every view has an
  // entry, which may be empty. Frames missing in all views are omitted. Times
  // are those in the file, otherwise frame / frame rate, or 0 if the rate is
  // unknown. Throws InputError. Overwrites `frame`; reusing the same object
  // saves allocations.
  virtual bool Next(DetectionFrame* frame) = 0;
  // Total number of frames, for progress; -1 if unknown. May read the whole
  // file (kinegraph's own format), so call it once.
  virtual int64_t frame_count() const { return -1; }
  virtual BadFrames bad_frames() const { return {}; }
};

// Opens detections and reads their header. Throws InputError naming the file;
// OptionError if `options` are invalid.
std::unique_ptr<DetectionSource> OpenDetections(
    const std::string& path, const DetectionReadOptions& options = {});

// Reads all frames.
DetectionSequence ReadDetections(const std::string& path,
                                 const DetectionReadOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SOURCE_H_
