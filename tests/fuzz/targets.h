// What is fuzzed: one function a reader, and one that makes scenes. Each takes
// any bytes and comes back; what a reader refuses, it refuses with InputError
// or OptionError. Anything else ends the program, which the fuzzer notices.
#ifndef KINEGRAPH_TESTS_FUZZ_TARGETS_H_
#define KINEGRAPH_TESTS_FUZZ_TARGETS_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kinegraph::testing {

struct FuzzTarget {
  const char* name;
  void (*run)(const uint8_t* bytes, size_t size);
};

const std::vector<FuzzTarget>& FuzzTargets();

// Throws std::out_of_range for an unknown name.
const FuzzTarget& FindFuzzTarget(const std::string& name);

}  // namespace kinegraph::testing

#endif  // KINEGRAPH_TESTS_FUZZ_TARGETS_H_
