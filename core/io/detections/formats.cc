#include "core/io/detections/formats.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/data/box.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/folder_entry.h"
#include "core/io/files/text_file.h"
#include "core/io/text/joint_names.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

void SortByName(NamedPaths* paths) {
  std::sort(paths->begin(), paths->end(), [](const auto& a, const auto& b) {
    return NaturalLess(a.first, b.first);
  });
}

bool HasFiles(const std::string& folder, const std::string& extension) {
  bool has_files = false;
  ForEachEntry(folder, [&](const fs::directory_entry& entry) {
    const fs::path& file = entry.path();
    has_files |= file.extension() == extension &&
                 file.filename().string().front() != '.';
  });
  return has_files;
}

}  // namespace

Keypoint MakeKeypoint(double x_px, double y_px, double confidence,
                      ZeroConfidence zero_confidence) {
  Keypoint joint;
  if (!std::isfinite(x_px) || !std::isfinite(y_px) ||
      !std::isfinite(confidence)) {
    return joint;
  }
  joint.px = {x_px, y_px};
  joint.confidence = confidence;
  joint.found = zero_confidence == ZeroConfidence::kPosition ||
                (confidence > 0.0 && (x_px != 0.0 || y_px != 0.0));
  return joint;
}

void SetKeypoints(const std::vector<double>& numbers,
                  ZeroConfidence zero_confidence,
                  std::vector<Keypoint>* joints) {
  joints->resize(numbers.size() / 3);
  const double* next = numbers.data();
  for (Keypoint& joint : *joints) {
    joint = MakeKeypoint(next[0], next[1], next[2], zero_confidence);
    next += 3;
  }
}

bool IsAnyFound(const std::vector<Keypoint>& joints) {
  return std::any_of(joints.begin(), joints.end(),
                     [](const Keypoint& joint) { return joint.found; });
}

NamedPaths ListViewFiles(const std::string& path,
                         const std::string& extension) {
  if (!fs::is_directory(path)) return {{fs::path(path).stem().string(), path}};
  NamedPaths files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
    const fs::path& file = entry.path();
    if (file.extension() != extension || file.filename() == "truth.json" ||
        file.filename().string().front() == '.' || !IsFileOrFolder(entry)) {
      continue;
    }
    files.emplace_back(file.stem().string(), file.string());
  }
  if (files.empty()) {
    throw InputError(path, "",
                     "holds no " + extension + " files, expected one per view");
  }
  SortByName(&files);
  return files;
}

NamedPaths ListViewFolders(const std::string& path) {
  NamedPaths folders;
  if (!IsFolder(path)) return folders;
  ForEachEntry(path, [&folders](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    const std::string inside = entry.path().string();
    if (name.front() == '.') return;
    std::error_code error;
    const bool is_folder = entry.is_directory(error);
    if (error ? IsFolder(inside) : is_folder) {
      folders.emplace_back(name, inside);
    }
  });
  SortByName(&folders);
  return folders;
}

NamedPaths ListDataFolders(const std::string& path,
                           const std::string& extension) {
  const NamedPaths folders = ListViewFolders(path);
  const bool are_views =
      folders.empty() || !HasFiles(path, extension) ||
      std::any_of(folders.begin(), folders.end(), [&](const auto& folder) {
        return HasFiles(folder.second, extension);
      });
  return are_views ? folders : NamedPaths();
}

DetectionHeader HeaderOf(std::vector<std::string> view_names,
                         const DetectionReadOptions& options,
                         const Skeleton& skeleton) {
  return {options.skeleton.value_or(skeleton), std::move(view_names),
          options.frame_rate_hz};
}

std::vector<std::string> NamesOf(const NamedPaths& paths) {
  std::vector<std::string> names;
  for (const auto& [name, path] : paths) names.push_back(name);
  return names;
}

std::vector<const Skeleton*> DetectorSkeletons(size_t joint_count,
                                               const std::string& key) {
  std::vector<const Skeleton*> found;
  std::string expected;
  for (const Skeleton* skeleton :
       {&Coco17(), &Coco18(), &Body25(), &Body25B(), &Halpe26(), &MediaPipe33(),
        &WholeBody133()}) {
    const size_t count = skeleton->joints().size();
    if (count == joint_count) found.push_back(skeleton);
    expected += (expected.empty() ? "" : ", ") + std::to_string(count) + " (" +
                skeleton->name() + ")";
  }
  if (!found.empty()) return found;
  throw InputError(key + ": found " + std::to_string(joint_count) +
                   " joints, expected " + expected +
                   "; give other skeletons by detections.skeleton");
}

