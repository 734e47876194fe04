#include "core/system/memory.h"

#include <cstdlib>  // says whose C library this is

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace kinegraph {

void ReturnFreeMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace kinegraph
