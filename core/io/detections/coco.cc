// JSON of keypoints: COCO results and MMPose predictions, one file per view
// (MMPose also one folder per view), and COCO annotations, one file for all
// views. Frames may be in any order, so a file is read as a whole.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
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
#include "core/io/text/joint_names.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
namespace {

constexpr const char* kKeypoints = "keypoints";

// If neither the options nor a file specify the skeleton, the first person's
// number of joints determines it.
void SettleSkeletonByCount(size_t joint_count, DetectionCollector* collector) {
  if (collector->has_skeleton()) return;
  collector->set_skeleton(*DetectorSkeletons(joint_count, kKeypoints).front());
}

// ---- COCO ----
// [{"image_id": frame, "keypoints": [x, y, c, ...], ...}, ...]. AlphaPose
// writes the image's file name as image_id; its last integer is the frame.

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
        if (keypoints.size() == 0) {
          collector->Add(frame, view_idx);
          return;
        }
        SettleSkeletonByCount((keypoints.size() + 2) / 3, collector);
        numbers.resize(3 * collector->header().skeleton.joints().size());
        AsNumbers(keypoints, kKeypoints, numbers.size(), numbers.data());
        SetKeypoints(numbers, options.zero_confidence,
                     &collector->Add(frame, view_idx)->joints);
      });
}

// "score" is the mean confidence of the found joints, "bbox" their bounding
// box.
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

// Also recognises AlphaPose's files, which have additional keys.
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
  const int64_t empty_frames =
      WriteViewFiles(path, ".json", "", source,
                     IsDeterminedByJointCount(source->header().skeleton),
                     lost_fields, WriteCocoView);
  NoteEmptyFrames(empty_frames, lost_fields);
}

// ---- MMPose (RTMPose) ----
// [{"frame_id": 0, "instances": [{"keypoints": [[x, y], ...],
// "keypoint_scores": [s, ...]}]}], or the same list as "instance_info" of an
// object, whose "meta_info" specifies the joints (keypoint_id2name), bones
// (skeleton_links) and the skeleton's name (dataset_name). With one folder per
// view and one file per image, each file has a list of instances instead.

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

// Takes the skeleton from `meta_info` if it names the joints.
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
    if (count == 0) {
      collector->Add(frame, view_idx);
      continue;
    }
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

// The list of frames; in a file of a single image, the list of its instances.
JsonArray FramesOf(JsonValue root) {
  if (!root.is_object()) return AsArray(root, kOutermost);
  return AsArray(Required(AsObject(root, kOutermost), "instance_info"),
                 "instance_info");
}