bool IsDeterminedByJointCount(const Skeleton& skeleton) {
  try {
    return *DetectorSkeletons(skeleton.joints().size(), "").front() == skeleton;
  } catch (const InputError&) {
    return false;
  }
}

void DetectionCollector::SettleSkeleton(const std::vector<std::string>& labels,
                                        const std::vector<Bone>& bones,
                                        const std::string& name) {
  const Skeleton& known = header_.skeleton;
  if (!has_skeleton()) {
    set_skeleton(SkeletonOfLabels(labels, bones, name));
    labels_ = labels;
  }
  if (known.joints().size() != labels.size()) {
    throw InputError("found " + std::to_string(labels.size()) +
                     " joints, expected the " +
                     std::to_string(known.joints().size()) + " of '" +
                     Printable(known.name()) + "'");
  }
  if (labels_.empty()) return;  // the options specify the skeleton
  for (size_t j = 0; j < labels.size(); ++j) {
    if (labels[j] == labels_[j]) continue;
    throw InputError("joint " + std::to_string(j) + " is '" +
                     Printable(labels[j]) + "', expected '" +
                     Printable(labels_[j]) + "' as in the first file");
  }
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

void DetectionCollector::AddFound(int64_t frame, size_t view_idx,
                                  std::vector<Keypoint> joints) {
  if (IsAnyFound(joints)) Add(frame, view_idx)->joints = std::move(joints);
}

bool DetectionCollector::Next(DetectionFrame* frame) {
  if (frames_.empty()) return false;
  *frame = std::move(frames_.begin()->second);
  frames_.erase(frames_.begin());
  for (ViewDetections& view : frame->views) {
    auto& all = view.detections;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [](const Detection& detection) {
                               return detection.joints.empty();
                             }),
              all.end());
  }
  return true;
}

std::unique_ptr<DetectionSource> DetectionCollector::Finish() {
  frame_count_ = static_cast<int64_t>(frames_.size());
  return std::make_unique<DetectionCollector>(std::move(*this));
}

std::unique_ptr<DetectionSource> ReadViews(const NamedPaths& files,
                                           const DetectionReadOptions& options,
                                           ReadView read) {
  DetectionCollector collector(HeaderOf(NamesOf(files), options));
  for (size_t v = 0; v < files.size(); ++v) {
    read(files[v].second, v, options, &collector);
  }
  if (!collector.has_skeleton()) collector.set_skeleton(Coco17());
  return collector.Finish();
}

void AddPoints(const JsonArray& points, std::string_view key,
               const std::vector<double>& scores,
               ZeroConfidence zero_confidence, Detection* detection) {
  detection->joints.reserve(scores.size());
  for (const JsonValue point : points) {
    double px[2];
    AsNumbers(point, key, 2, px);
    const double score = scores[detection->joints.size()];
    detection->joints.push_back(
        MakeKeypoint(px[0], px[1], score, zero_confidence));
  }
}

// ---- Writing ----

void WriteKeypoints(const Detection& detection, JsonOutput* out) {
  out->Join(detection.joints, [out](const Keypoint& joint) {
    if (!joint.found) return out->Text("0, 0, 0");
    out->Numbers({joint.px.x(), joint.px.y(), joint.confidence});
  });
}

void WritePoints(const Detection& detection, JsonOutput* out) {
  out->Join(detection.joints, [out](const Keypoint& joint) {
    out->Text("[");
    out->Numbers(
        {joint.found ? joint.px.x() : 0.0, joint.found ? joint.px.y() : 0.0});
    out->Text("]");
  });
}

void WriteConfidences(const Detection& detection, JsonOutput* out) {
  out->Join(detection.joints, [out](const Keypoint& joint) {
    out->Number(joint.found ? joint.confidence : 0.0);
  });
}

DetectionSummary Summarise(const Detection& detection) {
  DetectionSummary summary;
  const Eigen::AlignedBox2d box = BoxAround(detection.joints);
  if (box.isEmpty()) return summary;
  for (const Keypoint& joint : detection.joints) {
    if (!joint.found) continue;
    ++summary.found;
    summary.score += joint.confidence;
  }
  summary.score /= summary.found;
  summary.low_px = box.min();
  summary.size_px = box.sizes();
  return summary;
}

