// A drill for every writer: nothing half-written, one clear line, the right
// exit code, and nothing of the user's lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A small recording that every writer takes.
struct Take {
  TemporaryFolder folder;
  std::string cameras, detections, truth;

  Take() {
    const std::string scene = (folder.path() / "scene").string();
    const ProgramOutcome made = RunProgram(
        "synthesize",
        "--config=" + ProjectFile("configs/synthetic/demo.toml").string() +
            " --set='scene.duration=0.4' --out=" + scene);
    EXPECT_EQ(made.exit_code, 0) << made.errors;
    cameras = scene + "/cameras.json";
    detections = scene + "/detections.jsonl";
    truth = scene + "/truth.jsonl";
  }
};

const Take& TheRecording() {
  static const Take* const recording = new Take;
  return *recording;
}

// A writer: what runs it, with OUT where the result's name stands.
struct Writer {
  std::string name;
  std::string command;
  std::string arguments;  // CAMERAS, DETECTIONS, TRUTH and OUT are filled in
  bool is_folder = false;
};

std::string Replaced(std::string text, const std::string& word,
                     const std::string& by) {
  for (size_t at = text.find(word); at != std::string::npos;
       at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

std::string CommandOf(const Writer& writer, const std::string& out) {
  std::string line = ProgramPath(writer.command) + " " + writer.arguments;
  line = Replaced(line, "CAMERAS", TheRecording().cameras);
  line = Replaced(line, "DETECTIONS", TheRecording().detections);
  line = Replaced(line, "TRUTH", TheRecording().truth);
  line = Replaced(line, "CONFIG",
                  ProjectFile("configs/synthetic/track_paper.toml").string());
  line = Replaced(line, "SCENE",
                  ProjectFile("configs/synthetic/demo.toml").string());
  return Replaced(line, "OUT", out);
}

std::vector<Writer> Writers() {
  std::vector<Writer> writers = {
      {"track", "track",
       "--cameras=CAMERAS --detections=DETECTIONS --config=CONFIG --out=OUT"},
      {"report", "report", "--tracks=TRUTH --out=OUT"},
      {"evaluate", "evaluate",
       "--tracks=TRUTH --ground_truth=TRUTH --protocol=mpjpe --json=OUT"},
      {"synthesize", "synthesize",
       "--config=SCENE --set=scene.duration=0.4 --out=OUT/made", true}};
  const auto convert = [&](const std::string& kind, const std::string& format,
                           const std::string& more, bool is_folder) {
    writers.push_back({kind + "_" + format, "convert",
                       "--from=kinegraph --in=" + kind + " --to=" + format +
                           " --out=OUT " + more,
                       is_folder});
  };
  for (const char* format :
       {"kinegraph", "krt", "voxelpose", "longcw", "panoptic", "pose2sim"}) {
    convert("CAMERAS", format, "", false);
  }
  convert("CAMERAS", "tum", "--set=cameras.ignore_distortion=true", true);
  for (const char* format : {"opencv", "easymocap"}) {
    convert("CAMERAS", format, "", true);
  }
  convert("DETECTIONS", "kinegraph", "", false);
  convert("DETECTIONS", "longcw", "--image_size=1280,720", false);
  convert("DETECTIONS", "openpose", "", true);
  convert("DETECTIONS", "coco", "", true);
  for (const char* format :
       {"kinegraph", "tum", "4da", "longcw", "poses", "csv", "npz"}) {
    convert("TRUTH", format, "", false);
  }
  convert("TRUTH", "panoptic", "", true);
  convert("TRUTH", "trc", "", true);
  return writers;
}

class WriterTest : public ::testing::TestWithParam<Writer> {
 protected:
  // One line on standard error, that of an error.
  static void ExpectOneLine(const ProgramOutcome& outcome) {
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr(": error: "));
  }
};

TEST_P(WriterTest, WritesWhatItShould) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "result.jsonl").string();
  const ProgramOutcome outcome = RunShell(CommandOf(GetParam(), out));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(fs::is_directory(out), GetParam().is_folder);
  EXPECT_FALSE(HasPartial(folder.path()));
}

TEST_P(WriterTest, LeavesNothingOnAFullDisk) {
  if (!CanMount()) GTEST_SKIP() << "needs the right to mount (root)";
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "result.jsonl").string();
  const ProgramOutcome outcome =
      RunOnFullDisk(folder.path().string(), CommandOf(GetParam(), out));
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  EXPECT_THAT(outcome.output, IsEmpty());  // the names that are left
  ExpectOneLine(outcome);
  EXPECT_THAT(outcome.errors, HasSubstr("No space left on device"));
}

