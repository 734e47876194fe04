// Behaviour of a command on signals and when memory is exhausted.
#ifndef KINEGRAPH_APPS_COMMON_INTERRUPTION_H_
#define KINEGRAPH_APPS_COMMON_INTERRUPTION_H_

#include <string>

namespace kinegraph {

// From now on SIGINT, SIGTERM and SIGHUP remove partially written files
// (core/io/files/atomic_file.h), print one line on stderr, and end the program
// as the signal would have done: a shell sees 130, 143 or 129. Signals already
// ignored stay ignored (nohup, a job in the background). Exceeding the shell's
// file size limit (ulimit -f) becomes an ordinary write error.
void HandleInterruptions(const std::string& program);

// For endless streams: from now on the first such signal only ends the input
// (core/io/files/input_files.h), so that frames already read are finished and
// kept; the second ends the program as HandleInterruptions describes, which
// must be called before.
void EndInputOnInterruption();

// Sets the prefix of the line printed by EndOutOfMemory.
void NameProgram(const std::string& program);

// Prints one line and exits with code 1; partially written files remain,
// because removing them needs memory. Every program that links this file ends
// in this way if an allocation fails. An exception would not suffice:
// destructors of libraries (JSON's) allocate, and so do threads of libraries,
// which do not catch exceptions.
[[noreturn]] void EndOutOfMemory();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_INTERRUPTION_H_
