#include "apps/common/gnuplot.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "core/base/error.h"
#include "core/system/process.h"

namespace kinegraph {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

// A file without a name.
File TemporaryFile() {
  File file(std::tmpfile());
  if (file == nullptr) {
    throw std::runtime_error("no temporary file for a plot: " +
                             std::string(std::strerror(errno)));
  }
  return file;
}

std::string ContentOf(const File& file) {
  std::rewind(file.get());
  std::string content;
  char buffer[1 << 14];
  size_t size;
  while ((size = std::fread(buffer, 1, sizeof(buffer), file.get())) > 0) {
    content.append(buffer, size);
  }
  return content;
}

}  // namespace

std::string RunGnuplot(const std::string& script) {
  const File input = TemporaryFile();
  const File output = TemporaryFile();
  const File errors = TemporaryFile();
  std::fwrite(script.data(), 1, script.size(), input.get());
  std::fflush(input.get());
  std::rewind(input.get());

  // No start-up files; decimals as C writes them.
  const ProcessEnd end =
      RunWithStreams({"gnuplot", "-d", "-"}, input.get(), output.get(),
                     errors.get(), "LC_ALL=C.UTF-8");
  if (end.not_started != 0) {
    throw std::runtime_error(
        "plots need gnuplot (Debian: gnuplot-nox), which cannot be started: " +
        std::string(std::strerror(end.not_started)));
  }
  const std::string complaints = ContentOf(errors);
  if (!end.well()) {
    throw std::runtime_error("gnuplot failed: " + Printable(complaints, 300));
  }
  return ContentOf(output);
}

}  // namespace kinegraph
