#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "core/io/calibration/format.h"
#include "core/io/detections/format.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/identity_edits.h"
#include "core/synthetic/noise.h"
#include "core/synthetic/scene.h"
#include "tests/fuzz/input_file.h"
#include "tests/fuzz/targets.h"
#include "tests/support/hdf5_files.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

// Of its own, so that the fuzzers need no library of the tests.
class SeedFolder {
 public:
  SeedFolder()
      : path_(fs::temp_directory_path() /
              ("kinegraph_seeds_" + std::to_string(getpid()))) {
    fs::create_directory(path_);
  }
  ~SeedFolder() { fs::remove_all(path_); }
  SeedFolder(const SeedFolder&) = delete;
  SeedFolder& operator=(const SeedFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  const fs::path path_;
};

std::string ContentOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Hands out what is in memory.
class SampleSource : public DetectionSource {
 public:
  explicit SampleSource(const DetectionSequence& detections)
      : detections_(detections) {}
  const DetectionHeader& header() const override { return detections_.header; }
  bool Next(DetectionFrame* frame) override {
    if (next_ == detections_.frames.size()) return false;
    *frame = detections_.frames[next_++];
    return true;
  }

 private:
  const DetectionSequence& detections_;
  size_t next_ = 0;
};

// A short walk of one person before a few cameras.
struct Sample {
  Scene scene;
  DetectionSequence detections;
  TrackSequence tracks;
};

const Sample& SampleWith(const std::string& skeleton) {
  static std::map<std::string, Sample> samples;
  const auto [at, is_new] = samples.try_emplace(skeleton);
  if (!is_new) return at->second;
  SceneOptions options;
  options.people = 1;
  options.motion.visitors = 0.0;  // there from the first frame on
  options.duration_s = 0.12;
  options.skeleton = skeleton;
  Sample& made = at->second;
  made.scene = MakeScene(options);
  ObservationTruth truth;
  made.detections = Observe(made.scene, NoiseOptions(), &truth);
  made.tracks = TruthOf(made.scene);
  return made;
}

// The skeletons of formats that have but one.
const Sample& SampleFor(const std::string& format) {
  static const std::map<std::string, std::string> kSkeletons = {
      {"longcw", "tum14"}, {"tum", "tum14"}, {"4da", "tum15"}};
  const auto known = kSkeletons.find(format);
  return SampleWith(known == kSkeletons.end() ? "coco17" : known->second);
}

// Of a folder, its files by name.
std::map<std::string, fs::path> FilesOf(const fs::path& folder) {
  std::map<std::string, fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder)] = entry.path();
  }
  return files;
}

// The file itself, or the first of a folder with a file a view or person.
std::string OneFileOf(const fs::path& path) {
  return ContentOf(fs::is_directory(path) ? FilesOf(path).begin()->second
                                          : path);
}

// As InputFolder takes it.
std::string WholeFolder(const fs::path& folder) {
  std::string listed;
  for (const auto& [name, path] : FilesOf(folder)) {
    listed += InputFolder::kFileMark + name + "\n" + ContentOf(path);
    if (listed.back() != '\n') listed += '\n';
  }
  return listed;
}

std::vector<std::string> WrittenTracks(const TrackFormat& format) {
  if (format.write == nullptr) return {};
  const SeedFolder folder;
  const std::string path = (folder.path() / "seed").string();
  Losses losses;
  format.write(path, SampleFor(format.name).tracks, {}, &losses);
  return {format.files == TrackFormat::Files::kFileAFrame ? WholeFolder(path)
                                                          : OneFileOf(path)};
}

std::vector<std::string> WrittenDetections(const DetectionFormat& format) {
  if (format.write == nullptr) return {};
  const SeedFolder folder;
  const std::string path = (folder.path() / "seed").string();
  Losses losses;
  DetectionWriteOptions options;
  options.image_size = {1280, 720};
  SampleSource source(SampleFor(format.name).detections);
  format.write(path, options, &source, &losses);
  return {format.files == DetectionFormat::Files::kFolderAView
              ? WholeFolder(path)
              : OneFileOf(path)};
}

// Of formats of one file, or of those that are folders.
std::vector<std::string> WrittenCalibrations(bool folders) {
  std::vector<std::string> seeds;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    const SeedFolder folder;
    const std::string path = (folder.path() / "seed").string();
    Losses losses;
    format.write(path, SampleFor(format.name).scene.cameras, &losses);
    if (fs::is_directory(path) != folders) continue;
    seeds.push_back(folders ? WholeFolder(path) : ContentOf(path));
  }
  return seeds;
}

std::vector<std::string> Calibrations() {
  std::vector<std::string> seeds = WrittenCalibrations(false);
  seeds.emplace_back(
      "%YAML:1.0\n---\nnames:\n  - \"0\"\nK_0: !!opencv-matrix\n  rows: 3\n"
      "  cols: 3\n  dt: d\n  data: [1000, 0, 500, 0, 1000, 500, 0, 0, 1]\n"
      "dist_0: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
      "  data: [0, 0, 0, 0, 0]\n"
      "R_0: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n"
      "  data: [0, 0, 1]\n"
      "T_0: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n"
      "  data: [0, 0, 2]\n");
  return seeds;
}

