// Broken files: each results in one InputError, a single line that names the
// file and the problem; never in a crash, a wrong result or another error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/io/configuration/recording_files.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"
#include "tests/core/io/input_error.h"
#include "tests/support/mat_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::MatCell;
using testing::MatFile;
using testing::MatNumbers;
using testing::TemporaryFolder;
using testing::WithReplaced;

// Name (with folders) and content of each file.
using Files = std::map<std::string, std::string>;

using Reader = void (*)(const std::string& path);
constexpr Reader kDetections = [](const std::string& path) {
  ReadDetections(path);
};
constexpr Reader kTracks = [](const std::string& path) { ReadTracks(path); };
constexpr Reader kHeldOut = [](const std::string& path) {
  ReadHeldOutSet(path);
};

std::string ErrorOf(Reader read, const std::string& path) {
  return InputErrorOf([&] { read(path); });
}

std::string Repeat(const std::string& text, int count,
                   const std::string& separator = ", ") {
  std::string all;
  for (int i = 0; i < count; ++i) all += (i == 0 ? "" : separator) + text;
  return all;
}

// ---- Valid files, which the tests below corrupt ----

std::string OpenPose(int numbers) {
  return "{\"version\": 1.3, \"people\": [{\"person_id\": [-1], "
         "\"pose_keypoints_2d\": [" +
         Repeat("1.5", numbers) + "]}]}";
}

std::string CocoEntry(const std::string& frame = "3") {
  return "{\"image_id\": " + frame + ", \"category_id\": 1, \"keypoints\": [" +
         Repeat("2.5", 51) + "], \"score\": 1}";
}
std::string Coco() { return "[" + CocoEntry() + ", " + CocoEntry() + "]"; }

std::string Longcw2d() {
  return "{\"image_wh\": [360, 288], \"frames\": {\"C0/0.04.jpg\": "
         "{\"camera\": \"C0\", \"timestamp\": 0.04, \"poses\": [{\"id\": 0, "
         "\"points_2d\": [" +
         Repeat("[7, 8]", 14) + "], \"scores\": [" + Repeat("1", 14) + "]}]}}}";
}

const std::string kSkeletonText =
    R"({"name": "s", "joints": ["a", "b"], "bones": [[0, 1]]})";

std::string DetectionHeaderLine() {
  return R"({"kinegraph_detections": 1, "skeleton": )" + kSkeletonText +
         R"(, "frame_rate": 25.0, "views": ["cam0", "cam1"]})"
         "\n";
}
std::string DetectionLine(const std::string& frame = "1") {
  return R"({"frame": )" + frame +
         R"(, "time": 0.04, "views": {"cam1": [{"joints": [[1, 2, 0.5], )"
         R"(null]}]}, "capture_times": {"cam1": 0.05}})"
         "\n";
}
std::string Detections() { return DetectionHeaderLine() + DetectionLine(); }

std::string TrackHeaderLine() {
  return R"({"kinegraph": 1, "units": {"length": "m", "time": "s"}, )"
         R"("skeleton": )" +
         kSkeletonText +
         R"(, "mode": "paper", "frame_rate": 25.0, "views": ["cam0"], )"
         R"("config": {"a": 1}})"
         "\n";
}
const std::string kPersonText =
    R"({"id": 2, "joints": [[1, 2, 3], null], )"
    R"("status": ["observed", "missing"], )"
    R"("covariance": [[1, 0, 0, 1, 0, 1], null], "views": [2, 0], )"
    R"("score": 0.5, "matches": {"cam0": 1}, "weights": {"cam0": [1, null]}})";
std::string TrackLine(const std::string& people) {
  return R"({"frame": 1, "time": 0.04, "people": [)" + people + "]}\n";
}
std::string Tracks() { return TrackHeaderLine() + TrackLine(kPersonText); }

std::string FourDAssociation() {
  return "15 2\n1\n0\n" + Repeat("0.25", 60, " ") + "\n0\n";
}

