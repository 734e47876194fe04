// Adapters: programs that print files of other formats as kinegraph's JSON
// Lines (docs/adapters.md). kinegraph's own are in kinegraph-adapters; a user's
// adapters are in a folder that kinegraph-adapters searches, or given by
// SetAdapter. Neither a recording nor a configuration can name a program to be
// started. For core/io only, except for the setters.
#ifndef KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
#define KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kinegraph {

// The user's program (--adapter), which is tried before all built-in formats;
// empty: none.
void SetAdapter(const std::string& program);
// Command of kinegraph-adapters. Default: kinegraph-adapters in the folder of
// this program, otherwise in PATH.
void SetOwnAdapters(const std::vector<std::string>& command);

enum class AdapterKind { kCameras, kDetections, kTracks };

struct Adapter {
  std::vector<std::string> command;  // the path is appended
  AdapterKind kind = AdapterKind::kDetections;
  std::string name;  // of the format, or of the program
  std::string hint;  // how to install it, if it may be missing
};

// The program of SetAdapter, if it recognises the path.
std::optional<Adapter> GivenAdapterOf(const std::string& path);
// Any adapter that recognises the path. A program is asked again only if the
// file or folder has changed. Throws InputError if the user's program cannot be
// started, a program does not answer, or kinegraph-adapters reports an error; a
// missing kinegraph-adapters recognises nothing.
std::optional<Adapter> AdapterOf(const std::string& path);
// The same, but only adapters of this kind.
std::optional<Adapter> GivenAdapterOf(const std::string& path,
                                      AdapterKind kind);
std::optional<Adapter> AdapterOf(const std::string& path, AdapterKind kind);
// The adapter of kinegraph-adapters for this format.
Adapter OwnAdapter(const std::string& format, AdapterKind kind);

// A running adapter that reads a path.
class AdapterRun {
 public:
  // `options` are flags such as "--joints=17". `silence_ms` is the longest wait
  // for output; -1: a minute, plus a second for each of the first 3600 MiB of
  // input. Throws InputError if the path does not exist. A program that cannot
  // be started is reported by Guard and Finish.
  AdapterRun(const Adapter& adapter, const std::string& path,
             const std::vector<std::string>& options = {}, int silence_ms = -1);
  ~AdapterRun();  // ends the program

  // File descriptor of the program's output, which the caller closes.
  int TakeOutput();
  int silence_ms() const;
  // Call this after all output was read. Throws InputError naming path and
  // cause if the program failed or does not end.
  void Finish();

  // Calls `read`. If it throws because the program failed midway, throws the
  // program's own error instead.
  template <typename Read>
  auto Guard(const Read& read) {
    try {
      return read();
    } catch (const std::exception&) {
      ThrowItsFault();
      throw;
    }
  }

 private:
  void ThrowItsFault();

  class Impl;
  std::unique_ptr<Impl> impl_;
};

// All output of an adapter. Throws InputError if it exceeds 64 MiB, or if the
// program is silent for too long, fails or does not end.
std::string OutputOf(const Adapter& adapter, const std::string& path);

// Converts to a format by kinegraph-adapters: `write` writes kinegraph's JSON
// Lines to the file whose name it receives. Returns the content of the
// converted file. `silence_ms` is the longest wait for output. Throws
// InputError naming `path` if the program cannot be started, is silent for too
// long, prints more than 4 GiB, fails or does not end.
std::string WriteByAdapter(
    const std::string& format, const std::string& path,
    const std::function<void(const std::string& lines)>& write,
    int silence_ms = 600'000);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
