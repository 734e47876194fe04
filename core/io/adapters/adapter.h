// Programs that print files of other programs' formats as our own JSON Lines
// (docs/adapters.md). kinegraph-adapters has ours; the user's own are in a
// folder of which it knows, or named by SetAdapter. What a recording or a
// configuration says never starts one. For core/io alone, but for the setters.
#ifndef KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
#define KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kinegraph {

// The user's own program, which is asked before any format of ours (--adapter);
// empty: there is none.
void SetAdapter(const std::string& program);
// How kinegraph-adapters is started. Without it the one beside this program is
// taken, else the one in PATH.
void SetOwnAdapters(const std::vector<std::string>& command);

enum class AdapterKind { kCameras, kDetections, kTracks };

struct Adapter {
  std::vector<std::string> command;  // which the path follows
  AdapterKind kind = AdapterKind::kDetections;
  std::string name;  // of its format, or the program
  std::string hint;  // how it is got, where it may not be there
};

// The program of SetAdapter, where it recognises the path.
std::optional<Adapter> GivenAdapterOf(const std::string& path);
// Any adapter that recognises the path. Asked once for a path as it is. Throws
// InputError where a program cannot be started.
std::optional<Adapter> AdapterOf(const std::string& path);
// The same where it is of that kind.
std::optional<Adapter> GivenAdapterOf(const std::string& path,
                                      AdapterKind kind);
std::optional<Adapter> AdapterOf(const std::string& path, AdapterKind kind);
// One of kinegraph-adapters, whatever the path looks like.
Adapter OwnAdapter(const std::string& format, AdapterKind kind);

// An adapter that reads a path.
class AdapterRun {
 public:
  // `options` are flags such as "--joints=17". Without `silence_ms` it is a
  // minute, and a second a megabyte. Throws InputError where it cannot start.
  AdapterRun(const Adapter& adapter, const std::string& path,
             const std::vector<std::string>& options = {}, int silence_ms = -1);
  ~AdapterRun();  // ends it

  // What it prints; whoever takes it closes it.
  int TakeOutput();
  int silence_ms() const;
  // To be called when all was read. Throws InputError naming path and cause
  // when the program failed.
  void Finish();

  // Calls `read`. Where it throws because the program failed half-way, what the
  // program says of that is thrown instead.
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

// Writes a format by kinegraph-adapters: `write` puts our lines into a file of
// the name that it is given, and the bytes of the format come back. Throws as
// AdapterRun does, naming `path`.
std::string WriteByAdapter(
    const std::string& format, const std::string& path,
    const std::function<void(const std::string& lines)>& write);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_ADAPTERS_ADAPTER_H_
