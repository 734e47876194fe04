#include "apps/common/app.h"

#include <fcntl.h>
#include <gflags/gflags.h>
#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/config_folder.h"
#include "core/base/error.h"

DEFINE_string(test_out, "out.jsonl", "where the result goes");
DEFINE_int32(test_threads, 1, "threads at work");
DEFINE_uint64(test_seed, 0, "seed");
DEFINE_double(test_ratio, 0.5, "a ratio");
DEFINE_bool(test_loud, false, "talk");
DEFINE_string(set, "", "keys to change");

namespace kinegraph {
namespace {

using ::testing::ExitedWithCode;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// The message of the InputError that a command line causes; "" without one.
std::string Refusal(const std::vector<std::string>& arguments) {
  try {
    ParseCommandLine(arguments);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Flags are global; restores them after each test.
class CommandLine : public ::testing::Test {
 private:
  gflags::FlagSaver saver_;
};

TEST_F(CommandLine, AcceptsEveryFlagSyntax) {
  EXPECT_EQ(ParseCommandLine({"--test_out=a=b", "--test_threads", "3",
                              "--test_loud", "--test_ratio", "-0.25", "--"}),
            CommandLineRequest::kRun);
  EXPECT_EQ(FLAGS_test_out, "a=b");
  EXPECT_EQ(FLAGS_test_threads, 3);
  EXPECT_TRUE(FLAGS_test_loud);
  EXPECT_EQ(FLAGS_test_ratio, -0.25);
}

TEST_F(CommandLine, SwitchesABooleanOffAndAcceptsAnEmptyText) {
  FLAGS_test_loud = true;
  ParseCommandLine({"--notest_loud", "--test_out="});
  EXPECT_FALSE(FLAGS_test_loud);
  EXPECT_EQ(FLAGS_test_out, "");
  ParseCommandLine({"--test_loud=true"});
  EXPECT_TRUE(FLAGS_test_loud);
}

TEST_F(CommandLine, FindsTheFirstGivenFlag) {
  ParseCommandLine({"--test_loud", "--test_ratio=0.5"});
  EXPECT_EQ(FirstGiven({"test_out", "test_ratio", "test_loud"}), "test_loud");
  EXPECT_EQ(FirstGiven({"test_out", "test_ratio"}), "");
}

TEST_F(CommandLine, AsksForHelpAndVersion) {
  EXPECT_EQ(ParseCommandLine({"--test_threads=2", "--help", "stray"}),
            CommandLineRequest::kHelp);
  EXPECT_EQ(ParseCommandLine({"-h"}), CommandLineRequest::kHelp);
  EXPECT_EQ(ParseCommandLine({"--version"}), CommandLineRequest::kVersion);
}

TEST_F(CommandLine, RefusesUnknownFlagsAndNamesTheNearest) {
  EXPECT_THAT(Refusal({"--tset_out=x"}), HasSubstr("did you mean --test_out?"));
  EXPECT_THAT(Refusal({"--elephant"}), Not(HasSubstr("did you mean")));
  EXPECT_THAT(Refusal({"--notest_out"}), HasSubstr("unknown flag"));
  // Flags of libraries are refused like unknown ones.
  for (const std::string flag : {"--elephant", "--flagfile", "--log_dir"}) {
    EXPECT_THAT(Refusal({flag + "=x"}), HasSubstr("unknown flag " + flag));
  }
}

TEST_F(CommandLine, ErrorsNameTheFoundAndTheExpectedValue) {
  const std::pair<std::vector<std::string>, std::string> cases[] = {
      {{"--test_threads=two"},
       "--test_threads: found the text 'two', expected an integer"},
      {{"--test_threads=99999999999"},
       "--test_threads: found the text '99999999999', expected an integer"},
      {{"--test_seed=-1"},
       "--test_seed: found the text '-1', expected an integer >= 0"},
      {{"--test_ratio=1.5x"},
       "--test_ratio: found the text '1.5x', expected a number"},
      {{"--test_loud=maybe"},
       "--test_loud: found the text 'maybe', expected true or false"},
      {{"--notest_loud=true"}, "--notest_loud takes no value"},
      {{"--test_out=a", "--test_out", "a"},
       "--test_out is given more than once"},
      {{"--test_loud", "--notest_loud"}, "--test_loud is given more than once"},
      {{"--test_out"}, "--test_out: a value is missing"}};
  for (const auto& [arguments, message] : cases) {
    EXPECT_EQ(Refusal(arguments), message);
  }
  EXPECT_THAT(Refusal({"--test_out", "--test_threads=2"}),
              HasSubstr("found the flag --test_threads=2"));
}

// Users may append a fix, which a command prints as --set=..., to a command
// line that already has a --set.
TEST_F(CommandLine, RepeatedSetsAreConcatenated) {
  EXPECT_EQ(Refusal({"--set=a.b=1", "--set", "c=2;d=3"}), "");
  EXPECT_EQ(FLAGS_set, "a.b=1;c=2;d=3");
}

TEST_F(CommandLine, RefusesArgumentsThatAreNotFlags) {
  for (const std::string stray : {"file.json", "-", "-test_out", ""}) {
    EXPECT_THAT(Refusal({stray}), HasSubstr("found '" + stray + "'"));
  }
  EXPECT_THAT(Refusal({"--", "--test_out=a"}), HasSubstr("--test_out=a"));
  // A boolean takes no value from the next argument.
  EXPECT_THAT(Refusal({"--test_loud", "true"}), HasSubstr("found 'true'"));
}

TEST_F(CommandLine, ErrorsAreOneLineForArgumentsWithLineBreaks) {
  EXPECT_THAT(Refusal({"--a\nb"}), Not(HasSubstr("\n")));
  EXPECT_THAT(Refusal({"a\nb"}), Not(HasSubstr("\n")));
  EXPECT_THAT(Refusal({"--test_threads=1\n2"}), Not(HasSubstr("\n")));
}

TEST_F(CommandLine, HelpListsOnlyFlagsOfTheCommand) {
  const std::string help = HelpText({"walk",
                                     "walks about",
                                     "--test_out=F",
                                     {"--test_out=a", "--test_out=b"}});
  EXPECT_THAT(help, StartsWith("kinegraph-walk: walks about\n\n"
                               "  kinegraph walk --test_out=a\n"
                               "  kinegraph walk --test_out=b\n\n"
                               "Usage: kinegraph-walk --test_out=F\n"));
  EXPECT_THAT(help, HasSubstr("\nRequired:\n"
                              "  --test_out  (text, default \"out.jsonl\")\n"
                              "      where the result goes\n"
                              "      such as --test_out=out.jsonl\n"));
  EXPECT_THAT(help, HasSubstr("--test_threads  (integer, default 1)\n"));
  EXPECT_LT(help.find("--test_out  ("), help.find("\nOptional:\n"));
  EXPECT_GT(help.find("--test_threads  ("), help.find("\nOptional:\n"));
  EXPECT_THAT(help, Not(HasSubstr("logtostderr")));
  EXPECT_THAT(help, Not(HasSubstr("flagfile")));
}

TEST(HelpText, RequiredFlagsAreOutsideBrackets) {
  EXPECT_EQ(RequiredFlags("--tracks=F[,F2] [--cameras=F --detections=PATH "
                          "[--images=P]] --out=F"),
            (std::set<std::string>{"tracks", "out"}));
  EXPECT_EQ(
      RequiredFlags("--protocol=NAME\n       kinegraph-evaluate --json=F"),
      std::set<std::string>{"protocol"});
  EXPECT_EQ(FlagExample("track", "cameras", "string", ""),
            "--cameras=calibration.toml");
  EXPECT_EQ(FlagExample("compare", "plots", "bool", "true"), "--noplots");
}

TEST(RequireFlag, RefusesAnEmptyValue) {
  EXPECT_NO_THROW(RequireFlag("cameras", "a.json"));
  EXPECT_THROW(RequireFlag("cameras", ""), InputError);
}

// ---- Whole runs, each in a process of its own -------------------------------

[[noreturn]] void RunAndLeave(std::vector<std::string> arguments,
                              const std::function<void()>& body) {
  arguments.insert(arguments.begin(), "program");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  const int argc = static_cast<int>(argv.size());
  argv.push_back(nullptr);
  std::exit(
      RunApp(argc, argv.data(), {"walk", "walks about", "--flags", {}}, body));
}

void ReplaceStdout(int fd) {
  std::cout.flush();
  std::fflush(stdout);
  dup2(fd, STDOUT_FILENO);
}

// Redirects stdout to stderr, which EXPECT_EXIT compares.
void RunWithStdoutShown(const std::vector<std::string>& arguments) {
  ReplaceStdout(STDERR_FILENO);
  RunAndLeave(arguments, [] { std::cout << "walked " << FLAGS_test_threads; });
}

// Regular expression for stderr that consists of this line only.
std::string ErrorLine(const std::string& message) {
  return "^kinegraph-walk: error: " + message + "\n$";
}

TEST(RunAppDeathTest, RunsTheBodyWithParsedFlags) {
  EXPECT_EXIT(RunWithStdoutShown({"--test_threads=4"}),
              ExitedWithCode(kExitDone), "^walked 4$");
}

TEST(RunAppDeathTest, PrintsHelpAndVersionWithoutRunning) {
  EXPECT_EXIT(RunWithStdoutShown({"--help"}), ExitedWithCode(kExitDone),
              "^kinegraph-walk: walks about\n");
  EXPECT_EXIT(RunWithStdoutShown({"--version"}), ExitedWithCode(kExitDone),
              "^kinegraph-walk [0-9]+\\.[0-9]+\\.[0-9]+\n$");
}

TEST(RunAppDeathTest, ErrorsAreOneLineWithMatchingExitCode) {
  const struct {
    const char* flag;
    std::function<void()> body;
    int exit_code;
    const char* message;
  } cases[] = {
      {"--no_such_flag", [] {}, kExitBadInput, "unknown flag --no_such_flag.*"},
      {"--", [] { throw InputError("a.json", "line 3", "not so"); },
       kExitBadInput, "a.json: line 3: not so"},
      {"--", [] { throw OptionError("graph.lag_s", "too long"); },
       kExitBadInput, "graph.lag_s: too long"},
      {"--", [] { throw std::bad_alloc(); }, kExitFailure, "out of memory"},
      {"--", [] { throw std::runtime_error("two\nlines"); }, kExitFailure,
       "two\\?lines"},
      {"--", [] { throw 7; }, kExitFailure, "unknown error"}};
  for (const auto& one : cases) {
    EXPECT_EXIT(RunAndLeave({one.flag}, one.body),
                ExitedWithCode(one.exit_code), ErrorLine(one.message));
  }
}

TEST(RunAppDeathTest, LogsNothingUnlessAsked) {
  const auto body = [] {
    LOG(INFO) << "information";
    LOG(WARNING) << "warning";
    LOG(ERROR) << "mistake";
    VLOG(1) << "diagnosis";
  };
  EXPECT_EXIT(RunAndLeave({}, body), ExitedWithCode(kExitDone), "^$");
  EXPECT_EXIT(RunAndLeave({"--v=1"}, body), ExitedWithCode(kExitDone),
              "diagnosis");
}

TEST(RunAppDeathTest, AFailedCheckNamesFileAndReason) {
  const auto body = [] { CHECK_EQ(1, 2) << "the reason"; };
#ifdef NDEBUG
  EXPECT_EXIT(RunAndLeave({}, body), ExitedWithCode(kExitFailure),
              "app_test.cc.*the reason");
#else
  EXPECT_EXIT(RunAndLeave({}, body), ::testing::KilledBySignal(SIGABRT),
              "app_test.cc.*the reason");
#endif
}

// More than any buffer of a pipe holds.
void PrintMuch() {
  for (int i = 0; i < 100000; ++i) std::cout << "a line of text\n";
}

TEST(RunAppDeathTest, LostOutputIsAnError) {
  const auto run_full = [](const std::vector<std::string>& arguments) {
    ReplaceStdout(open("/dev/full", O_WRONLY));
    RunAndLeave(arguments, PrintMuch);
  };
  EXPECT_EXIT(run_full({}), ExitedWithCode(kExitFailure),
              ErrorLine("standard output: .*"));
  EXPECT_EXIT(run_full({"--help"}), ExitedWithCode(kExitFailure),
              ErrorLine("standard output: No space.*"));
  EXPECT_EXIT(
      {
        std::fflush(stdout);
        close(STDOUT_FILENO);
        RunAndLeave({}, PrintMuch);
      },
      ExitedWithCode(kExitFailure), ErrorLine("standard output: .*"));
}

TEST(RunAppDeathTest, AClosedPipeOnStandardOutputExitsWithSuccess) {
  EXPECT_EXIT(
      {
        int ends[2];
        if (pipe(ends) != 0) std::exit(99);
        close(ends[0]);
        ReplaceStdout(ends[1]);
        RunAndLeave({}, PrintMuch);
      },
      ExitedWithCode(kExitDone), "^$");
}

// A file opened by the body must not take the place of a closed standard
// stream.
TEST(RunAppDeathTest, DoesNotReuseDescriptorsOfClosedStreams) {
  EXPECT_EXIT(
      {
        close(STDIN_FILENO);
        RunAndLeave({}, [] {
          if (open("/dev/zero", O_RDONLY) == STDIN_FILENO) std::exit(99);
        });
      },
      ExitedWithCode(kExitDone), "^$");
}

// ---- Frame ranges and lists -------------------------------------------------

TEST(ParseFrameRanges, IncludesTheFirstAndExcludesTheLast) {
  const auto ranges = ParseFrameRanges("300:400,450:460");
  ASSERT_EQ(ranges.size(), 2u);
  for (const int64_t frame : {300, 399, 459}) {
    EXPECT_TRUE(ContainsFrame(ranges, frame)) << frame;
  }
  for (const int64_t frame : {299, 400, 449, 460}) {
    EXPECT_FALSE(ContainsFrame(ranges, frame)) << frame;
  }
  EXPECT_TRUE(ParseFrameRanges("").empty());  // every frame
  EXPECT_TRUE(ContainsFrame({}, -1));
}

TEST(ParseFrameRanges, RefusesMalformedEmptyAndOverlappingRanges) {
  for (const std::string text :
       {"300", "300:", ":400", "a:b", "1:2:3", "400:300", "300:300", "1:2,",
        ",1:2", " 1:2", "+1:2", "1:99999999999999999999", "1.5:2", "1:2;3:4"}) {
    EXPECT_THROW(ParseFrameRanges(text), InputError) << text;
  }
  // Overlapping ranges would count frames twice; descending ranges are refused
  // too.
  EXPECT_THROW(ParseFrameRanges("1:5,4:8"), InputError);
  EXPECT_THROW(ParseFrameRanges("5:8,1:3"), InputError);
  EXPECT_EQ(ParseFrameRanges("1:5,5:8").size(), 2u);
}

TEST(ParseFrameRanges, NamesTheFlag) {
  try {
    ParseFrameRanges("x", "eval_frames");
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--eval_frames: found 'x'"));
  }
}

TEST(ParseList, SplitsAtCommas) {
  EXPECT_EQ(ParseList("a,b c,d", "x"),
            (std::vector<std::string>{"a", "b c", "d"}));
  EXPECT_TRUE(ParseList("", "x").empty());
  EXPECT_THROW(ParseList("a,,b", "x"), InputError);
  EXPECT_THROW(ParseList(",", "x"), InputError);
}

TEST(JoinSets, ConcatenatesWithSemicolons) {
  EXPECT_EQ(JoinSets("", ""), "");
  EXPECT_EQ(JoinSets("a=1", ""), "a=1");
  EXPECT_EQ(JoinSets("", "b=2"), "b=2");
  EXPECT_EQ(JoinSets("a=1", "b=2"), "a=1;b=2");
}

}  // namespace
}  // namespace kinegraph
