// One COCO file of several cameras: `images` are the views' frames, with the
// camera by the key "camera" (or "view", "camera_id", or the folder of
// file_name) and the frame by "frame_id" (or "frame", or the last integer of
// file_name); `annotations` are people, with image_id and keypoints = x, y, v a
// joint; the first of `categories` with keypoints names joints and bones (from
// 1). v is COCO's flag, 0 for a joint that is not there, or a confidence up to
// 1; "keypoint_scores", where somebody has them, are the confidences.
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
    if (object[key].get(value) != simdjson::SUCCESS) continue;
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
    if (object[key].get(frame) != simdjson::SUCCESS) continue;
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
    if (category["keypoints"].get(names) != simdjson::SUCCESS) continue;
    std::vector<std::string> labels;
    for (const JsonValue name : AsArray(names, "keypoints")) {
      labels.emplace_back(AsText(name, "keypoints"));
    }
    if (labels.empty()) continue;
    std::vector<Bone> bones;
    JsonValue pairs;
    if (category["skeleton"].get(pairs) == simdjson::SUCCESS) {
      bones = ReadBones(pairs, "skeleton", 1, static_cast<int>(labels.size()));
    }
    return SkeletonOfLabels(labels, bones);
  }
  return std::nullopt;
}

class CocoViewsReader {
 public:
  CocoViewsReader(const std::string& path, const DetectionReadOptions& options)
      : path_(path), options_(options) {}

  std::unique_ptr<DetectionSource> Read() {
    const JsonObject root = Located(
        path_, [&] { return AsObject(parser_.Parse(path_), kOutermost); });
    DetectionHeader header = ReadHeader(root);
    ForEach(root, "images", "image", [this](const JsonObject& image) {
      const int64_t id = AsId(Required(image, "id"), "id");
      if (!images_.emplace(id, ReadImage(image)).second) {
        throw InputError("id " + std::to_string(id) + " appears twice");
      }
    });
    std::set<std::string> names;
    for (const auto& [id, image] : images_) names.insert(image.view);
    header.view_names.assign(names.begin(), names.end());
    std::sort(header.view_names.begin(), header.view_names.end(), NaturalLess);
    for (size_t v = 0; v < header.view_names.size(); ++v) {
      view_idx_[header.view_names[v]] = v;
    }
    collector_ = std::make_unique<DetectionCollector>(header);
    for (const auto& [id, image] : images_) collector_->Touch(image.frame);
    ForEach(root, "annotations", "annotation",
            [this](const JsonObject& person) { AddPerson(person); });
    return collector_->Finish();
  }

 private:
  template <typename Visit>
  void ForEach(const JsonObject& root, const char* key, const char* what,
               const Visit& visit) {
    size_t place = 0;
    Located(
        path_, [&] { return what + (" " + std::to_string(place)); },
        [&] {
          for (const JsonValue value : AsArray(Required(root, key), key)) {
            visit(AsObject(value, what));
            ++place;
          }
        });
  }

  DetectionHeader ReadHeader(const JsonObject& root) {
    return Located(path_, [&] {
      JsonValue categories;
      std::optional<Skeleton> own;
      if (root["categories"].get(categories) == simdjson::SUCCESS) {
        own = CocoViewsSkeleton(AsArray(categories, "categories"));
      }
      DetectionHeader header = HeaderOf({}, options_, own.value_or(Coco17()));
      JsonObject info;
      JsonValue rate;
      if (header.frame_rate_hz == 0.0 &&
          root["info"].get(info) == simdjson::SUCCESS &&
          info["frame_rate"].get(rate) == simdjson::SUCCESS) {
        header.frame_rate_hz = AsFrameRate(rate, "frame_rate");
      }
      return header;
    });
  }

  void AddPerson(const JsonObject& person) {
    JsonValue keypoints;
    // Boxes and masks of other things.
    if (person["keypoints"].get(keypoints) != simdjson::SUCCESS) return;
    const int64_t id = AsId(Required(person, "image_id"), "image_id");
    const auto image = images_.find(id);
    if (image == images_.end()) {
      throw InputError("image_id " + std::to_string(id) +
                       " is none of the images");
    }
    const size_t count = collector_->header().skeleton.joints().size();
    numbers_.resize(3 * count);
    AsNumbers(keypoints, "keypoints", 3 * count, numbers_.data());
    scores_.clear();
    JsonValue scores;
    if (person["keypoint_scores"].get(scores) == simdjson::SUCCESS) {
      scores_.resize(count);
      AsNumbers(scores, "keypoint_scores", count, scores_.data());
    }
    std::vector<Keypoint>& joints =
        collector_->Add(image->second.frame, view_idx_[image->second.view])
            ->joints;
    for (size_t j = 0; j < count; ++j) {
      const double v = numbers_[3 * j + 2];
      Keypoint joint = MakeKeypoint(numbers_[3 * j], numbers_[3 * j + 1],
                                    std::min(v, 1.0), options_.zero_confidence);
      if (!scores_.empty()) {
        joint.found = joint.found && v > 0.0 && std::isfinite(scores_[j]);
        joint.confidence = scores_[j];
      }
      joints.push_back(joint);
    }
  }

