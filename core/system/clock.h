// Clocks of the operating system.
#ifndef KINEGRAPH_CORE_SYSTEM_CLOCK_H_
#define KINEGRAPH_CORE_SYSTEM_CLOCK_H_

#include <cstdint>

namespace kinegraph {

// Processor time of this thread [ns]: what other programs do does not count.
int64_t ThreadCpuNs();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_CLOCK_H_
