// Broken files: each ends in one InputError, a single line that names the file
// and says what is wrong; never in a crash, a wrong answer or another error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/configuration/held_out_set.h"
#include "core/io/detections/source.h"
#include "core/io/tracks/tracks.h"
#include "tests/support/mat_file.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

using ::testing::HasSubstr;
using testing::MatCell;
using testing::MatFile;
using testing::MatNumbers;
using ::testing::Not;
using testing::TemporaryFolder;

// Name (with folders) and content of each file.
using Files = std::map<std::string, std::string>;

enum class Kind { kDetections, kTracks, kHeldOut };

void ReadAs(Kind kind, const std::string& path) {
  switch (kind) {
    case Kind::kDetections:
      ReadDetections(path);
      break;
    case Kind::kTracks:
      ReadTracks(path);
      break;
    case Kind::kHeldOut:
      ReadHeldOutSet(path);
      break;
  }
}

// The message of the InputError, or what else happened.
std::string ErrorOf(Kind kind, const std::string& path) {
  try {
    ReadAs(kind, path);
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("NOT AN INPUT ERROR: ") + error.what();
  }
  return "NO ERROR";
}

std::string Repeat(const std::string& text, int count,
                   const std::string& separator = ", ") {
  std::string all;
  for (int i = 0; i < count; ++i) all += (i == 0 ? "" : separator) + text;
  return all;
}

std::string Replaced(std::string text, const std::string& what,
                     const std::string& with) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

// --- Good files, which the corpus spoils -----------------------------------

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

std::string Smap() {
  return "{\"model_pattern\": \"MIX\", \"3d_pairs\": {\"num\": 1, "
         "\"pred_2d\": [[" +
         Repeat("[5, 6, 0.5, 0.9]", 15) + "]]}}";
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
  Kind kind;
  std::string name;
  std::string content;
  bool one_json_value;  // every proper beginning of it is broken
};

std::vector<Sample> Samples() {
  return {
      {Kind::kDetections, "take/cam0/a_3_keypoints.json", OpenPose(75), true},
      {Kind::kDetections, "coco.json", Coco(), true},
      {Kind::kDetections, "longcw.json", Longcw2d(), true},
      {Kind::kDetections, "smap.json", Smap(), true},
      {Kind::kDetections, "ours.jsonl", Detections(), false},
      {Kind::kTracks, "ours.jsonl", Tracks(), false},
      {Kind::kTracks, "gt.txt", FourDAssociation(), false},
      {Kind::kTracks, "longcw.json", Longcw3d(), true},
      {Kind::kTracks, "poses.json", Poses(), true},
      {Kind::kTracks, "body3DScene_3.json", Panoptic(), true},
      {Kind::kHeldOut, "set.json", HeldOut(), true}};
}

// What to open: OpenPose's is the folder of the recording.
std::string PathOf(const TemporaryFolder& folder, const std::string& name) {
  return folder.path() / name.substr(0, name.find('/'));
}

TEST(BrokenFiles, SamplesAreGood) {
  for (const Sample& sample : Samples()) {
    const TemporaryFolder folder;
    folder.Write(sample.name, sample.content);
    EXPECT_EQ(ErrorOf(sample.kind, PathOf(folder, sample.name)), "NO ERROR")
        << sample.name;
  }
}

// --- The corpus -------------------------------------------------------------

struct Case {
  const char* name;
  Kind kind;
  Files files;
  std::string open;      // file or folder among them
  std::string expected;  // part of the message
};

// One file of that content.
Case OneFile(const char* name, Kind kind, const std::string& content,
             const std::string& expected, const std::string& file = "f.json") {
  return {name, kind, {{file, content}}, file, expected};
}

Case OpenPoseCase(const char* name, const std::string& content,
                  const std::string& expected) {
  return {name,
          Kind::kDetections,
          {{"take/cam0/a_1_keypoints.json", OpenPose(75)},
           {"take/cam0/a_2_keypoints.json", content}},
          "take",
          expected};
}