std::string Longcw3d() {
  return "[{\"timestamp\": 0.04, \"poses\": [{\"id\": 1, \"points_3d\": [" +
         Repeat("[1, 2, 3]", 17) + "], \"scores\": [" + Repeat("1", 17) +
         "]}]}]";
}

std::string Poses() {
  return "{\"unit\": \"m\", \"poses\": [{\"frame\": 3, \"id\": 0, "
         "\"joints\": [" +
         Repeat("[1, 2, 3]", 17) + "]}]}";
}

std::string Panoptic() {
  return "{\"version\": 0.7, \"bodies\": [{\"id\": 4, \"joints19\": [" +
         Repeat("1, 2, 3, 0.5", 19) + "]}]}";
}

std::string HeldOut() {
  return R"({"confidence_at_least": 0.3, "cap_px": 100, )"
         R"("pairing_gate_m": 0.5, "set": [{"camera": 0, "frame": 3, )"
         R"("detection": 1, "person": 2}]})";
}

struct Sample {
  Reader read;
  std::string name;
  std::string content;
};

std::vector<Sample> Samples() {
  return {{kDetections, "take/cam0/a_3_keypoints.json", OpenPose(75)},
          {kDetections, "coco.json", Coco()},
          {kDetections, "longcw.json", Longcw2d()},
          {kDetections, "ours.jsonl", Detections()},
          {kTracks, "ours.jsonl", Tracks()},
          {kTracks, "gt.txt", FourDAssociation()},
          {kTracks, "longcw.json", Longcw3d()},
          {kTracks, "poses.json", Poses()},
          {kTracks, "body3DScene_3.json", Panoptic()},
          {kHeldOut, "set.json", HeldOut()}};
}

// The path to open; for OpenPose the folder of the recording.
std::string PathOf(const TemporaryFolder& folder, const std::string& name) {
  return folder.path() / name.substr(0, name.find('/'));
}

TEST(BrokenFiles, UnbrokenSamplesAreRead) {
  for (const Sample& sample : Samples()) {
    const TemporaryFolder folder;
    folder.Write(sample.name, sample.content);
    EXPECT_NO_THROW(sample.read(PathOf(folder, sample.name))) << sample.name;
  }
}

// ---- Corrupted files ----

// A broken file.
struct Case {
  std::string content;
  std::string expected;         // part of the message
  std::string file = "f.json";  // name of the file
};

void Check(Reader read, const Files& files, const std::string& open,
           const std::string& expected) {
  SCOPED_TRACE(expected);
  const TemporaryFolder folder;
  for (const auto& [name, content] : files) folder.Write(name, content);
  const std::string path = folder.path() / open;
  const std::string message = ErrorOf(read, path);
  EXPECT_THAT(message, HasSubstr(path));
  EXPECT_THAT(message, HasSubstr(expected));
}

TEST(BrokenFiles, OpenPoseFilesAreRefused) {
  // The broken file is the second of a view; the first is valid.
  for (const Case& broken : std::vector<Case>{
           {OpenPose(54), "found 54 numbers"},
           {OpenPose(74), "found 74 numbers"},
           {OpenPose(78), "found 78 numbers"},
           {WithReplaced(OpenPose(75), "1.5", "\"1.5\""),
            "found a text, expected a number"},
           {WithReplaced(OpenPose(75), "[1.5", "1, \"x\": [1.5"),
            "expected an array"},
           {WithReplaced(OpenPose(75), "pose_keypoints_2d", "pose"),
            "pose_keypoints_2d: is missing"},
           {"{}", "people: is missing"},
           {"{\"people\": {}}", "expected an array"},
           {"{\"people\": [7]}", "people[0]: people: found a number"},
           {"[]", "expected an object"},
           {"", "is empty"},
           {" \n ", "is empty"},
           {WithReplaced(OpenPose(75), "1.5", "1e400"), "out of range"},
           {OpenPose(75) + "x", "valid JSON"},
           {OpenPose(75) + OpenPose(75), "valid JSON"},
           {"{\"people\": [], \"x\": \"\xff\"}", "UTF-8"},
           {std::string("{\"people\"\0: []}", 15), "valid JSON"},
           {std::string(5000, '[') + std::string(5000, ']'),
            "nested too deeply"},
       }) {
    Check(kDetections,
          {{"take/cam0/a_1_keypoints.json", OpenPose(75)},
           {"take/cam0/a_2_keypoints.json", broken.content}},
          "take", broken.expected);
  }
}