// What other programs write, in small.
const std::map<std::string, std::vector<std::string>>& ByHand() {
  static const std::map<std::string, std::vector<std::string>> kSeeds = {
      {"manifest",
       {"report = true\n[[takes]]\nname = \"a\"\ncameras = \"c\"\n"
        "detections = \"d\"\n[[configurations]]\nname = \"b\"\n"
        "config = \"e.toml\"\n"}},
      {"held_out_set",
       {R"({"confidence_at_least": 0.3, "pairing_gate_m": 0.5, "cap_px": 100,)"
        R"( "set": [{"frame": 3, "camera": "a", "detection": 0, "person": 1}]})"}},
      {"corrections",
       {R"({"op": "join", "persons": [3, 7], "frames": [120, 131]})"
        "\n"
        R"({"op": "name", "persons": [3], "name": "Anna"})"
        "\n"
        R"({"op": "delete", "persons": [9], "frames": [0, 5]})"
        "\n"}},
      {"scene",
       {std::string("\x01\x02\x80\x02\x03\x40\x40\x40\x40\x01\x01", 11)}},
      {"page", {std::string(200, '\x41'), "</script>"}},
      {"detections_deeplabcut",
       {"scorer,net,net,net,net,net,net\n"
        "bodyparts,left_hip,left_hip,left_hip,tail,tail,tail\n"
        "coords,x,y,likelihood,x,y,likelihood\n"
        "0,10.5,20,0.9,30,40,0.8\n1,11.5,21,0.9,,,\n",
        "scorer,,,me,me,me,me\nindividuals,,,a,a,b,b\n"
        "bodyparts,,,nose,nose,nose,nose\ncoords,,,x,y,x,y\n"
        "labeled-data,cam1,img0012.png,1,2,3,4\n"}},
      {"detections_freemocap",
       // One camera, one frame of 17 points; the header has 70 bytes.
       {std::string("\x93NUMPY\x01\x00\x46\x00", 10) +
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 17, 2), }" +
        std::string(3, ' ') + "\n" + std::string(17 * 2 * 8, '\x40')}},
      {"tracks_freemocap",
       {"nose_x,nose_y,nose_z,left_hip_x,left_hip_y,left_hip_z\n"
        "100,200,300,,,\n1000,-2000,3000,1,2,3\n"}},
      {"detections_mediapipe",
       {"frame,left_hip_x,left_hip_y,left_hip_visibility,right_hip_x,"
        "right_hip_y,right_hip_visibility\n3,100,200,0.5,300,nan,0.5\n"}},
      {"detections_mmpose",
       {R"([{"frame_id": 7, "instances": [{"bbox": [[1, 2, 3, 4]],)"
        R"( "keypoints": [[1, 2], [3, 4], [5, 6], [1, 2], [3, 4], [5, 6],)"
        R"( [1, 2], [3, 4], [5, 6], [1, 2], [3, 4], [5, 6], [1, 2], [3, 4],)"
        R"( [5, 6], [7, 8], [9, 9]], "keypoint_scores": [1, 1, 1, 1, 1, 1,)"
        R"( 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0]}]}])"}},
      {"detections_smap",
       {R"({"3d_pairs": {"num": 1, "pred_2d": [[[1, 2, 0.5, 0.9], [1, 2, 0, 1])"
        R"(, [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1],)"
        R"( [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1],)"
        R"( [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1], [1, 2, 0, 1],)"
        R"( [1, 2, 0, 1]]]}})"}}};
  return kSeeds;
}

}  // namespace

std::vector<std::string> FuzzSeeds(const std::string& target) {
  const auto known = ByHand().find(target);
  if (known != ByHand().end()) return known->second;
  if (target == "calibration") return Calibrations();
  if (target == "calibration_folder") return WrittenCalibrations(true);
  if (target == "detections_sleap") return {SleapHdf5()};
  if (target == "detections_deeplabcut_h5") return {DeepLabCutHdf5()};
  if (target == "configuration") {
    return {ContentOf(KINEGRAPH_SOURCE_DIR "/configs/graph/offline.toml"),
            ContentOf(KINEGRAPH_SOURCE_DIR "/configs/paper/shelf.toml")};
  }
  std::vector<std::string> seeds;
  const auto add = [&](const std::vector<std::string>& more) {
    seeds.insert(seeds.end(), more.begin(), more.end());
  };
  for (const DetectionFormat& format : DetectionFormats()) {
    const bool is_file = format.files != DetectionFormat::Files::kFolderAView;
    if ((target == "detections" && is_file) ||
        target == "detections_" + format.name) {
      add(WrittenDetections(format));
    }
  }
  for (const TrackFormat& format : TrackFormats()) {
    const bool is_file = format.files != TrackFormat::Files::kFileAFrame;
    if ((target == "tracks" && is_file) || target == "tracks_" + format.name) {
      add(WrittenTracks(format));
    }
  }
  return seeds;
}

}  // namespace kinegraph::testing