std::vector<Case> DetectionCases() {
  const Kind kind = Kind::kDetections;
  const auto header = [&](const char* what, const std::string& with) {
    return Replaced(DetectionHeaderLine(), what, with) + DetectionLine();
  };
  const auto line = [&](const char* what, const std::string& with) {
    return DetectionHeaderLine() + Replaced(DetectionLine(), what, with);
  };
  return {
      {"missing path", kind, {}, "nowhere", "No such file"},
      {"empty folder", kind, {{"x/y", ""}}, "x", "without detections"},
      {"view without files", kind, {{"t/cam0/readme", ""}}, "t", "no .json"},
      {"file name without number",
       kind,
       {{"t/cam0/meta.json", OpenPose(75)}},
       "t",
       "frame number"},
      {"frame number beyond all",
       kind,
       {{"t/cam0/99999999999999999999_keypoints.json", OpenPose(75)}},
       "t",
       "frame number"},
      {"two files of a frame",
       kind,
       {{"t/cam0/a_1_keypoints.json", OpenPose(75)},
        {"t/cam0/b_01_keypoints.json", OpenPose(75)}},
       "t",
       "frame 1: stands there twice"},
      {"one OpenPose frame",
       kind,
       {{"a_1_keypoints.json", OpenPose(75)}},
       "a_1_keypoints.json",
       "one OpenPose frame"},
      {"folder with a whole recording",
       kind,
       {{"t/ours.json", Detections()}},
       "t",
       "whole recording"},
      OpenPoseCase("mixed skeletons", OpenPose(54), "found 54 numbers"),
      OpenPoseCase("odd count", OpenPose(74), "found 74 numbers"),
      OpenPoseCase("too many", OpenPose(78), "found 78 numbers"),
      OpenPoseCase("text as number", Replaced(OpenPose(75), "1.5", "\"1.5\""),
                   "found a text, expected a number"),
      OpenPoseCase("keypoints are no list",
                   Replaced(OpenPose(75), "[1.5", "1, \"x\": [1.5"),
                   "expected an array"),
      OpenPoseCase("no keypoints",
                   Replaced(OpenPose(75), "pose_keypoints_2d", "pose"),
                   "pose_keypoints_2d: is missing"),
      OpenPoseCase("no people", "{}", "people: is missing"),
      OpenPoseCase("people are an object", "{\"people\": {}}",
                   "expected an array"),
      OpenPoseCase("a person is a number", "{\"people\": [7]}",
                   "people[0]: people: found a number"),
      OpenPoseCase("an array", "[]", "expected an object"),
      OpenPoseCase("empty file", "", "is empty"),
      OpenPoseCase("only spaces", " \n ", "is empty"),
      OpenPoseCase("1e400", Replaced(OpenPose(75), "1.5", "1e400"),
                   "out of range"),
      OpenPoseCase("trailing garbage", OpenPose(75) + "x", "valid JSON"),
      OpenPoseCase("two values", OpenPose(75) + OpenPose(75), "valid JSON"),
      OpenPoseCase("not UTF-8", "{\"people\": [], \"x\": \"\xff\"}", "UTF-8"),
      OpenPoseCase("zero byte", std::string("{\"people\"\0: []}", 15),
                   "valid JSON"),
      OpenPoseCase("deep", std::string(5000, '[') + std::string(5000, ']'),
                   "nested too deeply"),
      {"first person of no known skeleton",
       kind,
       {{"t/cam0/a_1_keypoints.json", OpenPose(81)}},
       "t",
       "detections.skeleton"},
      OneFile("COCO entry without frame", kind,
              Replaced(Coco(), "image_id", "image"), "image_id: is missing"),
      OneFile("COCO frame is a text without a number", kind,
              "[" + CocoEntry("\"front.jpg\"") + "]",
              "entry 0: 'front.jpg' holds no frame number"),
      OneFile("COCO frame negative", kind,
              "[" + CocoEntry() + "," + CocoEntry("-1") + "]",
              "entry 1: image_id: found -1"),
      OneFile("COCO frame has a fraction", kind, "[" + CocoEntry("1.5") + "]",
              "expected an integer"),
      OneFile("COCO frame beyond all", kind,
              "[" + CocoEntry("9000000000000000000") + "]", "image_id: found"),
      OneFile("COCO short keypoints", kind,
              Replaced(Coco(), "[2.5, 2.5, ", "["),
              "found 49 numbers, expected 51"),
      OneFile("COCO entry is a number", kind, "[1]", "entry 0"),
      OneFile("COCO truncated", kind, "[" + CocoEntry(), "valid JSON"),
      OneFile("COCO deep", kind, std::string(100000, '['), "nested too deeply"),
      OneFile("longcw without camera", kind,
              Replaced(Longcw2d(), "\"camera\"", "\"cam\""),
              "camera: is missing"),
      OneFile("longcw without frames", kind,
              "{\"image_wh\": [1, 1], \"frames\": {}}", "frames: is empty"),
      OneFile("longcw negative time", kind,
              Replaced(Longcw2d(), "0.04, ", "-9.04, "), "timestamp"),
      OneFile("longcw endless time", kind,
              Replaced(Longcw2d(), "0.04, ", "1e300, "), "timestamp"),
      OneFile("longcw one point less", kind,
              Replaced(Longcw2d(), "[7, 8], ", ""), "found 13 joints"),
      OneFile("longcw one score less", kind,
              Replaced(Longcw2d(), "[1, 1", "[1"), "found 13 numbers"),
      OneFile("longcw 3D point", kind,
              Replaced(Longcw2d(), "[7, 8]", "[7, 8, 9]"), "found 3 numbers"),
      OneFile("SMAP short joint", kind,
              Replaced(Smap(), "[5, 6, 0.5, 0.9]", "[5, 6, 0.5]"),
              "found 3 numbers"),
      OneFile("SMAP short person", kind,
              Replaced(Smap(), "[5, 6, 0.5, 0.9], ", ""), "found 14 joints"),
      OneFile("SMAP without people", kind, "{\"3d_pairs\": {}}",
              "pred_2d: is missing"),
      OneFile("unknown object", kind, "{\"x\": 1}", "no known"),
      OneFile("unknown text", kind, "hello", "no known"),
      OneFile("empty", kind, "", "no known"),
      OneFile("tracks instead", kind, Tracks(), "file of tracks"),
      OneFile("ours: header alone is broken", kind,
              "{\"kinegraph_detections\": 1", "line 1"),
      OneFile("ours: wrong version", kind,
              header("detections\": 1", "detections\": 2"),
              "line 1: kinegraph_detections: found 2, expected 1 .. 1"),
      OneFile("ours: version is a text", kind,
              header("detections\": 1", "detections\": \"1\""), "found a text"),
      OneFile("ours: key twice in header", kind,
              header("\"frame_rate\"", "\"views\": [\"x\"], \"frame_rate\""),
              "line 1: views: stands there twice"),
      OneFile("ours: no views", kind, header("\"cam0\", \"cam1\"", ""),
              "views: is empty"),
      OneFile("ours: a view twice", kind, header("cam1", "cam0"),
              "'cam0' stands there twice"),
      OneFile("ours: view is a number", kind, header("\"cam0\"", "0"),
              "views: found a number"),
      OneFile("ours: no skeleton", kind, header("\"skeleton\"", "\"skull\""),
              "skeleton: is missing"),
      OneFile("ours: skeleton is a name", kind,
              header(kSkeletonText.c_str(), "\"coco17\""),
              "skeleton: found a text, expected an object"),
      OneFile("ours: joint twice", kind, header("\"b\"", "\"a\""),
              "'a' stands there twice"),
      OneFile("ours: no joints", kind, header("\"a\", \"b\"", ""), "joints"),
      OneFile("ours: bone leaves the joints", kind, header("[0, 1]", "[0, 2]"),
              "bones"),
      OneFile("ours: bone of three", kind, header("[0, 1]", "[0, 1, 0]"),
              "bones"),
      OneFile("ours: negative rate", kind, header("25.0", "-25.0"),
              "frame_rate: is out of range"),
      OneFile("ours: rate 0", kind, header("25.0", "0"), "frame_rate"),
      OneFile("ours: rate is a text", kind, header("25.0", "\"25\""),
              "frame_rate: found a text"),
      OneFile("ours: frame twice", kind, Detections() + DetectionLine(),
              "line 3: frame: found 1 after 1"),
      OneFile("ours: frames descend", kind, Detections() + DetectionLine("0"),
              "found 0 after 1"),
      OneFile("ours: time twice", kind, Detections() + DetectionLine("2"),
              "line 3: time: found 0.040000 after 0.040000"),
      OneFile("ours: negative frame", kind,
              line("\"frame\": 1", "\"frame\": -1"), "line 2: frame: found -1"),
      OneFile("ours: key twice", kind,
              line("\"time\"", "\"frame\": 2, \"time\""),
              "line 2: frame: stands there twice"),
      OneFile("ours: view twice in a frame", kind,
              line("{\"cam1\"", "{\"cam1\": [], \"cam1\""),
              "'cam1' stands there twice"),
      OneFile("ours: unknown view", kind, line("\"cam1\"", "\"cam7\""),
              "'cam7' is not named in the header"),
      OneFile("ours: unknown view's clock", kind,
              line("{\"cam1\": 0.05", "{\"cam7\": 0.05"), "cam7"),
      OneFile("ours: clock is a text", kind, line("0.05", "\"0\""),
              "capture_times: found a text"),
      OneFile("ours: endless time", kind, line("0.04", "1e18"),
              "time: is out of range"),
      OneFile("ours: no views in a frame", kind,
              DetectionHeaderLine() + "{\"frame\": 1}", "views: is missing"),
      OneFile("ours: no frame number", kind,
              DetectionHeaderLine() + "{\"views\": {}}", "frame: is missing"),
      OneFile("ours: short joint", kind, line("[1, 2, 0.5]", "[1, 2]"),
              "line 2: joints: found 2 numbers, expected 3"),
      OneFile("ours: short person", kind, line(", null", ""),
              "joints: found 1, expected 2"),
      OneFile("ours: person is a list", kind,
              line("{\"joints\": [[1, 2, 0.5], null]}", "[]"),
              "found an array, expected an object"),
      OneFile("ours: joint is a text", kind, line("[1, 2, 0.5]", "\"x\""),
              "joints: found a text"),
      OneFile("ours: 1e400", kind, line("0.5", "1e400"), "line 2: "),
      OneFile("ours: truncated", kind,
              Detections().substr(0, Detections().size() - 3), "line 2: "),
      OneFile("ours: two values in a line", kind,
              Detections() + "{\"frame\": 2, \"views\": {}} 7", "line 3: "),
      OneFile("ours: frame is a number", kind, DetectionHeaderLine() + "7",
              "line 2: the frame: found a number"),
  };
}