TEST(BrokenFiles, DetectionFoldersAreRefused) {
  Check(kDetections, {}, "nowhere", "No such file");
  Check(kDetections, {{"x/y", ""}}, "x", "without detections");
  Check(kDetections, {{"t/cam0/readme", ""}}, "t", "no .json");
  Check(kDetections, {{"t/cam0/meta.json", OpenPose(75)}}, "t", "frame number");
  Check(kDetections,
        {{"t/cam0/99999999999999999999_keypoints.json", OpenPose(75)}}, "t",
        "frame number");
  Check(kDetections,
        {{"t/cam0/a_1_keypoints.json", OpenPose(75)},
         {"t/cam0/b_01_keypoints.json", OpenPose(75)}},
        "t", "frame 1: appears twice");
  Check(kDetections, {{"a_1_keypoints.json", OpenPose(75)}},
        "a_1_keypoints.json", "single OpenPose frame");
  Check(kDetections, {{"t/ours.json", Detections()}}, "t", "whole recording");
  Check(kDetections, {{"t/cam0/a_1_keypoints.json", OpenPose(81)}}, "t",
        "detections.skeleton");
}

TEST(BrokenFiles, DetectionsAreRefused) {
  const auto header = [](const char* what, const std::string& with) {
    return WithReplaced(DetectionHeaderLine(), what, with) + DetectionLine();
  };
  const auto line = [](const char* what, const std::string& with) {
    return DetectionHeaderLine() + WithReplaced(DetectionLine(), what, with);
  };
  for (const Case& broken : std::vector<Case>{
           {WithReplaced(Coco(), "image_id", "image"), "image_id: is missing"},
           {"[" + CocoEntry("\"front.jpg\"") + "]",
            "entry 0: 'front.jpg' contains no frame number"},
           {"[" + CocoEntry() + "," + CocoEntry("-1") + "]",
            "entry 1: image_id: found -1"},
           {"[" + CocoEntry("1.5") + "]", "expected an integer"},
           {"[" + CocoEntry("9000000000000000000") + "]", "image_id: found"},
           {WithReplaced(Coco(), "[2.5, 2.5, ", "["),
            "found 49 numbers, expected 51"},
           {"[1]", "entry 0"},
           {"[" + CocoEntry(), "valid JSON"},
           {std::string(100000, '['), "nested too deeply"},
           {WithReplaced(Longcw2d(), "\"camera\"", "\"cam\""),
            "camera: is missing"},
           {"{\"image_wh\": [1, 1], \"frames\": {}}", "frames: is empty"},
           {WithReplaced(Longcw2d(), "0.04, ", "-9.04, "), "timestamp"},
           {WithReplaced(Longcw2d(), "0.04, ", "1e300, "), "timestamp"},
           {WithReplaced(Longcw2d(), "[7, 8], ", ""), "found 13 joints"},
           {WithReplaced(Longcw2d(), "[1, 1", "[1"), "found 13 numbers"},
           {WithReplaced(Longcw2d(), "[7, 8]", "[7, 8, 9]"), "found 3 numbers"},
           {"{\"3d_pairs\": {}}", "smap was removed"},
           {"{\"x\": 1}", "no known"},
           {"hello", "no known"},
           {"", "no known"},
           {Tracks(), "contains tracks"},
           {"{\"kinegraph_detections\": 1", "line 1"},
           {header("detections\": 1", "detections\": 2"),
            "line 1: kinegraph_detections: found 2, expected 1 .. 1"},
           {header("detections\": 1", "detections\": \"1\""), "found a text"},
           {header("\"frame_rate\"", "\"views\": [\"x\"], \"frame_rate\""),
            "line 1: views: appears twice"},
           {header("\"cam0\", \"cam1\"", ""), "views: is empty"},
           {header("cam1", "cam0"), "'cam0' appears twice"},
           {header("\"cam0\"", "0"), "views: found a number"},
           {header("\"skeleton\"", "\"skull\""), "skeleton: is missing"},
           {header(kSkeletonText.c_str(), "\"coco17\""),
            "skeleton: found a text, expected an object"},
           {header("\"b\"", "\"a\""), "'a' appears twice"},
           {header("\"a\", \"b\"", ""), "joints"},
           {header("[0, 1]", "[0, 2]"), "bones"},
           {header("[0, 1]", "[0, 1, 0]"), "bones"},
           {header("25.0", "-25.0"), "frame_rate: is out of range"},
           {header("25.0", "0"), "frame_rate"},
           {header("25.0", "\"25\""), "frame_rate: found a text"},
           {Detections() + DetectionLine(), "line 3: frame: found 1 after 1"},
           {Detections() + DetectionLine("0"), "found 0 after 1"},
           {Detections() + DetectionLine("2"),
            "line 3: time: found 0.040000 after 0.040000"},
           {line("\"frame\": 1", "\"frame\": -1"), "line 2: frame: found -1"},
           {line("\"time\"", "\"frame\": 2, \"time\""),
            "line 2: frame: appears twice"},
           {line("{\"cam1\"", "{\"cam1\": [], \"cam1\""),
            "'cam1' appears twice"},
           {line("\"cam1\"", "\"cam7\""), "'cam7' is not named in the header"},
           {line("{\"cam1\": 0.05", "{\"cam7\": 0.05"), "cam7"},
           {line("0.05", "\"0\""), "capture_times: found a text"},
           {line("0.04", "1e18"), "time: is out of range"},
           {DetectionHeaderLine() + "{\"frame\": 1}", "views: is missing"},
           {DetectionHeaderLine() + "{\"views\": {}}", "frame: is missing"},
           {line("[1, 2, 0.5]", "[1, 2]"),
            "line 2: joints: found 2 numbers, expected 3"},
           {line(", null", ""), "joints: found 1, expected 2"},
           {line("{\"joints\": [[1, 2, 0.5], null]}", "[]"),
            "found an array, expected an object"},
           {line("[1, 2, 0.5]", "\"x\""), "joints: found a text"},
           {line("0.5", "1e400"), "line 2: "},
           {Detections().substr(0, Detections().size() - 3), "line 2: "},
           {Detections() + "{\"frame\": 2, \"views\": {}} 7", "line 3: "},
           {DetectionHeaderLine() + "7", "line 2: the frame: found a number"},
       }) {
    Check(kDetections, {{broken.file, broken.content}}, broken.file,
          broken.expected);
  }
}

