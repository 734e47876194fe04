// Bringing what was written to the disk. For core/io alone.
#ifndef KINEGRAPH_CORE_IO_FILES_SYNC_H_
#define KINEGRAPH_CORE_IO_FILES_SYNC_H_

#include <string>

namespace kinegraph {

// An open file's bytes. -1 and errno when they were lost; a file system that
// knows no such request counts as done.
int SyncFile(int descriptor);

// Everything below a folder: its whole file system. As above.
int SyncTree(const std::string& folder);

// The entry of a name in its folder. Best effort: the name is there already.
void SyncFolderOf(const std::string& path);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_SYNC_H_
