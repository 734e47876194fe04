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
#include <sstream>
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

// A folder among the temporary ones with the files that the bytes list: each
// begins with a line "=== NAME". Names lead to no place outside.
class InputFolder {
 public:
  static constexpr const char* kFileMark = "=== ";

  InputFolder(const uint8_t* bytes, size_t size)
      : path_(std::filesystem::temp_directory_path() /
              ("kinegraph_fuzz_" + std::to_string(getpid()) + "_folder")) {
    std::filesystem::create_directory(path_);
    std::istringstream lines(
        std::string(reinterpret_cast<const char*>(bytes), size));
    std::ofstream file;
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind(kFileMark, 0) == 0) {
        file = std::ofstream();
        const std::string name = line.substr(std::strlen(kFileMark));
        if (!IsWithin(name)) continue;
        std::error_code ignored;
        std::filesystem::create_directories((path_ / name).parent_path(),
                                            ignored);
        file.open(path_ / name, std::ios::binary | std::ios::trunc);
      } else if (file.is_open()) {
        file << line << '\n';
      }
    }
  }
  ~InputFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  std::string path() const { return path_; }

 private:
  static bool IsWithin(const std::string& name) {
    return !name.empty() && name.size() < 80 && name.front() != '/' &&
           name.find("..") == std::string::npos &&
           name.find_first_not_of(
               "abcdefghijklmnopqrstuvwxyz"
               "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
               "0123456789_-./") == std::string::npos;
  }

  const std::filesystem::path path_;
};

// Runs `read` on a file with these bytes, or on a folder; false where it
// refuses them. Only what a user is told may be thrown, in one line.
template <typename Input = InputFile, typename Read>
bool Reading(const uint8_t* bytes, size_t size, const Read& read) {
  const Input input(bytes, size);
  try {
    read(input.path());
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
