// Limits of what is read (sizes are checked against the bytes before memory is
// allocated), of identities and names, and of the files that may be written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/data/limits.h"
#include "core/io/binary/npz_file.h"
#include "core/io/calibration/calibration.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/io/files/text_file.h"
#include "core/io/text/csv_rows.h"
#include "core/io/text/json.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/mat_file.h"
#include "tests/support/processor_time.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::MatArray;
using testing::MatFile;
using testing::ProcessorTime;
using testing::ProjectFile;
using testing::TemporaryFolder;
using testing::WriteAs;

// The limit, 5 s of processor time, is far above the time of a rejection and
// far below the time of reading data of the declared size.
void ExpectQuick(const ProcessorTime& used) { EXPECT_LT(used.Seconds(), 5.0); }

// ---- YAML

TEST(YamlBounds, StrayCommasAndBracketsAreRefusedQuickly) {
  const TemporaryFolder folder;
  const ProcessorTime used;
  for (const char* text :
       {"%YAML:1.0\n---\n,", "%YAML:1.0\n---\nnames: 1\n,",
        "%YAML:1.0\n---\n,,", "%YAML:1.0\n---\nK: 1\n...\n,\n---\n",
        "%YAML:1.0\n---\n]", ","}) {
    const std::string path = folder.Write("a.yml", text);
    EXPECT_THAT(InputErrorOf([&] { ReadCameras(path); }), HasSubstr("a.yml"))
        << text;
  }
  ExpectQuick(used);
}

TEST(YamlBounds, ManyCommasDoNotExhaustMemory) {
  const TemporaryFolder folder;
  const ProcessorTime used;
  const std::string path = folder.Write(
      "a.yml", "%YAML:1.0\n---\na: [" + std::string(2'000'000, ',') + "]\n");
  EXPECT_THAT(InputErrorOf([&] { ReadCameras(path); }),
              AnyOf(HasSubstr("too many values"), HasSubstr("is not YAML")));
  ExpectQuick(used);
}

