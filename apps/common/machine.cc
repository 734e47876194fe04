#include "apps/common/machine.h"

#include <thread>

#include "apps/common/app.h"
#include "apps/common/config_folder.h"
#include "core/base/error.h"
#include "core/io/files/text_file.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

constexpr const char* kUnknown = "unknown";

// The text after `separator` in the first line that begins with `key`, without
// surrounding blanks and quotes; kUnknown if there is none.
std::string Field(const std::string& path, const std::string& key,
                  char separator) {
  if (!IsFile(path)) return kUnknown;
  const std::string text = "\n" + ReadTextFile(path);
  const size_t line = text.find("\n" + key);
  if (line == std::string::npos) return kUnknown;
  size_t begin = text.find(separator, line + 1);
  const size_t end = text.find('\n', line + 1);
  if (begin == std::string::npos || begin > end) return kUnknown;
  begin = text.find_first_not_of(" \t\"", begin + 1);
  if (begin == std::string::npos || begin > end) return kUnknown;
  std::string value = text.substr(begin, end - begin);
  value.erase(value.find_last_not_of(" \t\"") + 1);
  return value;
}

std::string Commit() {
  try {
    const std::string config = ProjectConfig("paper/shelf.toml");
    return CommitOf(config.substr(0, config.rfind("/paper/")));
  } catch (const InputError&) {
    return kUnknown;
  }
}

}  // namespace

std::string CommitOf(const std::string& configs) {
  const std::string git = "git -C " + ShellQuoted(configs);
  // An installation may be inside a repository of the user.
  const bool is_own =
      FirstLineOf(git + " rev-parse --show-prefix 2>/dev/null") == "configs/";
  const std::string commit =
      is_own ? FirstLineOf(git +
                           " describe --always --dirty --exclude='*' "
                           "2>/dev/null")
             : "";
  return commit.empty() ? kUnknown : commit;
}

Machine ThisMachine() {
  Machine machine;
  machine.processor = Field(kProcessorFile, "model name", ':');
  machine.threads = static_cast<int>(std::thread::hardware_concurrency());
  machine.system = Field(kSystemFile, "PRETTY_NAME", '=');
#if defined(__clang__)
  machine.compiler = "clang " __clang_version__;
#elif defined(__GNUC__)
  machine.compiler = "g++ " __VERSION__;
#else
  machine.compiler = kUnknown;
#endif
  machine.commit = Commit();
  return machine;
}

}  // namespace kinegraph
