// Whole files, with errors a user can act on.
#ifndef KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace kinegraph {

// The file's bytes. Throws InputError naming the file when it is missing, a
// folder, may not be read, or is larger than `max_bytes`.
std::string ReadBytes(const std::string& path,
                      size_t max_bytes = std::numeric_limits<size_t>::max());
// The same as plain text.
std::string ReadTextFile(const std::string& path,
                         size_t max_bytes = std::numeric_limits<size_t>::max());

// What spreadsheets and editors put around a text goes: UTF-8's byte order mark
// is cut, and lines that end as on old Macs, by a carriage return alone, end by
// a newline. Lines that end by both keep both. Throws InputError naming the
// file when it is UTF-16 or compressed.
void MakePlainText(const std::string& path, std::string* text);

// At most the first `bytes`, as plain text; empty when it cannot be read.
std::string BeginningOf(const std::string& path, size_t bytes);

// Whether the path leads to a folder, or to anything but one; false for what is
// not there or out of reach. Throws InputError when the disk does not answer.
bool IsFolder(const std::string& path);
bool IsFile(const std::string& path);

// A pipe cannot be looked into and then read: there only our own formats, which
// are read in one go, are expected.
bool IsPipe(const std::string& path);

// `path` as seen from the folder of `file`, as a link in that file names it.
std::string RelativeToFile(const std::string& path, const std::string& file);

// Makes a folder and those above it. Throws InputError naming it when it cannot
// be made.
void MakeFolder(const std::string& path);

// Names of the files and folders in a folder, sorted as text. Throws InputError
// naming the folder when it cannot be listed.
std::vector<std::string> ListFolder(const std::string& path);

// Far more than any calibration or configuration has.
inline constexpr size_t kMaxSmallFileBytes = size_t{64} << 20;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_
