// The program kinegraph-convert: combinations of formats, exit codes, files.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>  // mkfifo
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/calibration/format.h"
#include "core/io/detections/format.h"
#include "core/io/detections/source.h"
#include "core/io/detections/writer.h"
#include "core/io/files/side_files.h"
#include "core/io/files/text_file.h"
#include "core/io/tracks/format.h"
#include "core/io/tracks/tracks.h"
#include "core/io/tracks/writer.h"
#include "tests/apps/command.h"
#include "tests/core/io/tracks/recordings.h"
#include "tests/support/opensim_trc.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

// The notes of a conversion that must succeed, and the error of one that must
// fail.
std::string Converted(const std::string& arguments) {
  return testing::Done("convert", arguments).errors;
}
std::string Refused(const std::string& arguments) {
  return testing::Refusal("convert", arguments);
}

// A small recording in kinegraph's formats.
struct SmallRecording {
  explicit SmallRecording(const TemporaryFolder& folder)
      : cameras(folder.path() / "cameras.json"),
        detections(folder.path() / "detections.jsonl"),
        tracks(folder.path() / "tracks.jsonl") {
    CameraParameters parameters;
    parameters.name = "cam0";
    parameters.width_px = 640;
    parameters.height_px = 480;
    parameters.K << 500, 0, 320, 0, 500, 240, 0, 0, 1;
    parameters.t = {0.1, 0.2, 3.0};
    WriteCameras(cameras, {Camera(parameters)});
    DetectionSequence seen;
    seen.header.skeleton = Coco17();
    seen.header.frame_rate_hz = 25.0;
    seen.header.view_names = {"cam0"};
    for (int64_t f = 1; f < 4; ++f) {
      DetectionFrame& frame = seen.frames.emplace_back();
      frame.frame = f;
      frame.views.resize(1);
      frame.time = frame.views[0].capture_time = f * 40'000'000;
      frame.views[0].detections.resize(1);
      frame.views[0].detections[0].joints.assign(17,
                                                 {{101.5, 202.5}, 0.5, true});
    }
    WriteDetections(detections, seen);
    WriteTracks(tracks, testing::Walk());
  }

  std::string cameras;
  std::string detections;
  std::string tracks;
};

TEST(Convert, OwnFormatsRoundTripByteForByte) {
  const TemporaryFolder folder;
  const SmallRecording recording(folder);
  for (const std::string& in :
       {recording.cameras, recording.detections, recording.tracks}) {
    const std::string out = in + ".again";
    Converted("--to=kinegraph --in=" + in + " --out=" + out);
    EXPECT_EQ(ReadTextFile(in), ReadTextFile(out));
  }
}

TEST(Convert, RefinementRecordIsKeptOrReportedLost) {
  const TemporaryFolder folder;
  const SmallRecording recording(folder);
  const std::string refinement =
      R"({"clock_zero_s":0.1,"cameras":[{"name":"cam0","clock":)"
      R"({"offset_s":-0.0123,"drift":1e-06},"parameters":["shift_x_px"]}],)"
      R"("covariance":[[0.25]]})";
  const std::string refined = folder.path() / "refined.cameras.json";
  WriteCameras(refined, ReadCameras(recording.cameras), refinement);
  const std::string in = "--in=" + refined + " --out=" + folder.path().string();
  EXPECT_EQ(Converted(in + "/own.json --to=kinegraph"), "");
  EXPECT_EQ(ReadTextFile(folder.path() / "own.json"), ReadTextFile(refined));
  EXPECT_THAT(Converted(in + "/other.toml --to=pose2sim"),
              HasSubstr("(clocks and covariances of the cameras) is not kept"));
  // An invalid record is not copied.
  WriteCameras(refined, ReadCameras(recording.cameras), "{\"cameras\": 3}");
  EXPECT_THAT(Refused(in + "/broken.json --to=kinegraph"),
              HasSubstr("refinement: cameras: found 3"));
  EXPECT_FALSE(fs::exists(folder.path() / "broken.json"));
}

