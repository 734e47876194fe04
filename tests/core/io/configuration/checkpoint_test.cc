#include "core/io/configuration/checkpoint.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/io/configuration/checkpoint_values.h"
#include "core/synthetic/scene.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::TemporaryFolder;

std::string Key(const std::string& name) { return FingerprintOf(name); }

TEST(Checkpoint, WhatWasAddedIsFoundByTheNextRun) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  const std::string value("\0\n\xff and more", 12);
  {
    Checkpoint first(path, "build", false, 0.0);
    EXPECT_FALSE(first.Find(Key("a")).has_value());
    first.Add(Key("a"), value);
    first.Add(Key("b"), "");
    EXPECT_EQ(first.Find(Key("a")), value);  // in the very run, too
  }
  Checkpoint second(path, "build", true, 0.0);
  EXPECT_EQ(second.Find(Key("a")), value);
  EXPECT_EQ(second.Find(Key("b")), "");
  EXPECT_FALSE(second.Find(Key("c")).has_value());
  EXPECT_EQ(second.found_count(), 2);
  second.Add(Key("c"), "third");
  second.Remove();
  EXPECT_FALSE(std::filesystem::exists(path));
}

// At every length at which a kill could have cut it.
TEST(Checkpoint, WhatIsCutOffIsNotThere) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  {
    Checkpoint whole(path, "build", false, 0.0);
    whole.Add(Key("a"), "first");
    whole.Add(Key("b"), "second");
  }
  const auto size = static_cast<int64_t>(std::filesystem::file_size(path));
  // Head 56 bytes; a record is 32 + 8 + 4 bytes and its value.
  constexpr int64_t kHead = 23 + 33;
  constexpr int64_t kFirst = kHead + 44 + 5;
  ASSERT_EQ(size, kFirst + 44 + 6);
  for (int64_t length = size; length >= kHead; --length) {
    SCOPED_TRACE(length);
    std::filesystem::resize_file(path, static_cast<uintmax_t>(length));
    Checkpoint rest(path, "build", true, 0.0);
    EXPECT_EQ(rest.Find(Key("a")).has_value(), length >= kFirst);
    EXPECT_EQ(rest.Find(Key("b")).has_value(), length == size);
  }
}

// Killed between making the file and writing its head.
TEST(Checkpoint, AnEmptyOneIsNone) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  std::ofstream(path).flush();
  ASSERT_TRUE(std::filesystem::exists(path));
  {
    Checkpoint resumed(path, "build", true, 0.0);
    EXPECT_FALSE(resumed.Find(Key("a")).has_value());
    resumed.Add(Key("a"), "first");
  }
  EXPECT_EQ(Checkpoint(path, "build", true, 0.0).Find(Key("a")), "first");
}

TEST(Checkpoint, AChangedByteIsAMiss) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  { Checkpoint(path, "build", false, 0.0).Add(Key("a"), "first"); }
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-1, std::ios::end);
    file.put('T');
  }
  Checkpoint rest(path, "build", true, 0.0);
  EXPECT_FALSE(rest.Find(Key("a")).has_value());
}

TEST(Checkpoint, AnotherBuildAndStrangeFilesAreRefused) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  { Checkpoint(path, "build", false, 0.0).Add(Key("a"), "first"); }
  EXPECT_THROW(Checkpoint(path, "other build", true, 0.0), InputError);
  const std::string notes = folder.Write("notes", "my notes");
  EXPECT_THROW(Checkpoint(notes, "build", true, 0.0), InputError);
  Checkpoint without(notes, "build", false, 0.0);
  without.Add(Key("a"), "first");
  EXPECT_FALSE(without.trouble().empty());
  EXPECT_EQ(std::filesystem::file_size(notes), 8u);  // untouched
  // A planted link is not followed.
  const std::string link = (folder.path() / "link").string();
  std::filesystem::create_symlink(notes, link);
  Checkpoint linked(link, "build", false, 0.0);
  linked.Add(Key("a"), "first");
  EXPECT_EQ(std::filesystem::file_size(notes), 8u);
}

TEST(Checkpoint, TwoRunsNeverShareOne) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  Checkpoint first(path, "build", false, 0.0);
  first.Add(Key("a"), "first");
  EXPECT_THROW(Checkpoint(path, "build", true, 0.0), InputError);
  Checkpoint second(path, "build", false, 0.0);
  second.Add(Key("b"), "second");
  EXPECT_FALSE(second.trouble().empty());
  EXPECT_EQ(first.Find(Key("a")), "first");
}

TEST(Checkpoint, ShortWorkLeavesNoFile) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "c").string();
  Checkpoint checkpoint(path, "build", false, 3600.0);
  checkpoint.Add(Key("a"), "first");
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Checkpoint, EveryBitOfTracksComesBack) {
  SceneOptions options;
  options.people = 2;
  options.duration_s = 0.2;
  options.motion.visitors = 0.0;
  TrackSequence tracks = TruthOf(MakeScene(options));
  PersonPose& person = tracks.frames.front().people.front();
  person.score = 0.1 + 0.2;
  person.inlier_views = {3, 0, 5};
  person.covariances = {std::nullopt, Eigen::Matrix3d::Random()};
  person.matches = {{2, 7, {std::nullopt, 1.0 / 3.0}}};
  person.joints[4].status = JointStatus::kMissing;
  ByteWriter writer;
  Put(tracks.frames, &writer);
  ByteReader reader(writer.bytes());
  const std::vector<TrackFrame> back = GetTrackFrames(&reader);
  EXPECT_TRUE(reader.done());
  ByteWriter again;
  Put(back, &again);
  EXPECT_EQ(again.bytes(), writer.bytes());
  const PersonPose& same = back.front().people.front();
  EXPECT_EQ(same.score, person.score);
  EXPECT_EQ(same.inlier_views, person.inlier_views);
  ASSERT_EQ(same.covariances.size(), 2u);
  EXPECT_FALSE(same.covariances[0].has_value());
  EXPECT_EQ(*same.covariances[1], *person.covariances[1]);
  EXPECT_EQ(same.matches[0].weights, person.matches[0].weights);
  EXPECT_EQ(same.joints[4].status, JointStatus::kMissing);
  EXPECT_EQ(same.joints[5].position_m, person.joints[5].position_m);
  // Cut bytes are refused and read nothing beyond their end.
  for (size_t length = 0; length < writer.bytes().size(); length += 97) {
    ByteReader cut(std::string_view(writer.bytes()).substr(0, length));
    EXPECT_THROW(GetTrackFrames(&cut), InputError);
  }
}

}  // namespace
}  // namespace kinegraph