std::vector<Case> TrackCases() {
  const Kind kind = Kind::kTracks;
  const auto header = [&](const char* what, const std::string& with) {
    return Replaced(TrackHeaderLine(), what, with) + TrackLine(kPersonText);
  };
  const auto person = [&](const char* what, const std::string& with) {
    return TrackHeaderLine() + TrackLine(Replaced(kPersonText, what, with));
  };
  const auto gt = [&](const char* what, const std::string& with) {
    return Replaced(FourDAssociation(), what, with);
  };
  return {
      {"missing path", kind, {}, "nowhere", "No such file"},
      {"empty folder",
       kind,
       {{"x/y", ""}},
       "x",
       "is no known format of tracks"},
      OneFile("empty", kind, "", "no known format"),
      OneFile("unknown object", kind, "{\"x\": 1}", "no known format"),
      OneFile("unknown text", kind, "hello", "no known format"),
      OneFile("detections instead", kind, Detections(), "file of detections"),
      OneFile("ours: wrong version", kind,
              header("kinegraph\": 1", "kinegraph\": 3"), "line 1: kinegraph"),
      OneFile("ours: units", kind, header("\"m\"", "\"cm\""), "units"),
      OneFile("ours: units without time", kind, header("\"time\"", "\"tick\""),
              "time: is missing"),
      OneFile("ours: config is a list", kind, header("{\"a\": 1}", "[1]"),
              "config: found an array"),
      OneFile("ours: mode is a number", kind, header("\"paper\"", "7"),
              "mode: found a number"),
      OneFile("ours: header key twice", kind,
              header("\"mode\"", "\"mode\": \"graph\", \"mode\""),
              "mode: stands there twice"),
      OneFile("ours: id twice in a frame", kind,
              TrackHeaderLine() + TrackLine(kPersonText + ", " + kPersonText),
              "line 2: people: id 2 stands there twice"),
      OneFile("ours: negative id", kind, person("\"id\": 2", "\"id\": -2"),
              "id: found -2"),
      OneFile("ours: id beyond 64 bits", kind,
              person("\"id\": 2", "\"id\": 18446744073709551615"), "id: "),
      OneFile("ours: no id", kind, person("\"id\": 2", "\"no\": 2"),
              "id: is missing"),
      OneFile("ours: no status", kind, person("\"status\"", "\"state\""),
              "status: is missing"),
      OneFile("ours: unknown status", kind, person("observed", "guessed"),
              "found 'guessed'"),
      OneFile("ours: short status", kind, person(", \"missing\"]", "]"),
              "status: found 1 entries"),
      OneFile("ours: status without position", kind,
              person("\"missing\"", "\"inferred\""),
              "joint 1 is inferred but its position is null"),
      OneFile("ours: position without status", kind,
              person("\"observed\"", "\"missing\""),
              "joint 0 is missing but has a position"),
      OneFile("ours: 2D joint", kind, person("[1, 2, 3]", "[1, 2]"),
              "joints: found 2 numbers"),
      OneFile("ours: three joints", kind, person("[1, 2, 3]", "null, null"),
              "joints: found 3 entries"),
      OneFile("ours: short covariance", kind,
              person("[1, 0, 0, 1, 0, 1]", "[1, 0, 0]"),
              "covariance: found 3 numbers"),
      OneFile("ours: covariances of one joint", kind,
              person("[1, 0, 0, 1, 0, 1], null", "null"),
              "covariance: found 1 entries"),
      OneFile("ours: negative views", kind, person("[2, 0]", "[2, -1]"),
              "views: found -1"),
      OneFile("ours: views of three joints", kind,
              person("[2, 0]", "[2, 0, 0]"), "views: found 3"),
      OneFile("ours: match twice", kind,
              person("{\"cam0\": 1}", "{\"cam0\": 1, \"cam0\": 2}"),
              "matches: 'cam0' stands there twice"),
      OneFile("ours: match is a text", kind,
              person("\"cam0\": 1", "\"cam0\": \"1\""),
              "matches: found a text"),
      OneFile("ours: weights without match", kind,
              person("\"matches\": {\"cam0\": 1}", "\"matches\": {}"),
              "has no match"),
      OneFile("ours: short weights", kind, person("[1, null]", "[1]"),
              "weights: found 1"),
      OneFile("ours: score is null", kind, person("0.5", "null"),
              "score: found null"),
      OneFile("ours: person key twice", kind,
              person("\"score\"", "\"id\": 3, \"score\""),
              "id: stands there twice"),
      OneFile("ours: frame twice", kind, Tracks() + TrackLine(""),
              "line 3: frame: found 1 after 1"),
      OneFile("ours: people are missing", kind,
              TrackHeaderLine() + "{\"frame\": 1}", "people: is missing"),
      OneFile("ours: truncated", kind, Tracks().substr(0, Tracks().size() - 9),
              "line 2: "),
      OneFile("gt: truncated", kind, "15 2\n1\n0\n0.25 0.25", "ends before"),
      OneFile("gt: frames missing", kind, gt("15 2", "15 3"), "ends before"),
      OneFile("gt: text after the end", kind, FourDAssociation() + " 1",
              "text after"),
      OneFile("gt: nan", kind, gt("0.25", "nan"), "found 'nan'"),
      OneFile("gt: inf", kind, gt("0.25", "-inf"), "found '-inf'"),
      OneFile("gt: 1e400", kind, gt("0.25", "1e400"), "found '1e400'"),
      OneFile("gt: word", kind, gt("0.25", "0.25x"), "line 4: "),
      OneFile("gt: negative people", kind, gt("\n1\n", "\n-1\n"),
              "number of people"),
      OneFile("gt: endless people", kind, gt("\n1\n", "\n1000000000\n"),
              "line "),
      OneFile("gt: endless frames", kind, gt("15 2", "15 99999999999999"),
              "number of frames"),
      OneFile("gt: fractional id", kind, gt("\n0\n", "\n0.5\n"),
              "id of a person"),
      OneFile("gt: unknown joints", kind, gt("15 2", "16 2"),
              "found 16 joints"),
      OneFile("gt: no joints", kind, gt("15 2", "0 2"), "number of joints"),
      OneFile("gt: person twice", kind,
              "15 1\n2\n" + Repeat("3 " + Repeat("0", 60, " "), 2, "\n"),
              "person 3 stands there twice"),
      OneFile("longcw: id is negative", kind,
              Replaced(Longcw3d(), "\"id\": 1", "\"id\": -1"), "entry 0: id"),
      OneFile(
          "longcw: id beyond 64 bits", kind,
          Replaced(Longcw3d(), "\"id\": 1", "\"id\": 118446744073709551615"),
          "valid JSON"),
      OneFile("longcw: joints", kind, Replaced(Longcw3d(), "[1, 2, 3], ", ""),
              "found 16 joints"),
      OneFile("longcw: scores", kind, Replaced(Longcw3d(), "[1, 1,", "[1,"),
              "scores: found 16 numbers"),
      OneFile("longcw: no time", kind, Replaced(Longcw3d(), "timestamp", "t"),
              "timestamp: is missing"),
      OneFile("longcw: negative time", kind,
              Replaced(Longcw3d(), "0.04", "-0.04"), "timestamp"),
      OneFile("longcw: frame twice", kind,
              "[{\"timestamp\": 1, \"poses\": []}, "
              "{\"timestamp\": 1.01, \"poses\": []}]",
              "entry 1: frame 25 stands there twice"),
      OneFile("longcw: detections of COCO", kind, Coco(), "poses: is missing"),
      OneFile("poses: unit", kind, Replaced(Poses(), "\"m\"", "\"mm\""),
              "unit: found 'mm'"),
      OneFile("poses: negative frame", kind, Replaced(Poses(), "3,", "-3,"),
              "poses[0]: frame: found -3"),
      OneFile("poses: unknown joints", kind,
              Replaced(Poses(), "[1, 2, 3], ", ""), "joints: found 16"),
      OneFile("poses: joint is a text", kind,
              Replaced(Poses(), "[1, 2, 3]", "\"x\""), "found a text"),
      OneFile("poses: person twice", kind,
              Replaced(Poses(), "[{",
                       "[{\"frame\": 3, \"id\": 0, \"joints\": [" +
                           Repeat("null", 17) + "]}, {"),
              "poses[1]: frame 3: person 0 stands there twice"),
      OneFile("Panoptic: no number in the name", kind, Panoptic(),
              "frame number", "body.json"),
      OneFile("Panoptic: short body", kind,
              Replaced(Panoptic(), "1, 2, 3, ", ""),
              "joints19: found 73 numbers", "body_1.json"),
      OneFile(
          "Panoptic: body twice", kind,
          Replaced(Panoptic(), "[{",
                   "[{\"id\": 4, \"joints19\": [" + Repeat("0", 76) + "]}, {"),
          "person 4 stands there twice", "body_1.json"),
      OneFile("mat: not one", kind, "MATLAB rules", "no MATLAB 5 file"),
      OneFile("mat: header alone", kind,
              "MATLAB 5.0" + std::string(116, ' ') + "IM", "is truncated"),
      OneFile("mat: big-endian", kind,
              "MATLAB 5.0" + std::string(116, ' ') + "MI", "little-endian"),
      OneFile("deep", kind, std::string(100000, '['), "nested too deeply"),
      OneFile("deep inside", kind,
              Replaced(Longcw3d(), "[1, 2, 3]",
                       std::string(5000, '[') + std::string(5000, ']')),
              "nested too deeply"),
  };
}

