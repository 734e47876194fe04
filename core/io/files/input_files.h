// InputFiles records the files that a command has read, to prevent overwriting
// them and to detect changes while it runs. InputStop ends endless input
// streams.
#ifndef KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_
#define KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_

#include <cstddef>
#include <string>

namespace kinegraph {

// After Protect() readers note every file, and AtomicFile refuses to replace
// any of them, whatever its name: device and inode are compared. Without
// Protect() nothing is noted, since a program that uses the library may read
// and write a file alternately. Thread-safe.
class InputFiles {
 public:
  static void Protect();

  static constexpr size_t kMaxFiles = 1 << 16;

  // Notes an open file that is being read: only regular files, and at most
  // kMaxFiles of them, so that memory does not depend on the length of a
  // recording. Readers call it again at the end of the file or when they read
  // it again; throws InputError if size or modification time have changed since
  // the first call with this path.
  static void Note(int descriptor, const std::string& path);

  // Call this before a file written by this command is removed or rewritten: it
  // is not an input even if the command has read it.
  static void Forget(const std::string& path);

  // Whether the path leads to a file that was noted.
  static bool Has(const std::string& path);
};

class InputStop {
 public:
  // Input counts as ended once `descriptor` becomes readable: it is the reading
  // end of a pipe to which another part of the program (a signal handler)
  // writes. At most one per process; -1 removes it.
  static void ListenTo(int descriptor);

  // Waits until `descriptor` is readable or at its end; false if the input
  // counts as ended. Returns true at once without ListenTo.
  static bool WaitForInput(int descriptor);

  // Whether the input counts as ended; the last line before it may be
  // incomplete.
  static bool HasHappened();
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_INPUT_FILES_H_
