// Numbers in files do not depend on the program's locale: some write 0,5.
#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <filesystem>
#include <locale>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"
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

struct LocaleSample {
  Scene scene;
  DetectionSequence detections;
  TrackSequence tracks;
};

LocaleSample MakeSample() {
  SceneOptions options;
  options.people = 1;
  options.motion.visitors = 0.0;
  options.duration_s = 0.2;
  LocaleSample sample;
  sample.scene = MakeScene(options);
  ObservationTruth truth;
  sample.detections = Observe(sample.scene, NoiseOptions(), &truth);
  sample.tracks = TruthOf(sample.scene);
  return sample;
}

// Every file of a result by its name in it.
using Written = std::vector<std::pair<std::string, std::string>>;
Written FilesOf(const fs::path& path) {
  Written files;
  if (!fs::is_directory(path)) return {{"", testing::ContentOf(path)}};
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (!entry.is_regular_file()) continue;
    files.emplace_back(fs::relative(entry.path(), path).string(),
                       testing::ContentOf(entry.path()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The numbers that a reader finds; those it refuses (some formats have other
// skeletons, or lack the size of images), it refuses alike.
std::vector<double> TracksIn(const std::string& path, const char* format) {
  TrackReadOptions options;
  options.format = format;
  std::vector<double> numbers;
  try {
    for (const TrackFrame& frame : ReadTracks(path, options).frames) {
      for (const PersonPose& person : frame.people) {
        for (const Joint3d& joint : person.joints) {
          for (int i = 0; i < 3; ++i) numbers.push_back(joint.position_m[i]);
        }
      }
    }
  } catch (const InputError&) {
    return {};
  }
  return numbers;
}

std::vector<double> CamerasIn(const std::string& path) {
  std::vector<double> numbers;
  try {
    for (const Camera& camera : ReadCameras(path)) {
      const CameraParameters& parameters = camera.parameters();
      for (int i = 0; i < 9; ++i) numbers.push_back(parameters.K.data()[i]);
      for (int i = 0; i < 3; ++i) numbers.push_back(parameters.t[i]);
    }
  } catch (const InputError&) {
    return {};
  }
  return numbers;
}

TEST(Locale, TracksAreTheSameFiles) {
  const LocaleSample sample = MakeSample();
  int read = 0;
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    SCOPED_TRACE(format.name);
    const TemporaryFolder folder;
    const std::string plain = (folder.path() / "plain").string();
    const std::string commas = (folder.path() / "commas").string();
    LostFields lost_fields;
    format.write(plain, sample.tracks, {}, &lost_fields);
    std::vector<double> numbers;
    if (format.read != nullptr) numbers = TracksIn(plain, format.name.c_str());
    read += numbers.empty() ? 0 : 1;
    const InCommas in_commas;
    format.write(commas, sample.tracks, {}, &lost_fields);
    EXPECT_EQ(FilesOf(plain), FilesOf(commas));
    if (format.read != nullptr) {
      EXPECT_EQ(TracksIn(plain, format.name.c_str()), numbers);
    }
  }
  EXPECT_GE(read, 6);  // most formats read back
}

TEST(Locale, CamerasAndDetectionsAreTheSameFiles) {
  const LocaleSample sample = MakeSample();
  const TemporaryFolder folder;
  int read = 0;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    if (format.name == "tum") continue;  // refuses lenses
    const std::string& name = format.name;
    SCOPED_TRACE(name);
    const std::string plain = (folder.path() / ("plain" + name)).string();
    const std::string commas = (folder.path() / ("commas" + name)).string();
    LostFields lost_fields;
    format.write(plain, sample.scene.cameras, &lost_fields);
    const std::vector<double> numbers = CamerasIn(plain);
    read += numbers.empty() ? 0 : 1;
    const InCommas in_commas;
    format.write(commas, sample.scene.cameras, &lost_fields);
    EXPECT_EQ(FilesOf(plain), FilesOf(commas));
    EXPECT_EQ(CamerasIn(plain), numbers);
  }
  EXPECT_GE(read, 5);
  const std::string plain = (folder.path() / "plain.jsonl").string();
  const std::string commas = (folder.path() / "commas.jsonl").string();
  WriteDetections(plain, sample.detections);
  const InCommas in_commas;
  WriteDetections(commas, sample.detections);
  EXPECT_EQ(FilesOf(plain), FilesOf(commas));
  const DetectionSequence again = ReadDetections(commas);
  ASSERT_EQ(again.frames.size(), sample.detections.frames.size());
  EXPECT_EQ(again.frames[0].views[0].detections.at(0).joints[0].px,
            sample.detections.frames[0].views[0].detections.at(0).joints[0].px);
}

}  // namespace
}  // namespace kinegraph
