// The output of `track`: a result with all its side files, or nothing; of a
// stream, the frames before an error.
#include <fcntl.h>  // open
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>  // mkfifo
#include <unistd.h>    // close

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/io/calibration/calibration.h"
#include "core/io/detections/writer.h"
#include "core/io/tracks/tracks.h"
#include "tests/apps/command.h"
#include "tests/support/rig.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

constexpr int kFrames = 60;

// One person who walks slowly, seen by four cameras.
DetectionSequence Walk(const CameraRig& rig, double y_m) {
  return SeenBy(rig, kFrames, [y_m](int f) {
    return std::vector<Pose3d>{StandingPerson(0.01 * f, y_m)};
  });
}

class TrackResultTest : public CommandTest {
 protected:
  TrackResultTest() {
    const CameraRig rig = RingOfCameras(4);
    WriteCameras(Path("cameras.json"), rig);
    WriteDetections(Path("first.jsonl"), Walk(rig, 0.0));
    WriteDetections(Path("second.jsonl"), Walk(rig, 1.0));
  }

  std::string Flags(const std::string& detections, const std::string& out,
                    const std::string& more = "") const {
    return "--cameras=" + Path("cameras.json") + " --detections=" + detections +
           " --out=" + Path(out) + " --mode=graph " + more;
  }
  // Flags for a stream of these lines.
  std::string Live(const std::vector<std::string>& lines,
                   const std::string& more = "") const {
    return Flags("- < " + folder_.Write("live.txt", Joined(lines)), "day.jsonl",
                 more);
  }
  // The lines of a recording with their line ends, the header first.
  std::vector<std::string> Lines(const std::string& name) const {
    std::ifstream file(Path(name));
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) {
      lines.push_back(line + "\n");
    }
    return lines;
  }
  static std::string Joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line;
    return text;
  }
  std::set<std::string> FilesOf(const std::string& name) const {
    std::set<std::string> files;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      const std::string file = entry.path().filename().string();
      if (file.rfind(name + ".", 0) == 0) files.insert(file);
    }
    return files;
  }
};

TEST_F(TrackResultTest, RemovesAndIgnoresFilesOfAnEarlierRun) {
  const std::string names = folder_.Write(
      "names.jsonl",
      "{\"op\": \"name\", \"persons\": [0], \"name\": \"Anna\"}\n");
  Done("track",
       Flags(Path("first.jsonl"), "a.jsonl", "--corrections=" + names));
  EXPECT_THAT(FilesOf("a"), UnorderedElementsAre("a.jsonl", "a.identity.jsonl",
                                                 "a.summary.json"));
  const std::string anna = " --to=csv --person=Anna --out=" + Path("anna.csv");
  Done("convert", "--in=" + Path("a.jsonl") + anna);
  fs::copy(Path("a.identity.jsonl"), Path("b.identity.jsonl"));
  Done("track", Flags(Path("second.jsonl"), "b.jsonl"));
  EXPECT_THAT(FilesOf("b"), UnorderedElementsAre("b.jsonl", "b.summary.json"));
  // A user restores the old file.
  fs::copy(Path("a.identity.jsonl"), Path("b.identity.jsonl"));
  const ProgramOutcome refused =
      RunProgram("convert", "--in=" + Path("b.jsonl") + anna);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("belongs to other tracks"));
  EXPECT_THAT(
      Done("report", "--tracks=" + Path("b.jsonl") + " --out=" + Path("b.html"))
          .errors,
      HasSubstr("belongs to other tracks"));
  EXPECT_EQ(ContentOf(Path("b.html")).find("Anna"), std::string::npos);
}

// Runs the command while its --detections, a pipe, is fed with the file.
ProgramOutcome Piped(const std::string& command, const std::string& pipe,
                     const std::string& file, const std::string& arguments) {
  EXPECT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer(
      [&] { std::ofstream(pipe, std::ios::binary) << ContentOf(file); });
  ProgramOutcome outcome = RunProgram(command, arguments);
  // A program that never opens the pipe leaves the writer blocked.
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  writer.join();
  close(reader);
  fs::remove(pipe);
  return outcome;
}

TEST_F(TrackResultTest, APipeIsReadOnce) {
  const std::string first = Path("first.jsonl");
  const std::string pipe = Path("pipe");
  for (const std::string more :
       {"--config=offline.toml", "--set=cameras.ground=feet"}) {
    Done("track", Flags(first, "file.jsonl", more));
    const ProgramOutcome outcome =
        Piped("track", pipe, first, Flags(pipe, "piped.jsonl", more));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_EQ(ContentOf(Path("piped.jsonl")), ContentOf(Path("file.jsonl")))
        << more;
  }
}

