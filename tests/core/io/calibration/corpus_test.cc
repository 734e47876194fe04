// One small valid file of each of nine formats, and variants: broken files must
// result in a one-line InputError that names file and problem, the lens is read
// under any of its names, and unknown keys are rejected.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/core/io/calibration/calibration_files.h"

namespace kinegraph {
namespace {

using testing::CamerasOf;
using ::testing::ElementsAre;
using testing::FaultOf;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::LensOf;
using testing::OpencvMatrix;
using ::testing::StartsWith;
using testing::TemporaryFolder;
using testing::WithReplaced;

// MORE is replaced by further keys of the first camera.
const std::string kOwn =
    R"({"kinegraph_cameras": 1, "units": {"length": "m"}, "cameras": [
{"name": "a", "image_size": [640, 480], "model": "opencv5",
 "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]],
 "distortion": [0.1, 0, 0, 0, 0],
 "cam_from_world": {"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [1, 2, 3]}},
{"name": "b", "image_size": null, "model": "pinhole",
 "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]], "distortion": [],
 "cam_from_world": {"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 3]}}
]})";
const std::string kKrt =
    R"({"0": {"K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
"RT": [1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 3], "imgSize": [640, 480]MORE},
"1": {"K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
"RT": [1, 0, 0, -0.5, 0, 1, 0, 0.25, 0, 0, 1, 3], "imgSize": [640, 480]}})";
const std::string kVoxelpose =
    R"({"0": {"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "T": [[1], [2], [-3000]],
"fx": 600, "fy": 601, "cx": 320, "cy": 240MORE}})";
const std::string kLongcw =
    R"({"cameras": {"Camera0": {"K": [[1.2, 0, 0.5], [0, 1.5, 0.45], [0, 0, 1]],
"Tw": [[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]MORE}}})";
const std::string kPanoptic =
    R"({"cameras": [{"name": "00_01", "type": "hd", "resolution": [640, 480],
"K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]],
"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [[1], [2], [300]]MORE}]})";
const std::string kPose2sim = R"([cam_01]
name = "cam_01"
size = [ 640.0, 480.0]
matrix = [ [ 600.0, 0.0, 320.0], [ 0.0, 600.0, 240.0], [ 0.0, 0.0, 1.0]]
rotation = [ 0.1, 0.2, 0.3]
translation = [ 1.0, 2.0, 3.0]
MORE[metadata]
adjusted = false
)";
const std::string kTum = "600,0,320,1\n0,600,240,2\n0,0,1,3\n";
const std::string kIdentity = "1, 0, 0, 0, 1, 0, 0, 0, 1";
const std::string kK = "600, 0, 320, 0, 600, 240, 0, 0, 1";
const std::string kEasymocap = "%YAML:1.0\n---\nnames:\n  - \"1\"\n" +
                               OpencvMatrix("K_1", "3", "3", kK) + "MORE" +
                               OpencvMatrix("Rot_1", "3", "3", kIdentity) +
                               OpencvMatrix("T_1", "3", "1", "1, 2, 3");
const std::string kOpencv =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n" +
    OpencvMatrix("camera_matrix", "3", "3", kK) + "MORE" +
    OpencvMatrix("R", "3", "3", kIdentity) +
    OpencvMatrix("T", "3", "1", "1, 2, 3");

// A change that makes a valid file invalid: `from` is replaced by `to`; but if
// `from` is "]})", it is appended to the file.
struct Change {
  std::string from;
  std::string to;
  // Text that the message must contain.
  const char* says;
};

// A key with the value `value` in the syntax of a format.
using Member = std::string (*)(const std::string& key,
                               const std::string& value);
std::string JsonMember(const std::string& key, const std::string& value) {
  return ", \"" + key + "\": " + value;
}
std::string TomlMember(const std::string& key, const std::string& value) {
  return key + " = " + value + "\n";
}
std::string YamlMember(const std::string& key, const std::string& value) {
  return key + ": " + value + "\n";
}
std::string EasymocapMember(const std::string& key, const std::string& value) {
  return key + "_1: " + value + "\n";
}

struct Sample {
  std::string file;
  std::string text;
  std::string lens;  // replaces MORE in the valid file
  Member member;     // nullptr: no other keys are tried
  std::vector<Change> changes;
  CameraReadOptions options = {};

