// Long work that is killed goes on: the same bytes as without a kill.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A few in every test run, one under a sanitizer; KINEGRAPH_KILLS asks for
// more.
int KillCount() {
  const char* asked = std::getenv("KINEGRAPH_KILLS");
  if (asked == nullptr) return kSanitized ? 1 : 3;
  return std::max(1, std::atoi(asked));
}

// What a result is made of, without what a clock says.
using Contents = std::map<std::string, std::string>;
Contents ContentsOf(const fs::path& folder) {
  Contents contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name =
        fs::relative(entry.path(), folder).generic_string();
    if (!entry.is_regular_file() || entry.path().filename() == "runtime.json" ||
        name.find(".partial-") != std::string::npos) {
      continue;
    }
    std::string text;
    std::ifstream file(entry.path(), std::ios::binary);
    for (std::string line; std::getline(file, line);) {
      const bool time = line.find("s of processor time (") != line.npos ||
                        line.find("\"processor_s\"") != line.npos ||
                        line.find("\"wall_s\"") != line.npos;
      if (!time) text += line + "\n";
    }
    contents[name] = text;
  }
  return contents;
}

std::vector<std::string> Line(const std::string& command,
                              std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), ProgramPath(command));
  return arguments;
}

int64_t SizeOf(const fs::path& path) {
  std::error_code none;
  const auto size = fs::file_size(path, none);
  return none ? -1 : static_cast<int64_t>(size);
}

// Kills the command when its checkpoint has grown, or, every third time, after
// a moment that differs from kill to kill; then lets it go on to the end.
void KillAndResume(const std::vector<std::string>& command,
                   const std::string& out_name) {
  const TemporaryFolder folder;
  const fs::path whole = folder.path() / "whole";
  const fs::path killed = folder.path() / "killed";
  fs::create_directory(whole);
  fs::create_directory(killed);
  const std::string errors = (folder.path() / "errors").string();
  const auto line = [&](const fs::path& out) {
    std::vector<std::string> all = command;
    all.push_back("--out=" + (out / out_name).string());
    return all;
  };
  ASSERT_EQ(RunningProgram(line(whole), errors).Wait(), 0) << ContentOf(errors);
  const Contents expected = ContentsOf(whole);
  ASSERT_FALSE(expected.empty());

  const fs::path checkpoint = killed / (out_name + ".checkpoint");
  std::vector<std::string> resuming = line(killed);
  resuming.emplace_back("--resume");
  resuming.emplace_back("--checkpoint_s=0");
  int kills = 0;
  int grown = 0;
  for (int round = 0; kills < KillCount() && round < 10 * KillCount();
       ++round) {
    const int64_t before = SizeOf(checkpoint);
    RunningProgram program(resuming, errors);
    if (round % 3 == 2) {
      std::this_thread::sleep_for(std::chrono::milliseconds(37 * round % 400));
    } else if (WaitUntil([&] {
                 return SizeOf(checkpoint) > before ||
                        fs::exists(killed / out_name);
               })) {
      ++grown;
    }
    program.Signal(SIGKILL);
    const int status = program.Wait();
    if (WIFSIGNALED(status)) {
      ++kills;
      // But for its last words it was done.
      const bool was_done =
          !fs::exists(checkpoint) && ContentsOf(killed) == expected;
      if (!was_done) continue;
    } else {
      // It was faster: its result must be right, and the next begins anew.
      ASSERT_EQ(status, 0) << ContentOf(errors);
      EXPECT_EQ(ContentsOf(killed), expected);
    }
    fs::remove_all(killed);
    fs::create_directory(killed);
  }
  EXPECT_GE(kills, KillCount());
  EXPECT_GT(grown, 0);
  ASSERT_EQ(RunningProgram(resuming, errors).Wait(), 0) << ContentOf(errors);
  EXPECT_EQ(ContentsOf(killed), expected);
  EXPECT_FALSE(fs::exists(checkpoint));
}

const std::string& Scene() { return DemoScene("2"); }

std::vector<std::string> SceneArguments() {
  return {"--cameras=" + Scene() + "/cameras.json",
          "--detections=" + Scene() + "/detections.jsonl",
          "--config=" + ProjectFile("configs/offline.toml").string()};
}

