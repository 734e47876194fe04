// New people from detections that belong to nobody yet (paper Algorithm 2).
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/assignment/hungarian.h"
#include "core/base/options.h"
#include "core/data/observation.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/reconstruction.h"

namespace kinegraph {

enum class InitialisationRule {
  kAffinitySum,       // the paper's text: sum of epipolar affinities, E > 0
  kWeightedDistance,  // the authors' code: confidence-weighted mean distance
};

struct InitialisationOptions {
  InitialisationRule rule = InitialisationRule::kAffinitySum;
  double alpha_group_px = 60.0;   // epipolar distance scale of the grouping
  double alpha_filter_px = 60.0;  // of the joints filter at initialisation
  // Detections take part when their mean confidence over the joints that take
  // part at all (under detections.zero_confidence = "position": all joints) is
  // above this.
  double min_confidence = 0.0;
  // weighted_distance: a pair with a cost above 1 in any member view is vetoed
  // after the assignment when the detection's mean confidence is above this.
  double veto_confidence = 0.5;
  // affinity_sum: common joints that a pair must have, as a share of 17 scaled
  // to the skeleton's association joints.
  double min_common_joints = 10.0;
  // Triangulated joints that a new person must have, likewise.
  double min_joints = 10.0;

  void Describe(OptionVisitor& visitor);
};

// Detections of different views that seem to be one person, in view order.
using ObservationGroup = std::vector<const Observation*>;

// How much a detection belongs to a group: the two published rules.
class GroupingRule {
 public:
  virtual ~GroupingRule() = default;
  // Gain of the pair; the assignment takes the largest total.
  virtual double Gain(const ObservationGroup& group,
                      const Observation& detection) const = 0;
  // Whether a pair that the assignment chose may be joined.
  virtual bool Accept(const ObservationGroup& group,
                      const Observation& detection, double gain) const = 0;
};

// `epipolar` must outlive the rule. `joints` are the association joints.
std::unique_ptr<GroupingRule> MakeGroupingRule(
    const InitialisationOptions& options, const EpipolarGeometry& epipolar,
    std::vector<int> joints);

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

  // `unmatched[view]` lists the detections of a view that nobody took. Goes
  // from view to view: each detection joins a group or starts one; groups of
  // two or more views pass the joints filter and DLT.
  void Run(const std::vector<ObservationGroup>& unmatched,
           std::vector<NewPerson>* people);

 private:
  void GroupViews(const std::vector<ObservationGroup>& unmatched);
  void AssignView(const ObservationGroup& detections);

  InitialisationOptions options_;
  Reconstructor* reconstructor_;
  std::vector<int> joints_;
  std::unique_ptr<GroupingRule> rule_;
  HungarianSolver solver_;
  std::vector<ObservationGroup> groups_;
  ObservationGroup eligible_;
  std::vector<double> gains_;
  std::vector<int> detection_of_group_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_
