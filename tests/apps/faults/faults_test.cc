// Faults of single commands: signals, streams, folders, limits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <sstream>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

const std::string& Scene() { return DemoScene("0.4"); }

std::string TrackCommand(
    const std::string& detections, const std::string& out,
    const std::string& scene = Scene(),
    const std::string& config = "configs/synthetic/track_paper.toml") {
  return ProgramPath("track") + " --cameras=" + scene +
         "/cameras.json --detections=" + detections +
         " --config=" + ProjectFile(config).string() + " --out=" + out;
}

RunningProgram Started(const std::string& line, const std::string& errors,
                       const std::string& input = "/dev/null",
                       const std::string& output = "/dev/null") {
  return RunningProgram({"/bin/bash", "-c", "exec " + line}, errors, input,
                        output);
}

// A program that reads a pipe and writes into a folder.
class PipeTest : public ::testing::Test {
 protected:
  PipeTest() {
    mkfifo(pipe_.c_str(), 0600);
    fs::create_directory(out_);
  }

  // Passes the scene to the program and waits until it has begun to write;
  // closing the stream ends the pipe.
  std::ofstream BeginInput() const {
    std::ofstream input = OpenPipe(pipe_);
    EXPECT_TRUE(input.is_open());
    input << ContentOf(Scene() + "/detections.jsonl") << std::flush;
    EXPECT_TRUE(WaitUntil([&] { return HasPartial(out_); }));
    return input;
  }

  // Checks that a program stopped while it writes leaves no files.
  void StopInTheMiddle(const std::string& line, int signal, const char* name) {
    RunningProgram program = Started(line, errors_);
    const std::ofstream input = BeginInput();
    program.Signal(signal);
    const int status = program.Wait();
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal);
    EXPECT_THAT(NamesIn(out_), IsEmpty());
    // A single line and nothing else.
    EXPECT_THAT(
        ContentOf(errors_),
        MatchesRegex("kinegraph-[a-z]+: stopped by " + std::string(name) +
                     "; partial files were removed\n"));
  }

  const TemporaryFolder folder_;
  const std::string pipe_ = (folder_.path() / "pipe").string();
  const fs::path out_ = folder_.path() / "out";
  const std::string result_ = (out_ / "result.jsonl").string();
  const std::string errors_ = (folder_.path() / "errors").string();
};

TEST_F(PipeTest, ASignalLeavesNoFileOfTrack) {
  StopInTheMiddle(TrackCommand(pipe_, result_), SIGINT, "SIGINT");
  StopInTheMiddle(TrackCommand(pipe_, result_), SIGTERM, "SIGTERM");
  StopInTheMiddle(TrackCommand(pipe_, result_), SIGHUP, "SIGHUP");
}

TEST_F(PipeTest, ASignalLeavesNoFolderOfManyFilesOfConvert) {
  StopInTheMiddle(ProgramPath("convert") + " --from=kinegraph --to=openpose" +
                      " --in=" + pipe_ + " --out=" + result_,
                  SIGTERM, "SIGTERM");
}

TEST_F(PipeTest, AnIgnoredSignalStaysIgnored) {
  const std::string script = folder_.Write(
      "script", "trap '' HUP\nexec " + TrackCommand(pipe_, result_) + "\n");
  RunningProgram program({"/bin/bash", script}, errors_);
  {
    const std::ofstream input = BeginInput();
    program.Signal(SIGHUP);
  }
  EXPECT_EQ(program.Wait(), 0);
  EXPECT_TRUE(fs::exists(result_));
}

TEST_F(PipeTest, ARemovedOutputFolderIsAnError) {
  RunningProgram program = Started(TrackCommand(pipe_, result_), errors_);
  {
    const std::ofstream input = BeginInput();
    fs::remove_all(out_);
  }
  const int status = program.Wait();
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1);
  EXPECT_THAT(ContentOf(errors_), HasSubstr("No such file or directory"));
}

TEST(StreamTest, StandardOutputHasOnlyTheResult) {
  const auto line = [](const std::string& out) {
    return TrackCommand(Scene() + "/detections.jsonl", out);
  };
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "file.jsonl").string();
  ASSERT_EQ(RunShell(line(file)).exit_code, 0);
  const std::string expected = ContentOf(file);
  for (const char* out : {"/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    const ProgramOutcome piped = RunShell(line(out) + " | cat");
    EXPECT_EQ(piped.output, expected) << out;
    EXPECT_THAT(piped.errors, StartsWith("10 frames, ")) << out;
  }
  // Appending with >> keeps the existing content.
  const std::string log = folder.Write("log", "before\n");
  ASSERT_EQ(RunShell(line("/dev/stdout") + " >> " + log).exit_code, 0);
  EXPECT_EQ(ContentOf(log), "before\n" + expected);
}