// A hundred thousand aliases of a text of one kilobyte exceed the limit of 16
// MiB.
TEST(YamlBounds, AliasesCountTowardsTheLimit) {
  const TemporaryFolder folder;
  const ProcessorTime used;
  std::string many = "a: &a \"" + std::string(1000, 'x') + "\"\nb: [";
  for (int i = 0; i < 100'000; ++i) many += "*a,";
  const std::string path = folder.Write("a.yml", many + "0]\n");
  EXPECT_THAT(InputErrorOf([&] { ReadCameras(path); }),
              HasSubstr("a.yml:2: has too many values"));
  ExpectQuick(used);
  EXPECT_EQ(ParseYaml("a: &a [1, x]\nb: [*a, *a]\n", "a.yml"),
            ParseYaml("a: [1, x]\nb: [[1, x], [1, x]]\n", "a.yml"));
  EXPECT_THAT(InputErrorOf([] { ParseYaml("a: &a [*a]\n", "a.yml"); }),
              HasSubstr("refers to itself"));
}

TEST(YamlBounds, DepthIsLimited) {
  const ProcessorTime used;
  for (const char* open : {"[", "{a: ", "\n- "}) {
    std::string deep;
    for (int i = 0; i < 300'000; ++i) deep += open;
    EXPECT_THAT(InputErrorOf([&] { ParseYaml(deep, "a.yml"); }),
                AnyOf(HasSubstr("nested deeper"), HasSubstr("is not YAML"),
                      HasSubstr("has too many values")))
        << open;
  }
  ExpectQuick(used);
}

// ---- The pages of the documentation

TEST(Pages, StateTheLimitsOfNumbers) {
  const std::string limits = ReadTextFile(ProjectFile("docs/limits.md"));
  EXPECT_EQ(kMaxFrame, int64_t{1} << 50);
  EXPECT_THAT(limits, HasSubstr("| frame numbers | 0 to 2^50 |"));
  EXPECT_EQ(kMaxFrameRate_hz, 1'000'000.0);
  EXPECT_THAT(limits, HasSubstr("| frame rates | above 0 to 1,000,000 Hz |"));
  EXPECT_EQ(kMaxTime_s, 4.6e9);
  EXPECT_THAT(limits, HasSubstr("| times | -4.6e9 to 4.6e9 s;"));
  EXPECT_THAT(ReadTextFile(ProjectFile("docs/formats.md")),
              HasSubstr("a number, -4.6e9 to 4.6e9 s."));
}

DetectionSequence ReadDetectionsAs(const std::string& format,
                                   const std::string& bytes) {
  const TemporaryFolder folder;
  DetectionReadOptions options;
  options.format = format;
  return ReadDetections(folder.Write("a", bytes), options);
}

// ---- NPZ

template <typename Value>
void Append(Value value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string NpyOf(const std::string& type, const std::string& shape,
                  const std::string& data) {
  std::string dictionary = "{'descr': '" + type +
                           "', 'fortran_order': False, 'shape': " + shape +
                           ", }";
  dictionary.resize(118, ' ');
  std::string file = "\x93NUMPY";
  file += '\x01';
  file += '\0';
  Append(static_cast<uint16_t>(dictionary.size()), &file);
  return file + dictionary + data;
}

TEST(NpzBounds, CamerasWithoutFramesAreRefused) {
  const ProcessorTime used;
  EXPECT_THAT(InputErrorOf([&] {
                ReadDetectionsAs("freemocap",
                                 NpyOf("<f8", "(2000000000, 0, 17, 2)", ""));
              }),
              HasSubstr("expected the shape [cameras, frames, points, 2]"));
  ExpectQuick(used);
}

// An archive in which all names refer to the same file.
std::string Archive(const std::vector<std::string>& names,
                    const std::string& file) {
  std::string archive = "PK\x03\x04";
  archive.resize(30, '\0');
  archive += file;
  const size_t directory = archive.size();
  for (const std::string& name : names) {
    std::string entry = "PK\x01\x02";
    entry.resize(16, '\0');
    Append(Crc32(file), &entry);
    Append(static_cast<uint32_t>(file.size()), &entry);
    Append(static_cast<uint32_t>(file.size()), &entry);
    Append(static_cast<uint16_t>(name.size()), &entry);
    entry.resize(46, '\0');
    archive += entry + name;
  }
  std::string end = std::string("PK\x05\x06", 4) + std::string(6, '\0');
  Append(static_cast<uint16_t>(names.size()), &end);
  Append(static_cast<uint32_t>(archive.size() - directory), &end);
  Append(static_cast<uint32_t>(directory), &end);
  return archive + end + std::string(2, '\0');
}

TEST(NpzBounds, TextsWithoutBytesAreRefused) {
  const TemporaryFolder folder;
  const ProcessorTime used;
  const std::string path = folder.Write(
      "a.npz", Archive({"joints.npy"}, NpyOf("<U0", "(100000000,)", "")));
  EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }),
              HasSubstr("has the type '<U0'"));
  ExpectQuick(used);
}

TEST(NpzBounds, ArraysWithSharedBytesAreRefused) {
  const TemporaryFolder folder;
  const std::string file = NpyOf("<f8", "(2,)", std::string(16, '\0'));
  const std::string path =
      folder.Write("a.npz", Archive({"a.npy", "b.npy", "c.npy"}, file));
  EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }), HasSubstr("overlaps"));
}

TEST(NpzBounds, BonesMustReferToJoints) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "a.npz").string();
  const auto said_of = [&](const std::vector<size_t>& shape,
                           const std::vector<int64_t>& bones) {
    NpzFile file(path);
    file.Add("positions", {1, 1, 2, 3}, std::vector<double>(6, 1.0));
    file.Add("ids", {1}, std::vector<int64_t>{0});
    file.Add("frames", {1}, std::vector<int64_t>{0});
    file.AddTexts("joints", {2}, {"a", "b"});
    file.AddTexts("skeleton", {}, {"two"});
    file.Add("bones", shape, bones);
    file.Commit();
    return InputErrorOf([&] { ReadTracks(path); });
  };
  // 2^32 + 1 is joint 1 when truncated to an int.
  EXPECT_THAT(said_of({1, 2}, {0, (int64_t{1} << 32) + 1}),
              HasSubstr("bones: found 4294967297, expected 0 .. 1"));
  EXPECT_THAT(said_of({1, 2}, {0, -1}),
              HasSubstr("bones: found -1, expected 0 .. 1"));
  EXPECT_THAT(said_of({1, 3}, {0, 1, 0}), HasSubstr("bones: expected [.., 2]"));
}

