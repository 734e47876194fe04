// From the frames an estimator is given to the values of a problem.
#ifndef KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_
#define KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// What a final pose needs to know of its frame besides the estimate.
struct FrameRecord {
  struct View {
    int view_idx = 0;
    int detection_idx = 0;
  };
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<View> views;
  double score = 0.0;  // mean confidence of the matched joints
  // Joints that the initial pose triangulated; their positions are the states
  // that were appended with the frame.
  std::vector<bool> triangulated;
};

// Turns fresh detections into measurements: sigma by confidence, joint class
// and the depth of the person's initial centre; information by the time since
// the view's last measurement of the joint. Whatever is not finite or behind
// the camera is no measurement.
class Assembler {
 public:
  // `scene` and `options` must outlive the assembler.
  Assembler(const SceneModel& scene, const GraphOptions& options);

  // Joints without frames.
  PersonProblem EmptyProblem() const;

  // Appends the frame to the problem. New states stand where the initial pose
  // triangulated the joint, else at the person's centre, at rest. The first
  // frame sets the birth priors. Time must have advanced.
  FrameRecord Append(const EstimatorFrame& frame, PersonProblem* problem);

  // Middle of the joints of the last initial pose.
  const Eigen::Vector3d& centre() const { return centre_; }

 private:
  void UpdateCentre(const EstimatorFrame& frame);
  void AppendView(const EstimatorFrame& frame, const FreshView& view, int slot,
                  PersonProblem* problem);
  void AppendUserFactors(const EstimatorFrame& frame, PersonProblem* problem);

  const SceneModel& scene_;
  const GraphOptions& options_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  // Time of the last measurement by view and joint.
  std::vector<TimeNs> last_measured_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_
