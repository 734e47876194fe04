// Entries of a folder.
#ifndef KINEGRAPH_CORE_IO_FILES_FOLDER_ENTRY_H_
#define KINEGRAPH_CORE_IO_FILES_FOLDER_ENTRY_H_

#include <filesystem>
#include <functional>
#include <string>
#include <system_error>

namespace kinegraph {

// Whether an entry of a folder may contain data. False for pipes, sockets and
// devices, because reading one could block forever; they are only read when
// they are named explicitly.
inline bool IsFileOrFolder(const std::filesystem::directory_entry& entry) {
  using Type = std::filesystem::file_type;
  std::error_code ignored;
  const Type type = entry.status(ignored).type();
  return type != Type::fifo && type != Type::socket && type != Type::block &&
         type != Type::character;
}

// Calls `visit` for each entry of a folder for which IsFileOrFolder is true, in
// any order. Throws InputError naming the folder if it cannot be listed.
void ForEachEntry(
    const std::string& folder,
    const std::function<void(const std::filesystem::directory_entry& entry)>&
        visit);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_FOLDER_ENTRY_H_
