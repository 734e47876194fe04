// --adapter: the user's own program that reads an unsupported format.
#ifndef KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
#define KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_

namespace kinegraph {

// Applies the flag, which every command that calls this has; call before
// reading input. Throws InputError if the program does not exist.
void UseAdapterFlag();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
