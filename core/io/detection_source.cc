#include "core/io/detection_source.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/bulk_json.h"
#include "core/io/detection_formats.h"
#include "core/io/folder_entry.h"
#include "core/io/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// In the order of DetectionFormat.
const std::vector<std::string>& FormatNames() {
  static const std::vector<std::string> kNames = {
      "auto", "kinegraph", "openpose", "coco", "longcw", "smap"};
  return kNames;
}

std::string KnownSkeletons() {
  std::string names;
  for (const std::string& name : SkeletonNames()) {
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

DetectionReadOptions Checked(DetectionReadOptions options) {
  if (!(options.frame_rate_hz >= 0.0 && options.frame_rate_hz <= 1e6)) {
    throw OptionError("input.frame_rate", "expected above 0 .. 1e6 Hz");
  }
  if (options.first_frame < 0 || options.first_frame > kMaxFrame) {
    throw OptionError("detections.first_frame", "expected a frame number >= 0");
  }
  if (options.skeleton || options.skeleton_name.empty()) return options;
  const Skeleton* skeleton = FindSkeleton(options.skeleton_name);
  if (skeleton == nullptr) {
    throw OptionError("detections.skeleton",
                      "found '" + Printable(options.skeleton_name) +
                          "', expected one of " + KnownSkeletons());
  }
  options.skeleton = *skeleton;
  return options;
}

DetectionFormat RecogniseFile(const std::string& path) {
  if (IsPipe(path)) return DetectionFormat::kKinegraph;
  const JsonHead head = PeekJson(path);
  if (head.kind == '[') return DetectionFormat::kCoco;
  if (head.Has("kinegraph_detections")) return DetectionFormat::kKinegraph;
  if (head.Has("3d_pairs")) return DetectionFormat::kSmap;
  if (head.Has("frames") && head.Has("image_wh")) {
    return DetectionFormat::kLongcw;
  }
  if (head.Has("people")) {
    throw InputError(path, "",
                     "is one OpenPose frame, expected the folder that holds "
                     "one folder a view");
  }
  if (head.Has("kinegraph")) {
    throw InputError(path, "", "is a file of tracks, expected detections");
  }
  throw InputError(path, "",
                   "is no known detection format, expected ours, OpenPose, "
                   "COCO results, longcw or SMAP");
}

DetectionFormat RecogniseFolder(const std::string& path) {
  std::vector<std::string> files;
  bool has_folder = false;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const std::string name = entry.path().filename().string();
    if (name.front() == '.') continue;
    if (entry.is_directory()) has_folder = true;
    if (entry.path().extension() == ".json" && IsFileOrFolder(entry)) {
      files.push_back(name);
    }
  }
  if (has_folder) return DetectionFormat::kOpenPose;
  if (files.empty()) {
    throw InputError(path, "",
                     "is a folder without detections, expected one folder or "
                     "one .json file a view");
  }
  const std::string first =
      (fs::path(path) /
       *std::min_element(files.begin(), files.end(), NaturalLess))
          .string();
  if (PeekJson(first).Has("people")) return DetectionFormat::kOpenPose;
  const DetectionFormat format = RecogniseFile(first);
  if (format != DetectionFormat::kCoco && format != DetectionFormat::kSmap) {
    throw InputError(first, "",
                     "names a whole take: give this file, not its folder");
  }
  return format;
}

DetectionFormat Recognise(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? RecogniseFolder(path)
                                       : RecogniseFile(path);
}

std::unique_ptr<DetectionSource> Open(const std::string& path,
                                      const DetectionReadOptions& options) {
  switch (options.format == DetectionFormat::kAuto ? Recognise(path)
                                                   : options.format) {
    case DetectionFormat::kKinegraph:
      return OpenKinegraphDetections(path, options);
    case DetectionFormat::kOpenPose:
      return OpenOpenPose(path, options);
    case DetectionFormat::kCoco:
      return OpenCocoResults(path, options);
    case DetectionFormat::kLongcw:
      return OpenLongcwDetections(path, options);
    default:
      return OpenSmap(path, options);
  }
}

// Hands out frames that are in memory.
class CollectedSource : public DetectionSource {
 public:
  CollectedSource(DetectionHeader header,
                  std::map<int64_t, DetectionFrame> frames)
      : header_(std::move(header)), frames_(std::move(frames)) {
    frame_count_ = static_cast<int64_t>(frames_.size());
  }

  const DetectionHeader& header() const override { return header_; }
  bool Next(DetectionFrame* frame) override {
    if (frames_.empty()) return false;
    *frame = std::move(frames_.begin()->second);
    frames_.erase(frames_.begin());
    return true;
  }
  int64_t frame_count() const override { return frame_count_; }

 private:
  DetectionHeader header_;
  std::map<int64_t, DetectionFrame> frames_;
  int64_t frame_count_ = 0;
};

}  // namespace

void DetectionReadOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("format", &format, FormatNames(),
                 "format of the detections; auto recognises it by content");
  visitor.Text("skeleton", &skeleton_name,
               "skeleton of the detections where the file does not tell it");
  visitor.Choice("zero_confidence", &zero_confidence, {"missing", "position"},
                 "what a joint with confidence 0 is");
  visitor.Integer("first_frame", &first_frame,
                  Between(0.0, static_cast<double>(kMaxFrame)), "frames",
                  "frame number of a file that names none");
}

std::unique_ptr<DetectionSource> OpenDetections(
    const std::string& path, const DetectionReadOptions& options) {
  try {
    return Open(path, Checked(options));
  } catch (const fs::filesystem_error& error) {
    throw InputError(path, "", "cannot be read: " + error.code().message());
  }
}

DetectionSequence ReadDetections(const std::string& path,
                                 const DetectionReadOptions& options) {
  const std::unique_ptr<DetectionSource> source = OpenDetections(path, options);
  DetectionSequence sequence;
  DetectionFrame frame;
  while (source->Next(&frame)) sequence.frames.push_back(std::move(frame));
  sequence.header = source->header();
  return sequence;
}

Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence) {
  Keypoint joint;
  if (!std::isfinite(x_px) || !std::isfinite(y_px) ||
      !std::isfinite(confidence)) {
    return joint;
  }
  joint.px = {x_px, y_px};
  joint.confidence = confidence;
  joint.found =
      confidence > 0.0 || zero_confidence == ZeroConfidence::kPosition;
  return joint;
}

std::vector<std::pair<std::string, std::string>> ListViewFiles(
    const std::string& path) {
  std::vector<std::pair<std::string, std::string>> files;
  if (!fs::is_directory(path)) {
    files.emplace_back(fs::path(path).stem().string(), path);
    return files;
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const fs::path& file = entry.path();
    if (file.extension() != ".json" || file.filename() == "truth.json" ||
        !IsFileOrFolder(entry)) {
      continue;
    }
    files.emplace_back(file.stem().string(), file.string());
  }
  if (files.empty()) {
    throw InputError(path, "", "holds no .json files, expected one a view");
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return NaturalLess(a.first, b.first);
  });
  return files;
}

DetectionFrame* DetectionCollector::Touch(int64_t frame_number) {
  DetectionFrame& frame = frames_[frame_number];
  if (frame.views.empty()) {
    frame.frame = frame_number;
    frame.time = TimeOfFrame(frame_number, header_.frame_rate_hz);
    frame.views.resize(header_.view_names.size());
    for (ViewDetections& view : frame.views) view.capture_time = frame.time;
  }
  return &frame;
}

Detection* DetectionCollector::Add(int64_t frame, size_t view_idx) {
  std::vector<Detection>& detections = Touch(frame)->views[view_idx].detections;
  detections.emplace_back();
  detections.back().index_in_file = static_cast<int>(detections.size()) - 1;
  return &detections.back();
}

std::unique_ptr<DetectionSource> DetectionCollector::Finish() {
  return std::make_unique<CollectedSource>(std::move(header_),
                                           std::move(frames_));
}

}  // namespace kinegraph