TEST(StreamTest, AReaderThatClosesThePipeIsAnError) {
  const ProgramOutcome outcome = RunShell(
      "set -o pipefail\n" +
      TrackCommand(Scene() + "/detections.jsonl", "/dev/stdout") + " | true");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.errors, HasSubstr("Broken pipe"));
}

int LinesOf(const std::string& path) {
  const std::string content = ContentOf(path);
  return static_cast<int>(std::count(content.begin(), content.end(), '\n'));
}

struct LiveCase {
  const char* name;
  const char* config;
  int lag;  // frames
};

class LiveTest : public PipeTest,
                 public ::testing::WithParamInterface<LiveCase> {
 protected:
  LiveTest() {
    std::ifstream file(recording_ + "/detections.jsonl");
    for (std::string line; std::getline(file, line);) lines_.push_back(line);
    EXPECT_GT(lines_.size(), 90u);
  }

  std::string Command(const std::string& detections,
                      const std::string& out) const {
    return TrackCommand(detections, out, recording_, GetParam().config);
  }

  const std::string recording_ = DemoScene("4");
  const std::string recorded_ = (folder_.path() / "recorded.jsonl").string();
  std::vector<std::string> lines_;  // of the detections, the header first
};

TEST_P(LiveTest, OutputsWithinTheLagAndEqualsOffline) {
  RunningProgram program =
      Started(Command("-", "/dev/stdout"), errors_, pipe_, result_);
  {
    std::ofstream input = OpenPipe(pipe_);
    ASSERT_TRUE(input.is_open());
    int given = 0;
    for (const std::string& line : lines_) {
      input << line << "\n" << std::flush;
      ++given;  // the header too, on both sides
      if (given % 10 != 0) continue;
      EXPECT_TRUE(WaitUntil([&] {
        return LinesOf(result_) >= given - GetParam().lag;
      })) << given
          << " lines in, " << LinesOf(result_) << " out";
    }
  }
  EXPECT_EQ(program.Wait(), 0) << ContentOf(errors_);
  // The same frames from a file give the same bytes.
  ASSERT_EQ(
      RunShell(Command(recording_ + "/detections.jsonl", recorded_)).exit_code,
      0);
  EXPECT_EQ(ContentOf(result_), ContentOf(recorded_));
}

TEST_P(LiveTest, ASignalEndsTheInputAndKeepsTheResult) {
  RunningProgram program = Started(Command("-", result_), errors_, pipe_);
  std::ofstream input = OpenPipe(pipe_);
  ASSERT_TRUE(input.is_open());
  for (const std::string& line : lines_) input << line << "\n";
  input << std::flush;
  ASSERT_TRUE(WaitUntil([&] { return HasPartial(out_); }));
  program.Signal(SIGINT);
  EXPECT_EQ(program.Wait(), 0);
  EXPECT_GT(LinesOf(result_), 1);
  EXPECT_THAT(ContentOf(errors_), HasSubstr("input ended"));
}

INSTANTIATE_TEST_SUITE_P(
    Modes, LiveTest,
    ::testing::Values(
        LiveCase{"paper", "configs/synthetic/track_paper.toml", 0},
        LiveCase{"window", "configs/synthetic/track_window.toml", 10}),
    [](const ::testing::TestParamInfo<LiveCase>& test) {
      return std::string(test.param.name);
    });

TEST(LiveOptionsTest, RefusesOptionsThatNeedTheWholeRecording) {
  for (const char* set : {"mode=graph;output.estimator=batch",
                          "mode=graph;tracking.second_pass=true"}) {
    const ProgramOutcome outcome = RunShell(TrackCommand("-", "/dev/null") +
                                            " --set='" + set + "' < /dev/null");
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.errors, HasSubstr("stream"));
  }
}

TEST(FolderTest, NamedPipesInFoldersAreIgnored) {
  const TemporaryFolder folder;
  const std::string poses = (folder.path() / "poses").string();
  ASSERT_EQ(
      RunProgram("convert", "--from=kinegraph --to=openpose --in=" + Scene() +
                                "/detections.jsonl --out=" + poses)
          .exit_code,
      0);
  ASSERT_EQ(
      mkfifo((poses + "/cam0/cam0_000000000099_keypoints.json").c_str(), 0600),
      0);
  ASSERT_EQ(mkfifo((poses + "/a.json").c_str(), 0600), 0);
  const ProgramOutcome outcome =
      RunShell("timeout 60 " +
               TrackCommand(poses, (folder.path() / "out.jsonl").string()) +
               " --set='input.frame_rate=25'");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
}