TEST_P(WriterTest, KeepsTheOldFileOnAFullDisk) {
  if (GetParam().is_folder) return;
  const TemporaryFolder folder;
  const std::string out = folder.Write("result.jsonl", "old");
  // A limit of the shell stands for the disk: it needs no rights.
  const ProgramOutcome outcome =
      RunShell("ulimit -f 1\n" + CommandOf(GetParam(), out) + " > /dev/null");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  EXPECT_EQ(ContentOf(out), "old");
  EXPECT_THAT(NamesIn(folder.path()), ::testing::ElementsAre("result.jsonl"));
  ExpectOneLine(outcome);
}

TEST_P(WriterTest, ReplacesAFileAndFollowsALink) {
  if (GetParam().is_folder) return;
  const TemporaryFolder folder;
  const std::string out = folder.Write("result.jsonl", "old");
  chmod(out.c_str(), 0600);
  fs::create_symlink("result.jsonl", folder.path() / "link.jsonl");
  fs::create_symlink("made", folder.path() / "dangling.jsonl");
  for (const char* name : {"link.jsonl", "dangling.jsonl"}) {
    const ProgramOutcome outcome =
        RunShell(CommandOf(GetParam(), (folder.path() / name).string()));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_TRUE(fs::is_symlink(folder.path() / name));
  }
  EXPECT_THAT(ContentOf(out), Not("old"));
  EXPECT_EQ(fs::status(out).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(fs::is_regular_file(folder.path() / "made"));
  EXPECT_FALSE(HasPartial(folder.path()));
}

TEST_P(WriterTest, TakesDevicesAsTheyAre) {
  if (GetParam().is_folder) return;
  // A device of the test's own, with the numbers of /dev/null.
  const TemporaryFolder folder;
  const std::string null = (folder.path() / "null").string();
  const ProgramOutcome outcome = RunShell(
      "mknod '" + null + "' c 1 3 || exit 99\n" + CommandOf(GetParam(), null));
  if (outcome.exit_code == 99) GTEST_SKIP() << "needs the right to mknod";
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_TRUE(fs::is_character_file(null));
}

TEST_P(WriterTest, NeverWritesOverAnInput) {
  if (GetParam().is_folder) return;
  const std::string& input =
      GetParam().arguments.find("TRUTH") != std::string::npos
          ? TheRecording().truth
      : GetParam().arguments.find("DETECTIONS") != std::string::npos
          ? TheRecording().detections
          : TheRecording().cameras;
  const std::string before = ContentOf(input);
  const TemporaryFolder folder;
  fs::create_symlink(input, folder.path() / "link.jsonl");
  fs::create_hard_link(input, folder.path() / "hard.jsonl");
  for (const std::string& out : {input, (folder.path() / "link.jsonl").string(),
                                 (folder.path() / "hard.jsonl").string()}) {
    const ProgramOutcome outcome = RunShell(CommandOf(GetParam(), out));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr("is an input of this command"));
    EXPECT_EQ(ContentOf(input), before);
  }
}

TEST_P(WriterTest, TwoAtOnceBothSucceedOrOneSaysWhy) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "result.jsonl").string();
  const std::string line = CommandOf(GetParam(), out);
  const ProgramOutcome outcome =
      RunShell(line + " > /dev/null & " + line +
               " > /dev/null; second=$?; wait $!; echo $? $second");
  if (GetParam().is_folder) {
    // A folder with files in it is never replaced.
    EXPECT_THAT(outcome.output,
                ::testing::AnyOf("0 0\n", "0 1\n", "1 0\n", "0 2\n", "2 0\n"));
  } else {
    EXPECT_EQ(outcome.output, "0 0\n") << outcome.errors;
  }
  EXPECT_THAT(NamesIn(folder.path()),
              ::testing::IsSubsetOf({"result.jsonl", "result.summary.json"}));
}

TEST_P(WriterTest, PlantedLinksAreNotFollowed) {
  // Whoever can guess the name of the file aside could have a victim's file
  // overwritten.
  if (GetParam().is_folder) return;
  const TemporaryFolder folder;
  const std::string victim = folder.Write("victim", "precious");
  const std::string out = (folder.path() / "result.jsonl").string();
  fs::create_symlink("victim", out + ".partial");
  // The shell's own number becomes the program's.
  const ProgramOutcome outcome =
      RunShell("for i in 0 1 2; do ln -s victim '" + out +
               "'.partial-$$-$i; done\nexec " + CommandOf(GetParam(), out));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(ContentOf(victim), "precious");
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(out)));
}

INSTANTIATE_TEST_SUITE_P(Every, WriterTest, ::testing::ValuesIn(Writers()),
                         [](const ::testing::TestParamInfo<Writer>& test) {
                           return test.param.name;
                         });

}  // namespace
}  // namespace kinegraph::testing