TEST(ResumeTest, TrackGoesOn) {
  KillAndResume(Line("track", SceneArguments()), "tracks.jsonl");
}

TEST(ResumeTest, CompareGoesOn) {
  std::vector<std::string> arguments = SceneArguments();
  arguments.emplace_back("--strategies=raw_dlt,butterworth,batch");
  arguments.emplace_back("--plots=false");
  KillAndResume(Line("compare", arguments), "compare");
}

TEST(ResumeTest, CompareGoesOnWhileItTunes) {
  std::vector<std::string> arguments = SceneArguments();
  arguments.emplace_back("--strategies=raw_dlt,butterworth");
  arguments.emplace_back("--plots=false");
  arguments.emplace_back("--tune");
  arguments.emplace_back("--folds=0:25,25:50");
  KillAndResume(Line("compare", arguments), "compare");
}

TEST(ResumeTest, CompareOfSeveralTakesGoesOn) {
  const TemporaryFolder folder;
  std::string takes;
  for (const char* frames : {"0:25", "25:50"}) {
    takes += "[[takes]]\nname = \"t" + std::to_string(takes.size()) +
             "\"\ncameras = \"" + Scene() + "/cameras.json\"\ndetections = \"" +
             Scene() + "/detections.jsonl\"\nframes = \"" + frames + "\"\n";
  }
  const std::string manifest = folder.Write(
      "takes.toml", takes + "[[configurations]]\nname = \"c\"\nconfig = \"" +
                        ProjectFile("configs/offline.toml").string() + "\"\n");
  KillAndResume(Line("compare", {"--manifest=" + manifest, "--tune",
                                 "--strategies=raw_dlt,butterworth"}),
                "compare");
}

// The folder has appeared, and the kill comes before the checkpoint is removed.
TEST(ResumeTest, CompareKilledWhenItsFolderIsThereIsDone) {
  const TemporaryFolder folder;
  const std::string errors = (folder.path() / "errors").string();
  const fs::path out = folder.path() / "compare";
  const fs::path checkpoint = out.string() + ".checkpoint";
  std::vector<std::string> line = Line("compare", SceneArguments());
  line.emplace_back("--strategies=raw_dlt,butterworth,batch");
  line.emplace_back("--plots=false");
  line.emplace_back("--checkpoint_s=0");
  line.push_back("--out=" + out.string());
  {
    RunningProgram program(line, errors);
    ASSERT_TRUE(WaitUntil([&] { return SizeOf(checkpoint) > 100; }));
    program.Signal(SIGKILL);
    ASSERT_TRUE(WIFSIGNALED(program.Wait()));
  }
  const std::string kept = ContentOf(checkpoint);
  line.emplace_back("--resume");
  ASSERT_EQ(RunningProgram(line, errors).Wait(), 0) << ContentOf(errors);
  const Contents expected = ContentsOf(out);
  const std::string times = ContentOf(out / "runtime.json");
  const std::set<std::string> names = NamesIn(folder.path());

  folder.Write("compare.checkpoint", kept);
  EXPECT_EQ(RunningProgram(line, errors).Wait(), 0) << ContentOf(errors);
  EXPECT_EQ(ContentsOf(out), expected);
  EXPECT_EQ(ContentOf(out / "runtime.json"), times);
  EXPECT_FALSE(fs::exists(checkpoint));

  // What another run has made is neither replaced nor taken for this one's.
  folder.Write("compare.checkpoint", kept);
  line[4] = "--strategies=raw_dlt,batch";
  const int refused = RunningProgram(line, errors).Wait();
  ASSERT_TRUE(WIFEXITED(refused));
  EXPECT_EQ(WEXITSTATUS(refused), 2);
  EXPECT_THAT(ContentOf(errors), HasSubstr("is there already, with other"));
  EXPECT_EQ(ContentsOf(out), expected);
  EXPECT_TRUE(fs::exists(checkpoint));
  EXPECT_EQ(NamesIn(folder.path()).size(), names.size() + 1);
}

