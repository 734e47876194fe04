// OpenPose's JSON output: one folder per view, one file per frame, each
// {"people": [{"pose_keypoints_2d": [x, y, c, ...], ...}, ...], ...}. A folder
// of frames without subfolders is a recording of one view.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/detections/format.h"
#include "core/io/detections/formats.h"
#include "core/io/detections/skeleton_fit.h"
#include "core/io/detections/view_files.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/folder_entry.h"
#include "core/io/files/text_file.h"
#include "core/io/text/bulk_json.h"
#include "core/io/text/json_output.h"
#include "core/io/text/names.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOpenposeKeypoints = "pose_keypoints_2d";

// Number of people that suffices to distinguish two layouts.
constexpr size_t kPeopleToRecogniseBy = 200;
constexpr size_t kFilesAView = 40;  // files sampled per view

struct OpenPoseView {
  std::string FileAt(size_t index) const {
    return folder + "/" + files[index].second;
  }

  std::string folder;
  std::vector<std::pair<int64_t, std::string>> files;  // frame and name
  size_t next = 0;                                     // to be read
};

OpenPoseView ListFrames(const std::string& folder) {
  OpenPoseView view{folder, {}};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.front() == '.' || entry.path().extension() != ".json") continue;
    if (!IsFileOrFolder(entry)) continue;
    view.files.emplace_back(Located(folder, [&] { return FrameOfName(name); }),
                            name);
  }
  if (view.files.empty()) {
    throw InputError(folder, "",
                     "holds no .json files, expected one per frame");
  }
  std::sort(view.files.begin(), view.files.end());
  const auto twice = std::adjacent_find(
      view.files.begin(), view.files.end(),
      [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice == view.files.end()) return view;
  throw InputError(
      folder, "frame " + std::to_string(twice->first),
      "appears twice: " + twice->second + ", " + std::next(twice)->second);
}

// Throws InputError if no layout has this many numbers.
std::vector<const Skeleton*> ByNumberCount(size_t number_count) {
  if (number_count % 3 != 0) {
    throw InputError(std::string(kOpenposeKeypoints) + ": found " +
                     std::to_string(number_count) +
                     " numbers, expected three per joint");
  }
  return DetectorSkeletons(number_count / 3, kOpenposeKeypoints);
}

class OpenPoseSource : public DetectionSource {
 public:
  OpenPoseSource(const std::string& path, const DetectionReadOptions& options)
      : options_(options) {
    header_.frame_rate_hz = options.frame_rate_hz;
    NamedPaths views = ListViewFolders(path);
    if (views.empty()) {
      views.emplace_back(fs::canonical(path).filename().string(), path);
    }
    for (const auto& [name, folder] : views) {
      header_.view_names.push_back(name);
      views_.push_back(ListFrames(folder));
      for (const auto& [frame, file] : views_.back().files) {
        frames_.push_back(frame);
      }
    }
    std::sort(frames_.begin(), frames_.end());
    frames_.erase(std::unique(frames_.begin(), frames_.end()), frames_.end());
    header_.skeleton = options.skeleton ? *options.skeleton : FindSkeleton();
    numbers_.resize(3 * static_cast<size_t>(header_.skeleton.joint_count()));
  }

  const DetectionHeader& header() const override { return header_; }
  int64_t frame_count() const override {
    return static_cast<int64_t>(frames_.size());
  }

  bool Next(DetectionFrame* frame) override {
    if (next_ == frames_.size()) return false;
    frame->frame = frames_[next_++];
    frame->time = TimeOfFrame(frame->frame, header_.frame_rate_hz);
    frame->views.resize(views_.size());
    for (size_t v = 0; v < views_.size(); ++v) {
      frame->views[v].capture_time = frame->time;
      std::vector<Detection>* detections = &frame->views[v].detections;
      OpenPoseView& view = views_[v];
      // Also skips files of frames that were not read because of an error in
      // another view.
      while (view.next < view.files.size() &&
             view.files[view.next].first < frame->frame) {
        ++view.next;
      }
      if (view.next < view.files.size() &&
          view.files[view.next].first == frame->frame) {
        ReadView(view.FileAt(view.next), detections);
      } else {
        detections->clear();
      }
    }
    return true;
  }

 private:
  // Determines the skeleton by the number of joints and, if several layouts
  // have this number, by the people's bones (skeleton_fit.h); BODY_25 if there
  // are no people. First samples files of every view, spread over the
  // recording; reads all files if these show too few people.
  Skeleton FindSkeleton() {
    std::vector<const Skeleton*> candidates;
    std::optional<SkeletonFit> fit;
    const auto best = [&] { return *candidates[fit->Best()]; };
    for (const bool spread : {true, false}) {
      for (size_t i = 0; i < (spread ? kFilesAView : frames_.size()); ++i) {
        for (const OpenPoseView& view : views_) {
          const size_t at = spread ? i * view.files.size() / kFilesAView : i;
          if (at < view.files.size() &&
              IsDetermined(view.FileAt(at), &candidates, &fit)) {
            return best();
          }
        }
      }
    }
    return candidates.empty() ? Body25() : best();
  }

