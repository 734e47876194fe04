#include <functional>

#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/configuration/manifest.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/io/tracks/tracks.h"
#include "tests/fuzz/input_file.h"
#include "tests/fuzz/targets.h"

// Asked by the leak sanitizer: Debian's HDF5 leaks where it refuses a file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace kinegraph::testing {
namespace {

// An empty name: recognised by content.
template <typename Input>
bool FuzzCalibration(const std::string& format, const uint8_t* bytes,
                     size_t size) {
  CameraReadOptions options;
  if (!format.empty()) options.format = format;
  options.image_size = {1280, 720};  // of the seeds, which some formats lack
  return Reading<Input>(bytes, size, [&](const std::string& path) {
    ReadCameras(path, options);
  });
}

template <typename Input>
bool FuzzDetections(const std::string& format, const uint8_t* bytes,
                    size_t size) {
  return Reading<Input>(bytes, size, [&](const std::string& path) {
    DetectionReadOptions options;
    if (!format.empty()) options.format = format;
    const auto source = OpenDetections(path, options);
    DetectionFrame frame;
    while (source->Next(&frame)) {
    }
  });
}

template <typename Input>
bool FuzzTracks(const std::string& format, const uint8_t* bytes, size_t size) {
  return Reading<Input>(bytes, size, [&](const std::string& path) {
    TrackReadOptions options;
    options.format = format;
    ReadTracks(path, options);
  });
}

bool FuzzManifest(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size,
                 [](const std::string& path) { ReadManifest(path); });
}

bool FuzzHeldOutSet(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size,
                 [](const std::string& path) { ReadHeldOutSet(path); });
}

bool FuzzCorrections(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size,
                 [](const std::string& path) { ReadIdentityEdits(path); });
}

}  // namespace

std::vector<FuzzTarget> ReaderTargets() {
  using namespace std::placeholders;  // NOLINT
  std::vector<FuzzTarget> targets = {
      {"calibration", std::bind(FuzzCalibration<InputFile>, "", _1, _2)},
      {"calibration_folder",
       std::bind(FuzzCalibration<InputFolder>, "", _1, _2)},
      {"manifest", FuzzManifest},
      {"held_out_set", FuzzHeldOutSet},
      {"corrections", FuzzCorrections},
      {"detections", std::bind(FuzzDetections<InputFile>, "", _1, _2)},
      {"tracks", std::bind(FuzzTracks<InputFile>, "", _1, _2)}};
  // Those that are written are seeds of the two targets above.
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write != nullptr) continue;
    targets.push_back(
        {"calibration_" + format.name,
         std::bind(FuzzCalibration<InputFile>, format.name, _1, _2)});
  }
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.open == nullptr) continue;
    const auto fuzz = format.files == DetectionFormat::Files::kFolderAView
                          ? FuzzDetections<InputFolder>
                          : FuzzDetections<InputFile>;
    targets.push_back(
        {"detections_" + format.name, std::bind(fuzz, format.name, _1, _2)});
  }
  for (const TrackFormat& format : TrackFormats()) {
    if (format.read == nullptr) continue;
    const auto fuzz = format.files == TrackFormat::Files::kFileAFrame
                          ? FuzzTracks<InputFolder>
                          : FuzzTracks<InputFile>;
    targets.push_back(
        {"tracks_" + format.name, std::bind(fuzz, format.name, _1, _2)});
  }
  return targets;
}

}  // namespace kinegraph::testing