  const std::string path_;
  const DetectionReadOptions& options_;
  JsonFileParser parser_;
  std::map<int64_t, Image> images_;
  std::map<std::string, size_t> view_idx_;
  std::vector<double> numbers_;  // of one person
  std::vector<double> scores_;
  std::unique_ptr<DetectionCollector> collector_;
};

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

// Collects the images while annotations are written.
class Writer {
 public:
  Writer(const std::string& path, const DetectionHeader& header,
         const ImageSize& size)
      : header_(header), size_(size), file_(path) {
    Json info = {{"description", "2D poses of several cameras"}};
    if (header.frame_rate_hz > 0.0) info["frame_rate"] = header.frame_rate_hz;
    out_.Text("{\"info\": " + DumpJson(info) + ",\n\"licenses\": [],\n");
    out_.Text("\"categories\": [" + CategoryText(header.skeleton) + "],\n");
    out_.Text("\"annotations\": [");
  }

  void Write(const DetectionFrame& frame) {
    for (size_t v = 0; v < frame.views.size(); ++v) {
      ++image_count_;
      AddImage(frame.frame, header_.view_names[v]);
      for (const Detection& detection : frame.views[v].detections) {
        AddPerson(detection);
      }
    }
    out_.FlushTo(&file_);
  }

  void Commit() {
    out_.Text("],\n\"images\": [");
    out_.FlushTo(&file_);
    images_.Text("]}\n");
    images_.FlushTo(&file_);
    file_.Commit();
  }

 private:
  void AddImage(int64_t frame, const std::string& view) {
    const std::string number = std::to_string(frame);
    const size_t zeros = number.size() < 12 ? 12 - number.size() : 0;
    images_.Add(
        image_count_ > 1 ? ",\n{\"id\": " : "\n{\"id\": ", image_count_,
        ", \"file_name\": ",
        JsonText(view + "/" + std::string(zeros, '0') + number + ".jpg"),
        ", \"camera\": ", JsonText(view), ", \"frame_id\": ", frame,
        ", \"width\": ", size_.width_px, ", \"height\": ", size_.height_px,
        "}");
  }

  void AddPerson(const Detection& detection) {
    const DetectionSummary summary = Summarise(detection);
    out_.Text(++person_count_ > 1 ? ",\n" : "\n");
    out_.Add("{\"id\": ", person_count_, ", \"image_id\": ", image_count_,
             ", \"category_id\": 1, \"iscrowd\": 0, \"num_keypoints\": ",
             summary.found, ", \"score\": ", summary.score,
             ", \"area\": ", summary.size_px.x() * summary.size_px.y(),
             ", \"bbox\": [");
    WriteBox(summary, &out_);
    out_.Text("], \"keypoints\": [");
    out_.Join(detection.joints, [this](const Keypoint& joint) {
      out_.Numbers(
          {joint.found ? joint.px.x() : 0.0, joint.found ? joint.px.y() : 0.0});
      out_.Text(joint.found ? ", 2" : ", 0");
    });
    out_.Text("], \"keypoint_scores\": [");
    WriteConfidences(detection, &out_);
    out_.Text("]}");
  }

  const DetectionHeader header_;
  const ImageSize size_;
  AtomicFile file_;
  JsonOutput out_;
  JsonOutput images_;
  int64_t image_count_ = 0;
  int64_t person_count_ = 0;
};

}  // namespace

// Tracks in COCO's manner have keypoints_3d and come without cameras.
bool RecogniseCocoViews(const DetectionHead& head) {
  return !head.is_folder && head.kind == '{' &&
         (head.HasKey("images") || head.HasKey("annotations")) &&
         !head.HasKey("kinegraph_detections") && !head.Contains("keypoints_3d");
}

std::unique_ptr<DetectionSource> OpenCocoViews(
    const std::string& path, const DetectionReadOptions& options) {
  return CocoViewsReader(path, options).Read();
}

void WriteCocoViews(const std::string& path,
                    const DetectionWriteOptions& options,
                    DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  DetectionLossFinder finder(header);
  Writer writer(path, header, options.image_size);
  DetectionFrame frame;
  while (source->Next(&frame)) {
    finder.See(frame);
    writer.Write(frame);
  }
  writer.Commit();
  finder.Report(/*skeleton_told=*/true, lost_fields, /*rate_told=*/true);
  if (options.image_size.width_px == 0) {
    lost_fields->push_back(
        "width and height of the images are 0; other programs may need them "
        "(--image_size=W,H)");
  }
}

}  // namespace kinegraph
