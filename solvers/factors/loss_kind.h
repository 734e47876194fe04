// The robust losses. Has no includes, because files compiled for wider
// instruction sets include it.
#ifndef KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
#define KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_

namespace kinegraph {

enum class LossKind { kNone, kHuber, kCauchy, kGemanMcClure, kTukey };

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
