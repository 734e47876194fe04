// dense_lanes.h by instruction set, for its dispatch alone.
#ifndef KINEGRAPH_CORE_BASE_DENSE_LANES_WIDE_H_
#define KINEGRAPH_CORE_BASE_DENSE_LANES_WIDE_H_

#include "core/base/dense_lanes.h"

namespace kinegraph {

bool EliminateDenseAvx2(const DenseElimination& blocks);
bool EliminateDenseAvx512(const DenseElimination& blocks);

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_DENSE_LANES_WIDE_H_
