// Selects one of the instruction sets for which kernels are compiled.
#ifndef KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_
#define KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_

namespace kinegraph {

// In ascending order of lanes. The baseline runs everywhere.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };
const char* ToString(InstructionSet set);

// The widest set supported by both the machine and the build.
InstructionSet BestInstructionSet();

// The set that kernels use: the best one, unless overridden. Results are
// bit-identical for every set (core/base/pack.h).
InstructionSet CurrentInstructionSet();

// For tests and benchmarks: uses `set`, or the best one where the machine does
// not support it. Must not be called while another thread computes.
void UseInstructionSet(InstructionSet set);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_
