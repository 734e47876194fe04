// Which body layout detections are in, by how plausible its bones look: files
// of BODY_25 and BODY_25B both hold 25 unnamed joints.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_

#include <cstddef>
#include <vector>

#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// A layout read in the wrong order joins a knee with an ear: its bones are
// longer in the image than those of the right one, and left and right are no
// longer alike. Lengths of arms, legs, shoulders and hips are taken as shares
// of the diagonal of the box around the joints; their medians over the people
// seen depend on no unit and hardly on posture or view. The mean length is 0.21
// on Shelf for BODY_25 and 0.38 for BODY_25B, 0.26 and 0.18 on Pose2Sim's
// trials; left and right differ by 0.01 and 0.28 of their sum there, by 0.35
// and 0.03 here. Of people who stand about with hanging arms, wrists lie beside
// hips: read in the wrong order they have bones of nearly the right length, and
// only the sides tell.
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
  // Whether the candidate's bones are too long for people: the median share of
  // those seen down to an ankle, `kEnoughPeople` of them or more. Of half a
  // body the box is small, and bones of the right layout look long.
  bool Implausible(size_t candidate_idx) const;
  // How far left and right limbs are from one another, as a share of their sum,
  // in the mean over limbs of the medians over people: 0 alike, 1 at most.
  double SideDifference(size_t candidate_idx) const;
  // The candidate to believe: another than the first only when its measure,
  // the median share times one plus the difference of the sides, is smaller by
  // `kClearly` or more, seen on at least `kEnoughPeople`.
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
    std::vector<double> whole_shares;  // of those seen down to an ankle
    // Per bone; empty where the people seen did not have it.
    std::vector<std::vector<double>> lengths;
  };

  double Measure(size_t candidate_idx) const;

  std::vector<Candidate> candidates_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
