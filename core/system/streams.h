// Standard streams, pipes and the terminal.
#ifndef KINEGRAPH_CORE_SYSTEM_STREAMS_H_
#define KINEGRAPH_CORE_SYSTEM_STREAMS_H_

#include <string>

namespace kinegraph {

bool IsTerminal(int descriptor);

// Once, at the beginning. A standard stream that was closed by the caller would
// give its number to the next file opened, and messages would end inside a
// result: such streams become ones that fail. A reader that leaves a pipe does
// not end the program half way through a file.
void PrepareStandardStreams();

// Whether whoever read the other end of a pipe is gone.
bool ReaderIsGone(int descriptor);

// Waits until one of them has something to read or is at its end; false when it
// is `stop`.
bool WaitForInput(int descriptor, int stop);
bool HasInput(int descriptor);

// Both ends, the one to read first; false when the system refuses.
bool MakePipe(int ends[2]);
// Without waiting for anybody; what cannot be written is lost.
void WriteAtOnce(int descriptor, const std::string& text);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_STREAMS_H_