  std::string With(const std::string& more) const {
    return text.find("MORE") == std::string::npos
               ? text
               : WithReplaced(text, "MORE", more);
  }
  std::string Text() const { return With(lens); }
};

CameraReadOptions Sized() {
  CameraReadOptions options;
  options.image_size = {640, 480};
  return options;
}

std::vector<Sample> Samples() {
  return {
      {"own.json",
       kOwn,
       "",
       nullptr,
       {
           {"cameras\": 1", "cameras\": 2", "kinegraph_cameras"},
           {"\"m\"", "\"ft\"", "length"},
           {"\"cameras\": [", "\"cams\": [", "cameras"},
           {"\"cameras\": [", "\"cameras\": {}, \"x\": [", "an object"},
           {"\"b\"", "\"a\"", "camera 'a': appears twice"},
           {"\"b\"", "\"\"", "empty name"},
           {"\"name\": \"b\", ", "", "name"},
           {"\"name\": \"b\"", "\"name\": 3", "name"},
           {"\"model\": \"pinhole\"",
            "\"model\": \"pinhole\", \"model\": \"opencv5\"",
            "key 'model': appears twice"},
           {"[640, 480]", "[-640, 480]", "-640 x 480"},
           {"[640, 480]", "[0, 480]", "0 x 480"},
           {"[640, 480]", "[640.5, 480]", "640.5"},
           {"[640, 480]", "[1e12, 480]", "image size"},
           {"[640, 480]", "[640]", "image_size"},
           {"\"opencv5\"", "\"fisheye\"", "fisheye"},
           {"[0.1, 0, 0, 0, 0]", "[0.1, 0, 0]", "3"},
           {"[0.1, 0, 0, 0, 0]", "[\"0.1\", 0]", "'0.1'"},
           {"[600, 0, 320]", "[\"600\", 0, 320]", "K"},
           {"[600, 0, 320], ", "", "3 x 3"},
           {"[600, 0, 320]", "[600, 0]", "3 x 3"},
           {"[600, 0, 320]", "[0, 0, 320]", "K"},
           {"[600, 0, 320]", "[-600, 0, 320]", "K"},
           {"[[600, 0, 320], [0, 600, 240], [0, 0, 1]]",
            "[[600, 0, 0], [0, 600, 0], [320, 240, 1]]", "K"},
           {"[[600, 0, 320], [0, 600, 240], [0, 0, 1]]", "null", "null"},
           {"[1, 2, 3]", "[1, 2, NaN]", "not JSON"},
           {"[1, 2, 3]", "[1, 2, Infinity]", "not JSON"},
           {"[1, 2, 3]", "[1, 2, 1e400]", "1e400"},
           {"[1, 2, 3]", "[1, 2, 1e308]", "too large"},
           {"[[1, 0, 0]", "[[2, 0, 0]", "not a rotation"},
           {"[[1, 0, 0]", "[[-1, 0, 0]", "not a rotation"},
           {"[[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
            "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "not a rotation"},
           {"cam_from_world", "world_from_cam", "cam_from_world"},
           {"\"cam_from_world\": {", "\"cam_from_world\": [], \"x\": {",
            "array"},
           {"]})", "", "not JSON"},
       }},
      {"krt.json",
       kKrt,
       "",
       JsonMember,
       {
           {"[600, 0, 320, 0,", "[600, 0, 320,", "3 x 3"},
           {"[1, 0, 0, 0.5,", "[1, 0, 0,", "3 x 4"},
           {"\"RT\"", "\"Rt\"", "known format"},
           {"\"RT\": [1, 0, 0, -0.5", "\"Rt\": [1, 0, 0, -0.5",
            "camera '1': has no key 'RT'"},
           {"\"1\": {\"K\"", "\"1\": [1], \"2\": {\"K\"", "camera '1'"},
           {"\"1\":", "\"0\":", "key '0': appears twice"},
           {"[640, 480]", "[1e400, 480]", "1e400"},
           {"[640, 480]", "[640, -480]", "640 x -480"},
           {"\"imgSize\"", "\"distCoeff\": [0, 0, 0, 0, 0, 0.1], \"imgSize\"",
            "6 coefficients"},
       }},
      {"voxelpose.json",
       kVoxelpose,
       R"(, "k": [[0], [0], [0]], "p": [[0], [0]])",
       JsonMember,
       {
           {"[[1], [2], [-3000]]", "[[1], [2]]", "T"},
           {"[[1], [2], [-3000]]", "[[1, 2], [3], [4]]", "T"},
           {"\"fx\": 600", "\"fx\": \"600\"", "fx"},
           {"\"fx\": 600", "\"fx\": 0", "K"},
           {"\"cy\"", "\"dy\"", "cy"},
           {"\"p\"", "\"q\"", "p"},
           {"[[0], [0], [0]]", "[[0], [0]]", "k"},
           {"[0, 1, 0]", "[0, 1.1, 0]", "not a rotation"},
       }},
      {"longcw.json",
       kLongcw,
       R"(, "dist_coeffs": [0, 0, 0, 0])",
       JsonMember,
       {
           {"[0, 0, 0, 1]", "[0, 0, 1, 1]", "0 0 0 1"},
           {", [0, 0, 0, 1]]", "]", "4 x 4"},
           {"\"Tw\"", "\"tw\"", "known format"},
           {"[[1, 0, 0, 7]", "[[1, 1, 0, 7]", "not a rotation"},
           {"1.2", "0", "K"},
           {"\"Camera0\"", "\"\"", "empty name"},
       },
       Sized()},
      {"panoptic.json",
       kPanoptic,
       R"(, "distCoef": [0.1, 0, 0, 0, 0])",
       JsonMember,
       {
           {"\"name\"", "\"nom\"", "camera 0"},
           {"[{\"name\"", "[7, {\"name\"", "camera 0"},
           {"\"t\"", "\"T\"", "camera '00_01': has no key 't'"},
           {"[[1], [2], [300]]", "[1, 2, 3, 4]", "t"},
           {"[[1], [2], [300]]", "[[[1]], [[2]], [[3]]]", "t"},
           {"[{\"name\"", "[], \"comment\": [{\"name\"", "no cameras"},
       }},
      {"pose2sim.toml",
       kPose2sim,
       "distortions = [ 0.1, 0.0, 0.0, 0.0]\nfisheye = false\n",
       TomlMember,
       {
           {"2.0, 3.0]", "nan, 3.0]", "not finite"},
           {"2.0, 3.0]", "-inf, 3.0]", "not finite"},
           {"2.0, 3.0]", "1e400, 3.0]", ""},
           {"false", "'no'", "fisheye"},
           {"0.2, 0.3]", "0.3]", "rotation"},
           {"matrix", "matrices", "matrix"},
           {"640.0, 480.0]", "640.0, -480.0]", "640 x -480"},
           {"fisheye = false", "fisheye = false\nname = 'x'",
            ":9: is not TOML"},
           {"[metadata]", "[cam_01]", "not TOML"},
           {"\"cam_01\"", "\"cam_01", "not TOML"},
           {"[cam_01]", "error = 1\n[cam_01]", "camera 'error'"},
           {"[ 0.1, 0.2, 0.3]", "1979-05-27", "1979-05-27"},
           {"[cam_01]", "[metadata]\n[metadata.x]", ""},
       }},
      {"P0.txt",
       kTum,
       "",
       nullptr,
       {
           {"240", "nan", "nan"},
           {"240", "inf", "inf"},
           {"240", "1e400", ""},
           {"0,0,1,3", "0,0,1", "11 numbers"},
           {"0,0,1,3", "0,0,1,3,4", "13 numbers"},
           {"0,600,240,2", "600,0,320,2", "singular"},
           {"600,0,320,1\n0,600,240,2\n0,0,1,3", "0 0 0 0\n0 0 0 0\n0 0 0 0",
            "singular"},
           {"240", "x", "known format"},
       }},
      {"easymocap.yml",
       kEasymocap,
       OpencvMatrix("dist_1", "1", "5", "0.1, 0, 0, 0, 0"),
       EasymocapMember,
       {
           {"K_1", "K_2", "K_1"},
           {"Rot_1", "Rot_2", "'R_1' or 'Rot_1'"},
           {"T_1", "T_2", "T_1"},
           {"data: [1, 2, 3]", "data: [1, 2]", "3 x 1"},
           {"rows: 3\n  cols: 1", "rows: 99999999999\n  cols: 1", "expected"},
           {"rows: 3\n  cols: 1", "rows: -3\n  cols: -1", "expected"},
           {"data: [1, 2, 3]", "data: [1, nan, 3]", "not finite"},
           {"data: [1, 2, 3]", "data: [1, .Inf, 3]", ".Inf"},
           {"data: [1, 2, 3]", "data: [1, \"2\", 3]", "'2'"},
           {"T_1", "K_1", "key 'K_1' appears twice"},
           {"  - \"1\"", "  - \"1\"\n  - \"1\"", "appears twice"},
           {"\n  - \"1\"", " one", "names"},
           {"names:", "names: [", "not YAML"},
           {"names:", "a: 1\n---\nnames:", "more than one YAML document"},
           {"names:", "nomes:", "known format"},
           {"data: [1, 0, 0", "data: [1, 0, 1", "not a rotation"},
       }},
      {"opencv.yml",
       kOpencv,
       OpencvMatrix("distortion_coefficients", "5", "1", "0.1, 0, 0, 0, 0"),
       YamlMember,
       {
           {"\nR:", "\nQ:", "'rvec' or 'R'"},
           {"\nT:", "\nU:", "'tvec' or 'T'"},
           {"image_width", "distortion_model: mei\nimage_width",
            "distortion_model"},
           {"640", "wide", "image_width"},
           {"rows: 3\n  cols: 1", "rows: 1\n  cols: 1", "1 x 1"},
           {"rows: 5", "rows: 8", "8 x 1"},
       }},
  };
}

TEST(CalibrationCorpus, ChangedFilesAreRefused) {
  for (const Sample& sample : Samples()) {
    for (const Change& change : sample.changes) {
      SCOPED_TRACE(sample.file + ": " + change.from + " -> " + change.to);
      const std::string broken =
          change.from == "]})"
              ? sample.Text() + "]})"
              : WithReplaced(sample.Text(), change.from, change.to);
      EXPECT_THAT(FaultOf(sample.file, broken, sample.options),
                  HasSubstr(change.says));
    }
  }
}

std::string Repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST(CalibrationCorpus, HostileFilesAreRefused) {
  const TemporaryFolder folder;
  const std::string brackets(10 << 20, '[');
  const std::string braces = Repeated("{\"a\":", 1 << 20);
  std::string wide = "{";
  for (int i = 0; i < 5000; ++i) {
    wide += (i == 0 ? "\"" : ",\"") + std::to_string(i) + "\":1";
  }
  // Ten levels of ten elements each, which are aliases except in the first:
  // 10^10 values in a few lines.
  std::string aliases = "names: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    aliases +=
        "k" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last;
    for (int k = 1; k < 10; ++k) aliases += ", " + last;
    aliases += "]\n";
  }
  const std::vector<std::pair<std::string, std::string>> files = {
      {"empty.json", ""},
      {"empty.toml", ""},
      {"empty.yml", ""},
      {"empty", ""},
      {"blank.json", " \n\t\n"},
      {"directive.yml", "%YAML:1.0"},
      {"directive2.yml", "%YAML:1.0\n---\n"},
      {"scalar.yml", "3"},
      {"null.json", "null"},
      {"number.json", "12"},
      {"list.json", "[]"},
      {"object.json", "{}"},
      {"text.json", "\"cameras\""},
      {"cameras.json", "{\"cameras\": 3}"},
      {"cameras2.json", "{\"cameras\": {}}"},
      {"cameras3.json", "{\"cameras\": [[]]}"},
      {"binary", std::string("\x00\x01\x02\xff\xfe", 5)},
      {"prose.txt", "Dear camera,\nplease stand still.\n"},
      {"bom.json", "\xEF\xBB\xBF{\"0\": 3}"},
      {"utf16.json", std::string("\xFF\xFE{\0}\0", 6)},
      {"brackets.json", brackets},
      {"brackets.toml", brackets},
      {"brackets.yml", brackets},
      {"brackets", brackets},
      {"nested.json", "{\"a\": " + brackets},
      {"nested.toml", "a = " + brackets},
      {"nested.yml", "a: " + brackets},
      {"braces.json", braces},
      {"braces.yml", "%YAML:1.0\n" + braces},
      {"dashes.yml", "%YAML:1.0\n" + std::string(100000, '-')},
      {"wide.json", wide + "}"},
      {"aliases.yml", aliases},
      {"dotted.toml", "[" + Repeated("a.", 100000) + "a]\n"},
      {"spaces.txt", std::string(1000000, ' ')},
      {"numbers.txt", Repeated("1 ", 1000000)},
  };
  for (const auto& [name, text] : files) {
    SCOPED_TRACE(name);
    const std::string path = folder.Write(name, text);
    EXPECT_THAT(InputErrorOf([&] { ReadCameras(path); }), StartsWith(path));
  }
}

