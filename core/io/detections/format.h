// The table of 2D detection formats. Recognition, the key detections.format,
// `convert` (--formats, --from, --to, --image_size) and `synthesize --format`
// use it. A new format requires its functions and two lines in format.cc.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_

#include <memory>
#include <string>
#include <vector>

#include "core/io/detections/source.h"
#include "core/io/text/file_head.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

struct DetectionWriteOptions {
  ImageSize image_size;  // of all views, for formats that store it
};

// The beginning of a path's content, to recognise its format. FileHead
// describes `file`.
struct DetectionHead : FileHead {
  bool is_folder = false;
  bool has_folders = false;  // the folder has subfolders that may be views
  // The path of the file whose beginning was read: the given file; of a folder,
  // its first .json, .csv or .h5 file, otherwise the first such file of its
  // first subfolder that has one; empty if there is none.
  std::string file;

  bool Contains(const std::string& text) const {
    return beginning.find(text) != std::string::npos;
  }
};

struct DetectionFormat {
  using Recognise = bool (*)(const DetectionHead& head);
  using Open = std::unique_ptr<DetectionSource> (*)(
      const std::string& path, const DetectionReadOptions& options);
  // Writes a file or a folder, which appears only when it is complete; reads
  // `source` frame by frame. Throws InputError if it cannot be created or
  // the format cannot represent the detections. Adds what the format cannot
  // store to `lost_fields`.
  using Write = void (*)(const std::string& path,
                         const DetectionWriteOptions& options,
                         DetectionSource* source, LostFields* lost_fields);
  enum class Files {
    kOne,          // the whole recording
    kFileAView,    // a folder with one file per view, or the file of one view
    kFolderAView,  // a folder with one folder per view, one file per frame
    kSession,      // one file, also found if its session folder is given
  };

  std::string name;
  std::string layout;     // one line for users
  std::string extension;  // of the files
  Files files = Files::kOne;
  Recognise recognise = nullptr;  // null: an adapter recognises it
  Open open = nullptr;
  Write write = nullptr;          // null: read only
  bool names_image_size = false;  // files store the size (--image_size)
  // Images without detections have no entry in the files.
  bool leaves_out_empty = false;
};

const std::vector<DetectionFormat>& DetectionFormats();
// nullptr if there is none of this name.
const DetectionFormat* FindDetectionFormat(const std::string& name);

// Reads the beginning of a path; throws InputError if it cannot be read.
DetectionHead LookAtDetections(const std::string& path);
// The first format that recognises `head`, or nullptr.
const DetectionFormat* RecogniseDetections(const DetectionHead& head);

// Whether the format of `path` (options.format, or the recognised one if that
// is "auto") omits frames without detections; false if there is no such format.
bool LeavesOutEmptyFrames(const std::string& path,
                          const DetectionReadOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_