// ---- .mat

std::string ActorArray(uint32_t array_class, int32_t rows, int32_t columns,
                       const std::string& content) {
  return MatArray(array_class, rows, columns, "actor3D", content);
}

std::string Packed(const std::string& element) {
  std::string packed(compressBound(element.size()), '\0');
  uLongf length = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()), &length,
           reinterpret_cast<const Bytef*>(element.data()), element.size());
  packed.resize(length);
  std::string bytes;
  Append(uint32_t{15}, &bytes);
  Append(static_cast<uint32_t>(length), &bytes);
  return bytes + packed;
}

TEST(MatBounds, DimensionsMustMatchTheData) {
  constexpr uint32_t kCell = 1;
  constexpr uint32_t kStruct = 2;
  constexpr uint32_t kDouble = 6;
  const TemporaryFolder folder;
  const ProcessorTime used;
  for (const uint32_t array_class : {kCell, kStruct, kDouble}) {
    const std::string element =
        ActorArray(array_class, 100'000'000, 20, std::string(1500, '\0'));
    for (const std::string& content : {element, Packed(element)}) {
      const std::string path = folder.Write("a.mat", MatFile(content));
      EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }), HasSubstr("a.mat"))
          << array_class;
    }
  }
  ExpectQuick(used);
}

// A text, and the imaginary part of a number, whose tags state more bytes than
// the file has.
TEST(MatBounds, TagsMustBeFollowedByData) {
  constexpr uint32_t kChar = 4;
  constexpr uint32_t kComplexDouble = 0x800 | 6;
  std::string parts;
  for (const uint32_t length : {8u, 2768241048u}) {
    Append(uint32_t{9}, &parts);  // doubles
    Append(length, &parts);
    parts += std::string(8, '\0');
  }
  const TemporaryFolder folder;
  for (const std::string& element :
       {ActorArray(kChar, 2577, 0, parts.substr(16)),
        ActorArray(kComplexDouble, 1, 1, parts)}) {
    const std::string path =
        folder.Write("a.mat", MatFile(ActorArray(1, 1, 1, element)));
    EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }), HasSubstr("a.mat"));
  }
}

TEST(MatBounds, ReadsPlainAndCompressedFiles) {
  const TemporaryFolder folder;
  Pose3d pose(14);
  for (Joint3d& joint : pose) joint = {{1.0, 2.0, 3.0}, JointStatus::kObserved};
  const std::string plain = testing::ActorsGroundTruth({{{2, pose}}}, 5);
  const std::string packed = plain.substr(0, 128) + Packed(plain.substr(128));
  for (const std::string& content : {plain, packed}) {
    const TrackSequence tracks = ReadTracks(folder.Write("a.mat", content));
    ASSERT_EQ(tracks.frames.size(), 5u);
    EXPECT_EQ(tracks.frames[2].people.size(), 1u);
    // Truncation is detected.
    for (const size_t length : {size_t{128}, content.size() / 2}) {
      const std::string path =
          folder.Write("cut.mat", content.substr(0, length));
      EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }), HasSubstr("cut.mat"))
          << length;
    }
  }
}

TEST(MatBounds, DeeplyNestedCellsAreRefused) {
  std::string element;
  for (int depth = 0; depth < 100; ++depth) {
    element = ActorArray(1, 1, 1, element);
  }
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.mat", MatFile(element));
  EXPECT_THAT(InputErrorOf([&] { ReadTracks(path); }),
              AnyOf(HasSubstr("actor3D{1}{1}: expected 14 x 3"),
                    HasSubstr("is truncated or damaged")));
}

// ---- Identities and names

TrackSequence OnePerson(int64_t id, const std::string& joint) {
  TrackSequence tracks;
  tracks.header.skeleton = Skeleton("one", {joint, "b"}, {});
  tracks.header.frame_rate_hz = 25.0;
  TrackFrame frame;
  PersonPose person;
  person.id = TrackId(id);
  person.joints = {{{1, 2, 3}, JointStatus::kObserved}, {}};
  frame.people.push_back(person);
  tracks.frames.push_back(frame);
  return tracks;
}

