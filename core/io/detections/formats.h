// Shared by the readers of detections. For core/io/detections only.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/adapters/adapter.h"
#include "core/io/detections/source.h"
#include "core/io/text/bulk_json.h"

namespace kinegraph {

// When a format's `open` (format.h) is called, the DetectionReadOptions have
// been validated, and `skeleton` is set if it or `skeleton_name` was given.

// A keypoint from position and confidence. It is not found if one of the three
// numbers is not finite or, with kMissing, if the confidence is not positive or
// the position is exactly (0, 0). All readers use this function; kinegraph's
// format ("null") and COCO's (visibility 0 beside keypoint_scores) mark further
// joints as missing.
Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence);
// Keypoints from x, y and confidence of each joint in turn.
void SetKeypoints(const std::vector<double>& numbers,
                  ZeroConfidence zero_confidence,
                  std::vector<Keypoint>* joints);

bool IsAnyFound(const std::vector<Keypoint>& joints);

// A view's name and its file or folder.
using NamedPaths = std::vector<std::pair<std::string, std::string>>;

// The view files of a folder in natural order (without truth.json and hidden
// files), or the file `path` itself; a view has the name of its file without
// the extension. Throws InputError if there are none.
NamedPaths ListViewFiles(const std::string& path,
                         const std::string& extension = ".json");
// The subfolders of a folder that are not hidden, in natural order (2 before
// 10). Empty for a file.
NamedPaths ListViewFolders(const std::string& path);
// The same, but empty if the folder itself contains files with this extension
// and no subfolder does: the subfolders may then contain images.
NamedPaths ListDataFolders(const std::string& path,
                           const std::string& extension);

// A header from view names and options. `skeleton` is used if the options
// specify none.
DetectionHeader HeaderOf(std::vector<std::string> view_names,
                         const DetectionReadOptions& options,
                         const Skeleton& skeleton = Skeleton());
std::vector<std::string> NamesOf(const NamedPaths& paths);

// Layouts of detectors with this number of joints, the most common first.
// Throws InputError that names `key`, but no file, if there is none.
std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key);
// Whether a reader that knows only the number of joints assumes this layout.
bool IsDeterminedByJointCount(const Skeleton& skeleton);

// Collects detections from files with frames in any order, and then returns
// them frame by frame.
class DetectionCollector : public DetectionSource {
 public:
  explicit DetectionCollector(DetectionHeader header)
      : header_(std::move(header)) {}

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override { return frame_count_; }
  bool Next(DetectionFrame* frame) override;

  bool has_skeleton() const { return header_.skeleton.joint_count() > 0; }
  // For files in which the first person determines the skeleton.
  void set_skeleton(const Skeleton& skeleton) { header_.skeleton = skeleton; }
  // For files that name their joints; called once per file. The first file
  // determines the skeleton (SkeletonOfLabels) unless the options do. Throws
  // InputError, which does not name the file, if a later file has other labels,
  // or if their number differs from that of the options' skeleton.
  void SettleSkeleton(const std::vector<std::string>& labels,
                      const std::vector<Bone>& bones = {},
                      const std::string& name = "");
  // Adds a detection without joints and sets its index_in_file. If the caller
  // adds no joints to it, Next() leaves it out, but it counts for the indices
  // of later detections.
  Detection* Add(int64_t frame, size_t view_idx);
  // Adds a detection with these joints, unless none was found.
  void AddFound(int64_t frame, size_t view_idx, std::vector<Keypoint> joints);
  // Returns the frame; creates it, without detections, if it does not exist.
  DetectionFrame* Touch(int64_t frame);
  void DropAfter(int64_t frame) {
    frames_.erase(frames_.upper_bound(frame), frames_.end());
  }
  // Moves the collected frames into the source that returns them.
  std::unique_ptr<DetectionSource> Finish();

 private:
  DetectionHeader header_;
  int64_t frame_count_ = 0;
  std::vector<std::string> labels_;  // of the first file that states them
  std::map<int64_t, DetectionFrame> frames_;
};

// For views whose files have their own frame rate or first frame number
// (view_frame_rate_hz and view_frame_offset of the options): each frame of such
// a view is assigned to the recording's frame nearest in time and keeps its own
// capture time. If several frames of a view are assigned to the same frame, the
// closest is kept. `open` opens the files anew, with all views at the
// recording's rate; it is called once for the other views, and once for each
// group of views with the same rate and offset. Reads the whole recording.
// Throws InputError for a view that does not exist and for a frame whose time
// is not its number divided by the recording's rate, and OptionError if that
// rate is unknown.
std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options);

// Adds the content of a view's file to the collector.
using ReadView = void (*)(const std::string& path, size_t view_idx,
                          const DetectionReadOptions& options,
                          DetectionCollector* collector);
// Reads the files of the views one after the other. If they contain no
// detections and nothing else specifies the skeleton, it is COCO's.
std::unique_ptr<DetectionSource> ReadViews(const NamedPaths& files,
                                           const DetectionReadOptions& options,
                                           ReadView read);

// Reads kinegraph's JSON Lines from a pipe, which the destructor of the source
// closes. Messages call the pipe `name`; reading throws InputError if nothing
// arrives for `silence_ms`.
std::unique_ptr<DetectionSource> OpenLines(const std::string& name,
                                           const DetectionReadOptions& options,
                                           int pipe, int silence_ms);

// Reads what an adapter prints for a path. OpenEverybodyByAdapter also returns
// people without any joint, so that indices match the file.
std::unique_ptr<DetectionSource> OpenByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);
std::unique_ptr<DetectionSource> OpenEverybodyByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);

// Calls `read` with each object of the array that `list` returns. Errors name
// the file and, by the word `entry`, the position in the array: "entry 3".
// Errors about an element that is not an object call it `key`: "a detection".
template <typename List, typename Read>
void ForEachObject(const std::string& path, const std::string& entry,
                   std::string_view key, const List& list, const Read& read) {
  size_t index = 0;
  Located(
      path, [&] { return entry + " " + std::to_string(index); },
      [&] {
        for (const JsonValue value : list()) {
          read(AsObject(value, key));
          ++index;
        }
      });
}

// Adds one joint for each "[x, y]" of `points`, with the confidence at the same
// position in `scores`, which has as many entries. `detection` has no joints
// yet.
void AddPoints(const JsonArray& points, std::string_view key,
               const std::vector<double>& scores,
               ZeroConfidence zero_confidence, Detection* detection);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
