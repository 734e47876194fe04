#include "core/association/view_matching.h"

#include <algorithm>

#include "core/data/box.h"

namespace kinegraph {

void ViewMatcher::Match(const std::vector<AssociationTarget>& targets,
                        Span<Observation> observations, const Camera& camera,
                        const std::vector<char>& barred,
                        std::vector<int>* match) {
  const size_t cols = observations.size();
  affinities_.resize(targets.size() * cols);
  boxes_.clear();
  for (const Observation& observation : observations) {
    boxes_.push_back(BoxAround(observation.joints));
  }
  for (size_t row = 0; row < targets.size(); ++row) {
    if (cols == 0) break;
    measure_->SetTarget(targets[row], camera);
    for (size_t col = 0; col < cols; ++col) {
      // A pair that may not match must not influence the assignment either, so
      // a negative affinity counts as zero.
      const size_t pair = row * cols + col;
      const bool may =
          (barred.empty() || !barred[pair]) && measure_->MayMatch(boxes_[col]);
      affinities_[pair] =
          may ? std::max(0.0, measure_->Of(observations[col])) : 0.0;
    }
  }
  solver_.MaximisePositive(affinities_, static_cast<int>(targets.size()),
                           static_cast<int>(cols), match);
}

}  // namespace kinegraph
