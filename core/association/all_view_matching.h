// Matches the detections of all views with people at once. Bodies of few joints
// (boxes, centroids) do not differ enough within one view for the paper's Eq. 1
// (affinity.h), but views that show one person agree on the person's position.
#ifndef KINEGRAPH_CORE_ASSOCIATION_ALL_VIEW_MATCHING_H_
#define KINEGRAPH_CORE_ASSOCIATION_ALL_VIEW_MATCHING_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/span.h"
#include "core/data/observation.h"
#include "core/data/pose.h"
#include "core/geometry/camera.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// The pose expected of a person, and the standard deviation of its position on
// each axis.
struct ExpectedPerson {
  const Pose3d* pose = nullptr;
  double sigma_m = 0.0;
};

// Time for which a person is expected to keep their velocity [s]; about the
// time constant of the velocity of walking people (core/identity/motion.cc).
inline constexpr double kSpeedLasts = 1.0;
// Standard deviation [m] on each axis of the position expected of a person
// whose pose is `age_s` old.
double ExpectedSigma(double age_s);

class AllViewMatcher {
 public:
  // Whether the skeleton has fewer than four association joints, so that graph
  // mode matches people in all views at once.
  static bool AppliesTo(const Skeleton& skeleton);

  // `cameras` must outlive the object; `joints` are the association joints,
  // `detector_px` is the part of the detector's error that does not depend on
  // distance.
  AllViewMatcher(const CameraRig& cameras, std::vector<int> joints,
                 double detector_px);

  // (*matches)[view][person] is the index of the observation in `views[view]`,
  // or -1. Pairs marked in `barred[view]` (row-major people x observations;
  // empty: none) cannot match.
  //
  // A hypothesis of a person is a detection, or none, in each view. Its gain is
  // the logarithm of the odds that these detections show the person, displaced
  // from the expected pose, and not other people; a joint hidden by a person
  // nearer to the camera is more likely to be misplaced. At most one
  // hypothesis is chosen per person, and each detection is in at most one of
  // the chosen hypotheses. The order of the views does not matter.
  void Match(Span<ExpectedPerson> people,
             const std::vector<Span<Observation>>& views,
             const std::vector<std::vector<char>>& barred,
             std::vector<std::vector<int>>* matches);

 private:
  struct Hypothesis {
    size_t person = 0;
    double gain = 0.0;            // nats
    std::vector<int> detections;  // [view], or -1
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  };
  static bool GainsMore(const Hypothesis& a, const Hypothesis& b);
  void FindHidden(Span<ExpectedPerson> people);
  bool IsNear(const ExpectedPerson& expected, size_t view,
              const Observation& observation) const;
  // Adds the detection to the hypothesis. False, with the hypothesis no longer
  // usable, if the detection more probably shows another person, if each of its
  // joints is more probably misplaced, or if one is expected behind the camera.
  bool Extend(const Pose3d& expected, size_t view, int detection,
              Span<Observation> observations, Hypothesis* hypothesis) const;
  // Adds the person's best hypotheses, each with at least one detection, to
  // all_.
  void Explain(size_t person, const ExpectedPerson& expected,
               const std::vector<Span<Observation>>& views,
               const std::vector<std::vector<char>>& barred);

  // Chooses compatible hypotheses with a large total gain: greedily at first;
  // then each hypothesis replaces those that it excludes if that raises the
  // total.
  void Choose(size_t people, const std::vector<Span<Observation>>& views);
  bool Improve(int hypothesis);
  bool IsFree(const Hypothesis& one) const;
  void Take(int hypothesis);
  double Release(size_t person);       // returns the gain that is lost
  double TakeBestFree(size_t person);  // returns the gain that is won

  const CameraRig* cameras_;
  std::vector<int> joints_;
  double detector_px_;
  // Buffers of Match.
  std::vector<std::vector<std::vector<char>>> hidden_;  // [view][person][joint]
  std::vector<std::vector<int>> near_;   // [view]: detections near one person
  std::vector<Hypothesis> open_;         // with equally many detections
  std::vector<Hypothesis> longer_;       // with one detection more
  std::vector<Hypothesis> all_;          // by descending gain
  std::vector<int> chosen_;              // [person]: a hypothesis, or -1
  std::vector<std::vector<int>> owner_;  // [view][observation]: a person, or -1
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_ASSOCIATION_ALL_VIEW_MATCHING_H_
