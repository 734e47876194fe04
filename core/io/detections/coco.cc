// JSON of key points, a file a view: COCO's results and MMPose's predictions.
// Frames need not ascend, so a file is read whole.
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

constexpr const char* kKeypoints = "keypoints";

// Where no file states the joints, the first person's number of them does.
void SettleSkeletonByCount(size_t joint_count, DetectionCollector* collector) {
  if (collector->has_skeleton()) return;
  collector->set_skeleton(*DetectorSkeletons(joint_count, kKeypoints).front());
}

// ---- COCO ----
// [{"image_id": frame, "keypoints": [x, y, c, ...], ...}, ...]. AlphaPose
// writes the image's file name instead of a number: then its last integer is
// the frame.

int64_t FrameOf(JsonValue image_id) {
  if (!image_id.is_string()) return AsFrame(image_id, "image_id");
  return FrameOfName(AsText(image_id, "image_id"));
}

void ReadCocoFile(const std::string& path, size_t view_idx,
                  const DetectionReadOptions& options,
                  DetectionCollector* collector) {
  JsonFileParser parser;
  const JsonValue root = parser.Parse(path);
  std::vector<double> numbers;  // of one person
  const JsonArray entries =
      Located(path, [&] { return AsArray(root, kOutermost); });
  ForEachObject(
      path, "entry", "a detection", [&] { return entries; },
      [&](const JsonObject& entry) {
        const int64_t frame = FrameOf(Required(entry, "image_id"));
        const JsonArray keypoints =
            AsArray(Required(entry, kKeypoints), kKeypoints);
        SettleSkeletonByCount((keypoints.size() + 2) / 3, collector);
        numbers.resize(3 * collector->header().skeleton.joints().size());
        AsNumbers(keypoints, kKeypoints, numbers.size(), numbers.data());
        SetKeypoints(numbers, options.zero_confidence,
                     &collector->Add(frame, view_idx)->joints);
      });
}

// The score of a person is the mean confidence of the joints found, the box the
// one around them.
void WriteCocoView(int64_t frame, const std::vector<Detection>& detections,
                   ViewFile* file) {
  for (const Detection& detection : detections) {
    JsonOutput& out = file->Entry();
    out.Add("{\"image_id\": ", frame, ", \"category_id\": 1, \"keypoints\": [");
    WriteKeypoints(detection, &out);
    const DetectionSummary summary = Summarise(detection);
    out.Add("], \"score\": ", summary.score, ", \"bbox\": [");
    WriteBox(summary, &out);
    out.Text("]}");
  }
}

}  // namespace

// AlphaPose's files have more keys and the same ones.
bool RecogniseCoco(const DetectionHead& head) {
  return head.kind == '[' && !head.has_folders &&
         !head.Contains("\"keypoint_scores\"") &&
         !head.Contains("\"instances\"");
}

std::unique_ptr<DetectionSource> OpenCoco(const std::string& path,
                                          const DetectionReadOptions& options) {
  return ReadViews(ListViewFiles(path), options, ReadCocoFile);
}

void WriteCoco(const std::string& path, const DetectionWriteOptions&,
               DetectionSource* source, LostFields* lost_fields) {
  RefuseViewTruth(source->header(), "COCO results");
  const int64_t empty_frames = WriteViewFiles(
      path, ".json", "", source, IsToldByJointCount(source->header().skeleton),
      lost_fields, WriteCocoView);
  NoteEmptyFrames(empty_frames, lost_fields);
}

// ---- MMPose (RTMPose) ----
// [{"frame_id": 0, "instances": [{"keypoints": [[x, y], ...],
// "keypoint_scores": [s, ...]}]}], or the same list as "instance_info" of an
// object, whose "meta_info" states the joints (keypoint_id2name), bones
// (skeleton_links) and the skeleton's name (dataset_name). A folder a view with
// a file an image has the list of instances alone in each.

