// --adapter: the user's own program that reads an unsupported format.
#ifndef KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
#define KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_

namespace kinegraph {

// Applies --adapter; call before reading input. Commands that call this offer
// the flag. Throws InputError if the flag is set but does not name a file.
void UseAdapterFlag();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
