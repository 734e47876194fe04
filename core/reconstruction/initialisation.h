// New people from unmatched detections (Algorithm 2 of Chu et al. 2021, here
// "the paper").
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_

#include <utility>
#include <vector>

#include "core/assignment/hungarian.h"
#include "core/data/observation.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/options.h"
#include "core/reconstruction/reconstruction.h"

namespace kinegraph {

// Detections of different views that appear to be one person, in view order.
using ObservationGroup = std::vector<const Observation*>;

// Affinity of a detection to a group, by one of the two published rules.
class GroupingRule {
 public:
  // `epipolar` must outlive the rule. `joints` are the association joints.
  GroupingRule(const InitialisationOptions& options,
               const EpipolarGeometry& epipolar, std::vector<int> joints)
      : options_(options),
        epipolar_(&epipolar),
        joints_(std::move(joints)),
        min_common_(ScaledJoints(options.min_common_joints, joints_.size())) {}

  // The larger, the better; may be negative for kWeightedDistance.
  double Gain(const ObservationGroup& group,
              const Observation& detection) const;
  // Whether a pair that the assignment chose may be joined.
  bool Accept(const ObservationGroup& group,
              const Observation& detection) const;

 private:
  // Paper, section 3.3: E = sum of 1 - distance / alpha over the joints that
  // both have, averaged over those views of the group that share at least
  // min_common_joints with the detection; 0 if negative or without such views.
  double AffinitySum(const ObservationGroup& group,
                     const Observation& detection) const;
  // The authors' code: mean over the joints of the confidence-weighted epipolar
  // distance, divided by alpha_group. Its mean over the group is minimised.
  double Cost(const Observation& a, const Observation& b) const;

  InitialisationOptions options_;
  const EpipolarGeometry* epipolar_;
  std::vector<int> joints_;
  int min_common_;
};

struct NewPerson {
  ObservationGroup members;
  Reconstruction reconstruction;
};

class Initialiser {
 public:
  // `epipolar` and `reconstructor` must outlive the object.
  Initialiser(const InitialisationOptions& options,
              const EpipolarGeometry& epipolar, Reconstructor* reconstructor,
              std::vector<int> joints);

  // `unmatched[view]` lists the unmatched detections of a view. Proceeds view
  // by view: each detection that is confident enough joins a group or starts
  // one; groups of two or more views pass through the joints filter and DLT,
  // and those with enough triangulated joints become `people`.
  void Run(const std::vector<ObservationGroup>& unmatched,
           std::vector<NewPerson>* people);

 private:
  void GroupViews(const std::vector<ObservationGroup>& unmatched);
  void AssignView(const ObservationGroup& detections);

  InitialisationOptions options_;
  Reconstructor* reconstructor_;
  std::vector<int> joints_;
  GroupingRule rule_;
  HungarianSolver solver_;
  std::vector<ObservationGroup> groups_;
  ObservationGroup eligible_;
  std::vector<double> gains_;
  std::vector<int> detection_of_group_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_
