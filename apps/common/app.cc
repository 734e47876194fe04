#include "apps/common/app.h"

#include <gflags/gflags.h>
#include <glog/logging.h>
#include <glog/vlog_is_on.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <iterator>
#include <new>
#include <set>
#include <utility>

#include "apps/common/interruption.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/io/files/text_file.h"
#include "core/system/file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

constexpr size_t kMaxErrorLength = 2000;  // characters

std::string ProgramName(const AppInfo& info) {
  return "kinegraph-" + info.command;
}

// Flags defined in a source file of apps/. glog and gflags define about forty
// more, which the commands do not offer.
bool IsOwnFlag(const gflags::CommandLineFlagInfo& flag) {
  const std::string path = "/" + flag.filename;
  return path.find("/apps/") != std::string::npos;
}

// glog's flags that enable VLOG.
bool IsDiagnosisFlag(const std::string& name) {
  return name == "v" || name == "vmodule";
}

bool FindFlag(const std::string& name, gflags::CommandLineFlagInfo* flag) {
  return gflags::GetCommandLineFlagInfo(name.c_str(), flag) &&
         (IsOwnFlag(*flag) || IsDiagnosisFlag(name));
}

std::vector<gflags::CommandLineFlagInfo> OwnFlags() {
  std::vector<gflags::CommandLineFlagInfo> all;
  gflags::GetAllFlags(&all);
  std::vector<gflags::CommandLineFlagInfo> own;
  std::copy_if(all.begin(), all.end(), std::back_inserter(own), IsOwnFlag);
  return own;
}

InputError UnknownFlag(const std::string& name) {
  const std::string positive = name.rfind("no", 0) == 0 ? name.substr(2) : name;
  if (positive == "resume" || positive == "checkpoint_s") {
    return InputError(
        "--" + Printable(name) +
        " was removed: a recording is processed from its start; "
        "`kinegraph-batch --resume` skips recordings that are done");
  }
  if (positive == "frames_out") {
    return InputError(
        "--frames_out was removed: the page of `kinegraph report` draws poses "
        "on --images and saves its view as PNG or SVG");
  }
  const std::string shown = "unknown flag --" + Printable(name);
  std::string nearest;
  size_t least = 3;  // this distance or more is no typing error
  for (const gflags::CommandLineFlagInfo& flag : OwnFlags()) {
    const size_t distance = EditDistance(name.substr(0, 100), flag.name);
    if (distance >= least) continue;
    least = distance;
    nearest = flag.name;
  }
  if (nearest.empty()) return InputError(shown + "; --help lists the flags");
  return InputError(shown + "; did you mean --" + nearest + "?");
}

std::string TypeName(const gflags::CommandLineFlagInfo& flag) {
  if (flag.type == "string") return "text";
  if (flag.type == "double") return "number";
  if (flag.type == "bool") return "true or false";
  return flag.type[0] == 'u' ? "integer >= 0" : "integer";
}

std::string Article(const gflags::CommandLineFlagInfo& flag) {
  if (flag.type == "bool") return "";
  return flag.type.find("int") != std::string::npos ? "an " : "a ";
}

// A shell does not expand the tilde of --out=~/x.
std::string WithHome(const std::string& value) {
  const char* home = std::getenv("HOME");
  if (home == nullptr || value.rfind("~/", 0) != 0) return value;
  return home + value.substr(1);
}

class CommandLineParser {
 public:
  explicit CommandLineParser(const std::vector<std::string>& arguments)
      : arguments_(arguments) {}

  CommandLineRequest Parse() {
    while (next_ < arguments_.size()) {
      const std::string& argument = arguments_[next_++];
      if (argument == "--help" || argument == "-h") {
        return CommandLineRequest::kHelp;
      }
      if (argument == "--version") return CommandLineRequest::kVersion;
      if (argument == "--") break;
      if (argument.rfind("--", 0) != 0) throw Stray(argument);
      ParseFlag(argument.substr(2));
    }
    if (next_ < arguments_.size()) throw Stray(arguments_[next_]);
    return CommandLineRequest::kRun;
  }

 private:
  static InputError Stray(const std::string& argument) {
    return InputError("found '" + Printable(argument) +
                      "', expected a flag such as --name=value");
  }

