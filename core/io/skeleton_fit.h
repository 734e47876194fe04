// Which body layout detections are in, by how plausible its bones look: files
// of BODY_25 and BODY_25B both hold 25 unnamed joints.
#ifndef KINEGRAPH_CORE_IO_SKELETON_FIT_H_
#define KINEGRAPH_CORE_IO_SKELETON_FIT_H_

#include <cstddef>
#include <vector>

#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A layout read in the wrong order joins a knee with an ear: its bones are
// longer in the image than those of the right one. The measure is the mean
// length of arms, legs, shoulders and hips as a share of the diagonal of the
// box around the joints; its median over the people seen depends on no unit and
// hardly on posture or view. On Shelf it is 0.21 for BODY_25 and 0.38 for
// BODY_25B, on Pose2Sim's trials 0.26 and 0.18.
class SkeletonFit {
 public:
  // Candidates have the joint count of the detections. The first is taken when
  // nothing tells them apart.
  explicit SkeletonFit(std::vector<const Skeleton*> candidates);

  // People with fewer than eight found joints say nothing. Everything after the
  // first few thousand is left out, so that memory stays bounded.
  void See(const Detection& detection);
  bool full() const;

  // Number of people that were measured, in the candidate with the most.
  size_t people() const;
  // Median share of the candidate; 0 when nobody could be measured.
  double MedianShare(size_t candidate_idx) const;
  // The candidate to believe: another than the first only when its bones are
  // shorter by `kClearly` or more, seen on at least `kEnoughPeople`.
  size_t Best() const;

  static constexpr double kClearly = 0.85;
  static constexpr size_t kEnoughPeople = 5;
  // No right layout was seen above 0.26 in the median.
  static constexpr double kImplausible = 0.32;

 private:
  struct Candidate {
    const Skeleton* skeleton = nullptr;
    std::vector<Bone> bones;
    std::vector<double> shares;
  };
  std::vector<Candidate> candidates_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_SKELETON_FIT_H_
