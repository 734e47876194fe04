#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/io/files/atomic_file.h"
#include "core/io/files/text_file.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

void WriteIn(const AtomicFolder& folder, const std::string& name) {
  AtomicFile file(folder.PathOf(name));
  file.Write("text");
  file.Commit();
}

TEST(AtomicFolder, AppearsWhenCommitted) {
  const TemporaryFolder temporary;
  const std::string path = temporary.path() / "result";
  {
    AtomicFolder folder(path + "//");
    WriteIn(folder, "a.txt");
    EXPECT_FALSE(fs::exists(path));
    folder.Commit();
  }
  EXPECT_THAT(ListFolder(temporary.path().string()), ElementsAre("result"));
  EXPECT_THAT(ListFolder(path), ElementsAre("a.txt"));
}

TEST(AtomicFolder, LeavesNothingWithoutCommit) {
  const TemporaryFolder temporary;
  {
    AtomicFolder folder(temporary.path() / "result");
    WriteIn(folder, "a.txt");
  }
  EXPECT_THAT(ListFolder(temporary.path().string()), IsEmpty());
}

TEST(AtomicFolder, TakesAnEmptyFolderAndNoOther) {
  const TemporaryFolder temporary;
  const std::string path = temporary.path() / "result";
  fs::create_directory(path);
  {
    AtomicFolder folder(path);
    WriteIn(folder, "a.txt");
    folder.Commit();
  }
  EXPECT_THAT(ListFolder(path), ElementsAre("a.txt"));
  EXPECT_THAT(InputErrorOf([&] { AtomicFolder folder(path); }),
              HasSubstr("is there already"));
  EXPECT_THAT(InputErrorOf([&] { AtomicFolder folder(path + "/a.txt"); }),
              HasSubstr("is there already"));
  EXPECT_THAT(InputErrorOf([&] { AtomicFolder folder(path + "/no/where"); }),
              HasSubstr("cannot be made"));
  EXPECT_THAT(InputErrorOf([&] { AtomicFolder folder(""); }),
              HasSubstr("empty name"));
  EXPECT_THAT(ListFolder(path), ElementsAre("a.txt"));
}

}  // namespace
}  // namespace kinegraph