  void ParseFlag(const std::string& text) {
    const size_t equals = text.find('=');
    const bool has_value = equals != std::string::npos;
    const std::string name = text.substr(0, equals);
    gflags::CommandLineFlagInfo flag;
    if (FindFlag(name, &flag)) {
      if (has_value) return Set(flag, text.substr(equals + 1));
      return Set(flag, flag.type == "bool" ? "true" : NextValue(flag));
    }
    const bool negated = name.rfind("no", 0) == 0 &&
                         FindFlag(name.substr(2), &flag) && flag.type == "bool";
    if (!negated) throw UnknownFlag(name);
    if (has_value) throw InputError("--" + name + " takes no value");
    Set(flag, "false");
  }

  // The argument after a flag without "=". If that is another flag, the value
  // is missing.
  std::string NextValue(const gflags::CommandLineFlagInfo& flag) {
    if (next_ == arguments_.size()) {
      throw InputError("--" + flag.name + ": a value is missing");
    }
    const std::string& value = arguments_[next_];
    if (value.rfind("--", 0) == 0) {
      throw InputError(
          "--" + flag.name + ": expected a value, found the flag " +
          Printable(value) + "; write --" + flag.name + "=VALUE if it is one");
    }
    ++next_;
    return value;
  }

  void Set(const gflags::CommandLineFlagInfo& flag, const std::string& value) {
    const bool again = !seen_.insert(flag.name).second;
    // Only the keys of --set accumulate, so that a suggested --set can be
    // appended to a command that has one.
    if (again && flag.name != "set") {
      throw InputError("--" + flag.name + " is given more than once");
    }
    std::string full = flag.type == "string" ? WithHome(value) : value;
    if (again) full = flag.current_value + ";" + full;
    if (gflags::SetCommandLineOption(flag.name.c_str(), full.c_str()).empty()) {
      throw InputError(
          "--" + flag.name + ": found the text '" + Printable(value) +
          "', expected " + Article(flag) + TypeName(flag) +
          (flag.has_validator_fn ? " within the allowed range" : ""));
    }
  }

  const std::vector<std::string>& arguments_;
  size_t next_ = 0;
  std::set<std::string> seen_;
};

#ifdef NDEBUG
// __attribute__((noreturn)) rather than [[noreturn]]: with Clang it is part of
// the function type, as in glog's signature.
__attribute__((noreturn)) void LeaveAfterFailedCheck() {
  RemovePartialFilesForGood();
  std::_Exit(kExitFailure);
}
#endif

void InitLogging(const AppInfo& info) {
  const bool diagnosis = FLAGS_v > 0 || !FLAGS_vmodule.empty();
  FLAGS_logtostderr = true;  // never a log file
  FLAGS_minloglevel = diagnosis ? google::GLOG_INFO : google::GLOG_FATAL;
  if (google::IsGoogleLoggingInitialized()) return;
  // Glog keeps the pointer.
  static const std::string program = ProgramName(info);
  google::InitGoogleLogging(program.c_str());
#ifdef NDEBUG
  // A debug build aborts, so that a debugger or core file shows the location.
  google::InstallFailureFunction(&LeaveAfterFailedCheck);
#endif
}

// Throws if printed output was not written, unless the reader of a pipe, such
// as `head`, has closed it.
void FinishStdout() {
  errno = 0;
  std::cout.flush();
  const bool failed =
      std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout.good();
  if (!failed || ReaderIsGone(kStandardOutput)) return;
  const std::string reason =
      errno != 0 ? std::strerror(errno) : "output was lost";
  throw std::runtime_error("standard output: " + reason);
}

void Run(int argc, char** argv, const AppInfo& info,
         const std::function<void()>& body) {
  // argc is 0 if a program is started without its own name.
  const std::vector<std::string> arguments(argv + std::min(argc, 1),
                                           argv + argc);
  switch (ParseCommandLine(arguments)) {
    case CommandLineRequest::kHelp:
      std::cout << HelpText(info);
      break;
    case CommandLineRequest::kVersion:
      std::cout << ProgramName(info) << " " << KINEGRAPH_VERSION << "\n";
      break;
    case CommandLineRequest::kRun:
      InitLogging(info);
      HandleInterruptions(ProgramName(info));
      InputFiles::Protect();
      body();
      break;
  }
  FinishStdout();
}

// Prints the error as one line on stderr and returns the exit code.
int Fail(const AppInfo& info, const std::string& message, int exit_code) {
  std::cout.flush();  // keeps the order of output
  std::fflush(stdout);
  const std::string line = ProgramName(info) +
                           ": error: " + Printable(message, kMaxErrorLength) +
                           "\n";
  std::fputs(line.c_str(), stderr);
  return exit_code;
}

