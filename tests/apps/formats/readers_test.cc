// Output of kinegraph-convert, read by other programs and compared with the
// input: three.js in Chromium, SciPy, xarray, COLMAP, Khronos' validator of
// glTF, and readers of C3D, of Anipose's tables and of COCO's JSON that were
// written for these tests. Also files of SLEAP and DeepLabCut, read by
// kinegraph.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/file_kind.h"
#include "core/io/files/text_file.h"
#include "core/io/text/json.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"
#include "tests/apps/formats/recording.h"
#include "tests/core/io/input_error.h"
#include "tests/support/browser.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::Browser;
using testing::HasPython;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MakeRecording;
using testing::TemporaryFolder;

const PersonNames kNames = {{TrackId(12), "Anna"}};

void RunCommand(const std::string& command) {
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

// The command that runs a script of this folder on a file or folder.
std::string Python(const std::string& script, const fs::path& argument) {
  return "/usr/bin/python3 '" +
         testing::ProjectFile("tests/apps/formats/" + script).string() + "' '" +
         argument.string() + "'";
}

class FormatReaders : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return folder_.path() / name;
  }
  // Returns the printed notes.
  static std::string ConvertFile(const std::string& in, const std::string& out,
                                 const std::string& more) {
    return testing::Done("convert",
                         "--in='" + in + "' --out='" + out + "' " + more)
        .errors;
  }
  // The recording as JSON Lines, converted to `name`.
  std::string Convert(const std::string& name, const std::string& more = "") {
    const std::string in = Path("take.jsonl");
    WriteTracks(in, recording_,
                {!recording_.header.view_names.empty(), kNames});
    return ConvertFile(in, Path(name), more);
  }
  // The JSON that a script prints of a file.
  Json Read(const std::string& script, const std::string& name) {
    RunCommand(Python(script, Path(name)) + " > '" + Path("read.json") + "'");
    return Json::parse(ReadTextFile(Path("read.json")));
  }
  void ExpectGltf(const std::string& name);

  TrackSequence recording_ = MakeRecording();
  const TemporaryFolder folder_;
};

const PersonPose* PersonIn(const TrackSequence& recording, int64_t frame,
                           int64_t id) {
  for (const TrackFrame& at : recording.frames) {
    if (at.frame != frame) continue;
    for (const PersonPose& person : at.people) {
      if (person.id == TrackId(id)) return &person;
    }
  }
  return nullptr;
}

// Calls `see(person, joint, frame, p)` for every joint of both people in frames
// 300 to 339; `person` is null if absent.
template <typename See>
void ForEachJoint(const TrackSequence& recording, const See& see) {
  for (int64_t f = 300; f < 340; ++f) {
    for (size_t p = 0; p < 2; ++p) {
      const PersonPose* person = PersonIn(recording, f, p == 0 ? 3 : 12);
      for (size_t j = 0; j < 25; ++j) see(person, j, f, p);
    }
  }
}

bool IsThere(const PersonPose* person, size_t j) {
  return person != nullptr && person->joints[j].present();
}

Vector3d VectorOf(const Json& array) {
  return {array[0].get<double>(), array[1].get<double>(),
          array[2].get<double>()};
}

// ---- C3D ----