TEST(FolderTest, AFailedRunLeavesNoEmptyFolders) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "a" / "b").string();
  // A limit of the shell keeps every file from being written.
  const ProgramOutcome outcome = RunShell(
      "ulimit -f 0\nexec 2> /dev/null\n" + ProgramPath("synthesize") +
      " --config=" + ProjectFile("configs/synthetic/demo.toml").string() +
      " --set=scene.duration=0.4 --out=" + out + " > /dev/null");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(NamesIn(folder.path()), IsEmpty());
  const ProgramOutcome reproduce =
      RunProgram("reproduce", "--data=" + (folder.path() / "none").string() +
                                  " --out=" + out);
  EXPECT_EQ(reproduce.exit_code, 2) << reproduce.errors;
  EXPECT_THAT(NamesIn(folder.path()), IsEmpty());
}

TEST(FolderTest, AReadOnlyFileSystemIsAnError) {
  if (!CanMount()) GTEST_SKIP() << "needs the right to mount (root)";
  const TemporaryFolder folder;
  const std::string line =
      ProgramPath("convert") + " --from=kinegraph --to=csv --in=" + Scene() +
      "/truth.jsonl --out=" + folder.path().string() + "/out.csv";
  const ProgramOutcome outcome =
      RunShell("unshare -m bash -c \"mount -t tmpfs -o ro none '" +
               folder.path().string() + "' && " + line + "\"");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.errors, HasSubstr("Read-only file system"));
}

// Detections in kinegraph's format for a skeleton with `joints` joints, with
// these lines.
std::string DetectionsOf(int joints, const std::string& lines,
                         const std::string& views = R"("cam0", "cam1")") {
  std::string names = R"("nose")";
  for (int i = 1; i < joints; ++i) names += ", \"" + std::to_string(i) + "\"";
  return R"({"kinegraph_detections": 1, "skeleton": {"name": "a", "joints": [)" +
         names + R"(], "bones": []}, "frame_rate": 25, "views": [)" + views +
         "]}\n" + lines;
}

// The text of a view with `count` people.
std::string ViewOf(const std::string& name, int count) {
  std::string text = "\"" + name + "\": [";
  for (int i = 0; i < count; ++i) {
    text += (i > 0 ? ", " : "") + std::string(R"({"joints": [[1, 2, 0.9]]})");
  }
  return text + "]";
}

// Expects the command to be rejected with the text `says`, and to be accepted
// with the key `set`, if there is one.
void ExpectLimit(const std::string& line, const std::string& says,
                 const std::string& set) {
  const ProgramOutcome refused = RunShell(line);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr(says));
  if (set.empty()) return;
  EXPECT_THAT(refused.errors, HasSubstr(set.substr(0, set.find('='))));
  const ProgramOutcome allowed = RunShell(line + " --set='" + set + "'");
  EXPECT_EQ(allowed.exit_code, 0) << allowed.errors;
}

TEST(LimitTest, LimitsCanBeRaisedByKeys) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out.jsonl").string();
  const auto track = [&](const std::string& text) {
    return TrackCommand(folder.Write("detections.jsonl", text), out);
  };
  for (const int joints : {10001, 100000}) {
    ExpectLimit(track(DetectionsOf(joints, "")), "expected at most 10000", "");
  }
  ExpectLimit(track(DetectionsOf(1001, "{\"frame\": 0, \"views\": {}}\n")),
              "has 1001 joints, more than 1000", "detections.max_joints=1001");
  const std::string begin = R"({"frame": 0, "views": {)";
  ExpectLimit(track(DetectionsOf(1, begin + ViewOf("cam0", 301) + "}}\n")),
              "frame 0, view 'cam0': has 301 detections",
              "detections.max_per_view=301");
  // Limit of all views together, whatever the limit of one view.
  const std::string views = ViewOf("a", 300) + ", " + ViewOf("b", 300) + ", " +
                            ViewOf("c", 300) + ", " + ViewOf("d", 300);
  const std::string many = folder.Write(
      "many.jsonl",
      DetectionsOf(1, begin + views + "}}\n", R"("a", "b", "c", "d")"));
  ExpectLimit(
      ProgramPath("convert") + " --in=" + many + " --to=kinegraph --out=" + out,
      "frame 0: has 1200 detections, more than 1000; "
      "detections.max_per_frame raises the limit",
      "detections.max_per_frame=1200");
}

// A clock that is set in the middle of a recording: the memory (here limited to
// 2 GB) depends on the number of frames, not on the span of their times.
TEST(LimitTest, AClockJumpDoesNotGrowMemory) {
  const TemporaryFolder folder;
  const std::string& scene = DemoScene("4");
  std::istringstream lines(ContentOf(scene + "/detections.jsonl"));
  std::string shifted;
  int number = 0;
  int late = 0;  // frames after the jump of 54 years
  for (std::string line; std::getline(lines, line); ++number) {
    const size_t at = line.find("\"time\": ");
    if (number > 50 && at != std::string::npos) {
      line.insert(at + 8, "170000000");
      ++late;
    }
    shifted += line + "\n";
  }
  EXPECT_GT(late, 40);
  const std::string detections = folder.Write("detections.jsonl", shifted);
  const ProgramOutcome outcome = RunShell(
      "ulimit -v 2000000; " + ProgramPath("doctor") + " --cameras=" + scene +
      "/cameras.json --detections=" + detections + " --config=" +
      ProjectFile("configs/synthetic/track_paper.toml").string() +
      " --out=" + (folder.path() / "doctor").string());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
}

