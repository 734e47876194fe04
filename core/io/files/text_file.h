// Reads files, examines paths, and creates and lists folders.
#ifndef KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_
#define KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_

#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace kinegraph {

// Throws InputError naming the file and the error in errno, or bad_alloc for
// ENOMEM.
[[noreturn]] void FailToRead(const std::string& path);

// The file's bytes. Throws InputError naming the file if it is missing, a
// folder, unreadable, or larger than `max_bytes`.
std::string ReadBytes(const std::string& path,
                      size_t max_bytes = std::numeric_limits<size_t>::max());
// The same, as plain text (MakePlainText).
std::string ReadTextFile(const std::string& path,
                         size_t max_bytes = std::numeric_limits<size_t>::max());

// Normalises text from spreadsheets and editors: removes UTF-8's byte order
// mark and, in a text with neither newlines nor zero bytes, converts carriage
// returns (old Mac line ends) to newlines. Throws InputError naming the file if
// it is UTF-16 or compressed by gzip.
void MakePlainText(const std::string& path, std::string* text);

// Calls `visit` with each block of a file's bytes. Throws InputError naming the
// file if it cannot be read.
void ForEachBlock(const std::string& path,
                  const std::function<void(std::string_view bytes)>& visit);

// At most the first `bytes` of a file. Throws InputError naming the file if it
// cannot be read.
std::string FirstBytes(const std::string& path, size_t bytes);

// At most the first `bytes` of a file, as plain text; empty if it cannot be
// read. Throws what MakePlainText throws.
std::string BeginningOf(const std::string& path, size_t bytes);

// Whether the path, with links followed, is a folder (IsFolder) or anything
// else, such as a pipe (IsFile); false if it does not exist or is inaccessible.
// Throws InputError if the disk or the network fails.
bool IsFolder(const std::string& path);
bool IsFile(const std::string& path);

// Whether the path is a pipe or device, whose content cannot be examined before
// it is read: unless a format is named, kinegraph's own is assumed.
bool IsPipe(const std::string& path);

// `path` relative to the folder of `file`, for a link in that file; `path`
// itself if there is no relative path.
std::string RelativeToFile(const std::string& path, const std::string& file);

// Creates a folder and its parents. Throws InputError naming it on failure.
void MakeFolder(const std::string& path);

// Names of the files and folders in a folder, sorted as text. Throws InputError
// naming the folder if it cannot be listed.
std::vector<std::string> ListFolder(const std::string& path);

// Returns read(). Adds `file` and place(), such as "line 3", to the message of
// its InputError; `place` is called only then.
template <typename Place, typename Read>
auto Located(const std::string& file, const Place& place, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(file, place(), error.what());
  }
}

template <typename Read>
auto Located(const std::string& file, const Read& read) {
  return Located(
      file, [] { return ""; }, read);
}

// Returns read(&text) for the content of a file as a Text (CsvRows, Words).
// Errors name the file and text.Place(), its current line.
template <typename Text, typename Read>
auto ReadText(const std::string& path, const Read& read) {
  const std::string content = ReadTextFile(path);
  Text text(content);
  return Located(
      path, [&] { return text.Place(); }, [&] { return read(&text); });
}

// A limit far larger than any calibration or configuration.
inline constexpr size_t kMaxSmallFileBytes = size_t{64} << 20;

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_TEXT_FILE_H_