void WriteBox(const DetectionSummary& summary, JsonOutput* out) {
  out->Numbers({summary.low_px.x(), summary.low_px.y(), summary.size_px.x(),
                summary.size_px.y()});
}

void WriteFrames(DetectionSource* source, bool skeleton_known,
                 LostFields* lost_fields,
                 const std::function<void(const DetectionFrame& frame)>& write,
                 bool rate_known, bool keeps_times) {
  const DetectionHeader header = source->header();
  int64_t zero_confidence_joints = 0;
  int64_t moved = 0;  // detections that get another index in their view
  bool own_times = false;
  for (DetectionFrame frame; source->Next(&frame);) {
    own_times = own_times ||
                frame.time != TimeOfFrame(frame.frame, header.frame_rate_hz);
    for (const ViewDetections& view : frame.views) {
      own_times = own_times || view.capture_time != frame.time;
      int index = 0;
      for (const Detection& detection : view.detections) {
        moved += detection.index_in_file != index++ ? 1 : 0;
        zero_confidence_joints +=
            std::count_if(detection.joints.begin(), detection.joints.end(),
                          [](const Keypoint& joint) {
                            return joint.found && !(joint.confidence > 0.0);
                          });
      }
    }
    write(frame);
  }
  const auto note = [&](bool is_lost, const std::string& what) {
    if (is_lost) lost_fields->push_back(what);
  };
  note(header.frame_rate_hz > 0.0 && !rate_known, "the frame rate is not kept");
  note(own_times && !keeps_times,
       "times other than frame / frame rate are not kept");
  note(!skeleton_known, "the file does not specify the skeleton '" +
                            header.skeleton.name() +
                            "': name it when reading (detections.skeleton)");
  note(zero_confidence_joints > 0,
       Counted(zero_confidence_joints, "joint with confidence 0 is",
               "joints with confidence 0 are") +
           " read as missing unless "
           "detections.zero_confidence = \"position\"");
  note(moved > 0, "people without joints are left out, so that " +
                      Counted(moved, "detection gets another index in its view",
                              "detections get another index in their views"));
  note(!keeps_times && !std::is_sorted(header.view_names.begin(),
                                       header.view_names.end(), NaturalLess),
       "views are read back in the order of their names");
}

JsonOutput& ViewFile::Entry() {
  out.Text(has_entries ? ",\n" : "[\n");
  has_entries = true;
  return out;
}

int64_t WriteViewFiles(const std::string& path, const std::string& extension,
                       const std::string& heading, DetectionSource* source,
                       bool skeleton_known, LostFields* lost_fields,
                       void (*write)(int64_t frame,
                                     const std::vector<Detection>& detections,
                                     ViewFile* file)) {
  AtomicFolder folder(path);
  std::deque<ViewFile> files;
  for (const std::string& view : source->header().view_names) {
    CheckFileName(view, "view");
    files.emplace_back(folder.PathOf(view + extension)).out.Text(heading);
  }
  int64_t empty_frames = 0;
  WriteFrames(source, skeleton_known, lost_fields,
              [&](const DetectionFrame& frame) {
                bool any = false;
                for (size_t v = 0; v < files.size(); ++v) {
                  const auto& detections = frame.views[v].detections;
                  write(frame.frame, detections, &files[v]);
                  files[v].out.FlushTo(&files[v].file);
                  any = any || !detections.empty();
                }
                empty_frames += any ? 0 : 1;
              });
  for (ViewFile& view : files) {
    if (heading.empty()) view.out.Text(view.has_entries ? "\n]\n" : "[]\n");
    view.out.FlushTo(&view.file);
    view.file.Commit();
  }
  folder.Commit();
  return empty_frames;
}

void NoteEmptyFrames(int64_t empty_frames, LostFields* lost_fields) {
  if (empty_frames == 0) return;
  lost_fields->push_back(Counted(empty_frames, "frame without any detection is",
                                 "frames without any detection are") +
                         " not kept");
}

void RefuseViewTruth(const DetectionHeader& header, const std::string& format) {
  for (const std::string& view : header.view_names) {
    if (view != "truth") continue;
    throw InputError("the view 'truth' cannot be written as " + format);
  }
}

}  // namespace kinegraph
