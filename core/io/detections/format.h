// The formats of 2D detections: one entry each, from which follow recognition,
// the key detections.format, `convert --formats`, its flags and `synthesize
// --format`. A format joins by its functions and by two lines in format.cc.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_

#include <memory>
#include <string>
#include <vector>

#include "core/io/detections/source.h"
#include "core/io/text/lost_fields.h"

namespace kinegraph {

struct ImageSize {
  int width_px = 0;
  int height_px = 0;
};

struct DetectionWriteOptions {
  ImageSize image_size;  // where the format names it
};

// What a path looks like, for recognising its format.
struct DetectionHead {
  std::string path;
  bool is_folder = false;
  bool has_folders = false;  // in the folder: one a view
  // The file itself, or the first of the folder's .json and .csv files, or of
  // its first folder's; empty when there is none.
  std::string file;
  char kind = '\0';               // first character of it that is no space
  std::vector<std::string> keys;  // outermost keys of a JSON object
  std::string beginning;          // its first 64 KiB

  bool HasKey(const std::string& key) const;
  std::vector<std::string> FirstRow() const;  // of a table
  bool Contains(const std::string& text) const {
    return beginning.find(text) != std::string::npos;
  }
};

struct DetectionFormat {
  using Recognise = bool (*)(const DetectionHead& head);
  using Open = std::unique_ptr<DetectionSource> (*)(
      const std::string& path, const DetectionReadOptions& options);
  // Writes a file or a folder, which appears when it is complete; takes the
  // frames one by one from `source`. Throws InputError when it cannot be made.
  // What the format leaves out is added to `lost_fields`.
  using Write = void (*)(const std::string& path,
                         const DetectionWriteOptions& options,
                         DetectionSource* source, LostFields* lost_fields);
  enum class Files {
    kOne,          // the whole recording
    kFileAView,    // a folder with a file a view; one alone is a view
    kFolderAView,  // a folder with one folder per view, one file per frame
    kSession,      // the whole recording, found in the folder of its session
  };

  std::string name;
  std::string layout;     // one line for people
  std::string extension;  // of its files
  Files files = Files::kOne;
  Recognise recognise = nullptr;  // null: an adapter does
  Open open = nullptr;
  Write write = nullptr;          // null: read only
  bool names_image_size = false;  // what is written does (--image_size)
  // An image in which nobody was found has no entry.
  bool leaves_out_empty = false;
};

const std::vector<DetectionFormat>& DetectionFormats();
// nullptr when there is none of that name.
const DetectionFormat* FindDetectionFormat(const std::string& name);

// Looks at a path; throws InputError when it cannot be read.
DetectionHead LookAtDetections(const std::string& path);
// The format that recognises it, or nullptr.
const DetectionFormat* RecogniseDetections(const DetectionHead& head);

// Whether frames that the path has not are frames in which nobody was found, as
// far as anybody can say.
bool LeavesOutEmptyFrames(const std::string& path,
                          const DetectionReadOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_FORMAT_H_