TEST(BrokenFiles, TracksAreRefused) {
  const auto header = [](const char* what, const std::string& with) {
    return WithReplaced(TrackHeaderLine(), what, with) + TrackLine(kPersonText);
  };
  const auto person = [](const char* what, const std::string& with) {
    return TrackHeaderLine() + TrackLine(WithReplaced(kPersonText, what, with));
  };
  const auto gt = [](const char* what, const std::string& with) {
    return WithReplaced(FourDAssociation(), what, with);
  };
  Check(kTracks, {}, "nowhere", "No such file");
  Check(kTracks, {{"x/y", ""}}, "x", "is in no known format of tracks");
  for (const Case& broken : std::vector<Case>{
           {"", "no known format"},
           {"{\"x\": 1}", "no known format"},
           {"hello", "no known format"},
           {Detections(), "contains detections"},
           {header("kinegraph\": 1", "kinegraph\": 3"), "line 1: kinegraph"},
           {header("\"m\"", "\"cm\""), "units"},
           {header("\"time\"", "\"tick\""), "time: is missing"},
           {header("{\"a\": 1}", "[1]"), "config: found an array"},
           {header("\"paper\"", "7"), "mode: found a number"},
           {header("\"mode\"", "\"mode\": \"graph\", \"mode\""),
            "mode: appears twice"},
           {TrackHeaderLine() + TrackLine(kPersonText + ", " + kPersonText),
            "line 2: people: id 2 appears twice"},
           {person("\"id\": 2", "\"id\": -2"), "id: found -2"},
           {person("\"id\": 2", "\"id\": 18446744073709551615"), "id: "},
           {person("\"id\": 2", "\"no\": 2"), "id: is missing"},
           {person("\"status\"", "\"state\""), "status: is missing"},
           {person("observed", "guessed"), "found 'guessed'"},
           {person(", \"missing\"]", "]"), "status: found 1 entries"},
           {person("\"missing\"", "\"inferred\""),
            "joint 1 is inferred but its position is null"},
           {person("\"observed\"", "\"missing\""),
            "joint 0 is missing but has a position"},
           {person("[1, 2, 3]", "[1, 2]"), "joints: found 2 numbers"},
           {person("[1, 2, 3]", "null, null"), "joints: found 3 entries"},
           {person("[1, 0, 0, 1, 0, 1]", "[1, 0, 0]"),
            "covariance: found 3 numbers"},
           {person("[1, 0, 0, 1, 0, 1], null", "null"),
            "covariance: found 1 entries"},
           {person("[2, 0]", "[2, -1]"), "views: found -1"},
           {person("[2, 0]", "[2, 0, 0]"), "views: found 3"},
           {person("{\"cam0\": 1}", "{\"cam0\": 1, \"cam0\": 2}"),
            "matches: 'cam0' appears twice"},
           {person("\"cam0\": 1", "\"cam0\": \"1\""), "matches: found a text"},
           {person("\"matches\": {\"cam0\": 1}", "\"matches\": {}"),
            "has no match"},
           {person("[1, null]", "[1]"), "weights: found 1"},
           {person("0.5", "null"), "score: found null"},
           {person("\"score\"", "\"id\": 3, \"score\""), "id: appears twice"},
           {Tracks() + TrackLine(""), "line 3: frame: found 1 after 1"},
           {TrackHeaderLine() + "{\"frame\": 1}", "people: is missing"},
           {Tracks().substr(0, Tracks().size() - 9), "line 2: "},
           {"15 2\n1\n0\n0.25 0.25", "ends before"},
           {gt("15 2", "15 3"), "ends before"},
           {FourDAssociation() + " 1", "text after"},
           {gt("0.25", "nan"), "found 'nan'"},
           {gt("0.25", "-inf"), "found '-inf'"},
           {gt("0.25", "1e400"), "found '1e400'"},
           {gt("0.25", "0.25x"), "line 4: "},
           {gt("\n1\n", "\n-1\n"), "number of people"},
           {gt("\n1\n", "\n1000000000\n"), "line "},
           {gt("15 2", "15 99999999999999"), "number of frames"},
           {gt("\n0\n", "\n0.5\n"), "id of a person"},
           {gt("15 2", "16 2"), "found 16 joints"},
           {gt("15 2", "0 2"), "number of joints"},
           {"15 1\n2\n" + Repeat("3 " + Repeat("0", 60, " "), 2, "\n"),
            "person 3 appears twice"},
           {WithReplaced(Longcw3d(), "\"id\": 1", "\"id\": -1"), "entry 0: id"},
           {WithReplaced(Longcw3d(), "\"id\": 1",
                         "\"id\": 118446744073709551615"),
            "valid JSON"},
           {WithReplaced(Longcw3d(), "[1, 2, 3], ", ""), "found 16 joints"},
           {WithReplaced(Longcw3d(), "[1, 1,", "[1,"),
            "scores: found 16 numbers"},
           {WithReplaced(Longcw3d(), "timestamp", "t"),
            "timestamp: is missing"},
           {WithReplaced(Longcw3d(), "0.04", "-0.04"), "timestamp"},
           {"[{\"timestamp\": 1, \"poses\": []}, "
            "{\"timestamp\": 1.01, \"poses\": []}]",
            "entry 1: frame 25 appears twice"},
           {Coco(), "poses: is missing"},
           {WithReplaced(Poses(), "\"m\"", "\"mm\""), "unit: found 'mm'"},
           {WithReplaced(Poses(), "3,", "-3,"), "poses[0]: frame: found -3"},
           {WithReplaced(Poses(), "[1, 2, 3], ", ""), "joints: found 16"},
           {WithReplaced(Poses(), "[1, 2, 3]", "\"x\""), "found a text"},
           {WithReplaced(Poses(), "[{",
                         "[{\"frame\": 3, \"id\": 0, \"joints\": [" +
                             Repeat("null", 17) + "]}, {"),
            "poses[1]: frame 3: person 0 appears twice"},
           {Panoptic(), "frame number", "body.json"},
           {WithReplaced(Panoptic(), "1, 2, 3, ", ""),
            "joints19: found 73 numbers", "body_1.json"},
           {WithReplaced(
                Panoptic(), "[{",
                "[{\"id\": 4, \"joints19\": [" + Repeat("0", 76) + "]}, {"),
            "person 4 appears twice", "body_1.json"},
           {"MATLAB rules", "is in no known format of tracks"},
           {"MATLAB 5.0" + std::string(116, ' ') + "IM", "is truncated"},
           {"MATLAB 5.0" + std::string(116, ' ') + "MI",
            "is truncated or damaged"},
           {std::string(100000, '['), "nested too deeply"},
           {WithReplaced(Longcw3d(), "[1, 2, 3]",
                         std::string(5000, '[') + std::string(5000, ']')),
            "nested too deeply"},
       }) {
    Check(kTracks, {{broken.file, broken.content}}, broken.file,
          broken.expected);
  }
}

