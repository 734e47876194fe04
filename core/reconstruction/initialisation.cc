#include "core/reconstruction/initialisation.h"

#include <algorithm>
#include <utility>

namespace kinegraph {

double GroupingRule::Gain(const ObservationGroup& group,
                          const Observation& detection) const {
  if (options_.rule == InitialisationRule::kAffinitySum) {
    return AffinitySum(group, detection);
  }
  double total = 0.0;
  for (const Observation* member : group) total += Cost(*member, detection);
  return -total / static_cast<double>(group.size());
}

bool GroupingRule::Accept(const ObservationGroup& group,
                          const Observation& detection) const {
  if (options_.rule == InitialisationRule::kAffinitySum ||
      !(detection.mean_confidence > options_.veto_confidence)) {
    return true;
  }
  return std::none_of(group.begin(), group.end(), [&](const auto* member) {
    return Cost(*member, detection) > 1.0;
  });
}

double GroupingRule::AffinitySum(const ObservationGroup& group,
                                 const Observation& detection) const {
  if (detection.found_count < min_common_) return 0.0;
  double total = 0.0;
  int views = 0;
  for (const Observation* member : group) {
    if (member->found_count < min_common_) continue;
    double sum = 0.0;
    int common = 0;
    auto left = static_cast<double>(joints_.size());
    for (const int j : joints_) {
      // Ends early when the sum cannot become positive any more.
      if (group.size() == 1 && sum + left < 0.0) return 0.0;
      left -= 1.0;
      if (!member->joints[j].found || !detection.joints[j].found) continue;
      ++common;
      sum +=
          1.0 - epipolar_->Distance(member->view_idx, member->ideal_px[j],
                                    detection.view_idx, detection.ideal_px[j]) /
                    options_.alpha_group_px;
    }
    if (common == 0 || common < min_common_) continue;
    total += sum;
    ++views;
  }
  // A pair that cannot be joined must not influence the assignment.
  return views == 0 ? 0.0 : std::max(0.0, total / views);
}

double GroupingRule::Cost(const Observation& a, const Observation& b) const {
  // Two poses without a common joint cost more than any conflict.
  constexpr double kNothingInCommon = 1e6;
  double sum = 0.0;
  int common = 0;
  for (const int j : joints_) {
    if (!a.joints[j].found || !b.joints[j].found) continue;
    ++common;
    sum += epipolar_->WeightedDistance(a.view_idx, a.ideal_px[j],
                                       a.joints[j].confidence, b.view_idx,
                                       b.ideal_px[j], b.joints[j].confidence);
  }
  return common == 0 ? kNothingInCommon
                     : sum / common / options_.alpha_group_px;
}

void InitialisationOptions::Describe(OptionVisitor& visitor) {
  visitor.Choice("rule", &rule, {"affinity_sum", "weighted_distance"},
                 "the paper's text or the authors' code");
  visitor.Number("alpha_group", &alpha_group_px, Positive(), "px",
                 "epipolar distance scale when views are grouped");
  visitor.Number("alpha_filter", &alpha_filter_px, Positive(), "px",
                 "alpha_epi of the joints filter at initialisation");
  visitor.Number("min_confidence", &min_confidence, Between(-1.0, 1e6), "",
                 "mean confidence that a detection must exceed");
  visitor.Number("min_common_joints", &min_common_joints, Between(0.0, 17.0),
                 "joints of 17", "affinity_sum: joints a pair must share");
  visitor.Number("min_joints", &min_joints, Between(0.0, 17.0), "joints of 17",
                 "triangulated joints that a new person must have");
}

Initialiser::Initialiser(const InitialisationOptions& options,
                         const EpipolarGeometry& epipolar,
                         Reconstructor* reconstructor, std::vector<int> joints)
    : options_(options),
      reconstructor_(reconstructor),
      joints_(joints),
      rule_(options, epipolar, std::move(joints)) {}

// Algorithm 2 for one view: its detections join the groups of the previous
// views by the assignment of the largest total gain, or start new groups.
void Initialiser::AssignView(const ObservationGroup& detections) {
  const size_t cols = detections.size();
  gains_.resize(groups_.size() * cols);
  for (size_t g = 0; g < groups_.size(); ++g) {
    for (size_t d = 0; d < cols; ++d) {
      gains_[g * cols + d] = rule_.Gain(groups_[g], *detections[d]);
    }
  }
  const size_t group_count = groups_.size();
  const auto assign = options_.rule == InitialisationRule::kAffinitySum
                          ? &HungarianSolver::MaximisePositive
                          : &HungarianSolver::Maximise;
  (solver_.*assign)(gains_, static_cast<int>(group_count),
                    static_cast<int>(cols), &detection_of_group_);
  std::vector<char> joined(cols, 0);
  for (size_t g = 0; g < group_count; ++g) {
    const int d = detection_of_group_[g];
    if (d < 0) continue;
    // No second choice: a rejected pair stays unmatched.
    if (!rule_.Accept(groups_[g], *detections[d])) continue;
    groups_[g].push_back(detections[d]);
    joined[d] = 1;
  }
  for (size_t d = 0; d < cols; ++d) {
    if (!joined[d]) groups_.push_back({detections[d]});
  }
}

void Initialiser::GroupViews(const std::vector<ObservationGroup>& unmatched) {
  groups_.clear();
  for (const ObservationGroup& detections : unmatched) {
    eligible_.clear();
    for (const Observation* detection : detections) {
      if (detection->mean_confidence > options_.min_confidence) {
        eligible_.push_back(detection);
      }
    }
    if (!eligible_.empty()) AssignView(eligible_);
  }
}

void Initialiser::Run(const std::vector<ObservationGroup>& unmatched,
                      std::vector<NewPerson>* people) {
  people->clear();
  GroupViews(unmatched);
  const int needed =
      std::max(1, ScaledJoints(options_.min_joints, joints_.size()));
  std::vector<UsedView> views;
  for (ObservationGroup& group : groups_) {
    if (group.size() < 2) continue;
    views.clear();
    for (const Observation* member : group) views.push_back({member, 0.0});
    NewPerson person;
    reconstructor_->Initialise(views, options_.alpha_filter_px,
                               &person.reconstruction);
    if (CountTriangulated(person.reconstruction, joints_) < needed) continue;
    person.members = std::move(group);
    people->push_back(std::move(person));
  }
}

}  // namespace kinegraph