TEST(Convert, FlagsSupplyUnitImageSizeAndFrameRate) {
  const TemporaryFolder folder;
  const std::string krt =
      folder.Write("krt.json",
                   R"({"a": {"K": [500,0,320,0,500,240,0,0,1],
                "RT": [1,0,0,100,0,1,0,0,0,0,1,300]}})");
  const std::string cameras = folder.path() / "cameras.json";
  Converted("--from=krt --to=kinegraph --unit=cm --image_size=640,480 --in=" +
            krt + " --out=" + cameras);
  const CameraRig rig = ReadCameras(cameras);
  EXPECT_EQ(rig[0].t(), Eigen::Vector3d(1, 0, 3));
  EXPECT_EQ(rig[0].width_px(), 640);
  EXPECT_EQ(rig[0].height_px(), 480);
  const SmallRecording recording(folder);
  const std::string coco = folder.path() / "coco";
  Converted("--to=coco --in=" + recording.detections + " --out=" + coco);
  const std::string own = folder.path() / "own.jsonl";
  Converted("--to=kinegraph --frame_rate=50 --in=" + coco + " --out=" + own);
  EXPECT_EQ(ReadDetections(own).header.frame_rate_hz, 50.0);
}

TEST(Convert, FirstFrameOf4DAssociation) {
  const TemporaryFolder folder;
  const std::string in = folder.Write("skel.txt", "15 2\n0\n0\n");
  const std::string out = folder.path() / "own.jsonl";
  Converted(
      "--from=4da --to=kinegraph --frame_rate=25 "
      "--set=tracks.first_frame=7 --in=" +
      in + " --out=" + out);
  const TrackSequence tracks = ReadTracks(out);
  ASSERT_EQ(tracks.frames.size(), 2u);
  EXPECT_EQ(tracks.frames[0].frame, 7);
  EXPECT_EQ(tracks.frames[1].time, 320'000'000);
}