std::vector<Case> HeldOutCases() {
  const Kind kind = Kind::kHeldOut;
  const auto set = [](const char* what, const std::string& with) {
    return Replaced(HeldOut(), what, with);
  };
  return {
      {"missing path", kind, {}, "nowhere", "No such file"},
      {"a folder", kind, {{"x/y", ""}}, "x", "is a folder"},
      OneFile("no set", kind, set("\"set\"", "\"sets\""), "set: is missing"),
      OneFile("no gate", kind, set("pairing_gate_m", "gate"),
              "pairing_gate_m: is missing"),
      OneFile("negative cap", kind, set("100", "-100"), "cap_px"),
      OneFile("negative frame", kind, set("\"frame\": 3", "\"frame\": -3"),
              "set[0]: frame"),
      OneFile("negative detection", kind,
              set("\"detection\": 1", "\"detection\": -1"), "detection"),
      OneFile("endless detection", kind,
              set("\"detection\": 1", "\"detection\": 9999999999"),
              "detection"),
      OneFile("no person", kind, set("\"person\"", "\"who\""),
              "person: is missing"),
  };
}

void Check(const std::vector<Case>& cases) {
  ::testing::Test::RecordProperty("broken_files",
                                  static_cast<int>(cases.size()));
  for (const Case& broken : cases) {
    SCOPED_TRACE(broken.name);
    const TemporaryFolder folder;
    for (const auto& [name, content] : broken.files) {
      folder.Write(name, content);
    }
    const std::string path = folder.path() / broken.open;
    const std::string message = ErrorOf(broken.kind, path);
    EXPECT_THAT(message, HasSubstr(path));
    EXPECT_THAT(message, HasSubstr(broken.expected));
    EXPECT_THAT(message, Not(HasSubstr("\n")));
    EXPECT_THAT(message, Not(HasSubstr("NOT AN INPUT ERROR")));
  }
}

