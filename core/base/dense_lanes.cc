#include "core/base/dense_lanes.h"

#include "core/base/dense_kernel.h"
#include "core/base/instruction_set.h"

namespace kinegraph {

bool EliminateDense(const DenseElimination& blocks) {
  switch (CurrentInstructionSet()) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return EliminateDenseAvx512(blocks);
    case InstructionSet::kAvx2:
      return EliminateDenseAvx2(blocks);
#endif
    default:
      return EliminateDenseWith<BaselinePack>(blocks);
  }
}

}  // namespace kinegraph
