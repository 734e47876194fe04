#include "core/base/instruction_set.h"

#include <algorithm>
#include <atomic>

namespace kinegraph {
namespace {

InstructionSet Detect() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f")) return InstructionSet::kAvx512;
  if (__builtin_cpu_supports("avx2")) return InstructionSet::kAvx2;
#endif
  return InstructionSet::kBaseline;
}

std::atomic<InstructionSet>& Current() {
  static std::atomic<InstructionSet> current{BestInstructionSet()};
  return current;
}

}  // namespace

const char* ToString(InstructionSet set) {
  static constexpr const char* kNames[] = {"baseline", "AVX2", "AVX-512"};
  return kNames[static_cast<int>(set)];
}

InstructionSet BestInstructionSet() {
  static const InstructionSet best = Detect();
  return best;
}

InstructionSet CurrentInstructionSet() {
  return Current().load(std::memory_order_relaxed);
}

void UseInstructionSet(InstructionSet set) {
  Current() = std::min(set, BestInstructionSet());
}

}  // namespace kinegraph
