#include "tests/support/test_data.h"

#include <stdlib.h>  // mkdtemp

#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace kinegraph::testing {

namespace fs = std::filesystem;

std::optional<fs::path> FindData(const std::string& relative) {
  const char* configured = std::getenv("KINEGRAPH_DATA");
  const fs::path root = configured != nullptr && *configured != '\0'
                            ? fs::path(configured)
                            : fs::path(KINEGRAPH_SOURCE_DIR) / "../shared/data";
  fs::path path = root / relative;
  if (!fs::exists(path)) return std::nullopt;
  return path;
}

fs::path ProjectFile(const std::string& relative) {
  return fs::path(KINEGRAPH_SOURCE_DIR) / relative;
}

fs::path BuildFile(const std::string& relative) {
  return fs::path(KINEGRAPH_BINARY_DIR) / relative;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern =
      (fs::temp_directory_path() / "kinegraph_test_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw std::runtime_error("cannot make a folder like " + pattern);
  }
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string TemporaryFolder::Write(const std::string& name,
                                   const std::string& content) const {
  const fs::path file = path_ / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << content;
  return file.string();
}

}  // namespace kinegraph::testing
