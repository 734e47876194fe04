// --adapter: the user's own reader of a format that is not ours.
#ifndef KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
#define KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_

namespace kinegraph {

// Takes the flag, which every command has that calls this, before anything is
// read. Throws InputError when there is no such program.
void UseAdapterFlag();

}  // namespace kinegraph

#endif  // KINEGRAPH_APPS_COMMON_ADAPTER_FLAG_H_
