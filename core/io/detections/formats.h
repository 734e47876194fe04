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

// The options passed to a format's `open` are checked; `skeleton` is set if
// either the value or a name was given.

// A keypoint from x, y, confidence in the file's pixels. NaN, also as
// confidence, means that it was not found. All readers use this function to
// decide which points are missing.
Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence);
// From three numbers per joint, in order.
void SetKeypoints(const std::vector<double>& numbers,
                  ZeroConfidence zero_confidence,
                  std::vector<Keypoint>* joints);

// A view's name and its file or folder.
using NamedPaths = std::vector<std::pair<std::string, std::string>>;

// The view files of a folder in natural order (without truth.json), or the file
// `path` itself; a view has the name of its file without the extension. Throws
// InputError if there is none.
NamedPaths ListViewFiles(const std::string& path,
                         const std::string& extension = ".json");
// The folders in a folder, without hidden ones, in natural order (2 before 10);
// none for a file.
NamedPaths ListViewFolders(const std::string& path);

// The header by options and view names. `skeleton` is used if the options
// specify none.
DetectionHeader HeaderOf(std::vector<std::string> view_names,
                         const DetectionReadOptions& options,
                         const Skeleton& skeleton = Skeleton());
std::vector<std::string> NamesOf(const NamedPaths& paths);

// Layouts of detectors with this number of joints, the most common first.
// Throws InputError without a file, naming `key`, if there is none.
std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key);
// Whether a reader that counts joints assumes this layout.
bool IsDeterminedByJointCount(const Skeleton& skeleton);

// Collects detections of formats whose files contain a whole recording, with
// frames in any order, and returns them frame by frame.
class DetectionCollector : public DetectionSource {
 public:
  explicit DetectionCollector(DetectionHeader header)
      : header_(std::move(header)) {}

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override { return frame_count_; }
  bool Next(DetectionFrame* frame) override;

  bool has_skeleton() const { return header_.skeleton.joint_count() > 0; }
  // For files whose first person determines it.
  void set_skeleton(const Skeleton& skeleton) { header_.skeleton = skeleton; }
  // For files that state it, called once per file (SkeletonOfLabels). The first
  // file decides unless the options do. Throws InputError without a file if a
  // later one has other labels, or another number than the options' skeleton.
  void SettleSkeleton(const std::vector<std::string>& labels,
                      const std::vector<Bone>& bones = {},
                      const std::string& name = "");
  // A new detection with its index_in_file set.
  Detection* Add(int64_t frame, size_t view_idx);
  // The same from joints; adds nothing if none was found.
  void AddFound(int64_t frame, size_t view_idx, std::vector<Keypoint> joints);
  // Creates the frame if it does not exist, even without detections.
  DetectionFrame* Touch(int64_t frame);
  void DropAfter(int64_t frame) {
    frames_.erase(frames_.upper_bound(frame), frames_.end());
  }
  // Returns itself as a source once everything is collected.
  std::unique_ptr<DetectionSource> Finish();

 private:
  DetectionHeader header_;
  int64_t frame_count_ = 0;
  std::vector<std::string> labels_;  // of the first file that states them
  std::map<int64_t, DetectionFrame> frames_;
};

// For views whose files have their own frame rate or first frame number: each
// is read at its own rate, and each of its frames joins the recording's frame
// that is nearest in time, with its own capture time. If several frames of a
// view are nearest to the same one, the closest joins. `open` opens the files
// anew, with all views at the recording's rate; uses the options'
// view_frame_rate_hz and view_frame_offset. Reads the whole recording. Throws
// InputError for a view that does not exist, for an unknown rate of the
// recording and for files that specify the times of their frames.
std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options);

// Adds the content of a view's file.
using ReadView = void (*)(const std::string& path, size_t view_idx,
                          const DetectionReadOptions& options,
                          DetectionCollector* collector);
// Reads the files of the views one after the other. If neither they nor the
// options specify a skeleton, there are no detections, and it is COCO's.
std::unique_ptr<DetectionSource> ReadViews(const NamedPaths& files,
                                           const DetectionReadOptions& options,
                                           ReadView read);

// Our own lines from a pipe, which is closed (OwnLines).
std::unique_ptr<DetectionSource> OpenLines(const std::string& name,
                                           const DetectionReadOptions& options,
                                           int pipe, int silence_ms);

// Reads what an adapter prints for a path. The second keeps people without any
// joint at their indices.
std::unique_ptr<DetectionSource> OpenByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);
std::unique_ptr<DetectionSource> OpenEverybodyByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);

// Calls `read` with each object of the array that `list` returns. Exceptions
// name the file and the position in the array, "entry 3".
template <typename List, typename Read>
void ForEachObject(const std::string& path, const std::string& entry,
                   std::string_view key, const List& list, const Read& read) {
  size_t place = 0;
  Located(
      path, [&] { return entry + " " + std::to_string(place); },
      [&] {
        for (const JsonValue value : list()) {
          read(AsObject(value, key));
          ++place;
        }
      });
}

// Adds "[x, y]" of each joint, as many as there are scores.
void AddPoints(const JsonArray& points, std::string_view key,
               const std::vector<double>& scores,
               ZeroConfidence zero_confidence, Detection* detection);

// Reads a table: passes its first row to `header` and each further row, of the
// same width, to `row`. Throws InputError naming file and line.
void ReadCsv(const std::string& path,
             const std::function<void(const std::vector<std::string>&)>& header,
             const std::function<void(const std::vector<std::string>&)>& row);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