TEST_F(FormatReaders, C3dHasPointsResidualsAndCameras) {
  if (!HasPython("json")) GTEST_SKIP() << "needs Debian's python3";
  recording_.header.view_names = {"one", "two", "three"};
  for (TrackFrame& frame : recording_.frames) {
    for (PersonPose& person : frame.people) {
      for (int v = 0; v < 3; v += 2) {
        ViewMatch match;
        match.view_idx = v;
        match.weights.assign(25, v == 0 ? 0.7 : 0.0);
        match.weights[7] = 1.0;
        person.matches.push_back(match);
      }
    }
  }
  const std::string notes = Convert("take.c3d");
  EXPECT_THAT(notes, HasSubstr("root of the trace"));
  const Json read = Read("c3d_reader.py", "take.c3d");
  EXPECT_EQ(read["first"], 301) << "C3D counts from 1";
  EXPECT_EQ(read["rate"], 50.0);
  ASSERT_EQ(read["frames"].size(), 40u) << "with frame 311, without points";
  ASSERT_EQ(read["labels"].size(), 50u);
  EXPECT_EQ(read["labels"][0], "person_3:nose");
  EXPECT_EQ(read["labels"][26], "person_12:neck");
  const Json& parameters = read["parameters"];
  EXPECT_EQ(parameters["POINT"]["UNITS"][0], "mm");
  EXPECT_EQ(parameters["POINT"]["FRAMES"], 40);
  EXPECT_EQ(parameters["ANALOG"]["USED"], 0);
  EXPECT_EQ(parameters["SUBJECTS"]["NAMES"], Json({"person_3", "Anna"}));
  EXPECT_EQ(parameters["SUBJECTS"]["LABEL_PREFIXES"],
            Json({"person_3:", "person_12:"}));
  EXPECT_EQ(parameters["EVENT"]["LABELS"],
            Json({"begin", "end", "begin", "end"}));
  // Minutes and seconds: frames 300, 339, 305 and 331 at 50 Hz.
  const std::vector<double> times = {0, 6.0, 0, 6.78, 0, 6.1, 0, 6.62};
  for (size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(parameters["EVENT"]["TIMES"][i].get<double>(), times[i], 1e-6);
  }
  const double step_mm = read["scale"].get<double>();
  int compared = 0;
  ForEachJoint(recording_, [&](const PersonPose* person, size_t j, int64_t f,
                               size_t p) {
    const Json& point =
        read["frames"][static_cast<size_t>(f - 300)][25 * p + j];
    ASSERT_EQ(!point.is_null(), IsThere(person, j)) << f << " " << p;
    if (point.is_null()) return;
    // Half a unit in the last place of a float below 16.4 m, on each axis.
    EXPECT_LT((VectorOf(point) - 1000.0 * person->joints[j].position_m)
                  .cwiseAbs()
                  .maxCoeff(),
              16384.0 * std::pow(2.0, -25.0));
    const double uncertainty_mm =
        1000.0 * std::sqrt(person->covariances[j]->trace());
    EXPECT_NEAR(point[3].get<double>(), uncertainty_mm,
                std::max(0.5001 * step_mm, step_mm - uncertainty_mm));
    const bool is_observed = person->joints[j].status == JointStatus::kObserved;
    EXPECT_EQ(point[4], !is_observed ? 0 : j == 7 ? 5 : 1);
    ++compared;
  });
  EXPECT_EQ(compared, 39 * 25 - 3 + 22 * 24);
}