TEST(CalibrationCorpus, InvalidPathsAreRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "empty");
  std::filesystem::create_directory(folder.path() / "P1.txt");
  std::filesystem::create_symlink("loop", folder.path() / "loop");
  const std::string file = folder.Write("file", kTum);
  const std::string easymocap = folder.Write("alone/intri.yml", kEasymocap);
  for (const std::string& path :
       {(folder.path() / "none.json").string(),
        (folder.path() / "empty").string(), folder.path().string(),
        (folder.path() / "loop").string(), file + "/below",
        (folder.path() / std::string(300, 'x')).string(), std::string("")}) {
    SCOPED_TRACE(path);
    for (const std::string& format : CalibrationFormatNames()) {
      CameraReadOptions options;
      options.format = format;
      InputErrorOf([&] { ReadCameras(path, options); });
    }
  }
  EXPECT_THAT(InputErrorOf([&] { ReadCameras(easymocap); }),
              HasSubstr("extri.yml"));
}

// Each sample is valid in its own format only.
TEST(CalibrationCorpus, WrongFormatsAreRefused) {
  const TemporaryFolder folder;
  for (const Sample& sample : Samples()) {
    const std::string path = folder.Write(sample.file, sample.Text());
    std::vector<std::string> accepted;
    for (const std::string& format : CalibrationFormatNames()) {
      CameraReadOptions options = sample.options;
      options.format = format;
      try {
        ReadCameras(path, options);
        accepted.push_back(format);
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), StartsWith(path));
      }
    }
    EXPECT_THAT(accepted, ElementsAre("auto", ::testing::_)) << sample.file;
  }
}

