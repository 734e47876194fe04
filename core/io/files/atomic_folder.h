// A folder of files that appears under its name only when it is complete.
#ifndef KINEGRAPH_CORE_IO_FILES_ATOMIC_FOLDER_H_
#define KINEGRAPH_CORE_IO_FILES_ATOMIC_FOLDER_H_

#include <memory>
#include <string>
#include <vector>

#include "core/system/file.h"

namespace kinegraph {

// Files are written into a folder beside the final name, which Commit()
// renames. Destroyed without Commit(), it leaves nothing. A folder that holds
// files already is never replaced: who knows what else is in it.
//
//   AtomicFolder folder(path);
//   WriteSomething(folder.PathOf("a.txt"));
//   folder.Commit();
class AtomicFolder {
 public:
  // Throws InputError when `path` is there and is no empty folder, or when no
  // folder can be made beside it.
  explicit AtomicFolder(const std::string& path);
  ~AtomicFolder();
  AtomicFolder(const AtomicFolder&) = delete;
  AtomicFolder& operator=(const AtomicFolder&) = delete;

  // Where a file or folder of the result is to be written.
  std::string PathOf(const std::string& name) const {
    return temporary_ + "/" + name;
  }

  // Makes the folder appear. Throws std::runtime_error when it cannot.
  void Commit();

 private:
  std::string target_;
  std::string temporary_;
  std::unique_ptr<Descriptor> lock_;  // on it, while it is written
  bool committed_ = false;
};

// A folder that is filled file by file and may be there already, with other
// things in it. Of the folders that had to be made, those in which nothing was
// put are gone when the object dies.
class OutputFolder {
 public:
  // Makes the folder and those above it. Throws InputError naming `path`.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  std::string PathOf(const std::string& name) const {
    return path_ + "/" + name;
  }

 private:
  void RemoveEmpty();

  const std::string path_;
  std::vector<std::string> made_;  // from the outermost on
};

// Throws InputError naming `what` ("view") when `name` cannot be the name of a
// file: empty, hidden, with a slash or a control character, or too long.
void CheckFileName(const std::string& name, const std::string& what);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_ATOMIC_FOLDER_H_