TEST_F(FormatReaders, C3dHasFrameNumbersAbove65535AndManyLabels) {
  if (!HasPython("json")) GTEST_SKIP() << "needs Debian's python3";
  for (TrackFrame& frame : recording_.frames) {
    frame.frame += 70'000;
    frame.time = frame.frame * 20'000'000;
    frame.people.resize(1);
    for (int64_t id = 20; id < 35; ++id) {  // 16 people: 400 labels
      frame.people.push_back(frame.people[0]);
      frame.people.back().id = TrackId(id);
    }
  }
  Convert("take.c3d");
  const Json read = Read("c3d_reader.py", "take.c3d");
  EXPECT_EQ(read["first"], 70'301);
  ASSERT_EQ(read["labels"].size(), 400u) << "LABELS and LABELS2";
  EXPECT_EQ(read["labels"][399], "person_34:r_heel");
  EXPECT_EQ(read["frames"].size(), 40u);
}

// ---- three.js ----

constexpr const char* kThree = "/usr/share/javascript/three/";

bool HasThree() {
  return Browser::IsInstalled() &&
         fs::exists(std::string(kThree) + "examples/js/loaders/BVHLoader.js");
}

// A page with three.js, a loader of it, the file as base64 text `data` and a
// script.
std::string PageWith(const TemporaryFolder& folder, const std::string& loader,
                     const std::string& file, const std::string& script) {
  const std::string base64 = folder.path() / "base64.txt";
  RunCommand("base64 -w0 '" + file + "' > '" + base64 + "'");
  std::string html = "<!doctype html><meta charset=utf-8>";
  for (const std::string& source :
       {std::string("three.js"), "examples/js/loaders/" + loader}) {
    html +=
        "<script src='file://" + std::string(kThree) + source + "'></script>\n";
  }
  html += "<script>const data = '" + ReadTextFile(base64) +
          "';\nconst bytes = Uint8Array.from(atob(data), c => "
          "c.charCodeAt(0));\n" +
          script + "</script>";
  return folder.Write("page.html", html);
}

// World to x, z, -y.
Vector3d InFile(const Vector3d& world) {
  return {world.x(), world.z(), -world.y()};
}

constexpr const char* kGltfScript = R"(
let gltf, mixer, failure = '';
new THREE.GLTFLoader().parse(bytes.buffer, '', result => {
  gltf = result;
  mixer = new THREE.AnimationMixer(gltf.scene);
  mixer.clipAction(gltf.animations[0]).play();
}, error => { failure = String(error); });
// Joints of all skinned bodies, and the centre of the ball that is skinned to
// each joint.
function at(time_s) {
  mixer.time = 0;
  const action = mixer.clipAction(gltf.animations[0]);
  action.time = Math.fround(time_s);
  mixer.update(0);
  gltf.scene.updateMatrixWorld(true);
  const people = [];
  gltf.scene.traverse(mesh => {
    if (!mesh.isSkinnedMesh) return;
    const joints = {};
    const position = mesh.geometry.attributes.position;
    const owner = mesh.geometry.attributes.skinIndex;
    mesh.skeleton.bones.forEach((bone, b) => {
      const place = bone.getWorldPosition(new THREE.Vector3());
      const skin = new THREE.Matrix4().multiplyMatrices(
          bone.matrixWorld, mesh.skeleton.boneInverses[b]);
      let first = -1;  // the ball: the first six vertices in a row
      for (let v = 0; v + 5 < position.count && first < 0; v += 6) {
        if (owner.getX(v) === b && owner.getX(v + 5) === b) first = v;
      }
      const middle = new THREE.Vector3();
      for (let v = first; v < first + 6; ++v) {
        middle.add(new THREE.Vector3().fromBufferAttribute(position, v)
            .applyMatrix4(skin));
      }
      middle.divideScalar(6);
      joints[bone.name] = [place.toArray(), middle.toArray()];
    });
    const root = mesh.skeleton.bones[0].parent;
    people.push({name: root.name, id: root.userData.id, scale: root.scale.x,
                 joints});
  });
  return people;
}
)";

void FormatReaders::ExpectGltf(const std::string& name) {
  if (!HasThree()) GTEST_SKIP() << "needs chromium and libjs-three";
  const std::string notes = Convert(name);
  EXPECT_THAT(notes, HasSubstr("missing joints were interpolated"));
  Browser browser;
  browser.Open(
      PageWith(folder_, "GLTFLoader.js", folder_.path() / name, kGltfScript));
  ASSERT_TRUE(browser.WaitFor("gltf !== undefined || failure !== ''"));
  ASSERT_EQ(browser.Evaluate("failure"), "");
  EXPECT_EQ(browser.Evaluate("gltf.scene.userData.first_frame"), 300);
  EXPECT_EQ(browser.Evaluate("gltf.asset.version"), "2.0");
  int compared = 0;
  for (int64_t f = 300; f < 339; ++f) {
    const Json people = browser.Evaluate(
        "at(" + std::to_string(0.02 * static_cast<double>(f - 300)) + ")");
    ASSERT_EQ(people.size(), 2u);
    for (size_t p = 0; p < 2; ++p) {
      const int64_t id = p == 0 ? 3 : 12;
      EXPECT_EQ(people[p]["id"], id);
      EXPECT_EQ(people[p]["name"], p == 0 ? "person_3" : "Anna");
      const PersonPose* person = PersonIn(recording_, f, id);
      EXPECT_EQ(people[p]["scale"], person != nullptr ? 1 : 0) << f;
      if (person == nullptr) continue;
      for (size_t j = 0; j < 25; ++j) {
        const Json& found =
            people[p]["joints"]
                  [(p == 0 ? "person_3_" : "Anna_") + Body25().joints()[j]];
        ASSERT_EQ(found.size(), 2u);
        if (!person->joints[j].present()) continue;
        const Vector3d expected = InFile(person->joints[j].position_m);
        // Seven links of floats at 4 m, each rounded by 2^-24 relative.
        EXPECT_LT((VectorOf(found[0]) - expected).norm(), 4e-6);
        EXPECT_LT((VectorOf(found[1]) - expected).norm(), 8e-6) << "the skin";
        ++compared;
      }
    }
  }
  EXPECT_EQ(compared, 38 * 25 - 3 + 22 * 24);
  EXPECT_THAT(browser.problems(), IsEmpty());
}

