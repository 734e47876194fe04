// Programs that print files of other formats as our own JSON Lines
// (docs/adapters.md). Ours are in kinegraph-adapters; the user's are in a
// folder known to it, or given by SetAdapter. Neither a recording nor a
// configuration can start one. For core/io only, except for the setters.
#ifndef KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
#define KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kinegraph {

// The user's program, which is tried before any format of ours (--adapter);
// empty: none.
void SetAdapter(const std::string& program);
// Command of kinegraph-adapters. Default: the one beside this program, else the
// one in PATH.
void SetOwnAdapters(const std::vector<std::string>& command);

enum class AdapterKind { kCameras, kDetections, kTracks };

struct Adapter {
  std::vector<std::string> command;  // the path is appended
  AdapterKind kind = AdapterKind::kDetections;
  std::string name;  // of its format, or of the program
  std::string hint;  // how to install it, if it may be missing
};

// The program of SetAdapter, if it recognises the path.
std::optional<Adapter> GivenAdapterOf(const std::string& path);
// Any adapter that recognises the path. Programs are asked once per state of
// the path. Throws InputError if a program cannot be started.
std::optional<Adapter> AdapterOf(const std::string& path);
// The same, for adapters of this kind only.
std::optional<Adapter> GivenAdapterOf(const std::string& path,
                                      AdapterKind kind);
std::optional<Adapter> AdapterOf(const std::string& path, AdapterKind kind);
// One of kinegraph-adapters, regardless of the path.
Adapter OwnAdapter(const std::string& format, AdapterKind kind);

// A running adapter that reads a path.
class AdapterRun {
 public:
  // `options` are flags such as "--joints=17". `silence_ms` is the longest wait
  // for output, by default a minute and a second per megabyte. Throws
  // InputError if the program cannot be started.
  AdapterRun(const Adapter& adapter, const std::string& path,
             const std::vector<std::string>& options = {}, int silence_ms = -1);
  ~AdapterRun();  // ends the program

  // Its standard output, to be closed by the caller.
  int TakeOutput();
  int silence_ms() const;
  // Call after all was read. Throws InputError naming path and cause if the
  // program failed.
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

// All that it prints.
std::string OutputOf(const Adapter& adapter, const std::string& path);

// Writes a format by kinegraph-adapters: `write` writes our lines to the file
// name it is given. Returns the bytes of the format. Throws as AdapterRun does,
// naming `path`.
std::string WriteByAdapter(
    const std::string& format, const std::string& path,
    const std::function<void(const std::string& lines)>& write);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