TEST(Convert, BadUsageGivesOneLineAndExitCodeTwo) {
  const TemporaryFolder folder;
  const SmallRecording recording(folder);
  const std::string out = folder.path() / "out";
  const std::string scrap = folder.Write("scrap.bin", "no format at all");
  const std::string lens = folder.Write(
      "lens.json",
      R"({"a": {"K": [500,0,320,0,500,240,0,0,1], "distCoeff": [0.1,0,0,0,0],
                "RT": [1,0,0,0,0,1,0,0,0,0,1,3]}})");
  const std::string& cameras = recording.cameras;
  const std::string& detections = recording.detections;
  const std::string& tracks = recording.tracks;
  const std::string c3d = folder.path() / "take.c3d";
  Converted("--to=c3d --in=" + tracks + " --out=" + c3d);
  const std::string timed = folder.Write(
      "timed.jsonl", R"({"kinegraph_detections": 1, "skeleton": {"name": "s", )"
                     R"("joints": ["a"], "bones": []}, "views": ["v"]})"
                     "\n"
                     R"({"frame": 1, "time": 0.04, "views": {}})"
                     "\n"
                     R"({"frame": 2, "time": 0.08, "views": {}})"
                     "\n");
  const std::string coco = folder.path() / "coco.json";
  Converted("--to=coco_views --in=" + detections + " --out=" + coco);
  const std::string to_out = " --out=" + out;
  struct Case {
    std::string flags;
    std::string in;
    std::string out;
    std::string expected;
  };
  for (const auto& [flags, in, to, expected] : std::vector<Case>{
           {"", tracks, to_out, "--to is missing"},
           {"--to=csv", tracks, "", "--out is required"},
           {"--to=fbx", tracks, to_out, "is not a format"},
           {"--to=sleap", tracks, to_out, "'sleap' cannot be written"},
           {"--to=poses", tracks, to_out, "poses can only be read: write csv"},
           {"--to=coco3d", tracks, to_out, "coco3d was removed"},
           {"--from=csv --to=kinegraph", tracks, to_out,
            "has no column 'frame'"},
           {"--to=longcw", detections, to_out, "--image_size"},
           {"--from=openpose --to=trc", tracks, to_out,
            "--from=openpose is a format of detections, --to=trc of tracks"},
           {"--to=csv", cameras, to_out,
            "contains calibrations, but --to=csv is a format of tracks"},
           {"--to=krt", tracks, to_out,
            "contains tracks, but --to=krt is a format of calibrations"},
           {"--to=kinegraph", scrap, to_out, "scrap.bin"},
           {"--to=kinegraph", "missing.json", to_out, "missing.json"},
           {"--from=krt --to=tum", lens, to_out, "has a lens"},
           {"--to=csv --unit=cm", tracks, to_out,
            "specifies its unit; --unit applies to tracks of"},
           {"--to=krt --skeleton=coco17", cameras, to_out,
            "--skeleton applies to"},
           {"--to=csv --frame_rate=61", tracks, to_out,
            "--frame_rate=61 is for input that does not specify its rate"},
           {"--to=kinegraph --frame_rate=100", detections, to_out,
            "--frame_rate=100 is for input that does not specify its rate"},
           {"--to=kinegraph --frame_rate=100", coco, to_out,
            "but the input specifies 25 Hz"},
           {"--to=kinegraph --frame_rate=100", timed, to_out,
            "but the times in the input imply 25 Hz"},
           {"--to=csv --frame_rate=100", c3d, to_out,
            "but the input specifies 25 Hz"},
           {"--to=csv --skeleton=body25b", tracks, to_out,
            "--skeleton=body25b is for input that does not specify its "
            "skeleton"},
           {"--to=csv --set=cameras.unit=mm", tracks, to_out,
            "key 'cameras.unit' does not apply: the input contains tracks"},
           {"--to=coco --set=tracks.first_frame=2", detections, to_out,
            "'tracks.first_frame' does not apply"},
           {"--to=trc --axes=x,z,y", tracks, to_out, "mirroring"},
           {"--to=csv --skeleton=octopus", tracks, to_out, "--skeleton"},
           {"--to=krt --set=cameras.unitt=cm", cameras, to_out, "cameras.unit"},
           {"--to=krt --image_size=640", cameras, to_out, "image_size"},
           {"--to=coco_views --image_size=1920x1080", detections, to_out,
            "--image_size: found '1920x1080', expected W,H"},
           {"--to=coco_views --image_size=-5,3", detections, to_out,
            "--image_size: found '-5,3'"},
           {"--to=coco_views --image_size=1e300,3", detections, to_out,
            "--image_size: found '1e300,3'"},
           {"--to=csv", tracks, " --out=/dev/null/out", "/dev/null"},
           {"--to=trc", tracks, " --out=" + folder.path().string(),
            "exists already"},
           {"--to=csv", "", to_out, "--in is required"}}) {
    const std::string arguments =
        flags + (in.empty() ? "" : " --in=" + in) + to;
    EXPECT_THAT(Refused(arguments), HasSubstr(expected)) << arguments;
    EXPECT_FALSE(fs::exists(out)) << arguments;
  }
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".partial")));
  }
}

