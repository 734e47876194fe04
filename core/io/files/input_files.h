// Which files a command has read, so that it does not write over one of them,
// and notices when one changes while it is at work.
#ifndef KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_
#define KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_

#include <string>

namespace kinegraph {

// A command says once that what it reads is to be protected; the readers then
// note every file, and AtomicFile refuses to replace one of them, under
// whatever name it is reached: device and inode are compared. A program that
// uses the library may read and write one file in turn: without Protect()
// nothing is noted. Safe in any thread.
class InputFiles {
 public:
  static void Protect();

  // An open file that is being read. Regular files count, the first 65,536 of
  // them, so that a long recording needs no more memory than a short one.
  // Called again, at the end of the file or when it is read once more, it
  // throws InputError where size or time of change are no longer what they
  // were.
  static void Note(int descriptor, const std::string& path);

  // A file of the command's own making is no input: to be called before it is
  // removed or written anew.
  static void Forget(const std::string& path);

  // Whether the path leads to a file that was noted.
  static bool Has(const std::string& path);
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_
