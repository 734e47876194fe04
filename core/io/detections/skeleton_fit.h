// Identifies the layout of detections by the plausibility of its bones: files
// of BODY_25 and BODY_25B both have 25 unnamed joints.
#ifndef KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
#define KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_

#include <cstddef>
#include <vector>

#include "core/data/detection.h"
#include "core/skeleton/skeleton.h"

namespace kinegraph {

// In the wrong layout, a bone may connect a knee with an ear: bones are longer
// in the image than in the right layout, and left and right differ. The lengths
// of the bones of arms, legs and trunk are divided by the diagonal of the box
// around the joints; their medians over people have no unit and hardly depend
// on posture or view. The mean length is 0.21 for BODY_25 and 0.38 for BODY_25B
// on Shelf, where BODY_25 is right; it is 0.26 and 0.18 on Pose2Sim's trials,
// where BODY_25B is right. Left and right differ by 0.01 and 0.28 of their sum
// on Shelf, and by 0.35 and 0.03 on Pose2Sim's trials. If people stand with
// hanging arms, their wrists are beside their hips: bones then have nearly the
// right length in the wrong layout too, and only left and right differ.
class SkeletonFit {
 public:
  // All candidates have as many joints as the detections. The first is the
  // default.
  explicit SkeletonFit(std::vector<const Skeleton*> candidates);

  // Adds a person. Ignores people with fewer than eight found joints or four
  // bones and, to bound memory, everybody after the first four thousand.
  void See(const Detection& detection);
  // Whether the limit of See() is reached for at least one candidate.
  bool full() const;

  // Number of people measured: the maximum over the candidates.
  size_t people() const;
  // Mean bone length of a person as a fraction of the diagonal, median over
  // people; 0 if no person was measured.
  double MedianShare(size_t candidate_idx) const;
  // Whether the candidate's bones are too long: the median share exceeds
  // kImplausible over at least kEnoughPeople people of whom an ankle is seen.
  // Others do not count, since bones look long in the small box around half a
  // body.
  bool Implausible(size_t candidate_idx) const;
  // Difference between the left and right bone lengths (medians over people) as
  // a fraction of their sum, mean over pairs of bones: 0 (equal) .. 1.
  double SideDifference(size_t candidate_idx) const;
  // The candidate with the smallest score, which is MedianShare * (1 +
  // SideDifference). A candidate other than the first is chosen only if its
  // score is below kClearly times the first one's and both were measured on at
  // least kEnoughPeople people.
  size_t Best() const;

  static constexpr double kClearly = 0.85;
  static constexpr size_t kEnoughPeople = 5;
  // Above this median share, a layout is implausible; the right layouts above
  // have 0.21 and 0.18.
  static constexpr double kImplausible = 0.32;

 private:
  struct Candidate {
    const Skeleton* skeleton = nullptr;
    std::vector<Bone> bones;
    std::vector<double> shares;  // of each person: mean bone length / diagonal
    std::vector<double> whole_shares;  // of people of whom an ankle is seen
    // By bone: its length in each person that shows it, as a fraction of the
    // diagonal.
    std::vector<std::vector<double>> lengths;
  };

  double Measure(size_t candidate_idx) const;

  std::vector<Candidate> candidates_;
};

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_IO_DETECTIONS_SKELETON_FIT_H_
