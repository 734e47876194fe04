// What the readers of detections share. For core/io/detections alone.
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

// The options that a format's `open` is given are checked; `skeleton` is set
// when either the value or a name was given.

// What a file stores as x, y, confidence, in the file's own pixels. NaN, also
// as confidence, is no measurement. Every reader asks here which points are
// missing.
Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence);
// Of three numbers a joint, one joint after the other.
void SetKeypoints(const std::vector<double>& numbers,
                  ZeroConfidence zero_confidence,
                  std::vector<Keypoint>* joints);

// A view's name and the file or folder that has it.
using NamedPaths = std::vector<std::pair<std::string, std::string>>;

// The view files of a folder in natural order (without truth.json), or the one
// file that `path` is; a view is named as its file, without the extension.
// Throws InputError when there is none.
NamedPaths ListViewFiles(const std::string& path,
                         const std::string& extension = ".json");
// The folders in a folder, hidden ones left out, 2 before 10; none of a file.
NamedPaths ListViewFolders(const std::string& path);

// What the options and the names of views say of a recording. `skeleton` holds
// where the options name none.
DetectionHeader HeaderOf(std::vector<std::string> view_names,
                         const DetectionReadOptions& options,
                         const Skeleton& skeleton = Skeleton());
std::vector<std::string> NamesOf(const NamedPaths& paths);

// Layouts of detectors with so many joints, the commonest first. Throws
// InputError without a file, naming `key`, when there is none.
std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key);
// Whether a reader that counts joints takes them for this layout.
bool IsToldByJointCount(const Skeleton& skeleton);

// Collects detections of formats whose files hold a whole recording, in any
// order of frames, and hands them out frame by frame.
class DetectionCollector : public DetectionSource {
 public:
  explicit DetectionCollector(DetectionHeader header)
      : header_(std::move(header)) {}

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override { return frame_count_; }
  bool Next(DetectionFrame* frame) override;

  bool has_skeleton() const { return header_.skeleton.joint_count() > 0; }
  // For files that tell it by their first person.
  void set_skeleton(const Skeleton& skeleton) { header_.skeleton = skeleton; }
  // For files that state it, one after the other (SkeletonOfLabels). The first
  // decides, where the options do not. Throws InputError without a file when
  // the next one has other labels, or not as many as the options' skeleton.
  void SettleSkeleton(const std::vector<std::string>& labels,
                      const std::vector<Bone>& bones = {},
                      const std::string& name = "");
  // The place of a new detection, its index_in_file set.
  Detection* Add(int64_t frame, size_t view_idx);
  // The same of joints of which any was found.
  void AddFound(int64_t frame, size_t view_idx, std::vector<Keypoint> joints);
  // Makes sure that the frame is there even if nobody was seen.
  DetectionFrame* Touch(int64_t frame);
  void DropAfter(int64_t frame) {
    frames_.erase(frames_.upper_bound(frame), frames_.end());
  }
  // Itself as a source, when everything is there.
  std::unique_ptr<DetectionSource> Finish();

 private:
  DetectionHeader header_;
  int64_t frame_count_ = 0;
  std::vector<std::string> labels_;  // of the first file that states them
  std::map<int64_t, DetectionFrame> frames_;
};

// Views whose files count frames at rates of their own, or from numbers of
// their own: each is read at its own pace, and each of its frames joins the
// frame of the recording that is nearest in time, with its own time of capture.
// `open` opens the files anew, all views at the recording's rate; the options'
// view_frame_rate_hz and view_frame_offset count. Of several frames of a view
// that lie nearest to the same frame of the recording, the nearest joins. The
// recording is read whole. Throws InputError for a view that there is not,
// where the recording's own rate is not known, and for files that tell the
// times of their frames.
std::unique_ptr<DetectionSource> OpenRated(
    const std::function<std::unique_ptr<DetectionSource>()>& open,
    const DetectionReadOptions& options);

// Adds what the file of a view has.
using ReadView = void (*)(const std::string& path, size_t view_idx,
                          const DetectionReadOptions& options,
                          DetectionCollector* collector);
// Reads a file a view, one after the other. Where neither they nor the options
// tell the skeleton, nobody was seen, and it is COCO's.
std::unique_ptr<DetectionSource> ReadViews(const NamedPaths& files,
                                           const DetectionReadOptions& options,
                                           ReadView read);

// Our own lines that come through a pipe, which is closed (OwnLines).
std::unique_ptr<DetectionSource> OpenLines(const std::string& name,
                                           const DetectionReadOptions& options,
                                           int pipe, int silence_ms);

// What an adapter prints of a path. Of people without a joint the second keeps
// their places.
std::unique_ptr<DetectionSource> OpenByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);
std::unique_ptr<DetectionSource> OpenEverybodyByAdapter(
    const Adapter& adapter, const std::string& path,
    const DetectionReadOptions& options);

// Calls `read` with each object of the array that `list` gives. What any of
// this throws names the file and the place in the array, "entry 3".
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

// Reads a table: `header` is given its first row, `row` each of the others,
// which are as wide. Throws InputError naming file and line.
void ReadCsv(const std::string& path,
             const std::function<void(const std::vector<std::string>&)>& header,
             const std::function<void(const std::vector<std::string>&)>& row);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMATS_H_
