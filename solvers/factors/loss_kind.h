// The robust losses. Sources for wider registers read it: it includes nothing.
#ifndef KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
#define KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_

namespace kinegraph {

enum class LossKind { kNone, kHuber, kCauchy, kGemanMcClure, kTukey };

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
