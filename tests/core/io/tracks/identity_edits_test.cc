#include "core/io/tracks/identity_edits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/io/files/side_files.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

TEST(IdentityEditsTest, RoundTrip) {
  IdentityEdit join;
  join.op = EditOp::kJoin;
  join.persons = {TrackId(3), TrackId(7)};
  join.frames = FrameSpan{131, 120};  // the two overlap in time
  join.evidence = {{"bones", 6.125}, {"gap_s", -0.44}};
  join.margin = 8.5;
  IdentityEdit name;
  name.op = EditOp::kName;
  name.persons = {TrackId(3)};
  name.name = "Anna \"A\" Ö";
  TemporaryFolder folder;
  const std::string path = (folder.path() / "take.identity.jsonl").string();
  WriteIdentityEdits(path, {join, name});
  const std::vector<IdentityEdit> read = ReadIdentityEdits(path);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].op, EditOp::kJoin);
  EXPECT_EQ(read[0].persons, join.persons);
  EXPECT_EQ(read[0].frames->first, 131);
  EXPECT_EQ(read[0].frames->last, 120);
  EXPECT_EQ(read[0].evidence, join.evidence);
  EXPECT_EQ(read[0].margin, 8.5);
  EXPECT_EQ(read[1].op, EditOp::kName);
  EXPECT_EQ(read[1].name, name.name);
  EXPECT_FALSE(read[1].frames.has_value());
  EXPECT_EQ(read[1].place, path + ": line 2");
}

TEST(IdentityEditsTest, BlankLinesAndTheFingerprintAreSkipped) {
  TemporaryFolder folder;
  const std::string edit =
      "{\"op\": \"delete\", \"persons\": [1], \"frames\": [0, 5]}\r\n  \n";
  std::string path = folder.Write("edits.jsonl", "\n" + edit);
  std::vector<IdentityEdit> read = ReadIdentityEdits(path);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].place, path + ": line 2");
  const std::string digits(32, 'a');
  path = (folder.path() / "a.identity.jsonl").string();
  WriteIdentityEdits(path, read, digits);
  EXPECT_EQ(FingerprintIn(path), digits);
  EXPECT_EQ(ReadIdentityEdits(path).size(), 1u);
}

TEST(IdentityEditsTest, ErrorsNameTheLineAndKey) {
  for (const auto& [line, expected] :
       std::vector<std::pair<std::string, std::string>>{
           {R"({"op": "glue", "persons": [1, 2]})", "op"},
           {R"({"persons": [1, 2]})", "op"},
           {R"({"op": "join"})", "persons"},
           {R"({"op": "join", "persons": []})", "persons"},
           {R"({"op": "join", "persons": [1, -2]})", "person"},
           {R"({"op": "join", "persons": [1, 2], "frame": [1, 2]})", "frame"},
           {R"({"op": "cut", "persons": [1], "frames": [9, 8]})",
            "empty range"},
           {R"({"op": "cut", "persons": [1], "frames": [9]})", "frames"},
           {R"({"op": "cut", "persons": [1])", "line 2"}}) {
    const TemporaryFolder folder;
    const std::string path =
        folder.Write("edits.jsonl", R"({"op": "join", "persons": [0, 1]})"
                                    "\n" +
                                        line + "\n");
    EXPECT_THAT(
        testing::InputErrorOf([&] { ReadIdentityEdits(path); }),
        AllOf(HasSubstr(path), HasSubstr("line 2"), HasSubstr(expected)))
        << line;
  }
}

TEST(IdentityEditsTest, PathIsBesideTheTracks) {
  EXPECT_EQ(BesideTracks("out/take.jsonl", kIdentityEnd),
            "out/take.identity.jsonl");
  EXPECT_EQ(BesideTracks("out.v2/take/", kIdentityEnd),
            "out.v2/take.identity.jsonl");
  EXPECT_EQ(BesideTracks("take.csv", kIdentityEnd), "take.identity.jsonl");
}

}  // namespace
}  // namespace kinegraph