// ---- Keys ----

std::vector<Sample> SamplesOfKeys() {
  std::vector<Sample> samples = Samples();
  samples.erase(
      std::remove_if(samples.begin(), samples.end(),
                     [](const Sample& one) { return one.member == nullptr; }),
      samples.end());
  return samples;
}

// A sample with further keys of its first camera.
class CalibrationKeys : public ::testing::TestWithParam<Sample> {
 protected:
  static Camera Read(const std::string& more) {
    return CamerasOf(GetParam().file, GetParam().With(more),
                     GetParam().options)[0];
  }
  static void ExpectLens(const std::string& more,
                         const std::vector<double>& terms) {
    EXPECT_EQ(LensOf(Read(more)), terms) << more;
  }
  static void ExpectRefusal(const std::string& more, const std::string& said) {
    EXPECT_THAT(
        FaultOf(GetParam().file, GetParam().With(more), GetParam().options),
        HasSubstr(said));
  }
  static std::string Key(const std::string& key, const std::string& value) {
    return GetParam().member(key, value);
  }
};

TEST_P(CalibrationKeys, LensTermsAreReadUnderAllKeys) {
  EXPECT_EQ(Read("").lens(), nullptr);
  const std::vector<double> terms = {-0.2, 0.05, 0.001, -0.002, 0.01};
  for (const char* key :
       {"distCoeffs", "distCoeff", "distCoef", "dist_coeffs", "dist", "D",
        "distortion", "distortions", "distortion_coefficients"}) {
    ExpectLens(Key(key, "[-0.2, 0.05, 0.001, -0.002, 0.01]"), terms);
  }
  // Term by term.
  ExpectLens(Key("k1", "-0.2") + Key("k2", "0.05") + Key("k3", "0.01") +
                 Key("p1", "0.001") + Key("p2", "-0.002"),
             terms);
}

