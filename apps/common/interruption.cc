#include "apps/common/interruption.h"

#include <atomic>
#include <mutex>

#include "core/io/files/atomic_file.h"
#include "core/io/files/input_files.h"
#include "core/system/file.h"
#include "core/system/process.h"
#include "core/system/streams.h"

namespace kinegraph {
namespace {

// Read by InputStop where a signal shall end the input first.
std::atomic<int> end_of_input[2] = {{-1}, {-1}};

void Say(const std::string& line) {
  // A terminal may show progress on this line.
  WriteAtOnce(kStandardError,
              (IsTerminal(kStandardError) ? "\r\033[K" : "") + line + "\n");
}

void WaitAndEnd(const std::string& program) {
  int number = NextSignal();
  if (number != 0 && end_of_input[1] >= 0) {
    Say(program + ": " + SignalName(number) +
        ": the input ends here; once more abandons the result");
    WriteAtOnce(end_of_input[1], std::string(1, '\0'));
    number = NextSignal();
  }
  if (number == 0) return;
  RemovePartialFilesForGood();
  Say(program + ": stopped by " + SignalName(number) +
      "; what was half-written is removed");
  EndBySignal(number);
}

}  // namespace

void HandleInterruptions(const std::string& program) {
  static std::once_flag once;
  std::call_once(
      once, [&program] { CatchSignals([program] { WaitAndEnd(program); }); });
}

void EndInputOnInterruption() {
  int ends[2];
  if (!MakePipe(ends)) return;  // then the first signal abandons
  InputStop::ListenTo(ends[0]);
  end_of_input[0] = ends[0];
  end_of_input[1] = ends[1];
}

}  // namespace kinegraph
