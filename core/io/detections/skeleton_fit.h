// Identifies the layout of detections by the plausibility of its bones: files
// of BODY_25 and BODY_25B both have 25 unnamed joints.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_

#include <cstddef>
#include <vector>

#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A layout read in the wrong order joins a knee to an ear: its bones are longer
// in the image than those of the right one, and left and right differ. Lengths
// of arms, legs, shoulders and hips are divided by the diagonal of the box
// around the joints; their medians over people depend on no unit and hardly on
// posture or view. The mean length on Shelf is 0.21 for BODY_25 and 0.38 for
// BODY_25B; on Pose2Sim's trials it is 0.26 and 0.18. Left and right differ by
// 0.01 and 0.28 of their sum on Shelf, by 0.35 and 0.03 on Pose2Sim's. The
// wrists of people who stand with hanging arms are beside their hips: in the
// wrong order their bones have nearly the right length, and only the sides
// differ.
class SkeletonFit {
 public:
  // Candidates have the joint count of the detections. The first is the
  // default.
  explicit SkeletonFit(std::vector<const Skeleton*> candidates);

  // Ignores people with fewer than eight found joints, and everything after the
  // first few thousand people to bound memory.
  void See(const Detection& detection);
  bool full() const;

  // Number of people measured, by the candidate with the most.
  size_t people() const;
  // Median share of the candidate; 0 if no person was measured.
  double MedianShare(size_t candidate_idx) const;
  // Whether the candidate's bones are too long for people: the median share of
  // those seen down to an ankle, at least `kEnoughPeople`. The box of half a
  // body is small, so that bones of the right layout look long.
  bool Implausible(size_t candidate_idx) const;
  // Difference of left and right limbs as a share of their sum: mean over limbs
  // of the medians over people. 0: equal; at most 1.
  double SideDifference(size_t candidate_idx) const;
  // The best candidate: one other than the first only if its measure, the
  // median share times one plus the side difference, is smaller by the factor
  // `kClearly` on at least `kEnoughPeople`.
  size_t Best() const;

  static constexpr double kClearly = 0.85;
  static constexpr size_t kEnoughPeople = 5;
  // The largest median share of a right layout was 0.26.
  static constexpr double kImplausible = 0.32;

 private:
  struct Candidate {
    const Skeleton* skeleton = nullptr;
    std::vector<Bone> bones;
    std::vector<double> shares;
    std::vector<double> whole_shares;  // of those seen down to an ankle
    // Per bone; empty if no person had it.
    std::vector<std::vector<double>> lengths;
  };

  double Measure(size_t candidate_idx) const;

  std::vector<Candidate> candidates_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