TEST(BrokenFiles, Detections) { Check(DetectionCases()); }
TEST(BrokenFiles, Tracks) { Check(TrackCases()); }
TEST(BrokenFiles, HeldOutSets) { Check(HeldOutCases()); }

// Python writes NaN into JSON, JavaScript null; names in texts are left alone.
TEST(NotANumber, IsAMissingJoint) {
  const TemporaryFolder folder;
  const auto found = [&](const std::string& content, const std::string& what,
                         const std::string& name) {
    std::vector<int> counts;
    for (const std::string number : {"NaN", "-Infinity", "Infinity", "null"}) {
      folder.Write(name, Replaced(content, what, number));
      const DetectionSequence read = ReadDetections(PathOf(folder, name));
      const Detection* person = nullptr;
      for (const ViewDetections& view : read.frames.at(0).views) {
        if (!view.detections.empty()) person = &view.detections[0];
      }
      counts.push_back(static_cast<int>(
          std::count_if(person->joints.begin(), person->joints.end(),
                        [](const Keypoint& joint) { return joint.found; })));
    }
    return counts;
  };
  EXPECT_THAT(found(OpenPose(75), "1.5", "t/cam0/1_keypoints.json"),
              ::testing::Each(24));
  EXPECT_THAT(found(Coco(), "2.5", "cam0.json"), ::testing::Each(16));
  EXPECT_THAT(found(Detections(), "0.5", "d.jsonl"), ::testing::Each(0));
  for (const std::string number : {"NaN", "-Infinity", "null"}) {
    folder.Write("p.json",
                 Replaced(Poses(), "[1, 2, 3]", "[" + number + ", 2, 3]"));
    EXPECT_EQ(CountPresent(ReadTracks(PathOf(folder, "p.json"))
                               .frames.at(0)
                               .people.at(0)
                               .joints),
              16);
  }
}

