// For each of Writers(): no partial files, a one-line error, the right exit
// code, and the user's files unharmed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/faulty_runs.h"

namespace kinegraph::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A file of a small recording, the input of all writers except synthesize.
std::string Input(const char* name) { return DemoScene("0.4") + "/" + name; }

// A command that writes a result OUT.
struct Writer {
  std::string name;
  std::string command;
  std::string arguments;  // CommandOf() replaces words in capitals
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
  line = Replaced(line, "CAMERAS", Input("cameras.json"));
  line = Replaced(line, "DETECTIONS", Input("detections.jsonl"));
  line = Replaced(line, "TRUTH", Input("truth.jsonl"));
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
       {"kinegraph", "tum", "4da", "longcw", "csv", "npz"}) {
    convert("TRUTH", format, "", false);
  }
  convert("TRUTH", "panoptic", "", true);
  convert("TRUTH", "trc", "", true);
  return writers;
}

std::vector<Writer> FileWriters() {
  std::vector<Writer> writers = Writers();
  writers.erase(std::remove_if(writers.begin(), writers.end(),
                               [](const Writer& one) { return one.is_folder; }),
                writers.end());
  return writers;
}

class WriterTest : public ::testing::TestWithParam<Writer> {
 protected:
  ProgramOutcome Run(const std::string& out) const {
    return RunShell(CommandOf(GetParam(), out));
  }
  // Expects a single error line on standard error.
  static void ExpectOneLine(const ProgramOutcome& outcome) {
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1)
        << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr(": error: "));
  }

  const TemporaryFolder folder_;
  const std::string out_ = (folder_.path() / "result.jsonl").string();
};

// Writers whose result is one file.
class FileWriterTest : public WriterTest {};

TEST_P(WriterTest, WritesAFileOrAFolder) {
  const ProgramOutcome outcome = Run(out_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(fs::is_directory(out_), GetParam().is_folder);
  EXPECT_FALSE(HasPartial(folder_.path()));
}

TEST_P(WriterTest, LeavesNothingOnAFullDisk) {
  if (!CanMount()) GTEST_SKIP() << "needs the right to mount (root)";
  const ProgramOutcome outcome =
      RunOnFullDisk(folder_.path().string(), CommandOf(GetParam(), out_));
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  EXPECT_THAT(outcome.output, IsEmpty());  // the names of remaining files
  ExpectOneLine(outcome);
  EXPECT_THAT(outcome.errors, HasSubstr("No space left on device"));
}

TEST_P(FileWriterTest, KeepsTheOldFileOnAFullDisk) {
  folder_.Write("result.jsonl", "old");
  // The shell's file size limit simulates a full disk without privileges.
  const ProgramOutcome outcome =
      RunShell("ulimit -f 1\n" + CommandOf(GetParam(), out_) + " > /dev/null");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.errors;
  EXPECT_EQ(ContentOf(out_), "old");
  EXPECT_THAT(NamesIn(folder_.path()), ::testing::ElementsAre("result.jsonl"));
  ExpectOneLine(outcome);
}

TEST_P(FileWriterTest, ReplacesAFileAndFollowsALink) {
  folder_.Write("result.jsonl", "old");
  chmod(out_.c_str(), 0600);
  fs::create_symlink("result.jsonl", folder_.path() / "link.jsonl");
  fs::create_symlink("made", folder_.path() / "dangling.jsonl");
  for (const char* name : {"link.jsonl", "dangling.jsonl"}) {
    const ProgramOutcome outcome = Run((folder_.path() / name).string());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_TRUE(fs::is_symlink(folder_.path() / name));
  }
  EXPECT_THAT(ContentOf(out_), Not("old"));
  EXPECT_EQ(fs::status(out_).permissions(),
            fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(fs::is_regular_file(folder_.path() / "made"));
  EXPECT_FALSE(HasPartial(folder_.path()));
}

TEST_P(FileWriterTest, WritesToADeviceWithoutReplacingIt) {
  // A separate device node with the numbers of /dev/null.
  const std::string null = (folder_.path() / "null").string();
  const ProgramOutcome outcome = RunShell(
      "mknod '" + null + "' c 1 3 || exit 99\n" + CommandOf(GetParam(), null));
  if (outcome.exit_code == 99) GTEST_SKIP() << "needs the right to mknod";
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_TRUE(fs::is_character_file(null));
}

TEST_P(FileWriterTest, NeverWritesOverAnInput) {
  const std::string input =
      GetParam().arguments.find("TRUTH") != std::string::npos
          ? Input("truth.jsonl")
      : GetParam().arguments.find("DETECTIONS") != std::string::npos
          ? Input("detections.jsonl")
          : Input("cameras.json");
  const std::string before = ContentOf(input);
  fs::create_symlink(input, folder_.path() / "link.jsonl");
  fs::create_hard_link(input, folder_.path() / "hard.jsonl");
  for (const std::string& out :
       {input, (folder_.path() / "link.jsonl").string(),
        (folder_.path() / "hard.jsonl").string()}) {
    const ProgramOutcome outcome = Run(out);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.errors;
    EXPECT_THAT(outcome.errors, HasSubstr("is an input of this command"));
    EXPECT_EQ(ContentOf(input), before);
  }
}

TEST_P(WriterTest, OfTwoConcurrentRunsAtLeastOneSucceeds) {
  const std::string line = CommandOf(GetParam(), out_);
  const ProgramOutcome outcome =
      RunShell(line + " > /dev/null & " + line +
               " > /dev/null; second=$?; wait $!; echo $? $second");
  if (GetParam().is_folder) {
    // Non-empty folders are never replaced.
    EXPECT_THAT(outcome.output,
                ::testing::AnyOf("0 0\n", "0 1\n", "1 0\n", "0 2\n", "2 0\n"));
  } else {
    EXPECT_EQ(outcome.output, "0 0\n") << outcome.errors;
  }
  EXPECT_THAT(NamesIn(folder_.path()),
              ::testing::IsSubsetOf({"result.jsonl", "result.summary.json"}));
}

TEST_P(FileWriterTest, PlantedLinksAreNotFollowed) {
  // Temporary names are predictable: if links of these names were followed, a
  // victim's file would be overwritten.
  const std::string victim = folder_.Write("victim", "precious");
  fs::create_symlink("victim", out_ + ".partial");
  // With exec, the program keeps the process ID of the shell.
  const ProgramOutcome outcome =
      RunShell("for i in 0 1 2; do ln -s victim '" + out_ +
               "'.partial-$$-$i; done\nexec " + CommandOf(GetParam(), out_));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(ContentOf(victim), "precious");
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(out_)));
}

std::string NameOf(const ::testing::TestParamInfo<Writer>& test) {
  return test.param.name;
}
INSTANTIATE_TEST_SUITE_P(Every, WriterTest, ::testing::ValuesIn(Writers()),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Every, FileWriterTest,
                         ::testing::ValuesIn(FileWriters()), NameOf);

}  // namespace
}  // namespace kinegraph::testing
