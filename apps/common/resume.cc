#include "apps/common/resume.h"

#include <cstdio>

#include "apps/common/machine.h"
#include "apps/common/track_output.h"
#include "core/base/error.h"
#include "core/io/binary/npz_file.h"
#include "core/io/files/text_file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

// The program itself, and the processor whose instructions it chooses among.
std::string ThisBuild() {
  return std::to_string(Crc32(ReadTextFile(ProgramPath()))) + " " +
         ThisMachine().processor;
}

}  // namespace

std::string CheckpointPath(const std::string& out) {
  std::string path = out;
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path + ".checkpoint";
}

std::unique_ptr<Checkpoint> OpenCheckpoint(const std::string& out, bool resume,
                                           double quiet_s) {
  if (!(quiet_s >= 0.0)) {
    throw InputError("--checkpoint_s: expected at least 0 seconds");
  }
  if (IsStream(out)) {
    if (resume) {
      throw InputError("--resume: what was written to a stream is gone");
    }
    return std::make_unique<Checkpoint>();
  }
  return std::make_unique<Checkpoint>(CheckpointPath(out), ThisBuild(), resume,
                                      quiet_s);
}

void CloseCheckpoint(const std::string& command, Checkpoint* checkpoint) {
  const std::string trouble = checkpoint->trouble();
  if (!trouble.empty()) {
    std::fprintf(stderr, "kinegraph-%s: note: no checkpoint was kept: it %s\n",
                 command.c_str(), trouble.c_str());
  }
  if (checkpoint->found_count() > 0) {
    std::fprintf(stderr, "kinegraph-%s: %lld pieces of work were done before\n",
                 command.c_str(),
                 static_cast<long long>(checkpoint->found_count()));
  }
  checkpoint->Remove();
}

}  // namespace kinegraph