// A command that solves people at the end, for a second or more.
std::string OfflineCommand(const std::string& detections, const fs::path& out) {
  return TrackCommand(detections, (out / "tracks.jsonl").string(),
                      DemoScene("8"), "configs/offline.toml");
}

// Ctrl-C during solving ends the program at once, with one line.
TEST(SignalTest, ASolveIsAbortedAtOnce) {
  const TemporaryFolder folder;
  const std::string errors = (folder.path() / "errors").string();
  const fs::path out = folder.path() / "out";
  const std::string line =
      OfflineCommand(DemoScene("8") + "/detections.jsonl", out);
  const auto clock = std::chrono::steady_clock::now;
  const auto begin = clock();
  ASSERT_EQ(Started(line, errors).Wait(), 0) << ContentOf(errors);
  const auto whole = clock() - begin;
  fs::remove_all(out);
  RunningProgram program = Started(line, errors);
  std::this_thread::sleep_for(whole / 2);
  program.Signal(SIGINT);
  const auto signal = clock();
  const int status = program.Wait();
  // Nothing delays the end; two seconds allow for a busy machine.
  EXPECT_LT(clock() - signal, std::chrono::seconds(2));
  ASSERT_TRUE(WIFSIGNALED(status)) << "the recording was solved too fast";
  EXPECT_EQ(WTERMSIG(status), SIGINT);
  EXPECT_EQ(ContentOf(errors),
            "kinegraph-track: stopped by SIGINT; partial files were removed\n");
  EXPECT_THAT(NamesIn(out), IsEmpty());
}

// If detections change between the first and the last reading, there is no
// result, or the result of the first reading.
TEST(InputTest, InputChangedDuringARunGivesNoMixedResult) {
  const TemporaryFolder folder;
  const std::string errors = (folder.path() / "errors").string();
  const fs::path out = folder.path() / "out";
  const std::string detections = folder.Write(
      "detections.jsonl", ContentOf(DemoScene("8") + "/detections.jsonl"));
  const std::string line = OfflineCommand(detections, out);
  ASSERT_EQ(Started(line, errors).Wait(), 0) << ContentOf(errors);
  const std::string whole = ContentOf(out / "tracks.jsonl");
  fs::remove_all(out);
  RunningProgram program = Started(line, errors);
  // The first reading is over.
  ASSERT_TRUE(WaitUntil([&] { return fs::exists(out) && HasPartial(out); }));
  fs::resize_file(detections, fs::file_size(detections) / 2);
  const int status = program.Wait();
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 0) {
    EXPECT_EQ(ContentOf(out / "tracks.jsonl"), whole);
  } else {
    EXPECT_THAT(ContentOf(errors), HasSubstr("detections.jsonl"));
    EXPECT_FALSE(fs::exists(out / "tracks.jsonl"));
    EXPECT_FALSE(HasPartial(out));
  }
}

TEST(RemovedFlagTest, ARemovedFlagNamesItsReplacement) {
  for (const std::string command : {"track", "compare", "reproduce"}) {
    for (const std::string flag :
         {"--resume", "--noresume", "--checkpoint_s=5"}) {
      const ProgramOutcome outcome = RunProgram(command, flag);
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_THAT(outcome.errors, HasSubstr("kinegraph-batch --resume"));
      EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'),
                1);
    }
  }
}

TEST(DriverTest, HelpNeedsNeitherPackagesNorACompiler) {
  // First with a build, then with a folder that has none.
  const TemporaryFolder folder;
  const std::string driver = ProjectFile("kinegraph").string();
  const ProgramOutcome built =
      RunShell("KINEGRAPH_BUILD=" + BuildFile("").string() + " " + driver +
               " track --help");
  EXPECT_EQ(built.exit_code, 0) << built.errors;
  EXPECT_THAT(built.output, HasSubstr("--detections"));
  EXPECT_THAT(built.errors, IsEmpty());
  const ProgramOutcome fresh =
      RunShell("KINEGRAPH_BUILD=" + (folder.path() / "none").string() + " " +
               driver + " track --help");
  EXPECT_EQ(fresh.exit_code, 0) << fresh.errors;
  EXPECT_THAT(fresh.output, HasSubstr("not built yet"));
  EXPECT_THAT(fresh.output, HasSubstr("--detections"));
  EXPECT_THAT(NamesIn(folder.path()), IsEmpty());
}

}  // namespace
}  // namespace kinegraph::testing
