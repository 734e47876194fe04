// MMPose's (RTMPose's) predictions, a file a view: [{"frame_id": 0,
// "instances": [{"keypoints": [[x, y], ...], "keypoint_scores": [s, ...]}]}],
// or the same list as "instance_info" of an object, whose "meta_info" states
// the joints (keypoint_id2name), bones (skeleton_links) and the skeleton's name
// (dataset_name). A folder a view with a file an image has the list of
// instances alone in each.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/atomic_folder.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMmposeKeypoints = "keypoints";

class MmposeReader {
 public:
  MmposeReader(const DetectionHeader& header, ZeroConfidence zero_confidence)
      : zero_confidence_(zero_confidence), collector_(header) {}

  // A file with all frames of a view.
  void ReadView(const std::string& path, size_t view_idx) {
    const JsonValue root = parser_.Parse(path);
    Located(path, [&] { SettleSkeleton(root); });
    size_t place = 0;
    Located(
        path, [&] { return "entry " + std::to_string(place); },
        [&] {
          for (const JsonValue entry : FramesOf(root)) {
            const JsonObject frame = AsObject(entry, "a frame");
            ReadInstances(AsArray(Required(frame, "instances"), "instances"),
                          AsFrame(Required(frame, "frame_id"), "frame_id"),
                          view_idx);
            ++place;
          }
        });
  }

  // A file with the instances of one image.
  void ReadImage(const std::string& path, size_t view_idx) {
    const JsonValue root = parser_.Parse(path);
    Located(path, [&] {
      ReadInstances(AsArray(root, kOutermost),
                    FrameOfName(fs::path(path).filename().string()), view_idx);
    });
  }

  std::unique_ptr<DetectionSource> Finish() {
    if (collector_.header().skeleton.joint_count() == 0) {
      collector_.set_skeleton(Coco17());  // nobody was seen
    }
    return collector_.Finish();
  }

 private:
  static JsonArray FramesOf(JsonValue root) {
    if (!root.is_object()) return AsArray(root, kOutermost);
    return AsArray(Required(AsObject(root, kOutermost), "instance_info"),
                   "instance_info");
  }

  // By `meta_info`, where there is one that names the joints.
  void SettleSkeleton(JsonValue root) {
    JsonObject meta;
    JsonObject names;
    if (root.at_key("meta_info").get(meta) != simdjson::SUCCESS ||
        meta["keypoint_id2name"].get(names) != simdjson::SUCCESS) {
      return;
    }
    const std::vector<std::string> labels = LabelsOf(names);
    std::vector<Bone> bones;
    JsonValue links;
    if (meta["skeleton_links"].get(links) == simdjson::SUCCESS) {
      bones = ReadBones(links, "meta_info.skeleton_links", 0,
                        static_cast<int>(labels.size()) - 1);
    }
    std::string_view name;
    if (meta["dataset_name"].get(name) != simdjson::SUCCESS) name = "";
    collector_.SettleSkeleton(labels, bones, std::string(name));
  }

  // {"0": "nose", "1": "left_eye", ...}, in any order.
  static std::vector<std::string> LabelsOf(const JsonObject& names) {
    constexpr const char* kKey = "meta_info.keypoint_id2name";
    std::vector<std::string> labels(names.size());
    for (const auto& [key, name] : names) {
      size_t number = 0;
      const char* end = key.data() + key.size();
      const auto [stop, error] = std::from_chars(key.data(), end, number);
      if (error != std::errc() || stop != end || number >= labels.size()) {
        throw InputError(std::string(kKey) + ": found '" +
                         Printable(std::string(key)) + "', expected 0 .. " +
                         std::to_string(labels.size() - 1));
      }
      labels[number] = AsText(name, kKey);
    }
    return labels;
  }

  void ReadInstances(const JsonArray& instances, int64_t frame,
                     size_t view_idx) {
    collector_.Touch(frame);
    for (const JsonValue value : instances) {
      const JsonObject instance = AsObject(value, "an instance");
      const JsonArray points =
          AsArray(Required(instance, kMmposeKeypoints), kMmposeKeypoints);
      const size_t count = points.size();
      if (collector_.header().skeleton.joint_count() == 0) {
        collector_.set_skeleton(
            *DetectorSkeletons(count, kMmposeKeypoints).front());
      }
      CheckCount(count);
      scores_.resize(count);
      AsNumbers(Required(instance, "keypoint_scores"), "keypoint_scores", count,
                scores_.data());
      Detection* detection = collector_.Add(frame, view_idx);
      detection->joints.reserve(count);
      for (const JsonValue point : points) {
        double px[2];
        AsNumbers(point, kMmposeKeypoints, 2, px);
        detection->joints.push_back(MakeKeypoint(
            px[0], px[1], scores_[detection->joints.size()], zero_confidence_));
      }
    }
  }

