// The end of a program that gets no more memory.
#ifndef KINEGRAPH_APPS_COMMON_OUT_OF_MEMORY_H_
#define KINEGRAPH_APPS_COMMON_OUT_OF_MEMORY_H_

#include <string>

namespace kinegraph {

// What the one line begins with.
void NameProgram(const std::string& program);

// Says so in one line, removes what is half-written and leaves with exit code
// 1; only the first thread that calls it does, others wait for the end. A
// program that links this ends so wherever an allocation fails. An exception
// would not do: destructors of libraries ask for memory (JSON's), and so do
// threads of libraries, which nobody catches for.
[[noreturn]] void EndOutOfMemory();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_OUT_OF_MEMORY_H_
