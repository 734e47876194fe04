// What a command does when it is told to stop.
#ifndef KINEGRAPH_APPS_COMMON_INTERRUPTION_H_
#define KINEGRAPH_APPS_COMMON_INTERRUPTION_H_

#include <string>

namespace kinegraph {

// From now on SIGINT, SIGTERM and SIGHUP remove what is half-written
// (core/io/files/atomic_file.h), say one line on stderr, and end the program
// as the signal would have: a shell sees 130, 143 or 129. A signal that is
// ignored already stays so (nohup, a job in the background). A file that grows
// beyond the limit of the shell (ulimit -f) becomes an ordinary error of
// writing.
void HandleInterruptions(const std::string& program);

// For a stream without an end: from now on the first such signal only ends the
// input (core/io/files/input_files.h), so that what was read is finished and
// kept; the second does as above. After HandleInterruptions.
void EndInputOnInterruption();

// What the one line begins with.
void NameProgram(const std::string& program);

// Says so in one line and leaves with exit code 1; what is half-written stays
// aside, for removing it needs memory. A program that links this ends so
// wherever an allocation fails. An exception would not do: destructors of
// libraries allocate (JSON's), and so do threads of libraries, which catch
// nothing.
[[noreturn]] void EndOutOfMemory();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_INTERRUPTION_H_
