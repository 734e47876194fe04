// Formats of detections that keep a file a view in one folder. For the writers
// of core/io/detections alone.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_

#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/data/detection.h"
#include "core/io/files/atomic_folder.h"

namespace kinegraph {

// Begins a File for each view, named as the view; `more` goes to its
// constructor behind the path. Throws InputError where a name is no file's.
template <typename File, typename... More>
std::vector<std::unique_ptr<File>> MakeViewFiles(const DetectionHeader& header,
                                                 const std::string& extension,
                                                 const AtomicFolder& folder,
                                                 const More&... more) {
  std::vector<std::unique_ptr<File>> files;
  for (const std::string& view : header.view_names) {
    CheckFileName(view, "view");
    files.push_back(
        std::make_unique<File>(folder.PathOf(view + extension), more...));
  }
  return files;
}

// Readers of JSON take truth.json in a folder for something else: a view of
// that name is refused. `format` completes "cannot be written as ...".
inline void RefuseViewTruth(const DetectionHeader& header,
                            const std::string& format) {
  for (const std::string& view : header.view_names) {
    if (view == "truth") {
      throw InputError("the view 'truth' cannot be written as " + format);
    }
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_VIEW_FILES_H_
