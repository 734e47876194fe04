#include "core/io/tracks/format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/io/conversion.h"
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/writer.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/rig.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::WriteAs;

TEST(TrackFormats, NamesAndExtensionsAreUnique) {
  std::set<std::string> names;
  std::set<std::string> extensions;
  for (const TrackFormat& format : TrackFormats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_FALSE(format.layout.empty()) << format.name;
    EXPECT_TRUE(format.read != nullptr || format.write != nullptr)
        << format.name;
    EXPECT_EQ(FindTrackFormat(format.name), &format);
    for (const std::string& extension : format.extensions) {
      EXPECT_TRUE(extensions.insert(extension).second) << extension;
      EXPECT_EQ(TrackFormatOfExtension("a/b" + extension), &format);
      EXPECT_THAT(TrackExtensions(), HasSubstr(extension));
    }
  }
  EXPECT_EQ(FindTrackFormat("auto"), nullptr);
  EXPECT_EQ(TrackFormatOfExtension("csv"), nullptr);
}

// Programs on Windows may write .TRC.
TEST(TrackFormats, ExtensionsMayBeCapitals) {
  EXPECT_EQ(TrackFormatOfExtension("a/TAKE.GLB"), FindTrackFormat("gltf"));
  const TemporaryFolder folder;
  const TrackSequence tracks = testing::RandomTracks(Coco17());
  const std::string path = folder.path() / "people";
  WriteAs("trc", path, tracks);
  for (const std::string& name : ListFolder(path)) {
    const std::string stem = name.substr(0, name.size() - 4);
    std::filesystem::rename(path + "/" + name, path + "/" + stem + ".TRC");
  }
  EXPECT_EQ(RecogniseKind(path), FileKind::kTracks);
  EXPECT_EQ(ReadTracks(path).frames.size(), tracks.frames.size());
  ConversionOptions conversion;
  conversion.in = path;
  conversion.out = folder.path() / "TAKE.TRC";
  EXPECT_THAT(testing::InputErrorOf([&] { Convert(conversion); }),
              HasSubstr("choose one with --person"));
}

// Recognition does not depend on the order of TrackFormats().
TEST(TrackFormats, OnlyTheWrittenFormatRecognisesAFile) {
  for (const TrackFormat& written : TrackFormats()) {
    if (written.write == nullptr) continue;
    const TemporaryFolder folder;
    const std::string path = folder.path() / "result";
    WriteAs(written.name, path, testing::RandomTracks(Coco17()));
    const TrackHead head = LookAtTracks(path);
    for (const TrackFormat& format : TrackFormats()) {
      if (format.recognise == nullptr) continue;
      EXPECT_EQ(format.recognise(head), &format == &written)
          << written.name << " by " << format.name;
    }
    if (written.read == nullptr) continue;
    EXPECT_EQ(RecogniseKind(path), FileKind::kTracks) << written.name;
    TrackReadOptions options;
    options.frame_rate_hz = 25.0;
    // BVH has its own skeleton, with the joints that it adds.
    if (written.name != "bvh") options.skeleton = Coco17();
    const TrackSequence read = ReadTracks(path, options);
    const TrackFormat* of_mode = FindTrackFormat(read.header.mode);
    // kinegraph's format stores the mode with which the tracks were made.
    EXPECT_TRUE(of_mode == nullptr || of_mode == &written) << written.name;
    // Some formats omit the frame without people.
    EXPECT_GE(read.frames.size(), 9u) << written.name;
  }
}

TEST(TrackFormats, ErrorForAnUnknownNameListsKnownNames) {
  TrackReadOptions options;
  options.format = "trk";
  EXPECT_THAT([&] { ReadTracks("/nowhere", options); },
              ::testing::ThrowsMessage<OptionError>(::testing::AllOf(
                  HasSubstr("'trk'"), HasSubstr("kinegraph, csv, npz, trc"))));
}

TEST(TrackFormats, ErrorForTheFirstFrameStatesBothLimits) {
  for (const int64_t first : {int64_t{-1}, kMaxFrame + 1}) {
    TrackReadOptions options;
    options.first_frame = first;
    EXPECT_THAT([&] { ReadTracks("/nowhere", options); },
                ::testing::ThrowsMessage<OptionError>(
                    HasSubstr("from 0 to 1125899906842624")))
        << first;
  }
}

