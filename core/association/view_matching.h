// One view's detections given to the people known so far.
#ifndef KINEGRAPH_CORE_ASSOCIATION_VIEW_MATCHING_H_
#define KINEGRAPH_CORE_ASSOCIATION_VIEW_MATCHING_H_

#include <Eigen/Geometry>
#include <memory>
#include <utility>
#include <vector>

#include "core/assignment/hungarian.h"
#include "core/association/affinity.h"
#include "core/base/span.h"

namespace kinegraph {

// Matches the observations of one view with targets: an affinity matrix and
// the assignment of the largest total. Keeps its memory between calls.
class ViewMatcher {
 public:
  ViewMatcher(const AssociationOptions& options, std::vector<int> joints)
      : measure_(MakeAffinityMeasure(options, std::move(joints))) {}

  // (*match)[target] is the index of its observation, or -1. A pair is a match
  // only if its affinity is > 0, with no tolerance. Pairs that are `barred`
  // (row-major targets x observations; empty: none) are no matches.
  void Match(const std::vector<AssociationTarget>& targets,
             Span<Observation> observations, const Camera& camera,
             const std::vector<char>& barred, std::vector<int>* match);
  void Match(const std::vector<AssociationTarget>& targets,
             Span<Observation> observations, const Camera& camera,
             std::vector<int>* match) {
    Match(targets, observations, camera, {}, match);
  }

  // Affinities of the last call, row-major targets x observations.
  const std::vector<double>& affinities() const { return affinities_; }

 private:
  std::unique_ptr<AffinityMeasure> measure_;
  HungarianSolver solver_;
  std::vector<double> affinities_;
  std::vector<Eigen::AlignedBox2d> boxes_;  // of the observations
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_VIEW_MATCHING_H_