// The advice of each note is a command that runs and removes the note.
TEST(Convert, NotesRotatedWorldsAndTheUpDirection) {
  const TemporaryFolder folder;
  const std::string tracks = folder.path() / "take.jsonl";
  WriteTracks(tracks, testing::Walk());
  const auto convert = [&](const std::string& in, const std::string& out,
                           const std::string& more) {
    return Converted(more + " --in=" + in + " --out=" + folder.path().string() +
                     "/" + out);
  };
  const auto stands = Not(HasSubstr("people stand"));
  EXPECT_THAT(convert(tracks, "up.trc", ""), stands);
  // A file whose Z is up although its format defines Y as up.
  EXPECT_THAT(convert(tracks, "side.trc", "--axes=x,y,z"),
              HasSubstr("people stand along z of the world, not along y, which "
                        "trc shows as up: --axes=x,z,-y makes them stand "
                        "upright"));
  EXPECT_THAT(convert(tracks, "mended.trc", "--axes=x,z,-y"), stands);
  const std::string side = folder.path() / "side.trc";
  EXPECT_THAT(convert(side, "side.bvh", ""),
              HasSubstr("people stand along x of the world, not along z, which "
                        "bvh shows as up: convert to a .jsonl with "
                        "--axes=x,y,z first, then convert that file without "
                        "--axes"));
  EXPECT_THAT(
      convert(side, "lying.jsonl", ""),
      HasSubstr("people stand along x of the world, not along z, as trc "
                "is read: --axes=x,y,z makes them stand upright"));
  EXPECT_THAT(convert(side, "turned.jsonl", "--axes=x,y,z"), stands);
  EXPECT_THAT(convert(folder.path() / "turned.jsonl", "turned.bvh", ""),
              stands);
}

// If neither format has axes of its own, tracks are rotated on reading: a
// rotation by 90 degrees about x and its inverse cancel.
TEST(Convert, AxesRotateTracksIfNeitherFormatHasAxes) {
  const TemporaryFolder folder;
  const std::string tracks = folder.path() / "take.jsonl";
  TrackSequence walk = testing::Walk();
  walk.frames[0].people[0].covariances.assign(
      walk.frames[0].people[0].joints.size(),
      Eigen::Matrix3d(Eigen::Vector3d(1.0, 4.0, 9.0).asDiagonal()));
  WriteTracks(tracks, walk);
  const std::string turned = folder.path() / "turned.jsonl";
  const std::string back = folder.path() / "back.jsonl";
  Converted("--axes=x,z,-y --in=" + tracks + " --out=" + turned);
  Converted("--axes=x,-z,y --in=" + turned + " --out=" + back);
  const PersonPose& was = walk.frames[0].people[0];
  const PersonPose is = ReadTracks(turned).frames[0].people[0];
  for (size_t j = 0; j < was.joints.size(); ++j) {
    if (!was.joints[j].present()) continue;
    // The file's Y is the world's z, its Z the world's -y.
    EXPECT_EQ(is.joints[j].position_m.z(), was.joints[j].position_m.y());
    EXPECT_EQ(is.joints[j].position_m.y(), -was.joints[j].position_m.z());
    EXPECT_EQ(is.covariances[j]->diagonal(), Eigen::Vector3d(1.0, 9.0, 4.0));
    EXPECT_EQ(ReadTracks(back).frames[0].people[0].joints[j].position_m,
              was.joints[j].position_m);
  }
}

// Cameras, detections and tracks have a format of this name.
TEST(Convert, KinegraphFromAPipeIsNotRecognised) {
  const TemporaryFolder folder;
  const std::string out = folder.path() / "out";
  EXPECT_THAT(
      Refused("--from=kinegraph --to=kinegraph --in=/dev/null --out=" + out),
      HasSubstr("cannot be recognised from a pipe, expected a file"));
}

TEST(Convert, AFailureLeavesNoFolders) {
  const TemporaryFolder folder;
  const std::string lens = folder.Write(
      "lens.json",
      R"({"a": {"K": [500,0,320,0,500,240,0,0,1], "distCoeff": [0.1,0,0,0,0],
                "RT": [1,0,0,0,0,1,0,0,0,0,1,3]}})");
  const std::string made = folder.path() / "new";
  const std::string to_out =
      " --in=" + lens + " --out=" + made + "/deep/result";
  EXPECT_THAT(Refused("--to=tum" + to_out), HasSubstr("has a lens"));
  EXPECT_FALSE(fs::exists(made));
  Converted("--to=pose2sim" + to_out);
  EXPECT_TRUE(fs::exists(made + "/deep/result"));
}

