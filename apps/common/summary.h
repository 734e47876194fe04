// Where a command prints what it has done.
#ifndef KINEGRAPH_APPS_COMMON_SUMMARY_H_
#define KINEGRAPH_APPS_COMMON_SUMMARY_H_

#include <cstdio>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/files/atomic_file.h"

namespace kinegraph {

// Standard output, or standard error when the result `out` itself goes to
// standard output (--out=/dev/stdout).
inline std::FILE* SummaryStream(const std::string& out) {
  return IsStandardOutput(out) ? stderr : stdout;
}

// What does not keep a command from its work, on standard error.
inline void SayNotes(const std::vector<std::string>& notes) {
  for (const std::string& note : notes) {
    std::fprintf(stderr, "note: %s\n", Printable(note, 500).c_str());
  }
}

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_SUMMARY_H_
