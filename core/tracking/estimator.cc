#include "core/tracking/estimator.h"

namespace kinegraph {
namespace {

std::optional<double> WeightOf(FilterVerdict verdict) {
  if (verdict == FilterVerdict::kUnmeasured) return std::nullopt;
  return verdict == FilterVerdict::kKept ? 1.0 : 0.0;
}

}  // namespace

void DescribeViews(const EstimatorFrame& frame, bool matches,
                   PersonPose* person) {
  person->inlier_views = frame.inlier_views;
  if (!matches) return;
  double confidence_sum = 0.0;
  int measured = 0;
  for (const FreshView& view : frame.views) {
    ViewMatch match;
    match.view_idx = view.view_idx;
    match.detection_idx = view.detection_idx;
    match.weights.reserve(view.verdicts.size());
    for (size_t j = 0; j < view.verdicts.size(); ++j) {
      match.weights.push_back(WeightOf(view.verdicts[j]));
      if (!match.weights.back().has_value()) continue;
      confidence_sum += view.joints[j].confidence;
      ++measured;
    }
    person->matches.push_back(std::move(match));
  }
  if (measured > 0) person->score = confidence_sum / measured;
}

}  // namespace kinegraph
