// Where tests find external data, the project's own files, and a folder to
// write to.
#ifndef KINEGRAPH_TESTS_SUPPORT_TEST_DATA_H_
#define KINEGRAPH_TESTS_SUPPORT_TEST_DATA_H_

#include <filesystem>
#include <optional>
#include <string>

namespace kinegraph::testing {

// The folder of real data: $KINEGRAPH_DATA, else ../shared/data from the
// project's root. `relative` names a file or folder in it; nullopt if it does
// not exist.
std::optional<std::filesystem::path> FindData(const std::string& relative);

// A file of the project, by its path from the root.
std::filesystem::path ProjectFile(const std::string& relative);

// The folder of the build, where programs are (apps/kinegraph-track).
std::filesystem::path BuildFile(const std::string& relative);

// An empty folder for this test alone, removed when the object dies.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  // Writes `content` to a file of that name and returns its path.
  std::string Write(const std::string& name, const std::string& content) const;

 private:
  std::filesystem::path path_;
};

}  // namespace kinegraph::testing

// Sets `path` to the data's place or skips the test, saying what is missing.
#define KINEGRAPH_DATA_OR_SKIP(path, relative)                        \
  std::string path;                                                   \
  if (const auto found_ = ::kinegraph::testing::FindData(relative)) { \
    path = found_->string();                                          \
  } else {                                                            \
    GTEST_SKIP() << "needs real data '" << (relative)                 \
                 << "' (set KINEGRAPH_DATA)";                         \
  }                                                                   \
  static_assert(true, "")

#endif  // KINEGRAPH_TESTS_SUPPORT_TEST_DATA_H_