TEST(BrokenFiles, HeldOutSetsAreRefused) {
  const auto set = [](const char* what, const std::string& with) {
    return WithReplaced(HeldOut(), what, with);
  };
  Check(kHeldOut, {}, "nowhere", "No such file");
  Check(kHeldOut, {{"x/y", ""}}, "x", "is a folder");
  for (const Case& broken : std::vector<Case>{
           {set("\"set\"", "\"sets\""), "set: is missing"},
           {set("pairing_gate_m", "gate"), "pairing_gate_m: is missing"},
           {set("100", "-100"), "cap_px"},
           {set("\"frame\": 3", "\"frame\": -3"), "set[0]: frame"},
           {set("\"detection\": 1", "\"detection\": -1"), "detection"},
           {set("\"detection\": 1", "\"detection\": 9999999999"), "detection"},
           {set("\"person\"", "\"who\""), "person: is missing"},
       }) {
    Check(kHeldOut, {{broken.file, broken.content}}, broken.file,
          broken.expected);
  }
}

// Python writes NaN and Infinity into JSON, JavaScript null.
TEST(NotANumber, IsAMissingJoint) {
  const TemporaryFolder folder;
  const auto found = [&](const std::string& content, const std::string& what,
                         const std::string& name) {
    std::vector<int> counts;
    for (const std::string number : {"NaN", "-Infinity", "Infinity", "null"}) {
      folder.Write(name, WithReplaced(content, what, number));
      const DetectionSequence read = ReadDetections(PathOf(folder, name));
      const Detection* person = nullptr;
      for (const ViewDetections& view : read.frames.at(0).views) {
        if (!view.detections.empty()) person = &view.detections[0];
      }
      counts.push_back(CountFound(*person));
    }
    return counts;
  };
  EXPECT_THAT(found(OpenPose(75), "1.5", "t/cam0/1_keypoints.json"),
              ::testing::Each(24));
  EXPECT_THAT(found(Coco(), "2.5", "cam0.json"), ::testing::Each(16));
  EXPECT_THAT(found(Detections(), "0.5", "d.jsonl"), ::testing::Each(0));
  for (const std::string number : {"NaN", "-Infinity", "null"}) {
    folder.Write("p.json",
                 WithReplaced(Poses(), "[1, 2, 3]", "[" + number + ", 2, 3]"));
    EXPECT_EQ(CountPresent(ReadTracks(PathOf(folder, "p.json"))
                               .frames.at(0)
                               .people.at(0)
                               .joints),
              16);
  }
}

