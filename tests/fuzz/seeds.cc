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
#include "tests/support/base64.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;

std::string BytesOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string Repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// A recording in memory as a source.
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

// One person who walks for 0.12 s in view of a few cameras.
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
  options.motion.visitors = 0.0;  // present from the first frame on
  options.duration_s = 0.12;
  options.skeleton = skeleton;
  Sample& made = at->second;
  made.scene = MakeScene(options);
  ObservationTruth truth;
  made.detections = Observe(made.scene, NoiseOptions(), &truth);
  made.tracks = TruthOf(made.scene);
  return made;
}

// The sample for a format, in its skeleton if it has only one.
const Sample& SampleFor(const std::string& format) {
  static const std::map<std::string, std::string> kSkeletons = {
      {"longcw", "tum14"}, {"tum", "tum14"}, {"4da", "tum15"}};
  const auto known = kSkeletons.find(format);
  return SampleWith(known == kSkeletons.end() ? "coco17" : known->second);
}

// Files of a folder by name.
std::map<std::string, fs::path> FilesOf(const fs::path& folder) {
  std::map<std::string, fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder)] = entry.path();
  }
  return files;
}

// The file itself, or the first of a folder with one file per view or person.
std::string OneFileOf(const fs::path& path) {
  return BytesOf(fs::is_directory(path) ? FilesOf(path).begin()->second : path);
}

// The files of a folder in the format of InputFolder.
std::string WholeFolder(const fs::path& folder) {
  std::string listed;
  for (const auto& [name, path] : FilesOf(folder)) {
    listed += InputFolder::kFileMark + name + "\n" + BytesOf(path);
    if (listed.back() != '\n') listed += '\n';
  }
  return listed;
}

// Output of `write`: a whole folder, or one file of it.
template <typename Write>
std::string Written(bool as_folder, const Write& write) {
  const TemporaryPath seed("_seed");
  LostFields lost_fields;
  write(seed.path().string(), &lost_fields);
  return as_folder && fs::is_directory(seed.path()) ? WholeFolder(seed.path())
                                                    : OneFileOf(seed.path());
}

std::string WrittenTracks(const TrackFormat& format) {
  return Written(format.is_file_a_frame, [&](const std::string& path,
                                             LostFields* lost_fields) {
    format.write(path, SampleFor(format.name).tracks, {}, lost_fields);
  });
}

std::string WrittenDetections(const DetectionFormat& format) {
  return Written(format.files == DetectionFormat::Files::kFolderAView,
                 [&](const std::string& path, LostFields* lost_fields) {
                   SampleSource source(SampleFor(format.name).detections);
                   format.write(path, {{1280, 720}}, &source, lost_fields);
                 });
}

// Calibrations in every format that kinegraph writes as a folder (`folders`),
// or as a single file.
std::vector<std::string> WrittenCalibrations(bool folders) {
  std::vector<std::string> seeds;
  for (const CalibrationFormat& format : CalibrationFormats()) {
    if (format.write == nullptr) continue;
    bool is_folder = false;
    const std::string seed =
        Written(folders, [&](const std::string& path, LostFields* lost_fields) {
          format.write(path, SampleFor(format.name).scene.cameras, lost_fields);
          is_folder = fs::is_directory(path);
        });
    if (is_folder == folders) seeds.push_back(seed);
  }
  return seeds;
}

// EasyMocap's two files in one, which no writer creates.
constexpr const char* kEasymocap =
    "%YAML:1.0\n---\nnames:\n  - \"0\"\nK_0: !!opencv-matrix\n  rows: 3\n"
    "  cols: 3\n  dt: d\n  data: [1000, 0, 500, 0, 1000, 500, 0, 0, 1]\n"
    "dist_0: !!opencv-matrix\n  rows: 1\n  cols: 5\n  dt: d\n"
    "  data: [0, 0, 0, 0, 0]\n"
    "R_0: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n"
    "  data: [0, 0, 1]\n"
    "T_0: !!opencv-matrix\n  rows: 3\n  cols: 1\n  dt: d\n"
    "  data: [0, 0, 2]\n";