TEST_P(CalibrationKeys, TwoLensesMustAgree) {
  const std::string first = Key("distCoeffs", "[-0.2, 0.05, 0, 0]");
  EXPECT_NO_THROW(Read(first + Key("dist", "[-0.2, 0.05, 0, 0, 0]")));
  ExpectRefusal(first + Key("dist", "[0.2, 0, 0, 0]"),
                "specifies its lens twice");
}

TEST_P(CalibrationKeys, UnsupportedLensModelsAreRefused) {
  EXPECT_NO_THROW(Read(Key("camera_model", "\"pinhole\"")));
  for (const char* model : {"\"mei\"", "\"double_sphere\"", "\"omni\""}) {
    ExpectRefusal(Key("distortion_model", model), "distortion_model");
  }
  ExpectRefusal(Key("omnidirectional", "1"), "omnidirectional");
}

TEST_P(CalibrationKeys, FisheyeLensIsReadUnderAllKeys) {
  const std::string list = Key("dist", "[0.1, -0.02, 0.003, 0.001]");
  const std::string terms = Key("k1", "0.1") + Key("k2", "-0.02") +
                            Key("k3", "0.003") + Key("k4", "0.001");
  for (const std::string& more :
       {Key("distortion_model", "\"equidistant\"") + list,
        Key("fisheye_model", "1") + list,
        Key("distortion_model", "\"fisheye\"") + terms}) {
    ExpectLens(more, {0.1, -0.02, 0.003, 0.001});
    EXPECT_EQ(Read(more).lens()->model(), kFisheyeModel);
  }
}