  // Adds one more file; returns whether the layout is determined. The first
  // person determines the candidates, all people decide among these.
  bool IsDetermined(const std::string& path,
                    std::vector<const Skeleton*>* candidates,
                    std::optional<SkeletonFit>* fit) {
    try {
      const JsonArray people = ParsePeople(path);
      Located(path, [&] {
        Detection detection;
        for (const JsonValue person : people) {
          const size_t count = Keypoints(person).size();
          if (count == 0) continue;
          if (candidates->empty()) {
            *candidates = ByNumberCount(count);
            fit->emplace(*candidates);
            numbers_.resize(count);
          }
          if (ReadPerson(person, &detection)) (*fit)->See(detection);
        }
      });
    } catch (const InputError&) {
      if (candidates->empty()) throw;
      // Otherwise the error is reported when that frame is read.
    }
    return candidates->size() == 1 ||
           (fit->has_value() && (*fit)->people() >= kPeopleToRecogniseBy);
  }

  JsonArray ParsePeople(const std::string& path) {
    const JsonValue root = parser_.Parse(path);
    return Located(path, [&] {
      return AsArray(Required(AsObject(root, kOutermost), "people"), "people");
    });
  }

  static JsonArray Keypoints(JsonValue person) {
    return AsArray(Required(AsObject(person, "people"), kOpenposeKeypoints),
                   kOpenposeKeypoints);
  }

  void ReadView(const std::string& path, std::vector<Detection>* detections) {
    const JsonArray people = ParsePeople(path);
    detections->resize(people.size());
    int index = 0;
    size_t count = 0;
    Located(
        path, [&] { return "people[" + std::to_string(index) + "]"; },
        [&] {
          for (const JsonValue person : people) {
            if (ReadPerson(person, &(*detections)[count])) {
              (*detections)[count++].index_in_file = index;
            }
            ++index;
          }
        });
    detections->resize(count);
  }

  // False for a person without joints.
  bool ReadPerson(JsonValue person, Detection* detection) {
    const JsonArray keypoints = Keypoints(person);
    if (keypoints.begin() == keypoints.end()) return false;
    AsNumbers(keypoints, kOpenposeKeypoints, numbers_.size(), numbers_.data());
    SetKeypoints(numbers_, options_.zero_confidence, &detection->joints);
    return true;
  }

  const DetectionReadOptions options_;
  DetectionHeader header_;
  std::vector<OpenPoseView> views_;
  std::vector<int64_t> frames_;  // that at least one view has, ascending
  size_t next_ = 0;
  JsonFileParser parser_;
  std::vector<double> numbers_;  // of one person
};

// Lists that OpenPose always writes; empty for parts that it does not detect.
constexpr const char* kEmptyParts =
    ", \"face_keypoints_2d\": [], \"hand_left_keypoints_2d\": [], "
    "\"hand_right_keypoints_2d\": [], \"pose_keypoints_3d\": [], "
    "\"face_keypoints_3d\": [], \"hand_left_keypoints_3d\": [], "
    "\"hand_right_keypoints_3d\": []}";

void WritePeople(const std::string& path,
                 const std::vector<Detection>& detections, JsonOutput* out) {
  out->Text("{\"version\": 1.3, \"people\": [");
  out->Join(detections, [out](const Detection& detection) {
    out->Text("{\"person_id\": [-1], \"pose_keypoints_2d\": [");
    WriteKeypoints(detection, out);
    out->Add("]", kEmptyParts);
  });
  out->Text("]}\n");
  AtomicFile file(path);
  out->FlushTo(&file);
  file.Commit();
}

}  // namespace

bool RecogniseOpenpose(const DetectionHead& head) {
  if (!head.is_folder) return false;
  if (head.HasKey("people")) return true;
  // Folders of views, possibly without files yet. If the first data file is no
  // JSON object, or MMPose's, this is another format, such as a folder per
  // detector of DeepLabCut.
  return head.has_folders && !head.HasKey("instance_info") &&
         (head.kind == '{' || head.kind == '\0');
}

std::unique_ptr<DetectionSource> OpenOpenpose(
    const std::string& path, const DetectionReadOptions& options) {
  return std::make_unique<OpenPoseSource>(path, options);
}

// VIEW/VIEW_FFFFFFFFFFFF_keypoints.json for every view and frame, including
// empty ones; a missing joint is 0, 0, 0.
void WriteOpenpose(const std::string& path, const DetectionWriteOptions&,
                   DetectionSource* source, LostFields* lost_fields) {
  const DetectionHeader header = source->header();
  AtomicFolder folder(path);
  for (const std::string& view : header.view_names) {
    CheckFileName(view, "view");
    MakeFolder(folder.PathOf(view));
  }
  JsonOutput out;
  const bool skeleton_known = IsDeterminedByJointCount(header.skeleton);
  WriteFrames(
      source, skeleton_known, lost_fields, [&](const DetectionFrame& frame) {
        for (size_t v = 0; v < header.view_names.size(); ++v) {
          const std::string& view = header.view_names[v];
          const std::string name = fmt::format("{}/{}_{:012}_keypoints.json",
                                               view, view, frame.frame);
          WritePeople(folder.PathOf(name), frame.views[v].detections, &out);
        }
      });
  folder.Commit();
}

}  // namespace kinegraph
