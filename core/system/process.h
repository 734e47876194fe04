// This process, its clock and signals, and processes that it starts.
#ifndef KINEGRAPH_CORE_SYSTEM_PROCESS_H_
#define KINEGRAPH_CORE_SYSTEM_PROCESS_H_

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace kinegraph {

int ProcessNumber();

// The file of the running program, links followed; empty where the system does
// not tell.
std::string ProgramPath();

struct ProcessEnd {
  int not_started = 0;  // errno when there was no process
  int code = 0;         // what it returned
  int signal = 0;       // what ended it; 0: it ended by itself
  bool well() const { return not_started == 0 && code == 0 && signal == 0; }
};

// Runs a program by its path, in a folder, without input. What it prints is
// appended to one file there, its errors make another. It ends with this
// process.
ProcessEnd RunInFolder(std::vector<std::string> words,
                       const std::string& folder, const char* printed,
                       const char* errors);

// Runs a program by its name, with these for its standard streams. `setting` is
// NAME=value of its environment.
ProcessEnd RunWithStreams(std::vector<std::string> words, std::FILE* input,
                          std::FILE* output, std::FILE* errors,
                          const std::string& setting);

// A program that runs beside this one, found by its name, with these
// descriptors for its standard streams; it takes its input from nowhere where
// that is -1.
class RunningProgram {
 public:
  RunningProgram(std::vector<std::string> words, int input, int output,
                 int errors);
  ~RunningProgram();  // ends it
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // Until it has ended, or so long; then it is ended.
  ProcessEnd Wait(int most_ms);
  bool was_ended() const { return was_ended_; }

 private:
  int64_t process_ = 0;  // 0: it has ended, as `end_` says
  bool was_ended_ = false;
  ProcessEnd end_;
};

// The first line that a command of the shell prints; empty when it fails.
std::string FirstLineOf(const std::string& command);

// Memory that is given back stays with this process for what it asks for next,
// up to 64 MB: the kernel would clear each page again. Where the C library is
// not glibc, nothing.
void KeepFreedMemory();

// What the system says of itself, as lines "key: value" and "key=value"; files
// that need not be there.
inline constexpr const char* kProcessorFile = "/proc/cpuinfo";
inline constexpr const char* kSystemFile = "/etc/os-release";

// Processor time of this thread [ns]: what other programs do does not count.
int64_t ThreadCpuNs();

// From now on SIGINT, SIGTERM and SIGHUP wake `thread`, which runs beside the
// program; one that is ignored already stays so. A file that grows beyond the
// limit of the shell becomes an ordinary error of writing. Once a process.
void CatchSignals(const std::function<void()>& thread);

// For that thread: waits for the next signal; 0 when there can be none.
int NextSignal();
const char* SignalName(int number);
// Ends the program as the signal would have.
[[noreturn]] void EndBySignal(int number);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_PROCESS_H_