  void CheckCount(size_t found) const {
    const size_t expected = collector_.header().skeleton.joints().size();
    if (found == expected) return;
    throw InputError(std::string(kMmposeKeypoints) + ": found " +
                     std::to_string(found) + " joints, expected " +
                     std::to_string(expected));
  }

  const ZeroConfidence zero_confidence_;
  DetectionCollector collector_;
  JsonFileParser parser_;
  std::vector<double> scores_;
};

// Folders of the views; none when each view is a file.
std::vector<std::string> ViewFolders(const std::string& path) {
  std::vector<std::string> folders;
  if (!IsFolder(path)) return folders;
  for (const std::string& name : ListFolder(path)) {
    if (name.front() != '.' && IsFolder(path + "/" + name)) {
      folders.push_back(name);
    }
  }
  std::sort(folders.begin(), folders.end(), NaturalLess);
  return folders;
}

std::unique_ptr<DetectionSource> OpenMmposeFile(
    const std::string& path, const DetectionReadOptions& options) {
  DetectionHeader header;
  header.skeleton = options.skeleton.value_or(Skeleton());
  header.frame_rate_hz = options.frame_rate_hz;
  header.view_names = ViewFolders(path);
  const bool by_image = !header.view_names.empty();
  std::vector<std::pair<std::string, std::string>> files;
  if (!by_image) files = ListViewFiles(path);
  for (const auto& [view, file] : files) header.view_names.push_back(view);
  MmposeReader reader(header, options.zero_confidence);
  for (size_t v = 0; v < header.view_names.size(); ++v) {
    if (!by_image) {
      reader.ReadView(files[v].second, v);
      continue;
    }
    for (const auto& [name, file] :
         ListViewFiles(path + "/" + header.view_names[v])) {
      reader.ReadImage(file, v);
    }
  }
  return reader.Finish();
}

bool RecogniseMmpose(const DetectionHead& head) {
  return head.HasKey("instance_info") ||
         (head.kind == '[' &&
          (head.Contains("\"keypoint_scores\"") ||
           head.Contains("\"instances\"") || head.has_folders));
}

// ---- Writing ----

class MmposeView {
 public:
  explicit MmposeView(const std::string& path) : file_(path) {}

  void Write(int64_t frame, const std::vector<Detection>& detections) {
    out_.Text(is_first_ ? "[\n" : ",\n");
    is_first_ = false;
    out_.Add("{\"frame_id\": ", frame, ", \"instances\": [");
    out_.Join(detections, [this](const Detection& detection) {
      out_.Text("{\"keypoints\": [");
      WritePoints(detection, &out_);
      out_.Text("], \"keypoint_scores\": [");
      WriteConfidences(detection, &out_);
      out_.Text("]}");
    });
    out_.Text("]}");
    out_.FlushTo(&file_);
  }

  void Commit() {
    out_.Text(is_first_ ? "[]\n" : "\n]\n");
    out_.FlushTo(&file_);
    file_.Commit();
  }

 private:
  AtomicFile file_;
  JsonOutput out_;
  bool is_first_ = true;
};

void WriteMmpose(const std::string& path,
                 const DetectionWriteOptions& /*options*/,
                 DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  RefuseViewTruth(header, "MMPose's files");
  const auto files = MakeViewFiles<MmposeView>(header, ".json", folder);
  DetectionLossFinder finder(header);
  WriteViewFiles(files, source, &finder);
  folder.Commit();
  finder.Report(IsToldByJointCount(header.skeleton), lost_fields);
}

}  // namespace

DetectionFormat MmposeFormat() {
  DetectionFormat format;
  format.name = "mmpose";
  format.layout = "JSON, a file a view (MMPose, RTMPose)";
  format.extension = ".json";
  format.files = DetectionFormat::Files::kFileAView;
  format.recognise = RecogniseMmpose;
  format.open = OpenMmposeFile;
  format.write = WriteMmpose;
  return format;
}

}  // namespace kinegraph
