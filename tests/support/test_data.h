// Paths of external data, of the project's files and of temporary folders.
#ifndef KINEGRAPH_TESTS_SUPPORT_TEST_DATA_H_
#define KINEGRAPH_TESTS_SUPPORT_TEST_DATA_H_

#include <filesystem>
#include <optional>
#include <string>

namespace kinegraph::testing {

// A file or folder, `relative` to the folder of real data: $KINEGRAPH_DATA,
// otherwise ../shared/data from the project's root; nullopt if it does not
// exist.
std::optional<std::filesystem::path> FindData(const std::string& relative);

// A file of the project, by its path from the root.
std::filesystem::path ProjectFile(const std::string& relative);

// A file of the build folder, such as apps/kinegraph-track.
std::filesystem::path BuildFile(const std::string& relative);

// A new empty folder, removed by the destructor.
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

// Defines the string `path`, the path of the data, or skips the test with a
// message.
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