namespace {

// {"0": "nose", "1": "left_eye", ...}, in any order.
std::vector<std::string> LabelsOf(const JsonObject& names) {
  constexpr const char* kKey = "meta_info.keypoint_id2name";
  std::vector<std::string> labels(names.size());
  for (const auto& [key, name] : names) {
    const auto number = ParseNumber<size_t>(key);
    if (!number.has_value() || *number >= labels.size()) {
      throw InputError(std::string(kKey) + ": found '" +
                       Printable(std::string(key)) + "', expected 0 .. " +
                       std::to_string(labels.size() - 1));
    }
    labels[*number] = AsText(name, kKey);
  }
  return labels;
}

// By `meta_info`, where there is one that names the joints.
void SettleMmposeSkeleton(JsonValue root, DetectionCollector* collector) {
  JsonObject file;
  JsonObject meta;
  JsonObject names;
  if (root.get(file) != simdjson::SUCCESS || !Get(file, "meta_info", &meta) ||
      !Get(meta, "keypoint_id2name", &names)) {
    return;
  }
  const std::vector<std::string> labels = LabelsOf(names);
  std::vector<Bone> bones;
  JsonValue links;
  if (Get(meta, "skeleton_links", &links)) {
    bones = ReadBones(links, "meta_info.skeleton_links", 0,
                      static_cast<int>(labels.size()) - 1);
  }
  std::string_view name;
  Get(meta, "dataset_name", &name);
  collector->SettleSkeleton(labels, bones, std::string(name));
}

void AddInstances(const JsonArray& instances, int64_t frame, size_t view_idx,
                  const DetectionReadOptions& options,
                  DetectionCollector* collector) {
  std::vector<double> scores;
  collector->Touch(frame);
  for (const JsonValue value : instances) {
    const JsonObject instance = AsObject(value, "an instance");
    const JsonArray points =
        AsArray(Required(instance, kKeypoints), kKeypoints);
    const size_t count = points.size();
    SettleSkeletonByCount(count, collector);
    const size_t expected = collector->header().skeleton.joints().size();
    CheckCount(kKeypoints, count, expected, " joints");
    scores.resize(count);
    AsNumbers(Required(instance, "keypoint_scores"), "keypoint_scores", count,
              scores.data());
    AddPoints(points, kKeypoints, scores, options.zero_confidence,
              collector->Add(frame, view_idx));
  }
}

JsonArray FramesOf(JsonValue root) {
  if (!root.is_object()) return AsArray(root, kOutermost);
  return AsArray(Required(AsObject(root, kOutermost), "instance_info"),
                 "instance_info");
}

// A file with all frames of a view, or a folder with the instances of an image
// a file.
void ReadMmposeView(const std::string& path, size_t view_idx,
                    const DetectionReadOptions& options,
                    DetectionCollector* collector) {
  JsonFileParser parser;
  if (IsFolder(path)) {
    for (const auto& [name, image] : ListViewFiles(path)) {
      const JsonValue root = parser.Parse(image);
      const std::string file = std::filesystem::path(image).filename().string();
      Located(image, [&] {
        AddInstances(AsArray(root, kOutermost), FrameOfName(file), view_idx,
                     options, collector);
      });
    }
    return;
  }
  const JsonValue root = parser.Parse(path);
  Located(path, [&] { SettleMmposeSkeleton(root, collector); });
  const JsonArray frames = Located(path, [&] { return FramesOf(root); });
  ForEachObject(
      path, "entry", "a frame", [&] { return frames; },
      [&](const JsonObject& frame) {
        AddInstances(AsArray(Required(frame, "instances"), "instances"),
                     AsFrame(Required(frame, "frame_id"), "frame_id"), view_idx,
                     options, collector);
      });
}

void WriteMmposeView(int64_t frame, const std::vector<Detection>& detections,
                     ViewFile* file) {
  JsonOutput& out = file->Entry();
  out.Add("{\"frame_id\": ", frame, ", \"instances\": [");
  out.Join(detections, [&out](const Detection& detection) {
    out.Text("{\"keypoints\": [");
    WritePoints(detection, &out);
    out.Text("], \"keypoint_scores\": [");
    WriteConfidences(detection, &out);
    out.Text("]}");
  });
  out.Text("]}");
}

}  // namespace

bool RecogniseMmpose(const DetectionHead& head) {
  return head.HasKey("instance_info") ||
         (head.kind == '[' &&
          (head.Contains("\"keypoint_scores\"") ||
           head.Contains("\"instances\"") || head.has_folders));
}

std::unique_ptr<DetectionSource> OpenMmpose(
    const std::string& path, const DetectionReadOptions& options) {
  NamedPaths views = ListViewFolders(path);
  if (views.empty()) views = ListViewFiles(path);
  return ReadViews(views, options, ReadMmposeView);
}

void WriteMmpose(const std::string& path, const DetectionWriteOptions&,
                 DetectionSource* source, LostFields* lost_fields) {
  RefuseViewTruth(source->header(), "MMPose's files");
  WriteViewFiles(path, ".json", "", source,
                 IsToldByJointCount(source->header().skeleton), lost_fields,
                 WriteMmposeView);
}

}  // namespace kinegraph
