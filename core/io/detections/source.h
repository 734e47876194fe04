// Reading 2D detections, whatever detector wrote them, frame by frame, so that
// long recordings need no more memory than short ones.
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

// What a joint is that has confidence 0, or lies at exactly (0, 0): detectors
// such as YOLO's write that for what they do not see, with any confidence.
enum class ZeroConfidence {
  kMissing,   // not a measurement
  kPosition,  // an ordinary position (filled in by whoever wrote the file)
};

struct DetectionReadOptions {
  // "auto": by content; else a name among DetectionFormats
  // (format.h).
  std::string format = "auto";
  ZeroConfidence zero_confidence = ZeroConfidence::kMissing;
  // Name of a built-in skeleton when the file does not tell its own or tells
  // less than is known (BODY_25B looks like BODY_25). Empty: by the file.
  std::string skeleton_name;
  // The same as a value, for skeletons that a user defined; wins over the name.
  std::optional<Skeleton> skeleton;
  // Wins over the file's. 0: as the file tells, if it does.
  double frame_rate_hz = 0.0;
  // Views whose files count frames at a rate of their own [Hz].
  std::map<std::string, double> view_frame_rate_hz;
  // What is taken from the frame numbers of a view's files.
  std::map<std::string, int64_t> view_frame_offset;
  // Views whose detector takes left for right.
  std::vector<std::string> exchange_sides;
  // Views whose images were mirrored: "x1279" reads 1279 - x for x, "y719"
  // 719 - y for y [px].
  std::map<std::string, std::string> mirror_px;
  // Frame number of a file that names none (FreeMoCap).
  int64_t first_frame = 0;
  // Association compares everybody with everybody and every joint: what goes
  // beyond these is refused before it takes minutes a frame.
  int64_t max_per_view = 300;    // detections of one view in one frame
  int64_t max_per_frame = 1000;  // of all its views
  int64_t max_joints = 1000;     // of the detections' skeleton
  // Times of our own format may stand or step back, for a reader that can take
  // it (Session).
  bool any_clock = false;
  // Frames of our own format that cannot be read are passed over and counted.
  bool skip_bad_frames = false;

  // Keys of the table `detections`, which the caller enters.
  void Describe(OptionVisitor& visitor);
};

// Frames that were passed over (DetectionReadOptions::skip_bad_frames).
struct BadFrames {
  int64_t count = 0;
  std::string last;  // what is wrong with the last one
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;

  virtual const DetectionHeader& header() const = 0;
  // The next frame, in ascending order; false at the end. Every view has an
  // entry, empty when nobody was seen. A frame that no view has is left out.
  // Times are those of the file, else frame / frame rate, else 0. Throws
  // InputError. `frame` is overwritten; handing in the same one again saves
  // allocations.
  virtual bool Next(DetectionFrame* frame) = 0;
  // Number of frames in all, for progress; -1 when only reading would tell.
  // May go through the file once more (our own format), so ask it once.
  virtual int64_t frame_count() const { return -1; }
  // How many were passed over so far, and why the last one was.
  virtual BadFrames bad_frames() const { return {}; }
};

// Opens detections and reads what holds for the whole recording. Throws
// InputError naming the file; OptionError when `options` are wrong by
// themselves.
std::unique_ptr<DetectionSource> OpenDetections(
    const std::string& path, const DetectionReadOptions& options = {});

// All frames at once.
DetectionSequence ReadDetections(const std::string& path,
                                 const DetectionReadOptions& options = {});

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SOURCE_H_
