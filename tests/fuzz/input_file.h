// What a reader makes of some bytes.
#ifndef KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_
#define KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "core/base/options.h"

namespace kinegraph::testing {

// A file among the temporary ones (TMPDIR): HDF5 opens none without a name, as
// memfd_create's are.
class InputFile {
 public:
  InputFile(const uint8_t* bytes, size_t size)
      : path_(std::filesystem::temp_directory_path() /
              ("kinegraph_fuzz_" + std::to_string(getpid()))) {
    std::ofstream file(path_, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes),
               static_cast<std::streamsize>(size));
    if (!file.flush()) std::abort();
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::string path() const { return path_; }

 private:
  const std::filesystem::path path_;
};

// Runs `read` on a file with these bytes, false where it refuses them; only
// what a user is told may be thrown, in one line.
template <typename Read>
bool Reading(const uint8_t* bytes, size_t size, const Read& read) {
  const InputFile file(bytes, size);
  try {
    read(file.path());
    return true;
  } catch (const InputError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  } catch (const OptionError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  }
  return false;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_
