// Numbers in files do not depend on the program's locale: some write 0,5.
#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <filesystem>
#include <locale>
#include <string>
#include <utility>
#include <vector>

#include "core/io/calibration.h"
#include "core/io/calibration_writer.h"
#include "core/io/detection_source.h"
#include "core/io/detection_writer.h"
#include "core/io/track_format.h"
#include "core/io/tracks.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "tests/support/program.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

class Commas : public std::numpunct<char> {
 protected:
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// The locale of streams, and that of C where the system has a German one.
class InCommas {
 public:
  InCommas()
      : before_(std::locale::global(
            std::locale(std::locale::classic(), new Commas))) {
    std::setlocale(LC_NUMERIC, "de_DE.UTF-8");
  }
  ~InCommas() {
    std::setlocale(LC_NUMERIC, "C");
    std::locale::global(before_);
  }
  InCommas(const InCommas&) = delete;
  InCommas& operator=(const InCommas&) = delete;

 private:
  const std::locale before_;
};

struct Sample {
  Scene scene;
  DetectionSequence detections;
  TrackSequence tracks;
};

Sample MakeSample() {
  SceneOptions options;
  options.people = 1;
  options.motion.visitors = 0.0;
  options.duration_s = 0.2;
  Sample sample;
  sample.scene = MakeScene(options);
  ObservationTruth truth;
  sample.detections = Observe(sample.scene, NoiseOptions(), &truth);
  sample.tracks = TruthOf(sample.scene);
  return sample;
}

// Every file of a result by its name in it.
using Files = std::vector<std::pair<std::string, std::string>>;
Files FilesOf(const fs::path& path) {
  Files files;
  if (!fs::is_directory(path)) return {{"", testing::ContentOf(path)}};
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    files.emplace_back(fs::relative(entry.path(), path).string(),
                       testing::ContentOf(entry.path()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(Locale, TracksAreTheSameFiles) {
  const Sample sample = MakeSample();
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    SCOPED_TRACE(format.name);
    const TemporaryFolder folder;
    const std::string plain = (folder.path() / "plain").string();
    const std::string commas = (folder.path() / "commas").string();
    Losses losses;
    format.write(plain, sample.tracks, {}, &losses);
    {
      const InCommas in_commas;
      format.write(commas, sample.tracks, {}, &losses);
      if (format.read != nullptr) {
        TrackReadOptions options;
        options.format = format.name;
        EXPECT_EQ(ReadTracks(commas, options).frames.size(),
                  sample.tracks.frames.size());
      }
    }
    EXPECT_EQ(FilesOf(plain), FilesOf(commas));
  }
}

TEST(Locale, CamerasAndDetectionsAreTheSameFiles) {
  const Sample sample = MakeSample();
  const TemporaryFolder folder;
  for (const CalibrationFormat format : WritableCalibrationFormats()) {
    if (format == CalibrationFormat::kTum) continue;  // refuses lenses
    const auto name = std::to_string(static_cast<int>(format));
    SCOPED_TRACE(name);
    const std::string plain = (folder.path() / ("plain" + name)).string();
    const std::string commas = (folder.path() / ("commas" + name)).string();
    Losses losses;
    WriteCalibration(plain, format, sample.scene.cameras, &losses);
    const CameraRig read = ReadCameras(plain);
    const InCommas in_commas;
    WriteCalibration(commas, format, sample.scene.cameras, &losses);
    EXPECT_EQ(FilesOf(plain), FilesOf(commas));
    const CameraRig again = ReadCameras(plain);
    ASSERT_EQ(again.size(), read.size());
    for (size_t c = 0; c < read.size(); ++c) {
      EXPECT_EQ(again[c].parameters().K, read[c].parameters().K);
      EXPECT_EQ(again[c].parameters().t, read[c].parameters().t);
    }
  }
  const std::string plain = (folder.path() / "plain.jsonl").string();
  const std::string commas = (folder.path() / "commas.jsonl").string();
  WriteDetections(plain, sample.detections);
  const InCommas in_commas;
  WriteDetections(commas, sample.detections);
  EXPECT_EQ(FilesOf(plain), FilesOf(commas));
  const DetectionSequence read = ReadDetections(commas);
  ASSERT_EQ(read.frames.size(), sample.detections.frames.size());
  EXPECT_EQ(read.frames[0].views[0].detections.at(0).joints[0].px,
            sample.detections.frames[0].views[0].detections.at(0).joints[0].px);
}

}  // namespace
}  // namespace kinegraph