TEST_F(FormatReaders, GltfHasTheJointsInThreeJs) { ExpectGltf("take.gltf"); }
TEST_F(FormatReaders, GlbHasTheJointsInThreeJs) { ExpectGltf("take.glb"); }

// Recordings that differ in the structure of the file: one person, two, a
// single frame, other axes.
TEST_F(FormatReaders, GltfPassesTheKhronosValidator) {
  const fs::path validator =
      testing::BuildFile("npm/node_modules/gltf-validator");
  if (!fs::exists(validator) || std::system("node --version >/dev/null") != 0) {
    GTEST_SKIP() << "needs nodejs and gltf-validator: copy "
                    "tests/apps/formats/npm to BUILD/npm and run "
                    "npm ci --prefix BUILD/npm, as .ci/run does";
  }
  const std::string script =
      testing::ProjectFile("tests/apps/formats/validate_gltf.js").string();
  const TrackSequence all = recording_;
  for (const size_t frames : {size_t{1}, size_t{2}, all.frames.size()}) {
    recording_.frames.assign(
        all.frames.begin(),
        all.frames.begin() + static_cast<std::ptrdiff_t>(frames));
    for (const char* more :
         {"", "--axes=x,y,z", "--axes=-z,x,-y", "--person=3"}) {
      for (const char* name : {"take.gltf", "take.glb"}) {
        SCOPED_TRACE(std::string(name) + " " + more);
        Convert(name, more);
        RunCommand("node '" + script + "' '" + validator.string() + "' '" +
                   Path(name) + "' > '" + Path("read.json") + "'");
        const Json issues =
            Json::parse(ReadTextFile(Path("read.json")))["issues"];
        EXPECT_EQ(issues["numErrors"], 0) << issues["messages"].dump(1);
        EXPECT_EQ(issues["numWarnings"], 0) << issues["messages"].dump(1);
      }
    }
  }
}

constexpr const char* kBvhScript = R"(
const bvh = new THREE.BVHLoader().parse(new TextDecoder().decode(bytes));
bvh.skeleton.bones[0].skeleton = bvh.skeleton;
const mixer = new THREE.AnimationMixer(bvh.skeleton.bones[0]);
const action = mixer.clipAction(bvh.clip);
action.play();
function at(time_s) {
  action.time = Math.fround(time_s);
  mixer.update(0);
  bvh.skeleton.bones[0].updateMatrixWorld(true);
  const joints = {};
  for (const bone of bvh.skeleton.bones) {
    joints[bone.name] = bone.getWorldPosition(new THREE.Vector3()).toArray();
  }
  return joints;
}
)";

