// Runs commands on a full disk, with signals and with named pipes.
#ifndef KINEGRAPH_TESTS_SUPPORT_FAULTY_RUNS_H_
#define KINEGRAPH_TESTS_SUPPORT_FAULTY_RUNS_H_

#include <fcntl.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/program.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_data.h"

namespace kinegraph::testing {

// Runs a shell script of one or several lines.
inline ProgramOutcome RunShell(const std::string& script) {
  const TemporaryFolder folder;
  const std::string file = folder.Write("script", script);
  const std::filesystem::path output = folder.path() / "stdout";
  const std::filesystem::path errors = folder.path() / "stderr";
  const int status = std::system(("bash '" + file + "' > '" + output.string() +
                                  "' 2> '" + errors.string() + "' < /dev/null")
                                     .c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ContentOf(output),
          ContentOf(errors)};
}

inline std::string ProgramPath(const std::string& command) {
  return BuildFile("apps/kinegraph-" + command).string();
}

// A folder with cameras.json, detections.jsonl and truth.jsonl of a demo scene
// of that duration; created once per program.
inline const std::string& DemoScene(const std::string& duration_s) {
  static const TemporaryFolder* const folder = new TemporaryFolder;
  static auto* const made = new std::map<std::string, std::string>;
  std::string& path = (*made)[duration_s];
  if (path.empty()) {
    path = (folder->path() / ("scene_" + duration_s)).string();
    const ProgramOutcome outcome = RunProgram(
        "synthesize",
        "--config=" + ProjectFile("configs/synthetic/demo.toml").string() +
            " --set='scene.duration=" + duration_s + "' --out=" + path);
    if (outcome.exit_code != 0) throw std::runtime_error(outcome.errors);
  }
  return path;
}

// Names of everything in a folder, sorted.
inline std::set<std::string> NamesIn(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

inline bool HasPartial(const std::filesystem::path& folder) {
  const std::set<std::string> names = NamesIn(folder);
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return name.find(".partial") != std::string::npos;
  });
}

// Whether a private mount namespace can be created, in which a small disk can
// be mounted that is invisible outside.
inline bool CanMount() {
  static const bool can =
      RunShell("unshare -m mount -t tmpfs none /mnt").exit_code == 0;
  return can;
}

// Runs `command` with a full disk mounted on `folder`, and lists what it left
// in the folder on standard output. The exit code is that of the command; 99 if
// the disk cannot be mounted.
inline ProgramOutcome RunOnFullDisk(const std::string& folder,
                                    const std::string& command) {
  return RunShell(
      "unshare -m bash -c \"\n"
      "mount -t tmpfs -o size=4k none '" +
      folder +
      "' || exit 99\n"
      "head -c 4096 /dev/zero > '" +
      folder + "/filler'\n" + command +
      " > /dev/null\n"
      "code=\\$?\n"
      "rm '" +
      folder +
      "/filler'\n"
      "ls -A '" +
      folder +
      "'\n"
      "exit \\$code\"\n");
}

// A command that runs beside the test.
class RunningProgram {
 public:
  // `arguments` begin with the program; the other parameters are files that
  // become its standard streams.
  RunningProgram(const std::vector<std::string>& arguments,
                 const std::string& errors_path,
                 const std::string& input = "/dev/null",
                 const std::string& output = "/dev/null") {
    std::vector<char*> raw;
    for (const std::string& argument : arguments) {
      raw.push_back(const_cast<char*>(argument.c_str()));
    }
    raw.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    // A shell that runs the tests in the background may set these signals to be
    // ignored. Restores the defaults.
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
      signal(number, SIG_DFL);
    }
    const bool ready = freopen(input.c_str(), "r", stdin) != nullptr &&
                       freopen(output.c_str(), "w", stdout) != nullptr &&
                       freopen(errors_path.c_str(), "w", stderr) != nullptr;
    if (ready) execv(raw[0], raw.data());
    _exit(127);
  }
  ~RunningProgram() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void Signal(int number) const { kill(process_, number); }

  // The status of waitpid.
  int Wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = -1;
    return status;
  }

 private:
  pid_t process_ = -1;
};

// Waits until the condition is true; false if it is not within 30 s (5 min
// under a sanitizer), which allows for busy machines.
template <typename Condition>
bool WaitUntil(const Condition& condition) {
  const auto until = std::chrono::steady_clock::now() +
                     std::chrono::seconds(kSanitized ? 300 : 30);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

// The writing end of a named pipe as soon as a program reads it; a closed
// stream if none does in time (a blocking open could wait forever).
inline std::ofstream OpenPipe(const std::string& path) {
  int reader_is_there = -1;
  WaitUntil([&] {
    reader_is_there = open(path.c_str(), O_WRONLY | O_NONBLOCK);
    return reader_is_there >= 0;
  });
  if (reader_is_there < 0) return {};
  std::ofstream stream(path, std::ios::binary);
  close(reader_is_there);
  return stream;
}

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_SUPPORT_FAULTY_RUNS_H_
