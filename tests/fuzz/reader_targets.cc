#include <functional>
#include <stdexcept>

#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/configuration/manifest.h"
#include "core/io/configuration/recording_files.h"
#include "core/io/configuration/refinement_record.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/c3d.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/io/tracks/tracks.h"
#include "tests/fuzz/input_file.h"
#include "tests/fuzz/targets.h"

namespace kinegraph::testing {
namespace {

// If `format` is empty, the format is recognised by content.
template <typename Input>
bool FuzzCalibration(const std::string& format, const std::string& bytes) {
  CameraReadOptions options;
  if (!format.empty()) options.format = format;
  // The image size of the seeds, which some formats do not store.
  options.image_size = {1280, 720};
  return Reading<Input>(
      bytes, [&](const std::string& path) { ReadCameras(path, options); });
}

template <typename Input>
bool FuzzDetections(const std::string& format, const std::string& bytes) {
  return Reading<Input>(bytes, [&](const std::string& path) {
    DetectionReadOptions options;
    if (!format.empty()) options.format = format;
    const auto source = OpenDetections(path, options);
    DetectionFrame frame;
    while (source->Next(&frame)) {
    }
  });
}

template <typename Input>
bool FuzzTracks(const std::string& format, const std::string& bytes) {
  return Reading<Input>(bytes, [&](const std::string& path) {
    TrackReadOptions options;
    options.format = format;
    ReadTracks(path, options);
    if (format.empty()) ReadPersonNames(path);
    if (format == "c3d") ReadSegments(path);
  });
}

// The three functions below write accepted input in every format (of tracks:
// without adapters). Tracks and cameras in kinegraph's own format must then be
// readable, with as many frames or cameras as the input.
bool FuzzRewrittenTracks(const std::string& bytes) {
  return Reading(bytes, [](const std::string& path) {
    const TrackSequence tracks = ReadTracks(path);
    for (const TrackFormat& format : TrackFormats()) {
      if (format.write == nullptr || format.is_of_adapter) continue;
      const TemporaryPath result("_result");
      LostFields lost_fields;
      const bool is_written = Accepts([&] {
        format.write(result.path().string(), tracks, {}, &lost_fields);
      });
      if (!is_written || format.name != "kinegraph") continue;
      const TrackSequence again = ReadTracks(result.path().string());
      if (again.frames.size() != tracks.frames.size()) std::abort();
    }
  });
}

bool FuzzRewrittenDetections(const std::string& bytes) {
  return Reading(bytes, [](const std::string& path) {
    for (const DetectionFormat& format : DetectionFormats()) {
      if (format.write == nullptr) continue;
      const TemporaryPath result("_result");
      LostFields lost_fields;
      DetectionWriteOptions options;
      options.image_size = {1280, 720};
      const auto source = OpenDetections(path, {});
      Accepts([&] {
        format.write(result.path().string(), options, source.get(),
                     &lost_fields);
      });
    }
  });
}

bool FuzzRewrittenCalibration(const std::string& bytes) {
  CameraReadOptions options;
  options.image_size = {1280, 720};
  return Reading(bytes, [&](const std::string& path) {
    const CameraRig cameras = ReadCameras(path, options);
    for (const CalibrationFormat& format : CalibrationFormats()) {
      if (format.write == nullptr) continue;
      const TemporaryPath result("_result");
      LostFields lost_fields;
      const bool is_written = Accepts(
          [&] { format.write(result.path().string(), cameras, &lost_fields); });
      if (!is_written || format.name != "kinegraph") continue;
      if (ReadCameras(result.path().string()).size() != cameras.size())
        std::abort();
    }
  });
}

// The target `fuzz` for the format of that name.
std::function<bool(const std::string&)> NamedBy(
    const std::string& format,
    bool (*fuzz)(const std::string& format, const std::string& bytes)) {
  return [=](const std::string& bytes) { return fuzz(format, bytes); };
}

std::vector<FuzzTarget> ReaderTargets() {
  std::vector<FuzzTarget> targets = {
      {"calibration", NamedBy("", FuzzCalibration<InputFile>)},
      {"calibration_folder", NamedBy("", FuzzCalibration<InputFolder>)},
      OfReader("manifest", [](const std::string& path) { ReadManifest(path); }),
      OfReader("held_out_set",
               [](const std::string& path) { ReadHeldOutSet(path); }),
      OfReader("corrections",
               [](const std::string& path) { ReadIdentityEdits(path); }),
      OfReader("bias", [](const std::string& path) { ReadViewBias(path); }),
      OfReader("refinement",
               [](const std::string& path) {
                 ReadRefinementRecord(path);
                 RefinementText(path);
               }),
      {"rewritten_calibration", FuzzRewrittenCalibration},
      {"rewritten_detections", FuzzRewrittenDetections},
      {"rewritten_tracks", FuzzRewrittenTracks},
      {"detections", NamedBy("", FuzzDetections<InputFile>)},
      {"tracks", NamedBy("", FuzzTracks<InputFile>)}};
  // Calibration formats that kinegraph writes are seeds of "calibration" and
  // "calibration_folder". Adapters run in a separate process
  // (tests/adapters/adapters_test.py).
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write != nullptr || format.recognise == nullptr) continue;
    targets.push_back({"calibration_" + format.name,
                       NamedBy(format.name, FuzzCalibration<InputFile>)});
  }
  for (const DetectionFormat& format : DetectionFormats()) {
    if (format.recognise == nullptr) continue;
    const auto fuzz = format.files == DetectionFormat::Files::kFolderAView
                          ? FuzzDetections<InputFolder>
                          : FuzzDetections<InputFile>;
    targets.push_back(
        {"detections_" + format.name, NamedBy(format.name, fuzz)});
  }
  for (const TrackFormat& format : TrackFormats()) {
    if (format.read == nullptr || format.is_of_adapter) continue;
    const auto fuzz = format.is_file_a_frame ? FuzzTracks<InputFolder>
                                             : FuzzTracks<InputFile>;
    targets.push_back({"tracks_" + format.name, NamedBy(format.name, fuzz)});
  }
  return targets;
}

}  // namespace

FuzzTarget OfReader(const std::string& name,
                    void (*read)(const std::string& path)) {
  return {name,
          [read](const std::string& bytes) { return Reading(bytes, read); }};
}

const std::vector<FuzzTarget>& FuzzTargets() {
  static const std::vector<FuzzTarget> kTargets = [] {
    std::vector<FuzzTarget> targets = ReaderTargets();
#ifndef KINEGRAPH_FUZZ_READERS_ONLY
    for (FuzzTarget& target : RunTargets()) {
      targets.push_back(std::move(target));
    }
#endif
    return targets;
  }();
  return kTargets;
}

const FuzzTarget& FindFuzzTarget(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (name == target.name) return target;
  }
  throw std::out_of_range("no fuzz target '" + name + "'");
}

}  // namespace kinegraph::testing