TEST_F(TrackResultTest, DoctorAsksForTheRateOfAPipe) {
  std::string text = ContentOf(Path("first.jsonl"));
  const std::string rate = "\"frame_rate\"";
  ASSERT_NE(text.find(rate), std::string::npos);
  const size_t at = text.find(rate);
  text.erase(at, text.find_first_of(",}", at) + 1 - at);
  const std::string pipe = Path("pipe");
  const ProgramOutcome outcome =
      Piped("doctor", pipe, folder_.Write("no_rate.jsonl", text),
            "--cameras=" + Path("cameras.json") + " --detections=" + pipe +
                " --out=" + Path("doctor"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.errors, HasSubstr("input.frame_rate"));
}

// --out=.trc would create a folder named by the text before the extension,
// which is empty.
TEST_F(TrackResultTest, RefusesAnExtensionWithoutAName) {
  for (const char* name : {".trc", ".jsonl"}) {
    EXPECT_THAT(Refusal("track", Flags(Path("first.jsonl"), name)),
                HasSubstr("with a name before"));
    EXPECT_FALSE(fs::exists(Path(name)));
  }
}

TEST_F(TrackResultTest, KeysIncludeSkeletonsOfTheConfiguration) {
  const std::string config = folder_.Write(
      "my.toml",
      "[detections]\nskeleton = \"my body\"\n[skeletons.\"my body\"]\n"
      "joints = [\"tail\", \"head\"]\nbones = [[\"tail\", \"head\"]]\n");
  const std::string keys = Done("track", "--keys --config=" + config).output;
  Done("track", "--keys --config=" + folder_.Write("again.toml", keys));
  EXPECT_THAT(keys, HasSubstr("bones = [[\"tail\",\"head\"]]"));
}

TEST_F(TrackResultTest, KeepsAForeignFileNamedLikeItsEdits) {
  folder_.Write("a.identity.jsonl", "mine\n");
  Done("track", Flags(Path("first.jsonl"), "a.jsonl"));
  EXPECT_EQ(ContentOf(Path("a.identity.jsonl")), "mine\n");
}

TEST_F(TrackResultTest, ARefusedRunLeavesNoFiles) {
  fs::copy(Path("cameras.json"), Path("z.summary.json"));
  const ProgramOutcome outcome =
      RunProgram("track", "--cameras=" + Path("z.summary.json") +
                              " --detections=" + Path("first.jsonl") +
                              " --mode=graph --out=" + Path("z.jsonl"));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
  EXPECT_THAT(FilesOf("z"), UnorderedElementsAre("z.summary.json"));
  EXPECT_EQ(ContentOf(Path("z.summary.json")), ContentOf(Path("cameras.json")));
}

TEST_F(TrackResultTest, AStreamKeepsTheFramesBeforeABadLine) {
  const std::vector<std::string> good = Lines("first.jsonl");
  for (const std::string& bad :
       {std::string("{\"frame\": 39, \"ti\n"), good[39],
        std::string("{\"frame\": 99, \"views\": {\"cam9\": []}}\n")}) {
    std::vector<std::string> lines = good;
    lines.insert(lines.begin() + 41, bad);  // after frame 39
    const ProgramOutcome outcome = RunProgram("track", Live(lines));
    EXPECT_EQ(outcome.exit_code, 2) << bad;
    EXPECT_THAT(outcome.errors, HasSubstr("line 42"));
    EXPECT_THAT(outcome.errors, HasSubstr("the 40 frames before it are kept"));
    EXPECT_EQ(ReadTracks(Path("day.jsonl")).frames.size(), 40u);
    EXPECT_THAT(FilesOf("day"),
                UnorderedElementsAre("day.jsonl", "day.summary.json"));
    // Bad frames are skipped on request, and counted.
    Done("track", Live(lines, "--set=input.skip_bad_frames=true"));
    EXPECT_EQ(ReadTracks(Path("day.jsonl")).frames.size(),
              static_cast<size_t>(kFrames));
    EXPECT_THAT(ContentOf(Path("day.summary.json")),
                HasSubstr("1 frame that cannot be read was skipped"));
  }
}

TEST_F(TrackResultTest, AStreamWithoutAGoodFrameLeavesNothing) {
  EXPECT_THAT(Refusal("track", Live({Lines("first.jsonl")[0], "{\"frame\"\n"})),
              HasSubstr("line 2"));
  EXPECT_TRUE(FilesOf("day").empty());
}

TEST_F(TrackResultTest, AcceptsAClockThatStepsBack) {
  std::vector<std::string> lines = Lines("first.jsonl");
  for (size_t f = 50; f < kFrames; ++f) {  // 2 s too early
    std::string& line = lines[f + 1];
    const size_t at = line.find("\"time\": ") + 8;
    line.replace(at, line.find(',', at) - at,
                 std::to_string(static_cast<double>(f - 50) / 25.0));
  }
  Done("track", Live(lines));
  const TrackSequence tracks = ReadTracks(Path("day.jsonl"));
  ASSERT_EQ(tracks.frames.size(), static_cast<size_t>(kFrames));
  EXPECT_EQ(tracks.frames[50].time, 0);
  EXPECT_THAT(ContentOf(Path("day.summary.json")),
              HasSubstr("steps back 1 time"));
}

TEST_F(TrackResultTest, RejectsViewTimesOfAnotherEpoch) {
  std::vector<std::string> lines = Lines("first.jsonl");
  lines[7].insert(1, "\"view_times\": {\"cam1\": 1.7e9}, ");
  folder_.Write("epoch.jsonl", Joined(lines));
  EXPECT_THAT(Refusal("track", Flags(Path("epoch.jsonl"), "a.jsonl")),
              HasSubstr("line 8: view_times: 'cam1'"));
  EXPECT_TRUE(FilesOf("a").empty());
}

}  // namespace
}  // namespace kinegraph::testing