TEST_P(CalibrationKeys, ErrorNamesAnUnknownKey) {
  for (const std::string key :
       {"distorsion", "R_rect", "orientation", "camera_pose", "extrinsics",
        "skew", "xi", "thin_prism"}) {
    ExpectRefusal(Key(key, "[0.1, 0.2, 0.3]"), "'" + key);
    ExpectRefusal(Key(key, "[0.1, 0.2, 0.3]"), "may describe lens or pose");
  }
}

TEST_P(CalibrationKeys, KnownMetadataKeysAreIgnored) {
  std::string more;
  for (const char* key :
       {"date", "calibration_time", "serialNumber", "rms", "flags", "comment",
        "avg_reprojection_error", "square_size", "fps", "_note"}) {
    more += Key(key, "\"some text\"");
  }
  EXPECT_NO_THROW(Read(more));
}

INSTANTIATE_TEST_SUITE_P(EachFormat, CalibrationKeys,
                         ::testing::ValuesIn(SamplesOfKeys()),
                         [](const auto& sample) {
                           const std::string& file = sample.param.file;
                           return file.substr(0, file.find('.'));
                         });

// The key "unit" is a member beside the cameras, before or after them.
TEST(CalibrationUnit, IsReadFromTheFile) {
  const std::string text =
      R"({"0": {"K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
"RT": [1, 0, 0, 1000, 0, 1, 0, 2000, 0, 0, 1, 3000]}, "unit": "mm"})";
  for (const char* unit : {"\"mm\"", "\"millimetres\"", "\"millimeters\""}) {
    EXPECT_EQ(CamerasOf("krt.json", WithReplaced(text, "\"mm\"", unit))[0].t(),
              Eigen::Vector3d(1.0, 2.0, 3.0))
        << unit;
  }
  EXPECT_THAT(FaultOf("krt.json", WithReplaced(text, "\"mm\"", "\"ft\"")),
              HasSubstr("unit: found the text 'ft'"));
  std::string first = WithReplaced(text, R"(, "unit": "mm")", "");
  first.replace(0, 1,
                R"({"_comment": "lab", "date": 20240501, "unit": "mm", )");
  EXPECT_EQ(CamerasOf("krt.json", first)[0].t(),
            Eigen::Vector3d(1.0, 2.0, 3.0));
}

// Two representations of one pose must agree.
TEST(CalibrationPose, TwoSpellingsMustAgree) {
  const std::string text =
      "K: [[600, 0, 320], [0, 600, 240], [0, 0, 1]]\n"
      "rvec: [0, 0, 0]\ntvec: [1, 2, 3]\n"
      "R: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n";
  CameraReadOptions options;
  options.format = "opencv";
  EXPECT_NO_THROW(CamerasOf("a.yml", text + "T: [1, 2, 3]\n", options));
  EXPECT_THAT(FaultOf("a.yml", text + "T: [1, 2, 4]\n", options),
              HasSubstr("contradicts tvec"));
}

}  // namespace
}  // namespace kinegraph
