#include "core/io/files/text_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <system_error>

#include "core/base/error.h"
#include "core/io/files/folder_entry.h"
#include "core/io/files/input_files.h"
#include "core/system/file.h"

namespace kinegraph {
namespace {

namespace fs = std::filesystem;

// The type of a path, with links followed. Throws InputError if the disk or the
// network fails, which does not mean that the file is absent.
fs::file_type TypeAt(const std::string& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  if (error.value() == EIO || error.value() == ESTALE) {
    throw InputError(path, "", "cannot be read: " + error.message());
  }
  return type;
}

bool BeginsWith(const std::string& text, const char* mark) {
  return text.compare(0, std::strlen(mark), mark) == 0;
}

}  // namespace

void FailToRead(const std::string& path) {
  if (errno == ENOMEM) throw std::bad_alloc();
  throw InputError(path, "",
                   std::string("cannot be read: ") + std::strerror(errno));
}

void MakePlainText(const std::string& path, std::string* text) {
  if (BeginsWith(*text, "\xff\xfe") || BeginsWith(*text, "\xfe\xff")) {
    throw InputError(path, "",
                     "is UTF-16 text, expected UTF-8 (`iconv -f UTF-16 -t "
                     "UTF-8 OLD > NEW` converts it)");
  }
  if (BeginsWith(*text, "\x1f\x8b")) {
    throw InputError(path, "", "is compressed; decompress it with `gunzip`");
  }
  if (BeginsWith(*text, "\xef\xbb\xbf")) text->erase(0, 3);
  if (text->find('\n') == std::string::npos &&
      text->find('\0') == std::string::npos) {
    std::replace(text->begin(), text->end(), '\r', '\n');
  }
}

std::string ReadTextFile(const std::string& path, size_t max_bytes) {
  std::string text = ReadBytes(path, max_bytes);
  MakePlainText(path, &text);
  return text;
}

std::string ReadBytes(const std::string& path, size_t max_bytes) {
  const Descriptor file(OpenToRead(path));
  if (file.get() < 0) FailToRead(path);
  const auto status = StatusOf(file.get());
  if (!status.has_value()) FailToRead(path);
  if (status->kind == FileType::kFolder) {
    throw InputError(path, "", "is a folder, expected a file");
  }
  const auto refuse = [&] {
    throw InputError(path, "",
                     "is larger than " + std::to_string(max_bytes >> 20) +
                         " MiB, the limit for such files");
  };
  if (status->size > 0 && static_cast<size_t>(status->size) > max_bytes) {
    refuse();
  }
  InputFiles::Note(file.get(), path);
  // The size is only a hint: pipes have none, and files grow. With the extra
  // bytes, the read that finds the end need not enlarge the buffer.
  constexpr size_t kMore = 1 << 12;
  std::string text(static_cast<size_t>(status->size) + kMore, '\0');
  size_t length = 0;
  while (true) {
    if (length == text.size()) text.resize(2 * length);
    const int64_t got =
        ReadSome(file.get(), text.data() + length, text.size() - length);
    if (got < 0) FailToRead(path);
    if (got == 0) break;
    length += static_cast<size_t>(got);
    if (length > max_bytes) refuse();
  }
  text.resize(length);
  return text;
}

void ForEachBlock(const std::string& path,
                  const std::function<void(std::string_view bytes)>& visit) {
  const Descriptor file(OpenToRead(path));
  if (file.get() < 0) FailToRead(path);
  std::string block(size_t{1} << 18, '\0');
  while (const int64_t got = ReadSome(file.get(), block.data(), block.size())) {
    if (got < 0) FailToRead(path);
    visit(std::string_view(block).substr(0, static_cast<size_t>(got)));
  }
}

std::string FirstBytes(const std::string& path, size_t bytes) {
  const Descriptor file(OpenToRead(path));
  if (file.get() < 0) FailToRead(path);
  std::string text(bytes, '\0');
  size_t length = 0;
  while (const int64_t got =
             ReadSome(file.get(), text.data() + length, bytes - length)) {
    if (got < 0) FailToRead(path);
    length += static_cast<size_t>(got);
  }
  text.resize(length);
  return text;
}

std::string BeginningOf(const std::string& path, size_t bytes) {
  std::string text;
  try {
    text = FirstBytes(path, bytes);
  } catch (const InputError&) {
    return text;
  }
  MakePlainText(path, &text);
  return text;
}

bool IsFolder(const std::string& path) {
  return TypeAt(path) == fs::file_type::directory;
}

bool IsFile(const std::string& path) {
  const fs::file_type type = TypeAt(path);
  return type != fs::file_type::none && type != fs::file_type::not_found &&
         type != fs::file_type::directory;
}

bool IsPipe(const std::string& path) {
  const auto status = StatusOf(path);
  return status.has_value() && status->kind != FileType::kRegular &&
         status->kind != FileType::kFolder;
}

std::string RelativeToFile(const std::string& path, const std::string& file) {
  std::error_code error;
  const fs::path folder = fs::absolute(fs::path(file), error).parent_path();
  const fs::path relative = fs::absolute(fs::path(path), error)
                                .lexically_normal()
                                .lexically_relative(folder.lexically_normal());
  return relative.empty() ? path : relative.generic_string();
}

void MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw InputError(path, "", "cannot be created: " + error.message());
}

void ForEachEntry(
    const std::string& folder,
    const std::function<void(const fs::directory_entry& entry)>& visit) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (IsFileOrFolder(*entry)) visit(*entry);
  }
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
  if (error) {
    throw InputError(folder, "", "cannot be listed: " + error.message());
  }
}

std::vector<std::string> ListFolder(const std::string& path) {
  std::vector<std::string> names;
  ForEachEntry(path, [&names](const fs::directory_entry& entry) {
    names.push_back(entry.path().filename().string());
  });
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace kinegraph
