// Memory that this process holds.
#ifndef KINEGRAPH_CORE_SYSTEM_MEMORY_H_
#define KINEGRAPH_CORE_SYSTEM_MEMORY_H_

namespace kinegraph {

// Gives the system back what was freed but lies scattered among what is still
// used, where the C library can do that. Takes milliseconds: for the end of a
// stage that freed much.
void ReturnFreeMemory();

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_SYSTEM_MEMORY_H_