TEST(ResumeTest, ReproduceGoesOn) {
  KINEGRAPH_DATA_OR_SKIP(campus, "campus");
  if (std::getenv("KINEGRAPH_KILLS") == nullptr) {
    GTEST_SKIP() << "takes minutes; KINEGRAPH_KILLS=N runs it with N kills";
  }
  KillAndResume(
      Line("reproduce", {"--data=" + fs::path(campus).parent_path().string(),
                         "--table=campus"}),
      "reproduce");
}

// Ctrl-C while people are being solved: at once, in one line, and what was
// solved is kept.
TEST(ResumeTest, ASolveIsLeftAtOnceAndGoneOnFrom) {
  const TemporaryFolder folder;
  const std::string errors = (folder.path() / "errors").string();
  const std::string out = (folder.path() / "tracks.jsonl").string();
  std::vector<std::string> line = Line("track", SceneArguments());
  line[2] = "--detections=" + DemoScene("8") + "/detections.jsonl";
  line[1] = "--cameras=" + DemoScene("8") + "/cameras.json";
  line.push_back("--out=" + out);
  line.emplace_back("--checkpoint_s=0");
  ASSERT_EQ(RunningProgram(line, errors).Wait(), 0) << ContentOf(errors);
  const std::string whole = ContentOf(out);
  fs::remove(out);
  RunningProgram program(line, errors);
  ASSERT_TRUE(WaitUntil([&] { return SizeOf(out + ".checkpoint") > 100; }));
  program.Signal(SIGINT);
  const auto start = std::chrono::steady_clock::now();
  const int status = program.Wait();
  // Nothing is waited for; the rest is a machine that is busy.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
  ASSERT_TRUE(WIFSIGNALED(status)) << "the take was solved too fast";
  EXPECT_EQ(WTERMSIG(status), SIGINT);
  EXPECT_EQ(ContentOf(errors),
            "kinegraph-track: stopped by SIGINT; what was half-written is "
            "removed\n");
  EXPECT_FALSE(HasPartial(folder.path()));
  EXPECT_FALSE(fs::exists(out));
  EXPECT_TRUE(fs::exists(out + ".checkpoint"));
  line.emplace_back("--resume");
  ASSERT_EQ(RunningProgram(line, errors).Wait(), 0) << ContentOf(errors);
  EXPECT_EQ(ContentOf(out), whole);
}

// Detections that change between the first reading and the last: the result is
// not made, or is that of what was read first.
TEST(ResumeTest, AnInputThatChangesUnderneathIsNoHarm) {
  const TemporaryFolder folder;
  const std::string errors = (folder.path() / "errors").string();
  const fs::path out = folder.path() / "out";
  const std::string detections = folder.Write(
      "detections.jsonl", ContentOf(DemoScene("8") + "/detections.jsonl"));
  std::vector<std::string> line = Line("track", SceneArguments());
  line[1] = "--cameras=" + DemoScene("8") + "/cameras.json";
  line[2] = "--detections=" + detections;
  line.push_back("--out=" + (out / "tracks.jsonl").string());
  line.emplace_back("--checkpoint_s=0");
  ASSERT_EQ(RunningProgram(line, errors).Wait(), 0) << ContentOf(errors);
  const std::string whole = ContentOf(out / "tracks.jsonl");
  fs::remove_all(out);
  RunningProgram program(line, errors);
  ASSERT_TRUE(WaitUntil([&] {
    return SizeOf((out / "tracks.jsonl.checkpoint").string()) > 100;
  }));
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

TEST(ResumeTest, AStrangeCheckpointIsRefusedAndKept) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "tracks.jsonl").string();
  folder.Write("tracks.jsonl.checkpoint", "my notes\n");
  std::string line;
  for (const std::string& argument : SceneArguments()) line += argument + " ";
  line += "--out=" + out;
  const ProgramOutcome refused = RunProgram("track", line + " --resume");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("is no checkpoint of kinegraph"));
  // Without --resume the run does without.
  const ProgramOutcome made = RunProgram("track", line + " --checkpoint_s=0");
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_THAT(made.errors, HasSubstr("no checkpoint was kept"));
  EXPECT_EQ(ContentOf(out + ".checkpoint"), "my notes\n");
}

}  // namespace
}  // namespace kinegraph::testing
