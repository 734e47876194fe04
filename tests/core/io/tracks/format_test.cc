#include "core/io/tracks/format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/base/error.h"
#include "core/io/file_kind.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

TEST(TrackFormats, NamesAndExtensionsAreTakenOnce) {
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
    if (format.files == TrackFormat::Files::kFileAPerson) {
      EXPECT_FALSE(format.person_extension.empty()) << format.name;
    }
  }
  EXPECT_EQ(FindTrackFormat("auto"), nullptr);
  EXPECT_EQ(TrackFormatOfExtension("csv"), nullptr);
}

// So no order of the registry's lines matters.
TEST(TrackFormats, EveryResultIsRecognisedByItsOwnFormatAlone) {
  for (const TrackFormat& written : TrackFormats()) {
    if (written.write == nullptr) continue;
    const TemporaryFolder folder;
    const std::string path = folder.path() / "result";
    testing::WriteAs(written.name, path, testing::RandomTracks(Coco17()));
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
    // BVH tells its own, with the joints that it adds.
    if (written.name != "bvh") options.skeleton = Coco17();
    const TrackSequence read = ReadTracks(path, options);
    const TrackFormat* of_mode = FindTrackFormat(read.header.mode);
    // Ours keeps the mode of who made the tracks.
    EXPECT_TRUE(of_mode == nullptr || of_mode == &written) << written.name;
    // Some leave out the frame that has nobody.
    EXPECT_GE(read.frames.size(), 9u) << written.name;
  }
}

TEST(TrackFormats, AnUnknownNameIsRefusedWithThoseThereAre) {
  TrackReadOptions options;
  options.format = "trk";
  std::string message;
  try {
    ReadTracks("/nowhere", options);
  } catch (const OptionError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("'trk'"));
  EXPECT_THAT(message, HasSubstr("kinegraph, csv, npz, trc"));
}

}  // namespace
}  // namespace kinegraph
