// What every command shares: flags, exit codes, the one line of an error.
//
//   DEFINE_string(cameras, "", "calibration file");
//
//   int main(int argc, char** argv) {
//     return kinegraph::RunApp(
//         argc, argv,
//         {"track", "2D detections to 3D tracks", "--cameras=F --out=F.jsonl",
//          {"--cameras=calibration.json --out=take.jsonl", ...}},
//         [] {
//           kinegraph::RequireFlag("cameras", FLAGS_cameras);
//           ...
//         });
//   }
//
// Flags are defined with gflags but parsed here: gflags' own parser leaves with
// exit code 1 for --help and for an unknown flag, lists the flags of every
// library, and silently takes the last of a repeated flag.
#ifndef KINEGRAPH_APPS_COMMON_APP_H_
#define KINEGRAPH_APPS_COMMON_APP_H_

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/base/frame_range.h"

namespace kinegraph {

// Exit codes of every command.
inline constexpr int kExitDone = 0;
inline constexpr int kExitFailure = 1;   // anything but the user's input
inline constexpr int kExitBadInput = 2;  // bad usage or bad input

struct AppInfo {
  std::string command;  // "track" for kinegraph-track
  std::string summary;  // one line
  std::string usage;    // the flags as one types them, one line or several
  // Two command lines that people need, without "kinegraph track".
  std::array<std::string, 2> examples;
};

// Parses the flags, runs `body` and returns the exit code for main.
//   --help, --version            printed on stdout, 0
//   InputError, OptionError      2
//   any other exception          1
//   stdout could not be written  1 (0 if its reader merely stopped reading)
// An error is one line on stderr: "kinegraph-track: error: ...".
// Logging is silent but for failed CHECKs; --v=N shows VLOG on stderr.
int RunApp(int argc, char** argv, const AppInfo& info,
           const std::function<void()>& body);

// Throws InputError when the flag --`name` was not given.
void RequireFlag(const std::string& name, const std::string& value);

// The first of the command's flags that does not have its default value; empty:
// all have.
std::string FirstGiven(const std::vector<std::string>& names);

// Throws InputError: "--name: found 'found', expected ...".
[[noreturn]] void FailFlag(const std::string& name, const std::string& found,
                           const std::string& expected);

// Makes the folders above a file that is to be written and returns its path.
std::string WithFolders(const std::string& path);

// What a command line asks for.
enum class CommandLineRequest { kRun, kHelp, kVersion };

// Sets the gflags of the files in apps/ (and glog's --v and --vmodule) from
// --name=value, --name value, --name and --noname (booleans); "--" ends them.
// A text that begins with "~/" begins with the home folder instead.
// Throws InputError for an unknown or repeated flag, a value that its type or
// validator refuses, and for anything that is not a flag. RunApp calls it.
CommandLineRequest ParseCommandLine(const std::vector<std::string>& arguments);

// What --help prints: the command's own flags, those that its usage has outside
// of brackets first, each with type, default and an example.
std::string HelpText(const AppInfo& info);

// "300:400,450:460", ascending and apart; no text gives no range, which means
// every frame. Throws InputError naming --`flag`.
std::vector<FrameRange> ParseFrameRanges(const std::string& text,
                                         const std::string& flag = "frames");

// "a,b,c" without empty parts; no text gives no part. Throws InputError naming
// --`flag` for an empty part.
std::vector<std::string> ParseList(const std::string& text,
                                   const std::string& flag);

// "--cameras=calibration.json". Flags of one name mean the same in every
// command, but for those with an example of the command's own.
std::string FlagExample(const std::string& command, const std::string& flag,
                        const std::string& type,
                        const std::string& default_value);

// Flags that a usage such as "--cameras=F [--mode=M] --out=F" has outside of
// brackets, in its first form where there are several.
std::set<std::string> RequiredFlags(const std::string& usage);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_APP_H_