// ---- names of people ----

// Persons 3 and 12 stand for two frames.
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

// A name that needs escaping in cells, arrays and keys.
const PersonNames kNames = {{TrackId(12), "=Anna, \"A\" Ö_2"}};

TEST(PersonNames, AreKeptInJsonLinesCsvAndNpz) {
  for (const PersonNames& names : {kNames, PersonNames()}) {
    for (const std::string format : {"kinegraph", "csv", "npz"}) {
      const TemporaryFolder folder;
      const std::string path = folder.path() / "tracks";
      WriteAs(format, path, Tracks(), {std::nullopt, names});
      EXPECT_EQ(ReadPersonNames(path), names) << format;
      // Names do not disturb the reading of the tracks.
      const TrackSequence read = ReadTracks(path);
      ASSERT_EQ(read.frames.size(), 2u) << format;
      ASSERT_EQ(read.frames[1].people.size(), 2u) << format;
      EXPECT_EQ(read.frames[1].people[1].id, TrackId(12)) << format;
    }
  }
  const TemporaryFolder folder;
  EXPECT_TRUE(ReadPersonNames(folder.Write("text.txt", "nothing\n")).empty());
}

// Empty lines are skipped, and NaN is read as null.
TEST(PersonNames, AreReadLikeTheTracks) {
  const TemporaryFolder folder;
  const std::string path =
      folder.Write("tracks.jsonl",
                   "\n{\"kinegraph\": 1, \"skeleton\": {\"name\": \"one\", "
                   "\"joints\": [\"nose\"], \"bones\": []}, \"frame_rate\": "
                   "NaN, \"names\": {\"12\": \"Anna\"}, \"config\": "
                   "{\"gate\": NaN, \"lag\": 0.2}}\n");
  EXPECT_EQ(ReadPersonNames(path), (PersonNames{{TrackId(12), "Anna"}}));
  const TrackSequence tracks = ReadTracks(path);
  EXPECT_EQ(tracks.header.config_json, "{\"gate\":null,\"lag\":0.2}");
  EXPECT_NO_THROW(WriteTracks(folder.path() / "again.jsonl", tracks));
}

// 40 characters of three bytes each; a file name contains at most 100 bytes of
// a name, thus 33 characters.
TEST(PersonNames, LongNamesAreCutBetweenCharacters) {
  std::string name;
  for (int i = 0; i < 40; ++i) name += "\u6f22";
  const TemporaryFolder folder;
  const std::string path = folder.path() / "trc";
  WriteAs("trc", path, Tracks(),
          {AxisMap::Parse("x,y,z"), {{TrackId(12), name}}});
  EXPECT_EQ(ReadPersonNames(path),
            (PersonNames{{TrackId(12), name.substr(0, 99)}}));
}

TEST(PersonNames, ArePartOfFileNames) {
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
    // People are in the order of the file names.
    ASSERT_EQ(read.frames[0].people.size(), 2u);
    EXPECT_EQ(read.frames[0].people[0].id, TrackId(12));
    EXPECT_EQ(read.frames[0].people[1].id, TrackId(3));
  }
}

TEST(PersonNames, InvalidNamesAreRefused) {
  const TemporaryFolder folder;
  for (const char* names : {"{\"Anna\": 3}", "{\"x\": \"Anna\"}", "[1]", "7"}) {
    const std::string path = folder.Write(
        "tracks.jsonl",
        "{\"kinegraph\": 1, \"names\": " + std::string(names) + "}\n");
    EXPECT_THROW(ReadPersonNames(path), InputError) << names;
  }
  const std::string table =
      folder.Write("a.csv",
                   "frame,time_s,id,joint,x_m,y_m,z_m,status,name\n"
                   "1,0,2,\"nose");
  EXPECT_THAT(testing::InputErrorOf([&] { ReadPersonNames(table); }),
              HasSubstr("a.csv: line 2"));
}

}  // namespace
}  // namespace kinegraph
