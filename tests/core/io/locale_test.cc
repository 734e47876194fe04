// Numbers in files do not depend on the program's locale, such as one with
// decimal commas.
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
#include "core/io/tracks/writer.h"
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

// Sets the locale of streams, and the C locale if the system has a German one.
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

// Name and content of every file of a result.
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

// Writes a result in both locales and expects equal files, and equal results
// read from them, which `rewrite` converts into kinegraph's own format for the
// comparison. Returns whether the reader accepted the files: some formats have
// other skeletons, or lack image sizes.
template <typename Write, typename Rewrite>
bool ExpectSameInCommas(const Write& write, const Rewrite& rewrite) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& path) -> std::string {
    const std::string own = path + ".own";
    try {
      rewrite(path, own);
    } catch (const InputError&) {
      return "";
    }
    return testing::ContentOf(own);
  };
  const std::string plain = (folder.path() / "plain").string();
  const std::string commas = (folder.path() / "commas").string();
  write(plain);
  const std::string numbers = read(plain);
  const InCommas in_commas;
  write(commas);
  EXPECT_EQ(FilesOf(plain), FilesOf(commas));
  EXPECT_EQ(read(commas), numbers);
  return !numbers.empty();
}

TEST(Locale, TrackFilesDoNotDependOnTheLocale) {
  const LocaleSample sample = MakeSample();
  LostFields lost_fields;
  int read = 0;
  for (const TrackFormat& format : TrackFormats()) {
    if (format.write == nullptr) continue;
    SCOPED_TRACE(format.name);
    TrackReadOptions options;
    options.format = format.name;
    read += ExpectSameInCommas(
        [&](const std::string& path) {
          format.write(path, sample.tracks, {}, &lost_fields);
        },
        [&](const std::string& path, const std::string& own) {
          if (format.read == nullptr) throw InputError("write only");
          WriteTracks(own, ReadTracks(path, options));
        });
  }
  EXPECT_GE(read, 6);  // kinegraph, csv, npz, trc, c3d and bvh
}

TEST(Locale, CameraAndDetectionFilesDoNotDependOnTheLocale) {
  const LocaleSample sample = MakeSample();
  LostFields lost_fields;
  int read = 0;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    SCOPED_TRACE(format.name);
    read += ExpectSameInCommas(
        [&](const std::string& path) {
          format.write(path, sample.scene.cameras, &lost_fields);
        },
        [](const std::string& path, const std::string& own) {
          WriteCameras(own, ReadCameras(path));
        });
  }
  EXPECT_GE(read, 5);
  EXPECT_TRUE(ExpectSameInCommas(
      [&](const std::string& path) {
        WriteDetections(path, sample.detections);
      },
      [](const std::string& path, const std::string& own) {
        WriteDetections(own, ReadDetections(path));
      }));
}

}  // namespace
}  // namespace kinegraph
