#include "core/io/adapters/adapter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "core/io/detections/source.h"
#include "core/io/files/input_files.h"
#include "core/system/file.h"
#include "tests/core/io/input_error.h"
#include "tests/support/test_data.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::InputErrorOf;
using testing::TemporaryFolder;

class AdapterTest : public ::testing::Test {
 protected:
  ~AdapterTest() override { SetAdapter(""); }

  Adapter Shell(const std::string& script) const {
    return {{"/bin/sh", "-c", script, "sh"},
            AdapterKind::kDetections,
            "a test's",
            ""};
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_.Write("a.xyz", "content");
};

TEST_F(AdapterTest, ReturnsTheOutput) {
  EXPECT_EQ(OutputOf(Shell("cat \"$1\"; echo .; echo note >&2"), path_),
            "content.\n");
}

TEST_F(AdapterTest, TimeoutEndsTheProgram) {
  AdapterRun run(Shell("sleep 600"), path_, {}, /*silence_ms=*/100);
  const Descriptor output(run.TakeOutput());
  EXPECT_FALSE(HasInput(output.get(), run.silence_ms()));
  // The destructor ends the program; otherwise this test would take ten
  // minutes.
}

TEST_F(AdapterTest, SilenceLimitFollowsTheSizeOfASession) {
  const std::string file = folder_.Write("session/cam1/a.h5", "");
  fs::resize_file(file, uintmax_t{5} << 20);
  const AdapterRun run(Shell("exit 0"), (folder_.path() / "session").string());
  EXPECT_EQ(run.silence_ms(), 65'000) << "a minute, and a second per MiB";
}

TEST_F(AdapterTest, HangingAdapterGivesReaderError) {
  const Adapter hangs = Shell("echo begun; sleep 600");
  AdapterRun run(hangs, path_, {}, /*silence_ms=*/100);
  const std::string said = InputErrorOf(
      [&] { run.Guard([]() -> int { throw InputError("nothing came"); }); });
  EXPECT_EQ(said, "nothing came") << "no error of the program, which hangs";
}

TEST_F(AdapterTest, AdapterErrorPrecedesReaderError) {
  AdapterRun run(Shell("echo a >&2; echo 'no good' >&2; exit 2"), path_);
  const Descriptor output(run.TakeOutput());
  EXPECT_EQ(InputErrorOf([&] {
              run.Guard([]() -> int { throw InputError("half a line"); });
            }),
            path_ + ": no good");
  EXPECT_EQ(InputErrorOf([&] { run.Finish(); }), path_ + ": no good");
}

TEST_F(AdapterTest, ReaderErrorPrecedesBrokenPipe) {
  ASSERT_NE(std::signal(SIGPIPE, SIG_DFL), SIG_ERR);
  AdapterRun run(Shell("exec yes"), path_);
  const std::string said = InputErrorOf([&] {
    run.Guard([&]() -> int {
      const Descriptor output(run.TakeOutput());
      throw InputError("found 3 joints");
    });
  });
  EXPECT_EQ(said, "found 3 joints");
}

TEST_F(AdapterTest, OtherFilesOfASessionAreNoInputs) {
  const std::string input = folder_.Write("session/cam1/a.h5", "points");
  const std::string result = folder_.Write("session/result.jsonl", "older");
  InputFiles::Protect();
  // The result grows meanwhile.
  EXPECT_EQ(OutputOf(Shell("echo more >> \"$1/result.jsonl\"; echo read"),
                     (folder_.path() / "session").string()),
            "read\n");
  EXPECT_TRUE(InputFiles::Has(input));
  EXPECT_FALSE(InputFiles::Has(result));
  // A program of the user, named by its path, may read any file.
  Adapter of_user = Shell("echo read");
  of_user.name = "/home/me/adapters/mine";
  OutputOf(of_user, (folder_.path() / "session").string());
  EXPECT_TRUE(InputFiles::Has(result));
}

TEST_F(AdapterTest, InputsAreNotedAsDeepAsAdaptersRead) {
  const std::string table =
      folder_.Write("session/recordings/a/b/c/xy_POSE.csv", "points");
  const std::string deeper =
      folder_.Write("session/recordings/a/b/c/d/xy_POSE.csv", "points");
  InputFiles::Protect();
  InputFiles::Forget(deeper);  // a removed file may have had its inode
  OutputOf(Shell("echo read"), (folder_.path() / "session").string());
  EXPECT_TRUE(InputFiles::Has(table));
  EXPECT_FALSE(InputFiles::Has(deeper));
}

TEST_F(AdapterTest, MissingProgramIsNamedWithInstallCommand) {
  Adapter none = {{"/no/such/program"}, AdapterKind::kDetections, "it", ""};
  none.hint = "apt-get install it";
  EXPECT_THAT(InputErrorOf([&] { OutputOf(none, path_); }),
              HasSubstr("a.xyz: requires it, which cannot be started (No such "
                        "file or directory): apt-get install it"));
}

TEST_F(AdapterTest, TheGivenAdapterIsTriedFirst) {
  const std::string program = folder_.Write(
      "reader",
      "#!/bin/sh\n"
      "if [ \"$1\" = --recognise ]; then\n"
      "  case $2 in *.jsonl) echo detections ;; *) exit 1 ;; esac\n"
      "  exit\n"
      "fi\n"
      "echo '{\"kinegraph_detections\": 1, \"skeleton\": {\"joints\": "
      "[\"LAnkle\", \"tail\"]}, \"views\": [\"a\"]}'\n"
      "echo '{\"frame\": 7, \"views\": {\"a\": [{\"joints\": [null, null]}, "
      "{\"joints\": [[3, 4, 1], null]}]}}'\n");
  fs::permissions(program, fs::perms::owner_all);
  SetAdapter(program);
  EXPECT_FALSE(GivenAdapterOf(path_).has_value());
  // Recognised by content, it would be an invalid file in kinegraph's own
  // format.
  const std::string ours =
      folder_.Write("b.jsonl", "{\"kinegraph_detections\": 1}\n");
  const DetectionSequence recording = ReadDetections(ours);
  EXPECT_EQ(recording.header.skeleton.joints(),
            (std::vector<std::string>{"l_ankle", "tail"}));
  ASSERT_EQ(recording.frames.size(), 1u);
  const auto& people = recording.frames[0].views[0].detections;
  ASSERT_EQ(people.size(), 1u) << "people without joints are skipped";
  EXPECT_EQ(people[0].index_in_file, 0);
  EXPECT_EQ(people[0].joints[0].px, Eigen::Vector2d(3, 4));
}

// SIGPIPE's default action, which a program that uses the library may not have
// changed, would end this test.
TEST_F(AdapterTest, WriterThatEndsEarlyIsAnError) {
  ASSERT_NE(std::signal(SIGPIPE, SIG_DFL), SIG_ERR);
  SetOwnAdapters({"/bin/sh", "-c", "echo 'no numpy' >&2; exit 1"});
  const std::string fault = InputErrorOf([&] {
    WriteByAdapter("movement", path_, [](const std::string& lines) {
      std::ofstream file(lines);
      file << std::string(1 << 20, 'a');  // more than a pipe holds
      file.close();
      if (!file) throw InputError("broken pipe");
    });
  });
  SetOwnAdapters({});
  EXPECT_EQ(fault, path_ + ": no numpy");
}

TEST_F(AdapterTest, HangingWriterIsNotReportedAsDamagedFile) {
  const auto fault_of = [this](const char* script) {
    SetOwnAdapters({"/bin/sh", "-c", script});
    const std::string fault = InputErrorOf([&] {
      WriteByAdapter(
          "movement", path_,
          [](const std::string& lines) { std::ofstream(lines) << "{}\n"; },
          /*silence_ms=*/1000);
    });
    SetOwnAdapters({});
    return fault;
  };
  EXPECT_EQ(fault_of("exec sleep 600"),
            path_ + ": its adapter has printed nothing for 1 s");
  EXPECT_EQ(fault_of("exec sleep 600 >&-"),
            path_ + ": its adapter (kinegraph-adapters) does not end");
  EXPECT_THAT(fault_of("kill -SEGV $$"), HasSubstr("was ended by signal 11"));
}

}  // namespace
}  // namespace kinegraph
