// Which of the instruction sets that kernels are compiled for is used.
#ifndef KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_
#define KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_

namespace kinegraph {

// In ascending order of lanes. The baseline runs everywhere.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };
const char* ToString(InstructionSet set);

// The widest set that this machine has and that the build contains.
InstructionSet BestInstructionSet();

// The set that kernels use: the best one, unless another was asked for.
// Results are the same bits with every set (core/base/pack.h).
InstructionSet CurrentInstructionSet();

// For tests and benchmarks: uses `set`, or the best one where the machine does
// not have it. Not while another thread computes.
void UseInstructionSet(InstructionSet set);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_INSTRUCTION_SET_H_
