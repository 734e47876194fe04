// Converts the frames given to an estimator into the values of a problem.
#ifndef KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_
#define KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/skeleton/skeleton.h"
#include "core/tracking/estimator.h"
#include "solvers/graph/options.h"
#include "solvers/graph/problem.h"

namespace kinegraph {

// Data of a frame that its final pose needs besides the estimate.
struct FrameRecord {
  struct View {
    int view_idx = 0;
    int detection_idx = 0;
  };
  int64_t frame = 0;
  TimeNs time = 0;
  std::vector<View> views;
  double score = 0.0;  // mean confidence of the matched joints
  // Joints triangulated in the initial pose; their positions are the states
  // appended with the frame.
  std::vector<bool> triangulated;
};

// Converts fresh detections into measurements. The sigma depends on confidence,
// joint class and the depth of the person's initial centre; the information
// depends on the time since the view's last measurement of the joint. Skips
// measurements that are not finite, and views in which that centre is not more
// than kNearestDepthM in front of the camera.
class Assembler {
 public:
  // `scene` and `options` must outlive the assembler.
  Assembler(const SceneModel& scene, const GraphOptions& options);

  // Appends the frame to the problem. Each new state starts at the joint's
  // initial position if that was triangulated, else at the person's centre, and
  // at rest. The first frame creates the joints and sets their birth priors.
  // Time must have advanced.
  FrameRecord Append(const EstimatorFrame& frame, PersonProblem* problem);

 private:
  void AppendView(const EstimatorFrame& frame, const FreshView& view, int slot,
                  PersonProblem* problem);
  void AppendUserFactors(const EstimatorFrame& frame, PersonProblem* problem);

  const SceneModel& scene_;
  const GraphOptions& options_;
  // Mean of the joints of the last initial pose.
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  // Time of the last measurement by view and joint.
  std::vector<TimeNs> last_measured_;
};

// Where pixel noise is learnt from the recording, sigmas are multiplied by this
// factor and the information by its square: the curvature at small residuals is
// the same, but a robust loss reduces weights only at larger residuals.
inline constexpr double kLearntWidening = 1.25;

// Standard deviation of one coordinate of a detected joint [px], at least
// GraphOptions::min_sigma_px. It scales with the person's size in the image,
// focal_px / depth_m, because detectors work on a person's crop; `depth_m` > 0
// is that of the initial pose, so that the sigma is constant during a solve.
double PixelSigma(const GraphOptions& options, JointClass joint_class,
                  double confidence, double depth_m, double focal_px);

// Factor on the information of an observation made `dt_s` after the previous
// observation of the same joint in the same view (infinity: the first one).
// Detector errors are correlated over correlation_time_s, and a chain of
// first-order correlated errors carries (1 - rho) / (1 + rho), rho = exp(-dt /
// tau), of the information of as many independent errors (variance of the mean
// of an AR(1) process), multiplied here by information_scale. Information per
// second therefore stays bounded as the frame rate grows.
double InformationScale(const GraphOptions& options, double dt_s);

// 1 / sigma [1/m] of BodyCentre in a frame `dt_s` after the one before. The
// offset of a joint from its person is as uncertain as at birth and changes
// slowly, so frames are correlated as in InformationScale: per second they
// carry a sixth of the birth prior's information. For a joint that two views
// measure to a centimetre in every frame that is less than 1e-5 of the total.
double CentrePerSigma(const GraphOptions& options, double dt_s);

// A convex loss needs one stage. Other losses start with Huber, whose only
// minimum does not depend on the start, and then narrow to their own scale
// (graduated non-convexity: Blake and Zisserman 1987; Yang et al., RA-L 2020).
// A redescending loss started from an old estimate can exclude good views
// permanently, so every window runs the whole schedule again.
SolveSchedule MakeSchedule(const GraphOptions& options);

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_ASSEMBLER_H_
