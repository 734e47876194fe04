// New people from detections that belong to nobody yet (paper Algorithm 2).
#ifndef KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_
#define KINEGRAPH_CORE_RECONSTRUCTION_INITIALISATION_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/assignment/hungarian.h"
#include "core/data/observation.h"
#include "core/geometry/epipolar.h"
#include "core/reconstruction/options.h"
#include "core/reconstruction/reconstruction.h"

namespace kinegraph {

// Detections of different views that seem to be one person, in view order.
using ObservationGroup = std::vector<const Observation*>;

// How much a detection belongs to a group: the two published rules.
class GroupingRule {
 public:
  virtual ~GroupingRule() = default;
  virtual double Gain(const ObservationGroup& group,
                      const Observation& detection) const = 0;
  // The largest total of the gains, groups x detections; -1: none.
  virtual void Assign(Span<double> gains, int groups, int detections,
                      HungarianSolver* solver,
                      std::vector<int>* detection_of_group) const = 0;
  // Whether a pair that the assignment chose may be joined.
  virtual bool Accept(const ObservationGroup& group,
                      const Observation& detection) const = 0;
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