TEST_F(FormatReaders, BvhHasTheJointsInThreeJs) {
  if (!HasThree()) GTEST_SKIP() << "needs chromium and libjs-three";
  const std::string notes = Convert("bvh", "--to=bvh");
  EXPECT_THAT(notes, HasSubstr("missing joints were interpolated"));
  for (const int64_t id : {3, 12}) {
    const std::string file = id == 3 ? "person_3.bvh" : "person_12_Anna.bvh";
    Browser browser;
    browser.Open(PageWith(folder_, "BVHLoader.js",
                          folder_.path() / "bvh" / file, kBvhScript));
    EXPECT_NEAR(browser.Evaluate("bvh.clip.duration").get<double>(), 39 * 0.02,
                1e-6);
    int compared = 0;
    for (int64_t f = 300; f < 339; ++f) {
      const PersonPose* person = PersonIn(recording_, f, id);
      if (person == nullptr) continue;
      const Json joints = browser.Evaluate(
          "at(" + std::to_string(0.02 * static_cast<double>(f - 300)) + ")");
      for (size_t j = 0; j < 25; ++j) {
        if (!person->joints[j].present()) continue;
        // The left elbow is always missing: upper arm and forearm act as one
        // bone of varying length.
        if (id == 12 && Body25().joints()[j] == "l_wrist") continue;
        const Vector3d found_cm = VectorOf(joints[Body25().joints()[j]]);
        // Six decimals of centimetres and degrees; three.js keeps rotations as
        // floats: 2^-24 of a metre per link.
        EXPECT_LT(
            (0.01 * found_cm - InFile(person->joints[j].position_m)).norm(),
            2e-6)
            << f << " " << Body25().joints()[j];
        ++compared;
      }
    }
    EXPECT_EQ(compared, id == 3 ? 38 * 25 - 3 : 22 * 23);
    EXPECT_THAT(browser.problems(), IsEmpty());
  }
}

// ---- xarray ----

TEST_F(FormatReaders, NetcdfInXarrayHasTheLayoutOfMovement) {
  if (!HasPython("xarray, scipy")) {
    GTEST_SKIP() << "needs python3-xarray and python3-scipy";
  }
  Convert("take.nc");
  const Json read = Read("movement_reader.py", "take.nc");
  EXPECT_EQ(read["fps"], 50.0);
  EXPECT_EQ(read["time_unit"], "seconds");
  EXPECT_EQ(read["individuals"], Json({"person_3", "Anna"}));
  EXPECT_EQ(read["identity"], Json({3.0, 12.0}));
  EXPECT_EQ(read["keypoints"], Json(Body25().joints()));
  ASSERT_EQ(read["position"].size(), recording_.frames.size());
  for (size_t f = 0; f < recording_.frames.size(); ++f) {
    EXPECT_EQ(read["frame"][f],
              static_cast<double>(recording_.frames[f].frame));
    EXPECT_EQ(read["time"][f], ToSeconds(recording_.frames[f].time));
  }
  ForEachJoint(recording_, [&](const PersonPose* person, size_t j,
                               int64_t number, size_t p) {
    if (number == 311) return;  // missing in the recording
    const auto f =
        static_cast<size_t>(number < 311 ? number - 300 : number - 301);
    const bool is_there = IsThere(person, j);
    const Json& confidence = read["confidence"][f][j][p];
    ASSERT_EQ(!confidence.is_null(), is_there);
    EXPECT_EQ(read["status"][f][j][p],
              !is_there ? 0 : static_cast<int>(person->joints[j].status));
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<size_t>(axis);
      const Json& m = read["position"][f][a][j][p];
      ASSERT_EQ(!m.is_null(), is_there);
      if (!is_there) continue;
      EXPECT_EQ(m, person->joints[j].position_m[axis]) << "bit for bit";
      EXPECT_EQ(read["sigma"][f][a][j][p],
                std::sqrt((*person->covariances[j])(axis, axis)));
    }
    // The probability of an error below 50 mm: joint 0 has a sigma of 1 mm per
    // axis, joint 24 of 24.02 mm.
    if (is_there && j == 0) {
      EXPECT_NEAR(confidence.get<double>(), 1.0, 1e-12);
    } else if (is_there && j == 24) {
      EXPECT_NEAR(confidence.get<double>(), 0.7722979, 1e-6);
    }
  });
  const PersonPose* anna =
      PersonIn(recording_, recording_.frames[10].frame, 12);
  const auto knee = static_cast<size_t>(Body25().IndexOf("r_knee"));
  EXPECT_EQ(VectorOf(read["chosen"]), anna->joints[knee].position_m);
}

// ---- SciPy ----

