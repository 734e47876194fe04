#include "core/io/detections/format.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "core/io/detections/formats.h"
#include "core/io/files/text_file.h"
#include "core/io/text/names.h"

namespace kinegraph {

// Declares the functions that a format may have; other sources of this folder
// define those that the table below uses.
#define KINEGRAPH_DECLARE(Format)                                    \
  bool Recognise##Format(const DetectionHead& head);                 \
  std::unique_ptr<DetectionSource> Open##Format(                     \
      const std::string& path, const DetectionReadOptions& options); \
  void Write##Format(const std::string& path,                        \
                     const DetectionWriteOptions& options,           \
                     DetectionSource* source, LostFields* lost_fields)
KINEGRAPH_DECLARE(Kinegraph);
KINEGRAPH_DECLARE(Openpose);
KINEGRAPH_DECLARE(Coco);
KINEGRAPH_DECLARE(CocoViews);
KINEGRAPH_DECLARE(Mmpose);
KINEGRAPH_DECLARE(Mediapipe);
KINEGRAPH_DECLARE(DeepLabCut);
KINEGRAPH_DECLARE(Longcw);
#undef KINEGRAPH_DECLARE
std::unique_ptr<DetectionSource> OpenDeepLabCutH5(
    const std::string& path, const DetectionReadOptions& options);

namespace {

namespace fs = std::filesystem;

// Opens a format that is read by kinegraph-adapters.
template <const char* const& kName>
std::unique_ptr<DetectionSource> OpenOurs(const std::string& path,
                                          const DetectionReadOptions& options) {
  return OpenByAdapter(OwnAdapter(kName, AdapterKind::kDetections), path,
                       options);
}
constexpr const char* kCaliscope = "caliscope";
constexpr const char* kFreemocap = "freemocap";
constexpr const char* kSleap = "sleap";

// Whether the file has the extension of a format whose files are looked up in
// folders.
bool IsDataFile(const fs::path& path) {
  const std::string extension = path.extension().string();
  return std::any_of(DetectionFormats().begin(), DetectionFormats().end(),
                     [&](const DetectionFormat& format) {
                       return format.files != DetectionFormat::Files::kOne &&
                              format.extension == extension;
                     });
}

// The first data file in a folder, in natural order.
std::optional<std::string> FirstFile(const std::string& folder) {
  std::optional<std::string> first;
  for (const std::string& name : ListFolder(folder)) {
    if (name.front() == '.' || !IsDataFile(name)) continue;
    if (!first || NaturalLess(name, *first)) first = name;
  }
  if (!first) return std::nullopt;
  return folder + "/" + *first;
}

}  // namespace

// `convert --formats` lists them, and RecogniseDetections tries them, in this
// order.
const std::vector<DetectionFormat>& DetectionFormats() {
  using Files = DetectionFormat::Files;
  static const std::vector<DetectionFormat> kFormats = {
      {"kinegraph", "JSON Lines", ".jsonl", Files::kOne, RecogniseKinegraph,
       OpenKinegraph, WriteKinegraph},
      {"caliscope", "Caliscope's xy_TRACKER.csv, or the folder of its session",
       ".csv", Files::kSession, nullptr, OpenOurs<kCaliscope>},
      {"openpose",
       "one folder per view, one file per frame (OpenPose, Pose2Sim, Sports2D)",
       ".json", Files::kFolderAView, RecogniseOpenpose, OpenOpenpose,
       WriteOpenpose},
      {"coco", "COCO results, one file per view (also AlphaPose)", ".json",
       Files::kFileAView, RecogniseCoco, OpenCoco, WriteCoco, false,
       /*leaves_out_empty=*/true},
      {"coco_views", "one COCO file for all cameras: images, annotations",
       ".json", Files::kOne, RecogniseCocoViews, OpenCocoViews, WriteCocoViews,
       /*names_image_size=*/true},
      {"mmpose", "JSON, one file per view (MMPose, RTMPose)", ".json",
       Files::kFileAView, RecogniseMmpose, OpenMmpose, WriteMmpose},
      {"mediapipe",
       "CSV, one file per view: frame, NAME_x, NAME_y, NAME_visibility", ".csv",
       Files::kFileAView, RecogniseMediapipe, OpenMediapipe, WriteMediapipe,
       false, /*leaves_out_empty=*/true},
      {"deeplabcut",
       "CSV, one file per view (also Lightning Pose); or one such folder per "
       "detector, to be fused",
       ".csv", Files::kFileAView, RecogniseDeepLabCut, OpenDeepLabCut},
      {"deeplabcut_h5", "DeepLabCut's HDF5, one file per view", ".h5",
       Files::kFileAView, nullptr, OpenDeepLabCutH5},
      {"sleap",
       "analysis HDF5, one file per view, or sleap-anipose's folder per camera",
       ".h5", Files::kFileAView, nullptr, OpenOurs<kSleap>},
      {"freemocap", "FreeMoCap's 2D points, one NPY for all cameras", ".npy",
       Files::kOne, nullptr, OpenOurs<kFreemocap>},
      {"longcw", "annotation_2d.json", ".json", Files::kOne, RecogniseLongcw,
       OpenLongcw, WriteLongcw, /*names_image_size=*/true}};
  return kFormats;
}

const DetectionFormat* FindDetectionFormat(const std::string& name) {
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

DetectionHead LookAtDetections(const std::string& path) {
  DetectionHead head;
  head.is_folder = IsFolder(path);
  head.file = path;
  if (head.is_folder) {
    const NamedPaths folders = ListViewFolders(path);
    std::optional<std::string> file = FirstFile(path);
    // Beside data files, only folders that contain data are views.
    head.has_folders =
        !folders.empty() &&
        (!file ||
         std::any_of(folders.begin(), folders.end(), [](const auto& folder) {
           return FirstFile(folder.second).has_value();
         }));
    for (const auto& [name, folder] : folders) {
      if (!file) file = FirstFile(folder);
    }
    head.file = file.value_or("");
    if (head.file.empty()) return head;
  }
  static_cast<FileHead&>(head) = LookAtFile(head.file);
  return head;
}

bool LeavesOutEmptyFrames(const std::string& path,
                          const DetectionReadOptions& options) {
  const DetectionFormat* format =
      options.format == "auto" ? RecogniseDetections(LookAtDetections(path))
                               : FindDetectionFormat(options.format);
  return format != nullptr && format->leaves_out_empty;
}

const DetectionFormat* RecogniseDetections(const DetectionHead& head) {
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.recognise != nullptr && format.recognise(head)) return &format;
  }
  return nullptr;
}

}  // namespace kinegraph
