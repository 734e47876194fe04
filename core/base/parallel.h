// Independent pieces of work on several threads.
#ifndef KINEGRAPH_CORE_BASE_PARALLEL_H_
#define KINEGRAPH_CORE_BASE_PARALLEL_H_

#include <functional>

namespace kinegraph {

// Calls work(0) .. work(count - 1), each once, on up to `threads` threads. The
// pieces must not touch each other's data, so the result does not depend on the
// number of threads. Rethrows the exception of the piece with the lowest index
// that threw; with several threads, after all pieces have ended. The caller's
// stop check (stop_check.h) runs before each piece and while the caller waits
// for other threads; an exception that it throws during that wait is rethrown
// instead of those of the pieces.
void ParallelFor(int threads, int count, const std::function<void(int)>& work);

// The `threads` of the call whose piece this thread works on, to be passed to
// nested calls; 1 outside of any call.
int AllowedThreads();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_PARALLEL_H_
