// What a reader makes of some bytes.
#ifndef KINEGRAPH_TESTS_FUZZ_MEMORY_FILE_H_
#define KINEGRAPH_TESTS_FUZZ_MEMORY_FILE_H_

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/base/options.h"

namespace kinegraph::testing {

// A file that is in memory alone.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* bytes, size_t size)
      : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
    while (size > 0) {
      const ssize_t written = write(descriptor_, bytes, size);
      if (written <= 0) std::abort();
      bytes += written;
      size -= static_cast<size_t>(written);
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const {
    return "/proc/self/fd/" + std::to_string(descriptor_);
  }

 private:
  const int descriptor_;
};

// Runs `read` on a file with these bytes; only what a user is told may be
// thrown, in one line.
template <typename Read>
void Reading(const uint8_t* bytes, size_t size, const Read& read) {
  const MemoryFile file(bytes, size);
  try {
    read(file.path());
  } catch (const InputError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  } catch (const OptionError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  }
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_FUZZ_MEMORY_FILE_H_