TEST(BrokenFiles, HundredMegabytesOfBracketsAreRefused) {
  const TemporaryFolder folder;
  const std::string brackets(size_t{100} << 20, '[');
  const std::string array = folder.Write("a.json", brackets);
  EXPECT_THAT(ErrorOf(kDetections, array), HasSubstr("too deeply"));
  EXPECT_THAT(ErrorOf(kTracks, array), HasSubstr("too deeply"));
  const std::string line =
      folder.Write("line.jsonl", DetectionHeaderLine() + brackets);
  EXPECT_THAT(ErrorOf(kDetections, line),
              HasSubstr("line 2: is longer than 64 MiB"));
}

// ---- .mat ----

// One cell of frames per actor.
std::string WriteMat(const TemporaryFolder& folder, const std::string& variable,
                     const std::vector<std::string>& actors) {
  const auto count = static_cast<int32_t>(actors.size());
  return folder.Write("actorsGT.mat",
                      MatFile(MatCell(1, count, actors, variable)));
}

std::vector<std::string> TwoActors(const std::string& first_entry) {
  const std::string nobody = MatNumbers(0, 0, 0);
  return {MatCell(3, 1, {first_entry, nobody, MatNumbers(14, 3, 2)}),
          MatCell(3, 1, {nobody, nobody, MatNumbers(14, 3, 3)})};
}

