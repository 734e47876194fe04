// What all commands share: flags, exit codes and one-line error messages.
//
//   DEFINE_string(cameras, "", "calibration file");
//
//   int main(int argc, char** argv) {
//     return kinegraph::RunApp(
//         argc, argv,
//         {"track", "turns 2D detections into 3D tracks", "--cameras=F",
//          {"--cameras=calibration.json --out=take.jsonl", ...}},
//         [] {
//           kinegraph::RequireFlag("cameras", FLAGS_cameras);
//           ...
//         });
//   }
//
// Flags are defined with gflags but parsed here: gflags' own parser exits with
// code 1 for --help and for an unknown flag, lists the flags of every library,
// and silently takes the last of a repeated flag.
#ifndef KINEGRAPH_APPS_COMMON_APP_H_
#define KINEGRAPH_APPS_COMMON_APP_H_

#include <array>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/base/frame_range.h"

namespace kinegraph {

// Exit codes of every command.
inline constexpr int kExitDone = 0;
// Anything not caused by the user's input.
inline constexpr int kExitFailure = 1;
inline constexpr int kExitBadInput = 2;  // wrong usage or bad input

struct AppInfo {
  std::string command;  // "track" for kinegraph-track
  std::string summary;  // one line
  std::string usage;    // the flags as typed, on one or several lines
  // Two typical command lines, without "kinegraph track".
  std::array<std::string, 2> examples;
};

// Parses the flags, runs `body` and returns the exit code for main.
//   --help, -h, --version        printed on stdout, 0
//   InputError, OptionError      2
//   any other exception          1
//   stdout could not be written  1 (0 if its reader merely stopped reading)
// An error is one line on stderr: "kinegraph-track: error: ...". Logging is
// silent except for failed CHECKs; --v=N shows VLOG on stderr.
int RunApp(int argc, char** argv, const AppInfo& info,
           const std::function<void()>& body);

// Throws InputError if `value`, that of the flag --`name`, is empty.
void RequireFlag(const std::string& name, const std::string& value);

// The first of the flags `names` whose value differs from its default; empty if
// there is none.
std::string FirstGiven(const std::vector<std::string>& names);

// The text as one word of a POSIX shell: 'text'.
std::string ShellQuoted(const std::string& text);

// Throws InputError: "--name: found 'found', expected ...".
[[noreturn]] void FailFlag(const std::string& name, const std::string& found,
                           const std::string& expected);

// Creates the parent folders of a file to be written and returns its path.
std::string WithFolders(const std::string& path);

// The kind of request of a command line.
enum class CommandLineRequest { kRun, kHelp, kVersion };

// Sets the gflags of the files in apps/ (and glog's --v and --vmodule) from
// --name=value, --name value, --name and --noname (booleans); "--" ends them.
// In the value of a string flag a leading "~/" is replaced by the home folder.
// Throws InputError for an unknown flag, a repeated one (except --set, whose
// values are joined by ";"), a missing value, a value that the flag's type or
// validator rejects, a value given to --noname, and for anything that is not a
// flag. Stops at --help, -h and --version. Called by RunApp.
CommandLineRequest ParseCommandLine(const std::vector<std::string>& arguments);

// The output of --help: the command's own flags, required ones (outside the
// brackets of its usage) first, each with type, default and an example.
std::string HelpText(const AppInfo& info);

// "300:400,450:460", ascending and disjoint; an empty text gives no range, i.e.
// every frame. Throws InputError naming --`flag`.
std::vector<FrameRange> ParseFrameRanges(const std::string& text,
                                         const std::string& flag = "frames");

// "a,b,c" without empty parts; an empty text gives none. Throws InputError
// naming --`flag` for an empty part.
std::vector<std::string> ParseList(const std::string& text,
                                   const std::string& flag);

// "--cameras=calibration.toml". Flags of one name have the same meaning in
// every command, except for those with a command-specific example.
std::string FlagExample(const std::string& command, const std::string& flag,
                        const std::string& type,
                        const std::string& default_value);

// Flags outside the brackets of a usage such as "--cameras=F [--mode=M]
// --out=F"; of a usage with several command lines, those of the first.
std::set<std::string> RequiredFlags(const std::string& usage);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_APP_H_
