#include "tests/fuzz/targets.h"

#include <stdexcept>

namespace kinegraph::testing {

const std::vector<FuzzTarget>& FuzzTargets() {
  static const std::vector<FuzzTarget> kTargets = [] {
    std::vector<FuzzTarget> targets = ReaderTargets();
#ifndef KINEGRAPH_FUZZ_READERS_ONLY
    for (FuzzTarget& target : RunTargets()) {
      targets.push_back(std::move(target));
    }
#endif
    return targets;
  }();
  return kTargets;
}

const FuzzTarget& FindFuzzTarget(const std::string& name) {
  for (const FuzzTarget& target : FuzzTargets()) {
    if (name == target.name) return target;
  }
  throw std::out_of_range("no fuzz target '" + name + "'");
}

}  // namespace kinegraph::testing