TEST_F(FormatReaders, TumActorsAreReadBySciPyBitForBit) {
  if (!HasPython("scipy.io")) GTEST_SKIP() << "needs python3-scipy";
  Convert("actorsGT.mat", "--to=tum");
  const Json read = Read("tum_reader.py", "actorsGT.mat");
  ASSERT_EQ(read.size(), 13u) << "one cell per id up to the largest";
  for (const Json& actor : read) ASSERT_EQ(actor.size(), 340u);
  ForEachJoint(recording_, [&](const PersonPose* person, size_t j, int64_t f,
                               size_t p) {
    const Json& pose = read[p == 0 ? 3 : 12][static_cast<size_t>(f)];
    ASSERT_EQ(pose.size(), person == nullptr ? 0u : 25u);
    if (person == nullptr) return;
    ASSERT_EQ(!pose[j].is_null(), IsThere(person, j));
    if (!IsThere(person, j)) return;
    EXPECT_EQ(VectorOf(pose[j]), person->joints[j].position_m) << "bit for bit";
  });
}

// ---- Python's own readers ----

TEST_F(FormatReaders, AniposeTableRestoresPositionsAndCameraCounts) {
  if (!HasPython("csv, json")) GTEST_SKIP() << "needs Debian's python3";
  Convert("anipose", "--to=anipose");
  std::vector<Json> read;
  for (const std::string file : {"person_3.csv", "person_12_Anna.csv"}) {
    read.push_back(Read("anipose_reader.py", "anipose/" + file));
    EXPECT_EQ(read.back()["joints"], Json(Body25().joints()));
    ASSERT_EQ(read.back()["frames"].size(), 40u);
  }
  ForEachJoint(recording_, [&](const PersonPose* person, size_t j, int64_t f,
                               size_t p) {
    const Json& found = read[p]["frames"][std::to_string(f)];
    ASSERT_EQ(found.contains(Body25().joints()[j]), IsThere(person, j));
    if (!IsThere(person, j)) return;
    const Json& joint = found[Body25().joints()[j]];
    EXPECT_EQ(joint["ncams"], person->inlier_views[j]);
    // Rounding of coordinates of up to 4000 mm.
    EXPECT_LT((VectorOf(joint["point"]) - 1000.0 * person->joints[j].position_m)
                  .norm(),
              1e-11);
  });
}

// ---- COCO's JSON, as its own tools index it: by the ids of images ----

void ExpectCocoPerson(const Detection& person, const Json& entry) {
  const std::vector<double> numbers = entry["keypoints"];
  const std::vector<double> box = entry["bbox"];  // left, top, width, height
  ASSERT_EQ(numbers.size(), 3 * person.joints.size());
  int count = 0;
  for (size_t j = 0; j < person.joints.size(); ++j) {
    const Keypoint& joint = person.joints[j];
    ASSERT_EQ(numbers[3 * j + 2] > 0.0, joint.found);
    if (!joint.found) continue;
    ++count;
    for (size_t axis = 0; axis < 2; ++axis) {
      const double px = numbers[3 * j + axis];
      EXPECT_EQ(px, joint.px[static_cast<Eigen::Index>(axis)]) << "bit for bit";
      // The sum of the box's corner and side may be rounded.
      EXPECT_TRUE(px >= box[axis] && px <= box[axis] + box[axis + 2] + 1e-9);
    }
  }
  EXPECT_EQ(entry["num_keypoints"], count);
}

// Annotations by image name such as "left/3"; also images without annotations.
std::map<std::string, std::vector<Json>> AnnotationsByImage(const Json& data) {
  std::map<int64_t, std::string> images;  // by id
  std::map<std::string, std::vector<Json>> found;
  for (const Json& image : data["images"]) {
    const std::string camera = image["camera"];
    const std::string file = image["file_name"];
    const int64_t frame = image["frame_id"];
    EXPECT_EQ(file.substr(0, camera.size() + 1), camera + "/");
    EXPECT_EQ(std::stoll(file.substr(camera.size() + 1)), frame);
    EXPECT_EQ(image["width"], 1920);
    EXPECT_EQ(image["height"], 1080);
    const std::string key = camera + "/" + std::to_string(frame);
    EXPECT_TRUE(images.emplace(image["id"], key).second);
    found[key];
  }
  std::set<int64_t> ids;
  for (const Json& entry : data["annotations"]) {
    EXPECT_TRUE(ids.insert(entry["id"].get<int64_t>()).second);
    EXPECT_EQ(entry["category_id"], data["categories"][0]["id"]);
    EXPECT_EQ(entry["iscrowd"], 0);
    found.at(images.at(entry["image_id"])).push_back(entry);
  }
  return found;
}

