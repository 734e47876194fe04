// One COCO file of several cameras: `images` are the views' frames, with the
// camera by the key "camera" (or "view", "camera_id", or the folder of
// file_name) and the frame by "frame_id" (or "frame", or the last integer of
// file_name); `annotations` are people, with image_id and keypoints = x, y, v a
// joint; the first of `categories` with keypoints names joints and bones (from
// 1). v is COCO's flag, 0 for a joint that is not there, or a confidence up to
// 1; "keypoint_scores", where somebody has them, are the confidences.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"
#include "core/io/text/skeleton_json.h"

namespace kinegraph {
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
  const size_t before = folder.find_last_of("/\\");
  return before == std::string::npos ? folder : folder.substr(before + 1);
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
    throw InputError("expected a key camera, or a folder in file_name");
  }
  JsonValue frame;
  for (const char* key : {"frame_id", "frame"}) {
    if (!Get(object, key, &frame)) continue;
    image.frame = AsFrame(frame, key);
    return image;
  }
  const size_t slash = file_name.find_last_of("/\\");
  image.frame = FrameOfName(
      slash == std::string::npos ? file_name : file_name.substr(slash + 1));
  return image;
}

// Of the first category that has key points.
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
  if (header.frame_rate_hz == 0.0 && Get(root, "info", &info) &&
      Get(info, "frame_rate", &rate)) {
    header.frame_rate_hz = AsFrameRate(rate, "frame_rate");
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

// Tracks in COCO's manner have keypoints_3d and come without cameras.
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
    // Boxes and masks of other things.
    if (!Get(person, "keypoints", &keypoints)) return;
    const int64_t id = AsId(Required(person, "image_id"), "image_id");
    const auto image = images.find(id);
    if (image == images.end()) {
      throw InputError("image_id " + std::to_string(id) +
                       " is none of the images");
    }
    const auto& [view, frame] = image->second;
    collector.Add(frame, view_idx[view])->joints =
        ReadJoints(person, keypoints, header.skeleton.joints().size(),
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
  JsonOutput images;  // stand behind the annotations
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
  WriteFrames(source, /*skeleton_told=*/true, lost_fields, write,
              /*rate_told=*/true);
  out.Text("],\n\"images\": [");
  out.FlushTo(&file);
  images.Text("]}\n");
  images.FlushTo(&file);
  file.Commit();
  if (options.image_size.width_px == 0) {
    lost_fields->push_back(
        "width and height of the images are 0; other programs may need them "
        "(--image_size=W,H)");
  }
}

}  // namespace kinegraph
