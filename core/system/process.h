// This process, its processor time and signals, and processes that it starts.
#ifndef KINEGRAPH_CORE_SYSTEM_PROCESS_H_
#define KINEGRAPH_CORE_SYSTEM_PROCESS_H_

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace kinegraph {

int ProcessNumber();

// The file of the running program, links resolved; empty if unknown.
std::string ProgramPath();

struct ProcessEnd {
  // errno if the process could not be started or its end is unknown.
  int not_started = 0;
  int code = 0;    // exit code
  int signal = 0;  // the signal that ended it; 0: it exited
  bool well() const { return not_started == 0 && code == 0 && signal == 0; }
  // Ended because no process reads its output any more (SIGPIPE).
  bool broke_pipe() const;
};

// Runs a program by its path, in a folder, without input, and waits for its
// end; `words` are the path and the arguments. Standard output is appended to
// the file `printed` in the folder, standard error replaces the file `errors`
// there. If this process ends first, the program receives SIGTERM.
ProcessEnd RunInFolder(std::vector<std::string> words,
                       const std::string& folder, const char* printed,
                       const char* errors);

// Runs a program by its name, with the given standard streams, and waits for
// its end. `setting`, NAME=value, is set in its environment.
ProcessEnd RunWithStreams(std::vector<std::string> words, std::FILE* input,
                          std::FILE* output, std::FILE* errors,
                          const std::string& setting);

// A program that runs concurrently, started by its name, with the given
// descriptors as its standard streams; `input` -1: no input.
class RunningProgram {
 public:
  RunningProgram(std::vector<std::string> words, int input, int output,
                 int errors);
  ~RunningProgram();  // kills the program if it still runs
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // Waits until the program has exited; kills it after `most_ms`.
  ProcessEnd Wait(int most_ms);
  // Whether Wait killed it.
  bool was_ended() const { return was_ended_; }

 private:
  int64_t process_ = 0;  // 0: ended; the result is in `end_`
  bool was_ended_ = false;
  ProcessEnd end_;
};

// The first line that a shell command prints, up to 255 bytes; empty if it
// prints none.
std::string FirstLineOf(const std::string& command);

// Keeps up to 64 MB of freed memory in the process, because the kernel would
// clear each page again before reuse. No effect without glibc.
void KeepFreedMemory();

// Files with system information, in lines "key: value" (the first) and
// "key=value" (the second). They may not exist.
inline constexpr const char* kProcessorFile = "/proc/cpuinfo";
inline constexpr const char* kSystemFile = "/etc/os-release";

// Processor time of this thread [ns].
int64_t ThreadCpuNs();

// Starts `thread` concurrently, which receives SIGINT, SIGTERM and SIGHUP by
// NextSignal, except those that are already ignored or handled. Also turns
// SIGXFSZ (the shell's limit of file sizes) into an ordinary write error. Call
// once.
void CatchSignals(const std::function<void()>& thread);

// For that thread: waits for the next signal; 0 on failure.
int NextSignal();
const char* SignalName(int number);
// Ends the process by the signal's default action, and programs of
// RunningProgram by SIGTERM.
[[noreturn]] void EndBySignal(int number);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_PROCESS_H_