int64_t FirstIdIn(const std::string& path, const std::string& format) {
  TrackReadOptions options;
  options.format = format;
  options.skeleton = OnePerson(0, "a").header.skeleton;
  return ReadTracks(path, options).frames.at(0).people.at(0).id.value();
}

TEST(IdBounds, LargeIdsRoundTrip) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "out").string();
  constexpr int64_t kId = (int64_t{1} << 62) + 1;
  for (const std::string format : {"csv", "npz", "4da"}) {
    WriteAs(format, path, OnePerson(kId, "a"));
    EXPECT_EQ(FirstIdIn(path, format), kId) << format;
  }
}

TEST(IdBounds, RenumberingIsReported) {
  for (const auto& [format, first_lost] :
       std::vector<std::pair<std::string, int64_t>>{
           {"longcw", int64_t{1} << 31}, {"trc", 1'000'000'000'000'000'000}}) {
    for (const int64_t id : {first_lost - 1, first_lost}) {
      const TemporaryFolder folder;
      const std::string path = (folder.path() / "out").string();
      const LostFields lost_fields = WriteAs(format, path, OnePerson(id, "a"));
      const auto said = std::count_if(
          lost_fields.begin(), lost_fields.end(), [](const std::string& loss) {
            return loss.find("number people anew") != std::string::npos;
          });
      EXPECT_EQ(said, id == first_lost ? 1 : 0) << format << id;
      EXPECT_EQ(FirstIdIn(path, format), id == first_lost ? 0 : id);
    }
  }
}

TEST(CsvCells, AreEscapedAgainstFormulas) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "a.csv").string();
  for (const std::string name :
       {"=1+1", "+a", "-a", "@a", "\ta", "'=a", "'a", "=a,\"b\"", "a=b", "'"}) {
    WriteAs("csv", path, OnePerson(1, name));
    EXPECT_EQ(ReadTracks(path).header.skeleton.joints().at(0), name);
    const std::string cell = CsvCell(name);
    const char first = cell[cell[0] == '"' ? 1 : 0];
    EXPECT_EQ(std::string("=+-@\t").find(first), std::string::npos) << cell;
  }
}

TEST(SkeletonBounds, TooManyJointsAreRefusedQuickly) {
  const ProcessorTime used;
  std::vector<std::string> joints;
  for (int j = 0; j < 100'000; ++j) joints.push_back(std::to_string(j));
  EXPECT_THROW(Skeleton("many", joints, {}), OptionError);
  ExpectQuick(used);
}

// ---- Files

TEST(AtomicFileBounds, RefusesReadOnlyFiles) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anything";
  const TemporaryFolder folder;
  const std::string path = folder.Write("a", "old");
  chmod(path.c_str(), 0444);
  EXPECT_THAT(InputErrorOf([&] { AtomicFile file(path); }),
              HasSubstr("Permission denied"));
}

TEST(AtomicFileBounds, CircularLinksAreRefused) {
  const TemporaryFolder folder;
  fs::create_symlink("b", folder.path() / "a");
  fs::create_symlink("a", folder.path() / "b");
  EXPECT_THAT(
      InputErrorOf([&] { AtomicFile file((folder.path() / "a").string()); }),
      HasSubstr("symbolic links"));
}

TEST(OutputFolderTest, IsRemovedIfEmpty) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "a" / "b").string();
  { const OutputFolder made(path); }
  EXPECT_FALSE(fs::exists(folder.path() / "a"));
  {
    const OutputFolder made(path + "/");
    std::ofstream(made.PathOf("file")) << "content";
  }
  EXPECT_TRUE(fs::exists(path + "/file"));
  { const OutputFolder there(path); }
  EXPECT_TRUE(fs::exists(path + "/file"));
  EXPECT_THAT(InputErrorOf([&] { OutputFolder file(path + "/file"); }),
              HasSubstr("is a file"));
  EXPECT_THAT(InputErrorOf([&] { OutputFolder file(path + "/file/c"); }),
              HasSubstr("cannot be created"));
}

}  // namespace
}  // namespace kinegraph
