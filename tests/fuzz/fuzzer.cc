// The entry points of libFuzzer. KINEGRAPH_FUZZ_TARGET names the target ("list"
// prints all targets), KINEGRAPH_FUZZ_SEEDS a folder to which the target's
// seeds are written.
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "tests/fuzz/targets.h"

namespace {

const kinegraph::testing::FuzzTarget& Target() {
  static const kinegraph::testing::FuzzTarget& target = []() -> const auto& {
    const char* name = std::getenv("KINEGRAPH_FUZZ_TARGET");
    return kinegraph::testing::FindFuzzTarget(name == nullptr ? "" : name);
  }
  ();
  return target;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name = std::getenv("KINEGRAPH_FUZZ_TARGET");
  if (name != nullptr && std::string(name) == "list") {
    for (const auto& target : kinegraph::testing::FuzzTargets()) {
      std::puts(target.name.c_str());
    }
    std::exit(0);
  }
  const char* folder = std::getenv("KINEGRAPH_FUZZ_SEEDS");
  if (folder == nullptr) return 0;
  int number = 0;
  for (const std::string& seed : kinegraph::testing::FuzzSeeds(Target().name)) {
    std::ofstream file(std::string(folder) + "/seed" + std::to_string(number++),
                       std::ios::binary);
    file << seed;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  Target().run({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
