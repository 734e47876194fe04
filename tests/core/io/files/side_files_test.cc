#include "core/io/files/side_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

class SideFilesTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  size_t FileCount() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(folder_.path()), {}));
  }
  static void Write(const std::string& path, const std::string& text) {
    AtomicFile file(path);
    file.Write(text);
    file.Commit();
  }

  testing::TemporaryFolder folder_;
};

TEST_F(SideFilesTest, AreFoundBesideTheirOwnTracksAlone) {
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
  EXPECT_EQ(SideFileOf(tracks, kBiasEnd, &notes), "") << "is not there";
  EXPECT_EQ(notes.size(), 1u);
}

TEST_F(SideFilesTest, TheFingerprintStandsFirst) {
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

TEST_F(SideFilesTest, OfAFolderCountsNamesAndBytes) {
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

TEST_F(SideFilesTest, ACommitOfSeveralShowsAllOrNothing) {
  {
    CommitTogether together;
    Write(Path("a.jsonl"), "tracks");
    Write(Path("a.summary.json"), "{}");
    EXPECT_FALSE(fs::exists(Path("a.jsonl")));
    EXPECT_EQ(FingerprintOfTracks(together.WaitingAt(Path("a.jsonl"))),
              FingerprintOfTracks(folder_.Write("same", "tracks")));
  }
  EXPECT_EQ(FileCount(), 1u) << "nothing but the file to compare with";
  folder_.Write("a.bias.json", "of an older run");
  CommitTogether together;
  Write(Path("a.jsonl"), "tracks");
  Write(Path("a.summary.json"), "{}");
  together.RemoveOld(Path("a.bias.json"));
  together.Commit();
  EXPECT_TRUE(fs::exists(Path("a.jsonl")));
  EXPECT_TRUE(fs::exists(Path("a.summary.json")));
  EXPECT_FALSE(fs::exists(Path("a.bias.json")));
}

TEST_F(SideFilesTest, WhatCannotBeRenamedTakesTheRestBack) {
  CommitTogether together;
  Write(Path("a.jsonl"), "tracks");
  Write(Path("a.summary.json"), "{}");
  // A folder of that name has appeared meanwhile.
  fs::create_directories(Path("a.jsonl/in"));
  EXPECT_THROW(together.Commit(), std::runtime_error);
  EXPECT_FALSE(fs::exists(Path("a.summary.json")));
}

TEST_F(SideFilesTest, LeftoversOfProcessesThatAreNoMoreAreSwept) {
  // No process has this number: Linux stops at 4,194,304.
  folder_.Write("a.jsonl.partial-5000000-0", "half");
  folder_.Write("b.jsonl.partial-5000000-0", "of another result");
  const std::string mine = "a.jsonl.partial-1-0";  // of a process that runs
  folder_.Write(mine, "being written");
  Write(Path("a.jsonl"), "tracks");
  EXPECT_FALSE(fs::exists(Path("a.jsonl.partial-5000000-0")));
  EXPECT_TRUE(fs::exists(Path("b.jsonl.partial-5000000-0")));
  EXPECT_TRUE(fs::exists(Path(mine)));
}

}  // namespace
}  // namespace kinegraph
