// Runs readers on arbitrary bytes.
#ifndef KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_
#define KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace kinegraph::testing {

// A temporary path (in TMPDIR) that is unique to this process and ends in
// `end`; whatever exists there is removed on construction and destruction.
class TemporaryPath {
 public:
  explicit TemporaryPath(const std::string& end)
      : path_(std::filesystem::temp_directory_path() /
              ("kinegraph_fuzz_" + std::to_string(getpid()) + end)) {
    Remove();
  }
  ~TemporaryPath() { Remove(); }
  TemporaryPath(const TemporaryPath&) = delete;
  TemporaryPath& operator=(const TemporaryPath&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  void Remove() const {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  const std::filesystem::path path_;
};

// A file with these bytes.
class InputFile : public TemporaryPath {
 public:
  explicit InputFile(const std::string& bytes) : TemporaryPath("_file") {
    std::ofstream file(path(), std::ios::binary);
    if (!(file << bytes).flush()) std::abort();
  }
};

// A folder with the files that the bytes list: each begins with a line
// "=== NAME". Files whose name might lead outside the folder, is longer than 79
// bytes or has unusual characters are ignored.
class InputFolder : public TemporaryPath {
 public:
  static constexpr const char* kFileMark = "=== ";

  explicit InputFolder(const std::string& bytes) : TemporaryPath("_folder") {
    std::filesystem::create_directory(path());
    std::istringstream lines(bytes);
    std::ofstream file;
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind(kFileMark, 0) == 0) {
        file = std::ofstream();
        const std::string name = line.substr(std::strlen(kFileMark));
        if (!IsWithin(name)) continue;
        std::error_code ignored;
        std::filesystem::create_directories((path() / name).parent_path(),
                                            ignored);
        file.open(path() / name, std::ios::binary | std::ios::trunc);
      } else if (file.is_open()) {
        file << line << '\n';
      }
    }
  }

 private:
  static bool IsWithin(const std::string& name) {
    return !name.empty() && name.size() < 80 && name.front() != '/' &&
           name.find("..") == std::string::npos &&
           name.find_first_not_of(
               "abcdefghijklmnopqrstuvwxyz"
               "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
               "0123456789_-./") == std::string::npos;
  }
};

// Runs `act`; false if it throws Refusal, an exception meant for users, whose
// message must be one line.
template <typename Refusal = InputError, typename Act>
bool Accepts(const Act& act) {
  try {
    act();
    return true;
  } catch (const Refusal& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  }
  return false;
}

// Whether `read(path)` accepts a file with these bytes, or such a folder
// (InputFolder). Readers may also reject their options, with OptionError, if
// the input does not match them.
template <typename Input = InputFile, typename Read>
bool Reading(const std::string& bytes, const Read& read) {
  const Input input(bytes);
  bool is_read = false;
  Accepts<OptionError>(
      [&] { is_read = Accepts([&] { read(input.path().string()); }); });
  return is_read;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_FUZZ_INPUT_FILE_H_
