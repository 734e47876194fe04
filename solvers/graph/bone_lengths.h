// How long a person's bones are.
#ifndef KINEGRAPH_SOLVERS_GRAPH_BONE_LENGTHS_H_
#define KINEGRAPH_SOLVERS_GRAPH_BONE_LENGTHS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/skeleton/skeleton.h"

namespace kinegraph {

// Length of that bone of an adult [m], from segment lengths as shares of a
// stature of 1.70 m (Drillis and Contini 1966, as in Winter, Biomechanics and
// Motor Control of Human Movement, fig. 4.1); nullopt for other bones.
std::optional<double> PopulationLength(const std::string& joint_a,
                                       const std::string& joint_b);

// Pairs of joints whose distance a person keeps: the skeleton's bones, and of a
// human the remaining pairs of nose, eyes and ears, which one rigid head
// carries.
std::vector<Bone> RigidPairs(const Skeleton& skeleton);

// Collects the distances of bones' ends where both were observed, and tells
// each bone's length: the median, shared by left and right, drawn towards the
// population's while little has been seen, of a human. Memory does not grow:
// distances are counted in bins of 2 mm.
class BoneLengths {
 public:
  explicit BoneLengths(const Skeleton& skeleton);

  // RigidPairs(skeleton); the bones of the functions below.
  const std::vector<Bone>& bones() const { return bones_; }

  // A distance of the ends of bone `bone_idx` [m], seen for `duration_s`.
  void Add(int bone_idx, double distance_m, double duration_s);

  // nullopt while neither enough was seen nor the population's is known.
  std::optional<double> Length(int bone_idx) const;

 private:
  static constexpr double kBin = 0.002;  // m
  static constexpr int kBinCount = 750;  // up to 1.5 m

  // Seen of a bone and its mirror, together.
  struct Seen {
    std::vector<float> seconds;  // by bin
    double total_s = 0.0;
  };

  std::vector<Bone> bones_;
  std::vector<int> group_;  // of each bone: bone and mirror share one
  std::vector<std::optional<double>> population_m_;  // by group
  std::vector<Seen> seen_;                           // by group
};

}  // namespace kinegraph

#endif  // KINEGRAPH_SOLVERS_GRAPH_BONE_LENGTHS_H_
