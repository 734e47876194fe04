#include "core/io/files/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

int FilesIn(const fs::path& folder) {
  return static_cast<int>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "out.txt").string();
  AtomicFile file(path);
  file.Write("first ");
  file.Write("second");
  EXPECT_FALSE(fs::exists(path));
  file.Commit();
  EXPECT_EQ(ReadTextFile(path), "first second");
  EXPECT_EQ(FilesIn(folder.path()), 1);
}

TEST(AtomicFile, LeavesNothingWithoutCommit) {
  const testing::TemporaryFolder folder;
  { AtomicFile((folder.path() / "out.txt").string()).Write("half"); }
  EXPECT_EQ(FilesIn(folder.path()), 0);
}

TEST(AtomicFile, HasThePermissionsOfTheUmask) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "out.txt").string();
  const mode_t before = umask(022);
  AtomicFile file(path);
  file.Commit();
  umask(before);
  EXPECT_EQ(fs::status(path).permissions(), static_cast<fs::perms>(0644));
}

TEST(AtomicFile, RefusesFoldersAndMissingFolders) {
  const testing::TemporaryFolder folder;
  EXPECT_THROW(AtomicFile(folder.path().string()), InputError);
  EXPECT_THROW(AtomicFile((folder.path() / "none" / "out.txt").string()),
               InputError);
  EXPECT_THROW(AtomicFile(""), InputError);
}

TEST(ReadBytes, GivesEveryByte) {
  const testing::TemporaryFolder folder;
  std::string content(300000, 'x');  // more than one read
  content[1000] = '\0';
  content.back() = '\r';
  for (const std::string& bytes : {content, "\xef\xbb\xbf" + content}) {
    EXPECT_EQ(ReadBytes(folder.Write("a", bytes)), bytes);
  }
  EXPECT_EQ(ReadBytes(folder.Write("b", "")), "");
}

TEST(ReadTextFile, CutsMarksAndEndsLinesOfOldMacs) {
  const testing::TemporaryFolder folder;
  for (const auto& [bytes, text] :
       {std::pair<std::string, std::string>{"a\nb", "a\nb"},
        {"\xef\xbb\xbf"
         "a\r\nb",
         "a\r\nb"},
        {"a\rb\r", "a\nb\n"},
        {"\xef\xbb\xbf"
         "a\rb",
         "a\nb"},
        {"a\r\"b\r\"\n", "a\r\"b\r\"\n"},
        {"\xef\xbb\xbf", ""}}) {
    const std::string path = folder.Write("a", bytes);
    EXPECT_EQ(ReadTextFile(path), text);
    EXPECT_EQ(BeginningOf(path, 100), text);
  }
  for (const char* bytes : {"\xff\xfe"
                            "a",
                            "\xfe\xff"
                            "a",
                            "\x1f\x8b\x08"}) {
    const std::string path = folder.Write("a", bytes);
    EXPECT_THROW(ReadTextFile(path), InputError);
    EXPECT_THROW(BeginningOf(path, 100), InputError);
  }
}

TEST(ReadTextFile, NamesWhatItCannotRead) {
  const testing::TemporaryFolder folder;
  const std::string missing = (folder.path() / "none").string();
  for (const std::string& path : {missing, folder.path().string()}) {
    try {
      ReadTextFile(path);
      ADD_FAILURE() << "expected an error";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).rfind(path, 0), 0u) << error.what();
    }
  }
  EXPECT_THROW(ReadTextFile(folder.Write("big", std::string(101, 'x')), 100),
               InputError);
  EXPECT_EQ(ReadTextFile((folder.path() / "big").string(), 101).size(), 101u);
}

}  // namespace
}  // namespace kinegraph