TEST(BrokenFiles, HundredMegabytesOfBrackets) {
  const TemporaryFolder folder;
  const std::string brackets(size_t{100} << 20, '[');
  const std::string array = folder.Write("a.json", brackets);
  EXPECT_THAT(ErrorOf(Kind::kDetections, array), HasSubstr("too deeply"));
  EXPECT_THAT(ErrorOf(Kind::kTracks, array), HasSubstr("too deeply"));
  const std::string line =
      folder.Write("line.jsonl", DetectionHeaderLine() + brackets);
  EXPECT_THAT(ErrorOf(Kind::kDetections, line),
              HasSubstr("line 2: is longer than 64 MiB"));
}

// --- .mat -------------------------------------------------------------------

// A cell of frames an actor.
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

TEST(BrokenFiles, MatIsRead) {
  const TemporaryFolder folder;
  const TrackSequence truth = ReadTracks(
      WriteMat(folder, "actor3D", TwoActors(MatNumbers(14, 3, NAN))));
  ASSERT_EQ(truth.frames.size(), 3u);
  EXPECT_EQ(CountPresent(truth.frames[0].people.at(0).joints), 0);  // NaN
  EXPECT_TRUE(truth.frames[1].people.empty());
  EXPECT_EQ(truth.frames[2].people.at(1).joints[13].position_m.z(), 3.0);
}