FrameRange ParseFrameRange(const std::string& text, const std::string& flag) {
  const std::vector<std::string> ends = Split(text, ':');
  if (ends.size() == 2) {
    const auto begin = ParseNumber<int64_t>(ends[0]);
    const auto end = ParseNumber<int64_t>(ends[1]);
    if (begin && end && *begin < *end) return {*begin, *end};
  }
  FailFlag(flag, text, "A:B with A < B (A is included, B is not)");
}

// The example value of a flag in --help, by the flag's name, or by command and
// name if its meaning differs in that command.
constexpr std::pair<const char*, const char*> kFlagExamples[] = {
    {"adapter", "./my_reader.py"},
    {"align", "none"},
    {"annotated", "everybody"},
    {"axes", "x,-z,y"},
    {"baseline", "butterworth"},
    {"batch.out", "out/batch"},
    {"calibrate.out", "out/cameras.json"},
    {"calibrate.to", "opencv"},
    {"cameras", "calibration.toml"},
    {"cameras_apart", "cam1,cam2,3.42"},
    {"compare.markers", "walk.c3d"},
    {"compare.out", "out/compare"},
    {"config", "my.toml"},
    {"convert.out", "out/take.csv"},
    {"convert.set", "'cameras.unit=mm'"},
    {"corrections", "take.identity.jsonl"},
    {"data", "data"},
    {"demo.config", "configs/synthetic/hard.toml"},
    {"demo.out", "out/demo"},
    {"demo.set", "scene.people=3"},
    {"detections", "openpose/"},
    {"distance", "l_hip,l_knee,0.44"},
    {"doctor", "out/doctor"},
    {"doctor.out", "out/doctor"},
    {"embed_megabytes", "20"},
    {"endpoints", "each"},
    {"evaluate.out", "out/markers"},
    {"focal", "1150"},
    {"focal_error", "5"},
    {"folds", "300:438,463:601"},
    {"format", "openpose"},
    {"frame_rate", "60"},
    {"frames", "300:600"},
    {"from", "pose2sim"},
    {"ground_truth", "truth.jsonl"},
    {"head", "mvpose"},
    {"held_out_set", "held_out_set.json"},
    {"image_size", "1920,1080"},
    {"images", "'cam1=video/cam1/%06d.jpg;cam2=video/cam2/%06d.jpg'"},
    {"in", "take.jsonl"},
    {"init.out", "my.toml"},
    {"jobs", "2"},
    {"joint", "l_wrist"},
    {"joints", "joints.toml"},
    {"json", "out/scores.json"},
    {"kinematics.out", "out/angles.csv"},
    {"manifest", "takes.toml"},
    {"markers", "pose2sim"},
    {"matching", "one_to_one"},
    {"mode", "paper"},
    {"motion", "walk.jsonl"},
    {"parameters", "out/compare/parameters.toml"},
    {"person", "3"},
    {"plot_strategies", "butterworth,batch"},
    {"protocol", "mpjpe"},
    {"reference", "paper.jsonl"},
    {"report.out", "out/take.html"},
    {"reproduce.out", "out/tables"},
    {"reproduce.set", "detections.skeleton=body25b"},
    {"runs", "without_cam0.jsonl,without_cam1.jsonl"},
    {"scale", "1.78"},
    {"set", "'input.frame_rate=60;cameras.unit=mm'"},
    {"skeleton", "body25b"},
    {"strategies", "butterworth,batch"},
    {"synthesize.config", "configs/synthetic/demo.toml"},
    {"synthesize.out", "out/scene"},
    {"synthesize.set", "'scene.people=8;noise.sigma=4'"},
    {"table", "shelf"},
    {"task", "walk/default"},
    {"threads", "2"},
    {"title", "'Walk, first try'"},
    {"to", "trc"},
    {"track.out", "out/take.jsonl"},
    {"tracks", "out/take.jsonl"},
    {"unit", "mm"},
    {"up", "-y"},
    {"without_cameras", "cam2"}};

// Empty if there is none.
std::string ExampleOf(const std::string& name) {
  for (const auto& [flag, example] : kFlagExamples) {
    if (flag == name) return example;
  }
  return "";
}

}  // namespace

int RunApp(int argc, char** argv, const AppInfo& info,
           const std::function<void()>& body) {
  NameProgram(ProgramName(info));
  PrepareStandardStreams();
  KeepFreedMemory();
  try {
    Run(argc, argv, info, body);
    return kExitDone;
  } catch (const InputError& error) {
    return Fail(info, error.what(), kExitBadInput);
  } catch (const OptionError& error) {
    return Fail(info, error.what(), kExitBadInput);
  } catch (const std::bad_alloc&) {
    EndOutOfMemory();
  } catch (const std::exception& error) {
    return Fail(info, error.what(), kExitFailure);
  } catch (...) {
    return Fail(info, "unknown error", kExitFailure);
  }
}

