#include <cstring>
#include <filesystem>
#include <functional>

#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/configuration/manifest.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/configuration/view_bias_file.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/detections/video_times.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/c3d.h"
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
    if (format.empty()) ReadPersonNames(path);
    if (format == "c3d") ReadSegments(path);
  });
}

// Where a format is written to; gone when the object dies.
class Result {
 public:
  Result()
      : path_(std::filesystem::temp_directory_path() /
              ("kinegraph_fuzz_" + std::to_string(getpid()) + "_result")) {
    Remove();
  }
  ~Result() { Remove(); }
  Result(const Result&) = delete;
  Result& operator=(const Result&) = delete;
  std::string path() const { return path_; }

 private:
  void Remove() const {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path path_;
};

// `write` may refuse what does not fit its format. False where it does.
template <typename Write>
bool Accepts(const Write& write) {
  try {
    write();
    return true;
  } catch (const InputError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  }
  return false;
}

// What is read is written in every format. Whatever our own recordings, it
// reads again, and nothing is lost.
bool FuzzRewrittenTracks(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size, [](const std::string& path) {
    const TrackSequence tracks = ReadTracks(path);
    for (const TrackFormat& format : TrackFormats()) {
      if (format.write == nullptr) continue;
      const Result result;
      LostFields lost_fields;
      const bool is_written = Accepts(
          [&] { format.write(result.path(), tracks, {}, &lost_fields); });
      if (!is_written || format.name != "kinegraph") continue;
      const TrackSequence again = ReadTracks(result.path());
      if (again.frames.size() != tracks.frames.size()) std::abort();
    }
  });
}

bool FuzzRewrittenDetections(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size, [](const std::string& path) {
    for (const DetectionFormat& format : DetectionFormats()) {
      if (format.write == nullptr) continue;
      const Result result;
      LostFields lost_fields;
      DetectionWriteOptions options;
      options.image_size = {1280, 720};
      const auto source = OpenDetections(path, {});
      Accepts([&] {
        format.write(result.path(), options, source.get(), &lost_fields);
      });
    }
  });
}

bool FuzzRewrittenCalibration(const uint8_t* bytes, size_t size) {
  CameraReadOptions options;
  options.image_size = {1280, 720};
  return Reading(bytes, size, [&](const std::string& path) {
    const CameraRig cameras = ReadCameras(path, options);
    for (const CalibrationFormat& format : CalibrationFormats()) {
      if (format.write == nullptr) continue;
      const Result result;
      LostFields lost_fields;
      const bool is_written =
          Accepts([&] { format.write(result.path(), cameras, &lost_fields); });
      if (!is_written || format.name != "kinegraph") continue;
      if (ReadCameras(result.path()).size() != cameras.size()) std::abort();
    }
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

bool FuzzBias(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size,
                 [](const std::string& path) { ReadViewBias(path); });
}

bool FuzzRefinement(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size, [](const std::string& path) {
    ReadRefinementRecord(path);
    RefinementText(path);
  });
}

bool FuzzVideoTimes(const uint8_t* bytes, size_t size) {
  return Reading(bytes, size,
                 [](const std::string& path) { ReadVideoTimes(path); });
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
      {"bias", FuzzBias},
      {"refinement", FuzzRefinement},
      {"video_times", FuzzVideoTimes},
      {"rewritten_calibration", FuzzRewrittenCalibration},
      {"rewritten_detections", FuzzRewrittenDetections},
      {"rewritten_tracks", FuzzRewrittenTracks},
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