// Examining a file to recognise it would consume the beginning of a pipe.
TEST(Convert, ReadsTracksFromAPipe) {
  const TemporaryFolder folder;
  const std::string tracks = folder.path() / "take.jsonl";
  WriteTracks(tracks, testing::Walk());
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto feed = [&](const std::string& arguments) {
    std::thread writer([&] {
      std::ofstream out(pipe, std::ios::binary);
      out << testing::ContentOf(tracks) << std::flush;
    });
    const testing::ProgramOutcome outcome =
        testing::RunProgram("convert", "--in=" + pipe + arguments);
    // A reader that never opens the pipe leaves the writer blocked.
    const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    writer.join();
    close(reader);
    return outcome;
  };
  const std::string direct = folder.path() / "direct.csv";
  const std::string piped = folder.path() / "piped.csv";
  Converted("--in=" + tracks + " --out=" + direct);
  for (const char* from : {"", " --from=kinegraph"}) {
    const auto outcome = feed(std::string(from) + " --to=csv --out=" + piped);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_EQ(testing::ContentOf(piped), testing::ContentOf(direct));
    EXPECT_THAT(outcome.errors, HasSubstr("names of people are not read"));
    fs::remove(piped);
  }
  // Three kinds of files have a format named kinegraph.
  const auto refused = feed(" --to=kinegraph --out=" + piped);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("cannot be recognised from a pipe"));
}

std::string FourthLineOf(const std::string& path) {
  std::istringstream lines(ReadTextFile(path));
  std::string line;
  for (int i = 0; i < 4; ++i) std::getline(lines, line);
  return line;
}

