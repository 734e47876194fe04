// Which files a command has read, so that it does not write over one of them,
// and notices when one changes while it is at work; and ending a stream of
// input that has no end of its own.
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

class InputStop {
 public:
  // Input counts as ended once there is anything to read from `descriptor`,
  // which somebody else (a handler of signals) writes to. At most one a
  // process; -1 takes it back.
  static void ListenTo(int descriptor);

  // Waits until `descriptor` has something to read or is at its end; false
  // when the input is to count as ended. True at once where nobody listens.
  static bool WaitForInput(int descriptor);

  // Whether the input counts as ended; what stands before it may be cut short.
  static bool HasHappened();
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_