// Reads a file with all frames of a view, or a folder with one file of
// instances per image.
void ReadMmposeView(const std::string& path, size_t view_idx,
                    const DetectionReadOptions& options,
                    DetectionCollector* collector) {
  JsonFileParser parser;
  if (IsFolder(path)) {
    for (const auto& [name, image] : ListViewFiles(path)) {
      const JsonValue root = parser.Parse(image);
      const std::string file = std::filesystem::path(image).filename().string();
      Located(image, [&] {
        SettleMmposeSkeleton(root, collector);
        AddInstances(FramesOf(root), FrameOfName(file), view_idx, options,
                     collector);
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
  NamedPaths views = ListDataFolders(path, ".json");
  if (views.empty()) views = ListViewFiles(path);
  return ReadViews(views, options, ReadMmposeView);
}

void WriteMmpose(const std::string& path, const DetectionWriteOptions&,
                 DetectionSource* source, LostFields* lost_fields) {
  RefuseViewTruth(source->header(), "MMPose's files");
  WriteViewFiles(path, ".json", "", source,
                 IsDeterminedByJointCount(source->header().skeleton),
                 lost_fields, WriteMmposeView);
}

// ---- COCO, one file for several cameras ----
// `images` are the views' frames, with the camera in "camera" (or "view",
// "camera_id", "cam_id", or the folder of file_name) and the frame in
// "frame_id" (or "frame", or the last integer of file_name); `annotations` are
// people, with image_id and keypoints = x, y, v per joint; the first of
// `categories` with keypoints names joints and bones (1-based). v is COCO's
// flag, 0 for a missing joint, or a confidence up to 1; "keypoint_scores", if
// present, are the confidences.

namespace {

std::optional<std::string> TextOf(const JsonObject& object,
                                  std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    JsonValue value;
    if (!Get(object, key, &value)) continue;
    if (value.is_string()) return std::string(AsText(value, key));
    return std::to_string(AsId(value, key));
  }
  return std::nullopt;
}

// "cam1/000012.jpg" -> "cam1"; empty without a folder.
std::string FolderOfImage(const std::string& file_name) {
  const size_t slash = file_name.find_last_of("/\\");
  if (slash == std::string::npos) return "";
  const std::string folder = file_name.substr(0, slash);
  return folder.substr(folder.find_last_of("/\\") + 1);  // npos + 1 is 0
}

struct Image {
  std::string view;
  int64_t frame = 0;
};

Image ReadImage(const JsonObject& object) {
  const std::string file_name = TextOf(object, {"file_name"}).value_or("");
  Image image;
  image.view = TextOf(object, {"camera", "view", "camera_id", "cam_id"})
                   .value_or(FolderOfImage(file_name));
  if (image.view.empty()) {
    throw InputError(
        "expected the key 'camera', 'view', 'camera_id' or 'cam_id', or a "
        "folder in file_name");
  }
  JsonValue frame;
  for (const char* key : {"frame_id", "frame"}) {
    if (!Get(object, key, &frame)) continue;
    image.frame = AsFrame(frame, key);
    return image;
  }
  image.frame =  // npos + 1 is 0
      FrameOfName(file_name.substr(file_name.find_last_of("/\\") + 1));
  return image;
}

// The skeleton of the first category with keypoints.
std::optional<Skeleton> CocoViewsSkeleton(const JsonArray& categories) {
  for (const JsonValue value : categories) {
    const JsonObject category = AsObject(value, "a category");
    JsonValue names;
    if (!Get(category, "keypoints", &names)) continue;
    std::vector<std::string> labels;
    for (const JsonValue name : AsArray(names, "keypoints")) {
      labels.emplace_back(AsText(name, "keypoints"));
    }
    if (labels.empty()) continue;
    std::vector<Bone> bones;
    JsonValue pairs;
    if (Get(category, "skeleton", &pairs)) {
      bones = ReadBones(pairs, "skeleton", 1, static_cast<int>(labels.size()));
    }
    return SkeletonOfLabels(labels, bones);
  }
  return std::nullopt;
}

DetectionHeader ReadHeader(const JsonObject& root,
                           const DetectionReadOptions& options) {
  JsonValue categories;
  std::optional<Skeleton> own;
  if (Get(root, "categories", &categories)) {
    own = CocoViewsSkeleton(AsArray(categories, "categories"));
  }
  DetectionHeader header = HeaderOf({}, options, own.value_or(Coco17()));
  JsonObject info;
  JsonValue rate;
  if ((header.frame_rate_hz == 0.0 || options.refuse_other_rate) &&
      Get(root, "info", &info) && Get(info, "frame_rate", &rate)) {
    header.frame_rate_hz =
        ChooseFrameRate(header.frame_rate_hz, AsFrameRate(rate, "frame_rate"),
                        options.refuse_other_rate);
  }
  return header;
}

std::vector<Keypoint> ReadJoints(const JsonObject& person, JsonValue keypoints,
                                 size_t count, ZeroConfidence zero_confidence) {
  std::vector<double> numbers(3 * count);
  AsNumbers(keypoints, "keypoints", 3 * count, numbers.data());
  std::vector<double> scores;
  JsonValue stated;
  if (Get(person, "keypoint_scores", &stated)) {
    scores.resize(count);
    AsNumbers(stated, "keypoint_scores", count, scores.data());
  }
  std::vector<Keypoint> joints;
  for (size_t j = 0; j < count; ++j) {
    const double v = numbers[3 * j + 2];
    Keypoint& joint = joints.emplace_back(MakeKeypoint(
        numbers[3 * j], numbers[3 * j + 1], std::min(v, 1.0), zero_confidence));
    if (scores.empty()) continue;
    joint.found = joint.found && v > 0.0 && std::isfinite(scores[j]);
    joint.confidence = scores[j];
  }
  return joints;
}

std::string CategoryText(const Skeleton& skeleton) {
  Json bones = Json::array();
  for (const Bone& bone : skeleton.bones()) {
    bones.push_back({bone.a + 1, bone.b + 1});
  }
  const Json category = {{"id", 1},
                         {"name", "person"},
                         {"supercategory", "person"},
                         {"keypoints", skeleton.joints()},
                         {"skeleton", bones}};
  return DumpJson(category);
}

void AddImage(const Image& image, int64_t id, const ImageSize& size,
              JsonOutput* out) {
  out->Add(id > 1 ? ",\n{\"id\": " : "\n{\"id\": ", id, ", \"file_name\": ",
           JsonText(fmt::format("{}/{:012}.jpg", image.view, image.frame)),
           ", \"camera\": ", JsonText(image.view),
           ", \"frame_id\": ", image.frame, ", \"width\": ", size.width_px,
           ", \"height\": ", size.height_px, "}");
}

void AddAnnotation(const Detection& detection, int64_t id, int64_t image_id,
                   JsonOutput* out) {
  const DetectionSummary summary = Summarise(detection);
  out->Add(id > 1 ? ",\n{\"id\": " : "\n{\"id\": ", id,
           ", \"image_id\": ", image_id,
           ", \"category_id\": 1, \"iscrowd\": 0, \"num_keypoints\": ",
           summary.found, ", \"score\": ", summary.score,
           ", \"area\": ", summary.size_px.x() * summary.size_px.y(),
           ", \"bbox\": [");
  WriteBox(summary, out);
  out->Text("], \"keypoints\": [");
  out->Join(detection.joints, [out](const Keypoint& joint) {
    out->Numbers(
        {joint.found ? joint.px.x() : 0.0, joint.found ? joint.px.y() : 0.0});
    out->Text(joint.found ? ", 2" : ", 0");
  });
  out->Text("], \"keypoint_scores\": [");
  WriteConfidences(detection, out);
  out->Text("]}");
}

}  // namespace

// Tracks in COCO's layout have keypoints_3d and no cameras.
bool RecogniseCocoViews(const DetectionHead& head) {
  return !head.is_folder && head.kind == '{' &&
         (head.HasKey("images") || head.HasKey("annotations")) &&
         !head.HasKey("kinegraph_detections") && !head.Contains("keypoints_3d");
}

std::unique_ptr<DetectionSource> OpenCocoViews(
    const std::string& path, const DetectionReadOptions& options) {
  JsonFileParser parser;
  const JsonObject root =
      Located(path, [&] { return AsObject(parser.Parse(path), kOutermost); });
  DetectionHeader header =
      Located(path, [&] { return ReadHeader(root, options); });
  const auto for_each = [&](const char* key, const char* entry,
                            const auto& read) {
    ForEachObject(
        path, entry, entry, [&] { return AsArray(Required(root, key), key); },
        read);
  };
  std::map<int64_t, Image> images;
  for_each("images", "image", [&](const JsonObject& image) {
    const int64_t id = AsId(Required(image, "id"), "id");
    if (!images.emplace(id, ReadImage(image)).second) {
      throw InputError("id " + std::to_string(id) + " appears twice");
    }
  });
  std::set<std::string, decltype(&NaturalLess)> names(NaturalLess);
  for (const auto& [id, image] : images) names.insert(image.view);
  header.view_names.assign(names.begin(), names.end());
  std::map<std::string, size_t> view_idx;
  for (const std::string& name : names) view_idx.emplace(name, view_idx.size());
  DetectionCollector collector(header);
  for (const auto& [id, image] : images) collector.Touch(image.frame);
  for_each("annotations", "annotation", [&](const JsonObject& person) {
    JsonValue keypoints;
    // Annotations of other objects have only boxes or masks.
    if (!Get(person, "keypoints", &keypoints)) return;
    const int64_t id = AsId(Required(person, "image_id"), "image_id");
    const auto image = images.find(id);
    if (image == images.end()) {
      throw InputError("image_id " + std::to_string(id) +
                       " does not occur in images");
    }
    const auto& [view, frame] = image->second;
    std::vector<Keypoint>& joints =
        collector.Add(frame, view_idx[view])->joints;
    if (AsArray(keypoints, kKeypoints).size() == 0) return;
    joints = ReadJoints(person, keypoints, header.skeleton.joints().size(),
                        options.zero_confidence);
  });
  return collector.Finish();
}

void WriteCocoViews(const std::string& path,
                    const DetectionWriteOptions& options,
                    DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  Json info = {{"description", "2D poses of several cameras"}};
  if (header.frame_rate_hz > 0.0) info["frame_rate"] = header.frame_rate_hz;
  AtomicFile file(path);
  JsonOutput out;
  out.Add("{\"info\": ", DumpJson(info), ",\n\"licenses\": [],\n",
          "\"categories\": [", CategoryText(header.skeleton), "],\n",
          "\"annotations\": [");
  JsonOutput images;  // written after the annotations
  int64_t image_count = 0;
  int64_t person_count = 0;
  const auto write = [&](const DetectionFrame& frame) {
    for (size_t v = 0; v < frame.views.size(); ++v) {
      AddImage({header.view_names[v], frame.frame}, ++image_count,
               options.image_size, &images);
      for (const Detection& detection : frame.views[v].detections) {
        AddAnnotation(detection, ++person_count, image_count, &out);
      }
    }
    out.FlushTo(&file);
  };
  WriteFrames(source, /*skeleton_known=*/true, lost_fields, write,
              /*rate_known=*/true);
  out.Text("],\n\"images\": [");
  out.FlushTo(&file);
  images.Text("]}\n");
  images.FlushTo(&file);
  file.Commit();
  if (options.image_size.width_px == 0) {
    lost_fields->push_back(
        "the width and height of the images are written as 0; other programs "
        "may need them "
        "(--image_size=W,H)");
  }
}

}  // namespace kinegraph
