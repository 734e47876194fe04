// Signals that end a program, handed to a thread that may do everything.
#ifndef KINEGRAPH_CORE_SYSTEM_SIGNALS_H_
#define KINEGRAPH_CORE_SYSTEM_SIGNALS_H_

#include <functional>

namespace kinegraph {

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

#endif  // KINEGRAPH_CORE_SYSTEM_SIGNALS_H_
