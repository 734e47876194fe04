#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using testing::TemporaryFolder;
using testing::WriteAs;

// Persons 3 and 12, who stand for two frames.
TrackSequence Tracks() {
  TrackSequence tracks;
  tracks.header.skeleton = Coco17();
  tracks.header.mode = "graph";
  tracks.header.frame_rate_hz = 25.0;
  for (const int64_t f : {5, 6}) {
    TrackFrame& frame = tracks.frames.emplace_back();
    frame.frame = f;
    frame.time = f * 40'000'000;
    for (const int64_t id : {3, 12}) {
      PersonPose& person = frame.people.emplace_back();
      person.id = TrackId(id);
      person.joints = testing::StandingPerson(0.1 * id, 0.0);
    }
  }
  return tracks;
}

// What a careless cell, array or key would spoil.
const PersonNames kNames = {{TrackId(12), "=Anna, \"A\" Ö_2"}};

TEST(PersonNames, AreKeptInJsonLinesCsvAndNpz) {
  for (const PersonNames& names : {kNames, PersonNames()}) {
    for (const std::string format : {"kinegraph", "csv", "npz"}) {
      const TemporaryFolder folder;
      const std::string path = folder.path() / "tracks";
      WriteAs(format, path, Tracks(), {std::nullopt, names});
      EXPECT_EQ(ReadPersonNames(path), names) << format;
      // Who reads no names reads the tracks all the same.
      const TrackSequence read = ReadTracks(path);
      ASSERT_EQ(read.frames.size(), 2u) << format;
      ASSERT_EQ(read.frames[1].people.size(), 2u) << format;
      EXPECT_EQ(read.frames[1].people[1].id, TrackId(12)) << format;
    }
  }
  const TemporaryFolder folder;
  EXPECT_TRUE(ReadPersonNames(folder.Write("text.txt", "nothing\n")).empty());
}

TEST(PersonNames, StandInTheNamesOfPeoplesFiles) {
  const TemporaryFolder folder;
  for (const std::string format : {"trc", "bvh"}) {
    const std::string path = folder.path() / format;
    WriteAs(format, path, Tracks(),
            {AxisMap::Parse("x,y,z"), {{TrackId(12), "Anna P_7/Ö"}}});
    if (format == "trc") {
      EXPECT_TRUE(testing::OpenSimReads(path));
    }
    EXPECT_EQ(ReadPersonNames(path),
              (PersonNames{{TrackId(12), "Anna-P-7-Ö"}}));
    const TrackSequence read = ReadTracks(path);
    // In the order of the files' names.
    ASSERT_EQ(read.frames[0].people.size(), 2u);
    EXPECT_EQ(read.frames[0].people[0].id, TrackId(12));
    EXPECT_EQ(read.frames[0].people[1].id, TrackId(3));
  }
}

TEST(PersonNames, WrongOnesAreNamed) {
  const TemporaryFolder folder;
  for (const char* names : {"{\"Anna\": 3}", "{\"x\": \"Anna\"}", "[1]", "7"}) {
    const std::string path = folder.Write(
        "tracks.jsonl",
        "{\"kinegraph\": 1, \"names\": " + std::string(names) + "}\n");
    EXPECT_THROW(ReadPersonNames(path), InputError) << names;
  }
}

}  // namespace
}  // namespace kinegraph