TEST(BrokenFiles, MatFileWithNaNAndEmptyCellsIsRead) {
  const TemporaryFolder folder;
  const TrackSequence truth = ReadTracks(
      WriteMat(folder, "actor3D", TwoActors(MatNumbers(14, 3, NAN))));
  ASSERT_EQ(truth.frames.size(), 3u);
  EXPECT_EQ(CountPresent(truth.frames[0].people.at(0).joints), 0);  // NaN
  EXPECT_TRUE(truth.frames[1].people.empty());
  EXPECT_EQ(truth.frames[2].people.at(1).joints[13].position_m.z(), 3.0);
}

TEST(BrokenFiles, MatFilesOfWrongShapesAreRefused) {
  const auto error = [](const std::string& variable,
                        const std::vector<std::string>& actors) {
    const TemporaryFolder folder;
    return ErrorOf(kTracks, WriteMat(folder, variable, actors));
  };
  EXPECT_THAT(error("actor2D", TwoActors(MatNumbers(14, 3, 0))),
              HasSubstr("actor3D: is missing"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(15, 3, 0))),
              HasSubstr("actor3D{1}{1}: expected 14 x 3"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(14, 2, 0))),
              HasSubstr("actor3D{1}{1}: expected 14 x 3"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(14, 3, INFINITY))),
              HasSubstr("actor3D{1}{1}: contains an infinite"));
  EXPECT_THAT(error("actor3D", {MatNumbers(14, 3, 0)}),
              HasSubstr("actor3D{1}: is not a cell"));
  EXPECT_THAT(
      error("actor3D",
            {MatCell(1, 1, {MatNumbers(14, 3, 0)}),
             MatCell(2, 1, {MatNumbers(14, 3, 0), MatNumbers(0, 0, 0)})}),
      HasSubstr("actor3D{2}: found 2 frames, expected 1"));
}

}  // namespace
}  // namespace kinegraph
