#include "core/io/files/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/side_files.h"
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
using ::testing::UnorderedElementsAre;

class AtomicFilesTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  std::vector<std::string> Names() const {
    return ListFolder(folder_.path().string());
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(AtomicFilesTest, AppearOnlyWhenCommitted) {
  {
    AtomicFile file(Path("out.txt"));
    file.Write("first ");
    file.Write("second");
    EXPECT_FALSE(fs::exists(Path("out.txt")));
    file.Commit();
    AtomicFile(Path("lost.txt")).Write("half");
  }
  EXPECT_EQ(ReadTextFile(Path("out.txt")), "first second");
  EXPECT_THAT(Names(), ElementsAre("out.txt"));
}

TEST_F(AtomicFilesTest, PermissionsFollowTheUmask) {
  const mode_t before = umask(022);
  WriteTextFile(Path("out.txt"), "");
  umask(before);
  EXPECT_EQ(fs::status(Path("out.txt")).permissions(),
            static_cast<fs::perms>(0644));
}

TEST_F(AtomicFilesTest, PathMustBeAFileInAnExistingFolder) {
  for (const std::string& path :
       {Path(""), Path("none/out.txt"), std::string()}) {
    EXPECT_THROW(AtomicFile{path}, InputError) << path;
  }
}

// A folder appears as a whole and replaces only an empty folder.
TEST_F(AtomicFilesTest, AFolderAppearsWhenCommitted) {
  const auto write_in = [](const AtomicFolder& folder) {
    WriteTextFile(folder.PathOf("a.txt"), "text");
  };
  const std::string path = Path("result");
  fs::create_directory(path);
  {
    AtomicFolder folder(path + "//");
    write_in(folder);
    EXPECT_THAT(ListFolder(path), IsEmpty());
    folder.Commit();
    AtomicFolder lost(Path("lost"));
    write_in(lost);
  }
  EXPECT_THAT(Names(), ElementsAre("result"));
  EXPECT_THAT(ListFolder(path), ElementsAre("a.txt"));
  for (const auto& [name, says] :
       {std::pair<std::string, const char*>{path, "exists already"},
        {path + "/a.txt", "exists already"},
        {path + "/no/where", "cannot be created"},
        {"", "empty name"}}) {
    EXPECT_THAT(InputErrorOf([&name = name] { AtomicFolder folder(name); }),
                HasSubstr(says));
  }
  EXPECT_THAT(ListFolder(path), ElementsAre("a.txt"));
}

TEST_F(AtomicFilesTest, CommitOfSeveralFilesIsAllOrNothing) {
  {
    AtomicFiles files;
    WriteTextFile(files.Aside(Path("a.jsonl")), "tracks");
    WriteTextFile(files.Aside(Path("a.summary.json")), "{}");
    EXPECT_FALSE(fs::exists(Path("a.jsonl")));
    EXPECT_EQ(FingerprintOfTracks(files.Aside(Path("a.jsonl"))),
              FingerprintOfTracks(folder_.Write("same", "tracks")));
  }
  EXPECT_THAT(Names(), ElementsAre("same"));
  folder_.Write("a.bias.json", "of an older run");
  AtomicFiles files;
  WriteTextFile(files.Aside(Path("a.jsonl")), "tracks");
  WriteTextFile(files.Aside(Path("a.summary.json")), "{}");
  fs::create_directory(files.FolderAside(Path("pictures")));
  files.RemoveOld(Path("a.bias.json"));
  files.Commit();
  EXPECT_THAT(Names(), UnorderedElementsAre("a.jsonl", "a.summary.json",
                                            "pictures", "same"));
}

TEST_F(AtomicFilesTest, KeepLinksAndPermissionsAndWriteStreamsDirectly) {
  folder_.Write("real.jsonl", "old");
  fs::permissions(Path("real.jsonl"),
                  fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real.jsonl", Path("link.jsonl"));
  AtomicFiles files;
  EXPECT_EQ(files.Aside("/dev/null"), "/dev/null");
  files.RemoveOld(Path("link.jsonl"));
  WriteTextFile(files.Aside(Path("link.jsonl")), "new");
  files.Commit();
  EXPECT_TRUE(fs::is_symlink(Path("link.jsonl")));
  EXPECT_EQ(ReadTextFile(Path("real.jsonl")), "new");
  EXPECT_EQ(fs::status(Path("link.jsonl")).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(AtomicFilesTest, InvalidPathsAreRefusedBeforeWriting) {
  folder_.Write("full/a", "");
  folder_.Write("file", "");
  AtomicFiles files;
  for (const auto& [name, says] : {std::pair{Path("full"), "is a folder"},
                                   {Path("none/a.json"), "cannot be written"},
                                   {std::string(), "empty name"}}) {
    EXPECT_THAT(InputErrorOf([&, &name = name] { files.Aside(name); }),
                HasSubstr(says));
  }
  for (const char* name : {"full", "file"}) {
    EXPECT_THAT(InputErrorOf([&] { files.FolderAside(Path(name)); }),
                HasSubstr("exists already"));
  }
}

// The first file is renamed last. If this fails, the file of that name is the
// old one and does not match the fingerprints in the other files.
TEST_F(AtomicFilesTest, TheFirstFileAppearsLast) {
  AtomicFiles files;
  const std::string tracks = files.Aside(Path("a.jsonl"));
  WriteTextFile(tracks, "tracks");
  const std::string fingerprint = FingerprintOfTracks(tracks);
  WriteTextFile(files.Aside(Path("a.summary.json")),
                WithFingerprint("{}", fingerprint));
  // A folder of that name has appeared meanwhile.
  folder_.Write("a.jsonl/in", "older");
  EXPECT_THROW(files.Commit(), std::runtime_error);
  EXPECT_EQ(FingerprintIn(Path("a.summary.json")), fingerprint);
  EXPECT_NE(FingerprintOfTracks(Path("a.jsonl")), fingerprint);
}

TEST(ReadBytes, ReturnsEveryByte) {
  const testing::TemporaryFolder folder;
  std::string content(300000, 'x');  // more than one read
  content[1000] = '\0';
  content.back() = '\r';
  for (const std::string& bytes : {content, "\xef\xbb\xbf" + content}) {
    EXPECT_EQ(ReadBytes(folder.Write("a", bytes)), bytes);
  }
  EXPECT_EQ(ReadBytes(folder.Write("b", "")), "");
}

TEST(ReadTextFile, RemovesByteOrderMarksAndConvertsOldMacLineEnds) {
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

TEST(ReadTextFile, ErrorsNameTheFile) {
  const testing::TemporaryFolder folder;
  const std::string missing = (folder.path() / "none").string();
  for (const std::string& path : {missing, folder.path().string()}) {
    EXPECT_THAT(InputErrorOf([&] { ReadTextFile(path); }),
                ::testing::StartsWith(path));
  }
  EXPECT_THROW(ReadTextFile(folder.Write("big", std::string(101, 'x')), 100),
               InputError);
  EXPECT_EQ(ReadTextFile((folder.path() / "big").string(), 101).size(), 101u);
}

}  // namespace
}  // namespace kinegraph