// Seeds by target: small handwritten inputs, and two of the project's
// configurations.
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
      {"bias",
       {R"({"kinegraph_bias": 1, "azimuth_deg": 140.5, "joints": [{)"
        R"("joint": "hip", "used": true, "observations": 52, "gain": 0.12,)"
        R"( "gain_error": 0.02, "across_m": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9],)"
        R"( "along_m": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]}]})"}},
      {"refinement",
       {R"({"kinegraph_cameras": 1, "cameras": [], "refinement": {)"
        R"("clock_zero_s": 1, "cameras": [{"name": "a", "clock": {)"
        R"("offset_s": 0.01, "drift": 0}, "parameters": ["rotation_x_rad",)"
        R"( "log_focal"]}], "covariance": [[2, 1], [1, 2]]}})"}},
      {"summary",
       {R"({"kinegraph_summary": 1, "frames": 3, "height_m": null,)"
        R"( "cameras": [{"view": "a", "matched_share": 0.5}], "people": [],)"
        R"( "warnings": [{"kind": "height", "text": "</script>",)"
        R"( "try": "cameras.unit"}]})"}},
      {"doctor",
       {R"({"verdict": "suspect", "findings": [{"kind": "rotation",)"
        R"( "camera": null, "confidence": 0.9, "before_px": 8.5,)"
        R"( "after_px": 3.5, "fix": "</script>", "evidence": "x"}],)"
        R"( "notes": ["y"]})"}},
      {"calibration_qualisys",
       {"<?xml version='1.0'?><calibration qtm-version='none'><cameras><camera "
        "serial='a' active='1'><fov_video left='0' top='0' right='1279' "
        "bottom='719'/><transform x='1' y='2' z='3' r11='1' r12='0' r13='0' "
        "r21='0' r22='1' r23='0' r31='0' r32='0' r33='1'/><intrinsic "
        "focalLengthU='640' focalLengthV='640' centerPointU='320' "
        "centerPointV='320'/></camera></cameras></calibration>"}},
      {"calibration_vicon",
       {"<Cameras><Camera DEVICEID='7' TYPE='Video' SENSOR_SIZE='1280 720'>"
        "<KeyFrames><KeyFrame FOCAL_LENGTH='600' ORIENTATION='0 0 0 1' "
        "POSITION='1 2 3' PRINCIPAL_POINT='320 240' VICON_RADIAL2='"
        "ViconRadial2 320 240 1e-8 0 0'/></KeyFrames></Camera></Cameras>"}},
      {"calibration_optitrack",
       {"<Profile><Calibration><Cameras><Camera Serial='a'><Attributes "
        "ImagerPixelWidth='1280' ImagerPixelHeight='720'/>"
        "<IntrinsicStandardCameraModel LensCenterX='320' LensCenterY='240' "
        "HorizontalFocalLength='600' VerticalFocalLength='600' k1='0.1'/>"
        "<Extrinsic X='0' Y='1' Z='2' OrientMatrix0='1' OrientMatrix1='0' "
        "OrientMatrix2='0' OrientMatrix3='0' OrientMatrix4='1' "
        "OrientMatrix5='0' OrientMatrix6='0' OrientMatrix7='0' "
        "OrientMatrix8='1'/></Camera></Cameras></Calibration></Profile>"}},
      {"calibration_biocv",
       {"1280\n720\n600 0 320\n0 600 240\n0 0 1\n\n1 0 0 1\n0 1 0 2\n"
        "0 0 1 3\n0 0 0 1\n\n0.1 0 0 0 0\n"}},
      {"tracks_poses",
       {R"({"poses": [{"frame": 3, "id": 1, "joints": [[1, 2, 3], null)" +
        Repeated(", [1.5, 2, 0]", 15) + "]}]}"}},
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
      {"tracks_freemocap",
       {"nose_x,nose_y,nose_z,left_hip_x,left_hip_y,left_hip_z\n"
        "100,200,300,,,\n1000,-2000,3000,1,2,3\n"}},
      {"configuration",
       {BytesOf(KINEGRAPH_SOURCE_DIR "/configs/offline.toml"),
        BytesOf(KINEGRAPH_SOURCE_DIR "/configs/paper/shelf.toml")}},
      {"detections_mediapipe",
       {"frame,left_hip_x,left_hip_y,left_hip_visibility,right_hip_x,"
        "right_hip_y,right_hip_visibility\n3,100,200,0.5,300,nan,0.5\n"}},
      {"detections_mmpose",
       {R"([{"frame_id": 7, "instances": [{"bbox": [[1, 2, 3, 4]],)"
        R"( "keypoints": [[7, 8])" +
        Repeated(", [1, 2]", 16) + R"(], "keypoint_scores": [0)" +
        Repeated(", 1", 16) + "]}]}]"}}};
  return kSeeds;
}

}  // namespace

std::vector<std::string> FuzzSeeds(const std::string& target) {
  const auto known = ByHand().find(target);
  if (known != ByHand().end()) return known->second;
  if (target == "calibration_folder") return WrittenCalibrations(true);
  if (target.rfind("rewritten_", 0) == 0) {
    return FuzzSeeds(target.substr(target.find('_') + 1));
  }
  std::vector<std::string> seeds;
  if (target == "calibration") {
    seeds = WrittenCalibrations(false);
    seeds.emplace_back(kEasymocap);
  }
  for (const DetectionFormat& format : DetectionFormats()) {
    const bool is_file = format.files != DetectionFormat::Files::kFolderAView;
    if (format.write != nullptr && ((target == "detections" && is_file) ||
                                    target == "detections_" + format.name)) {
      seeds.push_back(WrittenDetections(format));
    }
  }
  for (const TrackFormat& format : TrackFormats()) {
    const bool is_file = !format.is_file_a_frame;
    // Formats written by adapters are not read by these targets.
    if (format.is_of_adapter || format.write == nullptr) continue;
    if ((target == "tracks" && is_file) || target == "tracks_" + format.name) {
      seeds.push_back(WrittenTracks(format));
    }
  }
  return seeds;
}

}  // namespace kinegraph::testing