void RequireFlag(const std::string& name, const std::string& value) {
  if (value.empty()) throw InputError("--" + name + " is required");
}

std::string FirstGiven(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto flag = gflags::GetCommandLineFlagInfoOrDie(name.c_str());
    if (flag.current_value != flag.default_value) return name;
  }
  return "";
}

std::string ShellQuoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

void FailFlag(const std::string& name, const std::string& found,
              const std::string& expected) {
  throw InputError("--" + name + ": found '" + Printable(found) +
                   "', expected " + expected);
}

std::string WithFolders(const std::string& path) {
  const size_t slash = path.find_last_of('/');
  if (slash != std::string::npos && slash > 0) {
    MakeFolder(path.substr(0, slash));
  }
  return path;
}

CommandLineRequest ParseCommandLine(const std::vector<std::string>& arguments) {
  return CommandLineParser(arguments).Parse();
}

std::string HelpText(const AppInfo& info) {
  const std::set<std::string> required = RequiredFlags(info.usage);
  std::string first;
  std::string others;
  for (const gflags::CommandLineFlagInfo& flag : OwnFlags()) {
    const std::string quote = flag.type == "string" ? "\"" : "";
    std::string& group = required.count(flag.name) > 0 ? first : others;
    group += "  --" + flag.name + "  (" + TypeName(flag);
    if (!flag.default_value.empty()) {
      group += ", default " + quote + flag.default_value + quote;
    }
    group +=
        ")\n      " + flag.description + "\n      such as " +
        FlagExample(info.command, flag.name, flag.type, flag.default_value) +
        "\n";
  }
  std::string examples;
  for (const std::string& example : info.examples) {
    examples += "\n  kinegraph " + info.command +
                (example.empty() ? "" : " " + example);
  }
  return ProgramName(info) + ": " + info.summary + "\n" + examples +
         "\n\nUsage: " + ProgramName(info) + " " + info.usage +
         (first.empty() ? "" : "\n\nRequired:\n" + first) +
         (first.empty() ? "\n\n" : "\n") + "Optional:\n" + others +
         "  --help\n      print this and exit\n"
         "  --version\n      print the version and exit\n"
         "  --v  (integer, default 0)\n      diagnostic messages on stderr; "
         "higher values print more\n";
}

std::vector<FrameRange> ParseFrameRanges(const std::string& text,
                                         const std::string& flag) {
  std::vector<FrameRange> ranges;
  for (const std::string& part : ParseList(text, flag)) {
    const FrameRange range = ParseFrameRange(part, flag);
    if (!ranges.empty() && range.begin < ranges.back().end) {
      throw InputError("--" + flag + ": '" + Printable(part) +
                       "' must not begin before the previous range has ended");
    }
    ranges.push_back(range);
  }
  return ranges;
}

std::vector<std::string> ParseList(const std::string& text,
                                   const std::string& flag) {
  if (text.empty()) return {};
  std::vector<std::string> parts = Split(text, ',');
  for (const std::string& part : parts) {
    if (part.empty()) {
      throw InputError("--" + flag + ": an empty part in '" + Printable(text) +
                       "'");
    }
  }
  return parts;
}

std::string FlagExample(const std::string& command, const std::string& flag,
                        const std::string& type,
                        const std::string& default_value) {
  const std::string name = "--" + flag;
  if (type == "bool") {
    return default_value == "true" ? "--no" + flag : name;
  }
  std::string example = ExampleOf(command + "." + flag);
  if (example.empty()) example = ExampleOf(flag);
  if (example.empty())
    example = default_value.empty() ? "VALUE" : default_value;
  return name + "=" + example;
}

std::set<std::string> RequiredFlags(const std::string& usage) {
  const std::string first = usage.substr(0, usage.find("kinegraph-"));
  std::set<std::string> flags;
  int depth = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (first[i] == '[') ++depth;
    if (first[i] == ']') --depth;
    if (depth > 0 || first.compare(i, 2, "--") != 0) continue;
    size_t end = i + 2;
    while (end < first.size() &&
           (std::isalnum(static_cast<unsigned char>(first[end])) != 0 ||
            first[end] == '_')) {
      ++end;
    }
    flags.insert(first.substr(i + 2, end - i - 2));
    i = end - 1;
  }
  return flags;
}

}  // namespace kinegraph
