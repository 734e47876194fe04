// Ending a stream of input that has no end of its own.
#ifndef KINEGRAPH_CORE_IO_FILES_INPUT_STOP_H_
#define KINEGRAPH_CORE_IO_FILES_INPUT_STOP_H_

namespace kinegraph {

class InputStop {
 public:
  // Input counts as ended once there is anything to read from `descriptor`,
  // which somebody else (a handler of signals) writes to. At most one a
  // process; -1 takes it back.
  static void ListenTo(int descriptor);

  // Waits until `descriptor` has something to read or is at its end; false
  // when the input is to count as ended. True at once where nobody listens.
  static bool WaitForInput(int descriptor);

  // Whether the input counts as ended; what stands before it may be cut short.
  static bool HasHappened();
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_FILES_INPUT_STOP_H_
