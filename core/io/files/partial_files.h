// What is being written and does not have its final name yet. AtomicFile,
// AtomicFolder and OutputFolder keep this list; a program that is told to stop
// removes what is on it.
#ifndef KINEGRAPH_CORE_IO_FILES_PARTIAL_FILES_H_
#define KINEGRAPH_CORE_IO_FILES_PARTIAL_FILES_H_

#include <string>

namespace kinegraph {

// One list a process. Every function is safe in any thread; those that return
// an int give -1 and errno when the system refuses.
class PartialFiles {
 public:
  // Makes a new file (open with O_EXCL, so a planted link is never followed) or
  // a new folder, and puts it on the list.
  static int OpenNew(const std::string& path);
  static int MakeFolder(const std::string& path);
  // The same for a folder that is to stay once anything is in it.
  static int MakeFolderToFill(const std::string& path);

  // Removes what runs that were killed have left of the file or folder
  // `target`, TARGET.partial-PROCESS-N, where that process is no more and
  // nobody holds a lock on it. A folder is looked through once a process.
  static void SweepLeftovers(const std::string& target);

  // Gives a file or folder its final name and takes it off the list.
  static int Rename(const std::string& path, const std::string& final_name);
  // Removes it with all that is in it (a folder to fill: only if it is empty)
  // and takes it off the list.
  static void Remove(const std::string& path);

  // Whether the path leads into a folder on the list, which becomes visible as
  // a whole.
  static bool IsInsideFolder(const std::string& path);

  // Removes everything on the list. No file is made or renamed any more: who
  // tries waits for ever, so the program must end now.
  static void RemoveAllForGood();
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_PARTIAL_FILES_H_
