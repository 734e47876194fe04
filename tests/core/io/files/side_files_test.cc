#include "core/io/files/side_files.h"

#include <gtest/gtest.h>
#include <unistd.h>  // geteuid

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

class SideFilesTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  testing::TemporaryFolder folder_;
};

TEST_F(SideFilesTest, AreUsedOnlyWithMatchingTracks) {
  const std::string tracks = folder_.Write("a.jsonl", "tracks\n");
  const std::string other = folder_.Write("b.jsonl", "other tracks\n");
  const std::string stamped =
      WithFingerprint("{\"people\": 3}\n", FingerprintOfTracks(tracks));
  folder_.Write("a.summary.json", stamped);
  folder_.Write("b.summary.json", stamped);
  std::vector<std::string> notes;
  EXPECT_EQ(SideFileOf(tracks, kSummaryEnd, &notes), Path("a.summary.json"));
  EXPECT_TRUE(notes.empty());
  EXPECT_EQ(SideFileOf(other, kSummaryEnd, &notes), "");
  EXPECT_EQ(notes.size(), 1u);
  EXPECT_EQ(SideFileOf(tracks, kBiasEnd, &notes), "") << "does not exist";
  EXPECT_EQ(notes.size(), 1u);
}

TEST_F(SideFilesTest, FingerprintIsTheFirstKey) {
  const std::string digits(32, '7');
  EXPECT_EQ(WithFingerprint("{\n \"a\": 1}", digits),
            "{\"tracks_fingerprint\": \"" + digits + "\", \n \"a\": 1}");
  EXPECT_EQ(WithFingerprint("{}", digits),
            "{\"tracks_fingerprint\": \"" + digits + "\"}");
  EXPECT_EQ(WithFingerprint("{\"a\": 1}", ""), "{\"a\": 1}");
  EXPECT_EQ(FingerprintIn(folder_.Write("x", WithFingerprint("{}", digits))),
            digits);
  for (const char* text :
       {"", "{", "{}", "[]", "{\"tracks_fingerprint\"",
        "{\"tracks_fingerprint\": 7}", "{\"tracks_fingerprint\": \"77\"}"}) {
    EXPECT_EQ(FingerprintIn(folder_.Write("y", text)), "") << text;
  }
}

TEST_F(SideFilesTest, FolderFingerprintDependsOnNamesAndBytes) {
  const auto of = [&](const std::string& name, const std::string& text) {
    const fs::path folder = folder_.path() / "people";
    fs::remove_all(folder);
    fs::create_directory(folder);
    std::ofstream(folder / name) << text;
    return FingerprintOfTracks(folder.string());
  };
  const std::string one = of("person_0.trc", "x");
  EXPECT_EQ(of("person_0.trc", "x"), one);
  EXPECT_NE(of("person_1.trc", "x"), one);
  EXPECT_NE(of("person_0.trc", "y"), one);
}

TEST_F(SideFilesTest, IgnoresLinksToNothingAndThrowsForLinkLoops) {
  const fs::path folder = folder_.path() / "people";
  fs::create_directory(folder);
  const std::string empty = FingerprintOfTracks(folder.string());
  fs::create_symlink("nothing", folder / "a");
  EXPECT_EQ(FingerprintOfTracks(folder.string()), empty);
  fs::create_symlink("b", folder / "b");  // to itself
  EXPECT_THROW(FingerprintOfTracks(folder.string()), InputError);
}

TEST_F(SideFilesTest, ThrowsForAFolderThatCannotBeListed) {
  if (geteuid() == 0) GTEST_SKIP() << "root may list anything";
  const fs::path folder = folder_.path() / "people";
  fs::create_directory(folder);
  fs::permissions(folder, fs::perms::none);
  EXPECT_THROW(FingerprintOfTracks(folder.string()), InputError);
  fs::permissions(folder, fs::perms::owner_all);
}

}  // namespace
}  // namespace kinegraph
