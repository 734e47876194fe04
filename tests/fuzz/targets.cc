#include "tests/fuzz/targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "core/base/error.h"
#include "core/io/calibration.h"
#include "core/io/detection_source.h"
#include "core/io/held_out_set.h"
#include "core/io/manifest.h"
#include "core/io/tracks.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "solvers/session/options.h"
#include "solvers/session/run.h"

namespace kinegraph::testing {
namespace {

// A file that is in memory alone.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* bytes, size_t size)
      : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
    while (size > 0) {
      const ssize_t written = write(descriptor_, bytes, size);
      if (written <= 0) std::abort();
      bytes += written;
      size -= static_cast<size_t>(written);
    }
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const {
    return "/proc/self/fd/" + std::to_string(descriptor_);
  }

 private:
  const int descriptor_;
};

// Runs `read` on a file with these bytes; only what a user is told may be
// thrown, in one line.
template <typename Read>
void Reading(const uint8_t* bytes, size_t size, const Read& read) {
  const MemoryFile file(bytes, size);
  try {
    read(file.path());
  } catch (const InputError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  } catch (const OptionError& error) {
    if (std::strchr(error.what(), '\n') != nullptr) std::abort();
  }
}

void FuzzCalibration(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) { ReadCameras(path); });
}

void FuzzDetections(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) {
    const auto source = OpenDetections(path);
    DetectionFrame frame;
    while (source->Next(&frame)) {
    }
  });
}

void FuzzTracks(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) { ReadTracks(path); });
}

// Readers that recognition by content hardly ever reaches.
void FuzzNpz(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) {
    TrackReadOptions options;
    options.format = "npz";
    ReadTracks(path, options);
  });
}

void FuzzMat(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) {
    TrackReadOptions options;
    options.format = "tum";
    ReadTracks(path, options);
  });
}

void FuzzConfiguration(const uint8_t* bytes, size_t size) {
  Reading(bytes, size,
          [](const std::string& path) { ReadRunOptions(path, "", ""); });
}

void FuzzManifest(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) { ReadManifest(path); });
}

void FuzzHeldOutSet(const uint8_t* bytes, size_t size) {
  Reading(bytes, size, [](const std::string& path) { ReadHeldOutSet(path); });
}

// The bytes choose a small valid scene; the whole pipeline must give finite
// positions, ascending frames and everybody once a frame.
void FuzzScene(const uint8_t* bytes, size_t size) {
  const auto byte = [&](size_t at) {
    return at < size ? bytes[at] : uint8_t{0};
  };
  const auto share = [&](size_t at) { return byte(at) / 255.0; };
  SceneOptions scene_options;
  scene_options.seed = byte(0);
  scene_options.people = 1 + byte(1) % 4;
  scene_options.duration_s = 0.2 + 0.6 * share(2);
  scene_options.cameras.count = 2 + byte(3) % 4;
  NoiseOptions noise;
  noise.seed = byte(4);
  noise.joints.missing_rate = 0.5 * share(5);
  noise.joints.outlier_rate = 0.5 * share(6);
  noise.missed_rate = 0.5 * share(7);
  noise.false_people = 2.0 * share(8);
  RunOptions options;
  options.estimators.mode = byte(9) % 2 == 0 ? Mode::kPaper : Mode::kGraph;
  options.tracker.life.second_pass = byte(10) % 2 == 0;
  const Scene scene = MakeScene(scene_options);
  ObservationTruth truth;
  const DetectionSequence detections = Observe(scene, noise, &truth);
  RunRequest request;
  request.cameras = scene.cameras;
  const TrackSequence tracks = TrackSequenceOf(options, request, detections);
  int64_t last = -1;
  for (const TrackFrame& frame : tracks.frames) {
    if (frame.frame <= last) std::abort();
    last = frame.frame;
    int64_t last_id = -1;
    for (const PersonPose& person : frame.people) {
      if (person.id.value() <= last_id) std::abort();
      last_id = person.id.value();
      for (const Joint3d& joint : person.joints) {
        if (joint.present() && !joint.position_m.allFinite()) std::abort();
      }
    }
  }
}

}  // namespace

const std::vector<FuzzTarget>& FuzzTargets() {
  static const std::vector<FuzzTarget> kTargets = {
      {"calibration", FuzzCalibration},
      {"detections", FuzzDetections},
      {"tracks", FuzzTracks},
      {"npz", FuzzNpz},
      {"mat", FuzzMat},
      {"configuration", FuzzConfiguration},
      {"manifest", FuzzManifest},
      {"held_out_set", FuzzHeldOutSet},
      {"scene", FuzzScene}};
  return kTargets;
}

const FuzzTarget& FindFuzzTarget(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (name == target.name) return target;
  }
  throw std::out_of_range("no fuzz target '" + name + "'");
}

}  // namespace kinegraph::testing