TEST(Convert, ChoosesMarkerNamesAndPerson) {
  const TemporaryFolder folder;
  TrackSequence found;
  found.header.skeleton = Halpe26();
  found.header.frame_rate_hz = 25.0;
  found.frames.resize(1);
  for (const int64_t id : {3, 8}) {
    found.frames[0].people.emplace_back();
    found.frames[0].people.back().id = TrackId(id);
    found.frames[0].people.back().joints.assign(
        26, {{1.0 * static_cast<double>(id), 2, 3}, JointStatus::kObserved});
  }
  const std::string tracks = folder.path() / "take.jsonl";
  WriteTracks(tracks, found);
  const std::string of_tracks =
      "{\"tracks_fingerprint\": \"" + FingerprintOfTracks(tracks) + "\"}\n";
  folder.Write("take.identity.jsonl",
               of_tracks + R"({"op": "name", "persons": [8], "name": "Anna"})"
                           "\n");
  struct Case {
    std::string names;
    std::vector<std::string> expected;
  };
  for (const Case& one :
       {Case{"pose2sim", {"\tNose\t", "\tRHip\t", "\tHip\t", "\tHead\t"}},
        Case{"opensim", {"\tmidHip\t", "\tLBigToe\t"}},
        Case{"ours", {"\tmid_hip\t", "\tl_big_toe\t"}}}) {
    const std::string out = folder.path() / ("new/" + one.names + ".trc");
    Converted("--to=trc --person=Anna --markers=" + one.names +
              " --in=" + tracks + " --out=" + out);
    for (const std::string& marker : one.expected) {
      EXPECT_THAT(FourthLineOf(out), HasSubstr(marker)) << one.names;
    }
    EXPECT_TRUE(testing::OpenSimReads(out));
    // With any naming convention the joints are recognised.
    const TrackSequence back = ReadTracks(out);
    EXPECT_TRUE(back.header.skeleton == Halpe26()) << one.names;
    ASSERT_EQ(back.frames.at(0).people.size(), 1u);
    EXPECT_NEAR(back.frames[0].people[0].joints[0].position_m.x(), 8.0, 1e-12);
  }
  // Without --person the result is a folder with a file per person; with it,
  // only that person is written.
  Converted("--to=trc --in=" + tracks +
            " --out=" + (folder.path() / "both").string());
  const std::string csv = folder.path() / "one.csv";
  const auto chosen = [&](const std::string& person, const std::string& in) {
    Converted("--to=csv --person=" + person + " --in=" + in + " --out=" + csv);
    return ReadTracks(csv).frames.at(0).people.at(0).id;
  };
  EXPECT_EQ(chosen("3", tracks), TrackId(3));
  // Names in the tracks themselves are accepted too.
  std::string named = ReadTextFile(tracks);
  named.insert(1, R"("names":{"3":"Carl"},)");
  EXPECT_EQ(chosen("Carl", folder.Write("own.jsonl", named)), TrackId(3));
  // An excerpt has no names of other people.
  named = ReadTextFile(tracks);
  named.insert(1, R"("names":{"3":"Carl","8":"Dora"},)");
  const std::string excerpt = folder.path() / "excerpt.jsonl";
  Converted("--person=3 --in=" + folder.Write("both.jsonl", named) +
            " --out=" + excerpt);
  EXPECT_THAT(ReadTextFile(excerpt), HasSubstr("Carl"));
  EXPECT_THAT(ReadTextFile(excerpt), Not(HasSubstr("Dora")));
  // The last name given to a person is used.
  folder.Write("take.identity.jsonl",
               of_tracks + R"({"op": "name", "persons": [3], "name": "Anna"})"
                           "\n"
                           R"({"op": "name", "persons": [3], "name": "Bea"})"
                           "\n"
                           R"({"op": "name", "persons": [8], "name": "Anna"})"
                           "\n");
  EXPECT_EQ(chosen("Anna", tracks), TrackId(8));
  const std::multimap<std::string, std::string> wrong = {
      {"--to=trc --out=" + (folder.path() / "x.trc").string(),
       "one person, but the tracks have 3, 8; choose one with --person"},
      {"--to=csv --person=5 --out=" + (folder.path() / "x").string(),
       "no '5' in the tracks, expected one of 3, 8"},
      {"--to=csv --person=Bob --out=" + (folder.path() / "x").string(),
       "expected one of 3, 8, 'Bea', 'Anna'"},
      {"--to=4da --markers=pose2sim --out=" + (folder.path() / "x").string(),
       "--markers requires --to="},
      {"--to=csv --markers=vicon --out=" + (folder.path() / "x").string(),
       "ours, pose2sim, opensim"}};
  for (const auto& [arguments, expected] : wrong) {
    EXPECT_THAT(Refused(arguments + " --in=" + tracks), HasSubstr(expected));
  }
}

TEST(Convert, ThePageNamesEveryFormatAndFlag) {
  const std::string page =
      ReadTextFile(testing::ProjectFile("docs/convert.md").string());
  std::istringstream lines(testing::Done("convert", "--formats").output);
  int count = 0;
  std::string line;
  while (std::getline(lines, line)) ++count;
  EXPECT_EQ(static_cast<size_t>(count), CalibrationFormats().size() +
                                            DetectionFormats().size() +
                                            TrackFormats().size());
  const auto expect_row = [&page](const auto& format, bool reads) {
    EXPECT_THAT(page, ContainsRegex("\n\\| `" + format.name + "` \\| " +
                                    (reads ? "yes" : "no") + "[^|]* \\| " +
                                    (format.write == nullptr ? "no " : "f")));
  };
  for (const auto& format : CalibrationFormats()) expect_row(format, true);
  for (const auto& format : DetectionFormats()) expect_row(format, true);
  for (const auto& format : TrackFormats()) {
    expect_row(format, format.read != nullptr);
  }
  for (const char* flag : {"unit", "image_size", "skeleton", "frame_rate",
                           "axes", "markers", "person", "set", "formats"}) {
    EXPECT_THAT(page, HasSubstr("--" + std::string(flag)));
  }
}

}  // namespace
}  // namespace kinegraph
