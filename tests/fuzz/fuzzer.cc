// The entry point of libFuzzer; one program a target (KINEGRAPH_FUZZ_TARGET).
#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const kinegraph::testing::FuzzTarget& target =
      kinegraph::testing::FindFuzzTarget(KINEGRAPH_FUZZ_TARGET);
  target.run(bytes, size);
  return 0;
}