TEST_F(FormatReaders, CocoViewsHasAnAnnotationPerDetection) {
  DetectionSequence recording;
  recording.header.skeleton = Coco17();
  recording.header.view_names = {"left", "right"};
  recording.header.frame_rate_hz = 50.0;
  for (int64_t f = 3; f < 9; ++f) {
    DetectionFrame frame;
    frame.frame = f;
    frame.time = f * 20'000'000;
    frame.views.resize(2);
    for (size_t v = 0; v < 2; ++v) {
      frame.views[v].capture_time = frame.time;
      for (int p = 0; p < static_cast<int>(f % 3); ++p) {
        Detection& detection = frame.views[v].detections.emplace_back();
        detection.index_in_file = p;
        detection.joints.resize(17);
        for (int j = 0; j < 17; ++j) {
          if ((j + p + f) % 5 == 0) continue;
          const double x = 100.0 * static_cast<double>(v) + 7.1 * j + 0.3 * p;
          detection.joints[static_cast<size_t>(j)] = {
              {x, 1.7 * x + static_cast<double>(f)}, 0.25 + 0.01 * j, true};
        }
      }
    }
    recording.frames.push_back(frame);
  }
  WriteDetections(Path("take.jsonl"), recording);
  ConvertFile(Path("take.jsonl"), Path("take.json"),
              "--to=coco_views --image_size=1920,1080");
  const Json data = Json::parse(ReadTextFile(Path("take.json")));
  EXPECT_EQ(data["info"]["frame_rate"], 50.0);
  EXPECT_EQ(data["categories"][0]["skeleton"].size(), Coco17().bones().size());
  EXPECT_EQ(data["categories"][0]["keypoints"], Json(Coco17().joints()));
  const auto found = AnnotationsByImage(data);
  ASSERT_EQ(found.size(), 12u);
  for (const DetectionFrame& frame : recording.frames) {
    for (size_t v = 0; v < 2; ++v) {
      const auto& people = frame.views[v].detections;
      const std::vector<Json>& entries = found.at(
          recording.header.view_names[v] + "/" + std::to_string(frame.frame));
      ASSERT_EQ(entries.size(), people.size());
      for (size_t p = 0; p < people.size(); ++p) {
        ExpectCocoPerson(people[p], entries[p]);
      }
    }
  }
}

// ---- Files written by h5py ----

// Reads a folder of two views with five frames: one animal in frames 0 and 1,
// `animals` from frame 2 on. If `misses_one`, a joint is missing in frame 3.
void ExpectAnimals(const fs::path& views, const std::string& format,
                   size_t animals, bool misses_one) {
  EXPECT_EQ(RecogniseKind(views), FileKind::kDetections);
  const DetectionSequence recording = ReadDetections(views);
  EXPECT_EQ(recording.header.view_names,
            (std::vector<std::string>{"cam0", "cam1"}));
  EXPECT_EQ(recording.header.skeleton.joints(),
            (std::vector<std::string>{"snout", "l_ear", "tail_base"}));
  ASSERT_EQ(recording.frames.size(), 5u);
  for (size_t f = 0; f < 5; ++f) {
    for (size_t v = 0; v < 2; ++v) {
      const auto& found = recording.frames[f].views[v].detections;
      ASSERT_EQ(found.size(), f < 2 ? 1u : animals) << f;
      for (size_t t = 0; t < found.size(); ++t) {
        for (size_t n = 0; n < 3; ++n) {
          const Keypoint& joint = found[t].joints[n];
          ASSERT_EQ(joint.found, !(misses_one && f == 3 && t == 0 && n == 1));
          if (!joint.found) continue;
          const double x = 1.0 + 100.0 * static_cast<double>(v) +
                           10.0 * static_cast<double>(t) +
                           static_cast<double>(n) +
                           static_cast<double>(f) / 8.0;
          EXPECT_EQ(joint.px, Eigen::Vector2d(x, 2.0 * x));
          EXPECT_EQ(joint.confidence, 1.0 / static_cast<double>(1 + n));
        }
      }
    }
  }
  // A truncated file is rejected with its name.
  const TemporaryFolder folder;
  const fs::path one = fs::is_directory(views / "cam0")
                           ? views / "cam0/take.analysis.h5"
                           : views / "cam0.h5";
  const std::string whole = ReadTextFile(one);
  const std::string cut =
      folder.Write("cut.h5", whole.substr(0, whole.size() / 2));
  DetectionReadOptions options;
  options.format = format;
  EXPECT_THAT(testing::InputErrorOf([&] { ReadDetections(cut, options); }),
              HasSubstr("cut.h5"));
}