TEST(BrokenFiles, MatOfWrongShapes) {
  const auto error = [](const std::string& variable,
                        const std::vector<std::string>& actors) {
    const TemporaryFolder folder;
    return ErrorOf(Kind::kTracks, WriteMat(folder, variable, actors));
  };
  EXPECT_THAT(error("actor2D", TwoActors(MatNumbers(14, 3, 0))),
              HasSubstr("actor3D: is missing"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(15, 3, 0))),
              HasSubstr("actor3D{1}{1}: expected 14 x 3"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(14, 2, 0))),
              HasSubstr("actor3D{1}{1}: expected 14 x 3"));
  EXPECT_THAT(error("actor3D", TwoActors(MatNumbers(14, 3, INFINITY))),
              HasSubstr("actor3D{1}{1}: holds an infinite"));
  EXPECT_THAT(error("actor3D", {MatNumbers(14, 3, 0)}),
              HasSubstr("actor3D{1}: is no cell"));
  EXPECT_THAT(
      error("actor3D",
            {MatCell(1, 1, {MatNumbers(14, 3, 0)}),
             MatCell(2, 1, {MatNumbers(14, 3, 0), MatNumbers(0, 0, 0)})}),
      HasSubstr("actor3D{2}: found 2 frames, expected 1"));
}

}  // namespace
}  // namespace kinegraph
