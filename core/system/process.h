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

// Does work in a process of its own, of which nothing stays but how it ended:
// for libraries that damaged input brings down. Exceptions end it well, for
// they come again where the work is done in earnest. More than `limit_s` of
// processor time ends it by a signal.
ProcessEnd Rehearse(const std::function<void()>& work, int limit_s);

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