// Files written by the formats' own libraries (tests/adapters/samples.py).
TEST_F(FormatReaders, FilesOfSleapAndDeepLabCutAreRead) {
  if (!HasPython("h5py, pandas, tables, scipy")) {
    GTEST_SKIP() << "needs python3-h5py, -pandas, -tables and -scipy";
  }
  RunCommand("/usr/bin/python3 '" +
             testing::ProjectFile("tests/adapters/samples.py").string() +
             "' '" + folder_.path().string() + "'");
  ExpectAnimals(folder_.path() / "sleap", "sleap", 2, true);
  EXPECT_EQ(ReadDetections(Path("sleap")).header.skeleton.bones().size(), 2u);
  ExpectAnimals(folder_.path() / "session", "sleap", 2, true);
  ExpectAnimals(folder_.path() / "dlc_one", "deeplabcut_h5", 1, false);
  ExpectAnimals(folder_.path() / "dlc_two", "deeplabcut_h5", 2, false);
  // Two detectors that are an eighth of a pixel apart, less than a twentieth of
  // the animal's box.
  const DetectionSequence fused = ReadDetections(Path("dlc_seeds"));
  EXPECT_EQ(fused.frames.at(0).views.at(0).detections.at(0).joints.at(0).px,
            Eigen::Vector2d(1.0625, 2.0));
}

// ---- COLMAP ----

// Debian's COLMAP reads the converted model and writes it again.
TEST_F(FormatReaders, ColmapReadsTheConvertedModel) {
  if (std::system("colmap help > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "needs colmap";
  }
  KINEGRAPH_DATA_OR_SKIP(shelf, "shelf/calibration.json");
  KINEGRAPH_DATA_OR_SKIP(panoptic,
                         "panoptic/calibration_160422_ultimatum1.json");
  for (const std::string& in : {shelf, panoptic}) {
    const TemporaryFolder folder;
    const std::string ours = folder.path() / "ours";
    const std::string theirs = folder.path() / "theirs";
    ConvertFile(in, ours, "--to=colmap");
    fs::create_directory(theirs);
    RunCommand("colmap model_converter --input_path '" + ours +
               "' --output_path '" + theirs +
               "' --output_type TXT > /dev/null 2>&1");
    const CameraRig rig = ReadCameras(in);
    CameraReadOptions options;
    for (const Camera& camera : rig) options.use.push_back(camera.name());
    const CameraRig again = ReadCameras(theirs, options);
    ASSERT_EQ(again.size(), rig.size());
    for (size_t c = 0; c < rig.size(); ++c) {
      EXPECT_EQ(again[c].width_px(), rig[c].width_px());
      // COLMAP writes 17 digits and normalises the quaternion again.
      EXPECT_LT((again[c].R() - rig[c].R()).norm(), 1e-9);
      EXPECT_LT((again[c].t() - rig[c].t()).norm(), 1e-12);
      EXPECT_LT((again[c].K() - rig[c].K()).norm(), 0.02) << "Shelf's skew";
      const Eigen::Vector3d point(0.3, -0.4, 1.2);
      const auto px = rig[c].Project(point);
      if (!px.has_value()) continue;
      // The omitted skew moves a pixel by at most its own value.
      EXPECT_LT((*again[c].Project(point) - *px).norm(), 0.02);
    }
  }
}

}  // namespace
}  // namespace kinegraph
