// The checkpoint of a command and its --resume.
#ifndef KINEGRAPH_APPS_COMMON_RESUME_H_
#define KINEGRAPH_APPS_COMMON_RESUME_H_

#include <memory>
#include <string>

#include "core/io/configuration/checkpoint.h"

namespace kinegraph {

std::string CheckpointPath(const std::string& out);

// OUT.checkpoint beside the result `out`, from `quiet_s` seconds of work on.
// Where the result is a stream nothing is kept, and `resume` is refused. Throws
// InputError for a checkpoint that cannot be gone on from.
std::unique_ptr<Checkpoint> OpenCheckpoint(const std::string& out, bool resume,
                                           double quiet_s);

// The result is there: the checkpoint goes. Says on standard error what was
// taken from it, or why nothing could be kept.
void CloseCheckpoint(const std::string& command, Checkpoint* checkpoint);

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_RESUME_H_
