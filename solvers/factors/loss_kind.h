// The robust losses by name.
#ifndef KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
#define KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_

#include <string>
#include <vector>

namespace kinegraph {

enum class LossKind { kNone, kHuber, kCauchy, kGemanMcClure, kTukey };

// Names in the order of the enum.
const std::vector<std::string>& LossNames();

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_FACTORS_LOSS_KIND_H_
